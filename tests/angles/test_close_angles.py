"""Angles close, lengths agree, depths are those that were planted, and limbs stay above the floor of float64."""

from __future__ import annotations

import numpy as np
import pytest
from bodies import grow, random_body
from triangulations import icosphere

from igl_spheremap import spherical_conformal_map
from igl_spheremap.angles.close_angles import close_angles, proper_angles
from igl_spheremap.angles.deep_limbs import shorten_limbs, tips_beyond
from igl_spheremap.angles.layout import Layout, Placed, centred, lengths_and_directions, onto_sphere
from igl_spheremap.angles.poles import at_poles
from igl_spheremap.io.float32 import as_mapped
from igl_spheremap.mesh.arrays import HALF_DIGITS
from igl_spheremap.mesh.check import check_mesh
from igl_spheremap.mesh.measure import corner_angles, log_edges
from igl_spheremap.newton.system import VertexSystem
from igl_spheremap.sphere.log_plane import exponential, logarithm, to_ball
from igl_spheremap.sphere.rows import from_chart, to_chart
from igl_spheremap.verify.certificate import Certificate


def system(mesh):
    return VertexSystem(mesh.f, len(mesh.v), limbs=True)


@pytest.fixture(scope="module")
def body():
    """A body with limbs beyond float64, and its closed angles, a face of the ball cut out."""
    mesh = check_mesh(*random_body(2, depth=60))
    source = proper_angles(corner_angles(mesh.unit, mesh.f))
    hole = int((mesh.f.max(axis=1) < 642).argmax())
    return mesh, source, hole, close_angles(system(mesh), source, hole)


def _centred(body):
    mesh, _, hole, closed = body
    return centred(mesh, Layout.of(mesh.f, closed, hole))


def test_angles_close_around_faces_and_vertices(body):
    mesh, _, hole, closed = body
    f, n = np.delete(mesh.f, hole, 0), len(mesh.v)
    a = np.delete(closed, hole, 0)
    inner = np.ones(n, dtype=bool)
    inner[mesh.f[hole]] = False
    assert (a > 0).all()
    assert np.abs(a.sum(axis=1) - np.pi).max() < 1e-12
    assert np.abs(np.bincount(f.ravel(), a.ravel(), n) - 2 * np.pi)[inner].max() < HALF_DIGITS
    sines = np.log(np.sin(a))
    product = np.bincount(f.ravel(), (np.roll(sines, -1, 1) - np.roll(sines, 1, 1)).ravel(), n)
    assert np.abs(product[inner]).max() < HALF_DIGITS


def test_closed_angles_stay_near_the_meshs_own_and_angles_that_close_stay(body):
    mesh, source, hole, closed = body
    kept = np.arange(len(mesh.f)) != hole
    assert np.degrees(np.abs(closed - source)[kept].mean()) < 8
    again = close_angles(system(mesh), closed, hole)
    assert np.abs(again - closed)[kept].max() < 1e-7


def test_lengths_agree_across_every_edge_and_positions_have_the_angles(body):
    mesh, _, hole, closed = body
    f = mesh.f
    length, direction = lengths_and_directions(f, closed, hole)
    start, end = f[:, [1, 2, 0]].ravel(), f[:, [2, 0, 1]].ravel()
    n = len(mesh.v)
    forth, back = np.argsort(start * n + end), np.argsort(end * n + start)
    away = length.ravel()[forth] - length.ravel()[back]
    turned = np.exp(1j * (direction.ravel()[forth] - direction.ravel()[back]))
    known = np.isfinite(away)
    assert np.abs(away[known]).max() < 1e-6
    assert np.abs(turned[known] + 1).max() < 1e-6
    layout = Layout.of(f, closed, hole)
    tip = int(np.argmin(layout.log_edge))
    z = exponential(layout.about(tip) - layout.log_edge[tip])
    near = np.flatnonzero((np.abs(z) < 1e6)[f].all(axis=1))
    plane = np.column_stack((z.real, z.imag, 0 * z.real))
    assert len(near) > 20
    assert np.abs(corner_angles(plane, f[near]) - closed[near]).max() < 1e-6


def test_an_inverted_layout_keeps_its_angles_in_the_deepest_limb_and_is_one_over_z_elsewhere(body):
    mesh, _, hole, closed = body
    layout = Layout.of(mesh.f, closed, hole)
    tip = int(np.argmin(layout.log_edge))
    face = int(
        np.argmax(
            np.where(np.arange(len(mesh.f)) == hole, -np.inf, layout.log_edge[mesh.f].min(axis=1))
        )
    )
    inverted = layout.inverted(face)
    z = exponential(inverted.about(tip) - inverted.log_edge[tip])
    near = np.flatnonzero((np.abs(z) < 1e6)[mesh.f].all(axis=1))
    assert len(near) > 20
    assert (
        np.abs(
            corner_angles(np.column_stack((z.real, z.imag, 0 * z.real)), mesh.f[near])
            - closed[near]
        ).max()
        < 1e-6
    )
    corner = mesh.f[face, 0]
    plane = exponential(layout.about(corner))
    w = 1 / (plane - plane[mesh.f[face]].mean())
    assert np.abs(exponential(inverted.about(corner)) - (w - w[corner])).max() < 1e-9
    back = inverted.inverted(hole)  # about another point of that face: shapes come back, turned
    shape = [
        np.exp(
            1j * np.angle(exponential(at.about(tip) - at.log_edge[tip])[mesh.f[near]] @ [1, -1, 0])
        )
        for at in (layout, back)
    ]
    assert np.abs(shape[0] / shape[1] / (shape[0] / shape[1])[0] - 1).max() < 1e-6


def test_a_limb_comes_back_with_the_depth_that_was_planted():
    for depth in (15.0, 90.0):
        v, f, *_ = grow(
            np.random.default_rng(0), *icosphere(3), np.array([0, 0, 1.0]), depth, 16, 0.0
        )
        used, f = np.unique(f, return_inverse=True)
        mesh = check_mesh(v[used], f.reshape(-1, 3).astype(np.int64))
        area = mesh.A
        source = proper_angles(corner_angles(mesh.unit, mesh.f))
        hole = int(np.argmin(mesh.unit[mesh.f].mean(axis=1) @ [0, 0, 1]))
        placed = centred(mesh, Layout.of(mesh.f, close_angles(system(mesh), source, hole), hole))
        assert np.ptp(placed.depth) == pytest.approx(depth, abs=2 + 0.03 * depth)
        assert np.abs(area @ to_ball(placed.points)).max() < 1e-6 * max(1, depth)


def test_every_limb_is_above_the_floor_and_no_more_is_shortened_than_must_be(body):
    mesh, source, _, _ = body
    placed = _centred(body)
    assert placed.depth.max() > 37
    for floor in (35.0, 20.0):
        points, stretch = shorten_limbs(placed, source, floor)
        x = onto_sphere(placed, points)
        assert stretch > 1
        assert -log_edges(x, mesh.f).min() < floor + 1.5
        assert Certificate.of(x, mesh.f).foldings < 0.01 * len(mesh.f)
    points, stretch = shorten_limbs(placed, source, placed.depth.max() + 1)
    assert stretch == 1
    assert (points.z == placed.points.z).all()


@pytest.mark.parametrize("limbs", [1, 2, 3, 5])
def test_tips_go_to_ends_of_axes_by_a_moebius_map(limbs):
    rng = np.random.default_rng(limbs)
    mesh = check_mesh(*random_body(limbs, depth=9, limbs=limbs))
    closed = close_angles(system(mesh), proper_angles(corner_angles(mesh.unit, mesh.f)), hole=0)
    placed = centred(mesh, Layout.of(mesh.f, closed, 0))
    floor = 5.0
    roots = [tip.vertex for tip in tips_beyond(placed, floor) if tip.meets < 0]
    moved = at_poles(placed, floor)
    x, y = (onto_sphere(p, p.points) for p in (placed, moved))
    tips = sorted(roots, key=lambda tip: -placed.depth[tip])[:3]
    assert (np.sort(np.abs(y[tips]), axis=1) == [0, 0, 1]).all()
    assert len(np.unique(y[tips], axis=0)) == min(3, len(roots))
    a, b, c, d = rng.integers(len(x), size=(4, 1000))
    ratio = [
        [np.linalg.norm(z[i] - z[j], axis=1) for i, j in ((a, b), (c, d), (a, c), (b, d))]
        for z in (x, y)
    ]
    apart = np.min(ratio, axis=(0, 1)) > 1e-3
    first, second = (p * q / np.where(apart, r * s, 1) for p, q, r, s in ratio)
    assert first[apart] == pytest.approx(second[apart], rel=1e-9)
    if len(roots) == 1:  # turned, no more
        assert mesh.A @ y == pytest.approx(np.zeros(3), abs=1e-6)
    # of the angle from the nearest tip
    half = np.arcsin(np.linalg.norm(y[:, None] - y[tips], axis=2).min(axis=1) / 2)
    small = (log_edges(y, mesh.f) < -2) & (half > 1e-3)
    found = -log_edges(y, mesh.f)[small] + np.log(np.minimum(1, np.tan(half[small])))
    assert np.quantile(np.abs(moved.depth[small] - found), 0.95) < 0.2  # not beside the hole


def test_at_ends_of_axes_only_limbs_that_lead_elsewhere_are_shortened(body):
    placed = _centred(body)
    moved = at_poles(placed, 35.0)
    deep = (placed.depth > 37) & (moved.depth < 5)
    assert deep.any()
    assert moved.depth[placed.depth > 37].max() < 21  # twigs on these limbs
    drawn, stretch = shorten_limbs(moved, body[1], 12.0)
    assert stretch > 1
    z, before = drawn.z, moved.points.z
    assert (np.abs(z - before)[deep] <= 1e-12 * np.abs(before)[deep]).all()
    x = onto_sphere(moved, drawn)
    assert log_edges(x, body[0].f)[deep].min() < -37
    assert Certificate.of(x, body[0].f).foldings < 0.01 * len(body[0].f)


def test_a_map_with_room_for_its_limbs_is_as_shortened_in_its_chart_as_on_paper():
    x, f = icosphere(3)
    pole = np.array([[0.0, 0.0, 1.0]])
    z = to_chart(x, pole)
    # edges as short as cubes of what they were
    narrow = from_chart(z * np.minimum(1, np.abs(z)) ** 2, pole)
    placed = as_mapped(narrow, f, pole)
    assert placed.depth == pytest.approx(-log_edges(narrow, f))
    points, stretch = shorten_limbs(placed, corner_angles(narrow, f), placed.depth.max() - 2)
    shortened = onto_sphere(placed, points)
    assert stretch > 1
    assert -log_edges(shortened, f).min() < placed.depth.max() - 1
    assert (points.z == placed.points.z)[narrow[:, 2] < 0.5].all()


def test_tips_are_those_of_the_merge_tree():
    v, f = icosphere(4)
    peaks = np.array([[0, 0, 1.0], [1, 0, 0], [0.6, 0, 0.8]])
    depth = (np.array([50, 45, 48]) - 40 * np.arccos(np.clip(v @ peaks.T, -1, 1))).max(axis=1)
    nowhere = logarithm(np.zeros(len(v)))
    placed = Placed(f, nowhere, depth, lambda tip: nowhere)
    found = {tip.vertex: (tip.meets, set(tip.members.tolist())) for tip in tips_beyond(placed, 40)}
    a, b, c = (int(np.argmax(v @ p)) for p in peaks)
    assert set(found) == {a, b, c}
    assert found[a][0] == -1
    assert found[c][0] == a
    assert found[b][0] in (a, c)
    assert found[a][1] == set(np.flatnonzero(depth > 4).tolist())
    assert {tip.vertex for tip in tips_beyond(placed, 49)} == {a}


def test_a_random_body_beyond_float64_comes_back_certified_and_near_its_angles():
    v, f = random_body(1, depth=50)
    for gauge, least, mean in (("poles", 1, 9), ("centred", 1.1, 10)):
        result = spherical_conformal_map(v, f, gauge=gauge)
        assert (result.gauge, result.certificate.folding_free) == (gauge, True)
        assert result.stretch >= least
        assert np.abs(result.angle_differences()).mean() < mean
