"""Caps close a surface for its map and count nowhere else: the gauge, the figures and the files are the surface's."""

from __future__ import annotations

import numpy as np
import pytest
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap.io.written_map import read_mark

BALL, BALL_F = icosphere(3)


def bowl(height, stretch=(1.0, 1.0, 1.0)):
    """A ball without its top, filled: the mesh, and how many vertices and faces were there before."""
    f = BALL_F[BALL[BALL_F].mean(axis=1)[:, 2] < height]
    used, corners = np.unique(f, return_inverse=True)
    return (
        ism.repair_mesh(BALL[used] * stretch, corners.reshape(-1, 3), holes="fill"),
        len(used),
        len(f),
    )


@pytest.fixture(scope="module")
def body():
    return bowl(0.5, (1.0, 1.2, 0.9))


@pytest.fixture(scope="module")
def result(body):
    mesh = body[0]
    return ism.spherical_conformal_map(mesh.v, mesh.f, caps=mesh.face_source < 0)


def test_the_surface_weighs_and_caps_do_not(body, result):
    mesh, _, m = body
    part = np.zeros((len(mesh.f), 1))
    part[:m, 0] = np.linalg.norm(
        np.cross(*(mesh.v[mesh.f[:m, k]] - mesh.v[mesh.f[:m, 0]] for k in (1, 2))), axis=1
    )
    weights = np.bincount(mesh.f.ravel(), np.repeat(part, 3), len(mesh.v))
    assert np.linalg.norm(weights @ result.sphere) / weights.sum() < 1e-6
    ordinary = ism.spherical_conformal_map(mesh.v, mesh.f)
    assert np.linalg.norm(weights @ ordinary.sphere) / weights.sum() > 0.1


def test_moebius_maps_leave_angles_so_caps_are_seen_in_no_figure(body, result):
    """Figures are those of the surface's rows alone, whatever the faces of the caps look like."""
    mesh, _, m = body
    caps = mesh.face_source < 0
    assert len(result.angle_differences()) == len(result.log_area_ratios()) == m
    whole = ism.angle_differences(mesh.v, mesh.f, result.sphere)
    assert np.array_equal(result.angle_differences(), whole[~caps])
    image, source = (
        np.linalg.norm(
            np.cross(p[mesh.f[:m, 1]] - p[mesh.f[:m, 0]], p[mesh.f[:m, 2]] - p[mesh.f[:m, 0]]),
            axis=1,
        )
        for p in (result.sphere, mesh.v)
    )
    ratios = np.log(image / image.sum() / source * source.sum())
    assert np.allclose(result.log_area_ratios(), ratios)
    assert len(result.plot().axes) > 0


def test_a_capped_ball_maps_by_a_moebius_map():
    """The exact map of a part of a sphere is the identity up to a Moebius map: cross ratios stay."""
    mesh, n, _ = bowl(0.6)
    result = ism.spherical_conformal_map(mesh.v, mesh.f, caps=mesh.face_source < 0)
    rows = (
        np.random.default_rng(0)
        .permutation(np.flatnonzero(mesh.v[:n, 2] < 0.4))[:400]
        .reshape(4, -1)
    )

    def cross_ratio(x):
        a, b, c, d = x[rows]
        return (
            np.linalg.norm(a - c, axis=1)
            * np.linalg.norm(b - d, axis=1)
            / np.linalg.norm(a - d, axis=1)
            / np.linalg.norm(b - c, axis=1)
        )

    assert np.abs(np.log(cross_ratio(result.sphere) / cross_ratio(mesh.v))).mean() < 0.02


@pytest.mark.parametrize("name", ["map.npz", "sphere.ply", "sphere.obj"])
def test_files_say_how_many_faces_are_caps(name, body, result, tmp_path):
    mesh, _, m = body
    ism.write_map(tmp_path / name, result)
    assert f"caps={len(mesh.f) - m}" in read_mark(tmp_path / name)
    if name.endswith(".npz"):
        again = ism.read_map(tmp_path / name)
        assert np.array_equal(again.mesh.caps, mesh.face_source < 0)
        assert np.array_equal(again.angle_differences(), result.angle_differences())


def test_findings_count_caps(body, result):
    mesh, _, m = body
    assert f"{len(mesh.f) - m:,} of its {len(mesh.f):,} faces are caps" in result._repr_html_()
    assert "caps" not in ism.spherical_conformal_map(BALL, BALL_F)._repr_html_()


def test_every_map_takes_caps(body, result):
    mesh, _, m = body
    v, f, caps = mesh.v, mesh.f, mesh.face_source < 0
    made = [
        ism.balanced_spherical_map(v, f, balance=0.5, caps=caps),
        ism.SphereMapper(v, f, caps=caps).map(),
        ism.spherical_conformal_map(v, f, method="lai2014", caps=caps),
        ism.spherical_conformal_map(v, f, method="gu-yau", caps=caps),
        ism.spherical_conformal_map(v, f, method="stereographic", caps=caps),
        ism.algorithm_1(v, f, caps=caps),
        ism.p_harmonic_map(v, f, 1.8, caps=caps),
        ism.landmark_map(v, f, [0], [[0, 0, 1.0]], caps=caps),
        ism.repair_foldings(v, f, result.sphere, caps=caps),
        ism.sphere_map(v, f, result.sphere, caps=caps),
    ]
    for each in made:
        assert each.certificate.folding_free
        assert np.array_equal(each.mesh.caps, caps)
        assert len(each.angle_differences()) == m
    assert np.array_equal(made[1].sphere, result.sphere)
    # minimisers of the same energy, the last digits of its minimum apart
    for each in (made[2], made[3], made[5]):
        assert (
            np.abs(each.angle_differences()).mean()
            < np.abs(result.angle_differences()).mean() + 0.3
        )
    area = result.rebalance(1)
    assert np.abs(area.log_area_ratios()).mean() < 0.05 < np.abs(result.log_area_ratios()).mean()


def test_what_are_no_caps_is_refused(body):
    mesh = body[0]
    for caps, words in (
        (np.flatnonzero(mesh.face_source < 0), "caps have shape"),
        (np.ones(len(mesh.f), bool), "all faces"),
        (np.zeros(len(mesh.f)), "dtype float64"),
        ([True], "shape"),
    ):
        with pytest.raises(ism.MeshError, match=words):
            ism.check_mesh(mesh.v, mesh.f, caps=caps)
    assert ism.check_mesh(mesh.v, mesh.f, caps=np.zeros(len(mesh.f), bool)).caps is None
