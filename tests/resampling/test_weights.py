"""Matrices that carry data: constants, integrals, labels; the rule of Workbench's ADAP_BARY_AREA."""

from __future__ import annotations

import shutil
import subprocess

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.io.scalars import read_scalars, write_scalars
from igl_spheremap.io.write_mesh import write_mesh
from igl_spheremap.resampling.transfer import regular_mesh, transfer, transfer_matrix


@pytest.fixture(scope="module")
def brain():
    """White surface and sphere of fsaverage5, which nilearn brings."""
    pytest.importorskip("nibabel")
    folder = pytest.importorskip("nilearn.datasets").fetch_surf_fsaverage("fsaverage5")
    v, f = ism.read_mesh(folder["white_left"])
    return ism.sphere_map(v, f, ism.read_mesh(folder["sphere_left"]).v)


@pytest.fixture(scope="module")
def dino():
    return ism.balanced_spherical_map(*ism.samples.make("dino", n_vertices=3000), balance=0.7)


def targets(brain):
    """Coarser, finer and similar meshes, and another map, whose areas differ much from those of the source."""
    return [regular_mesh(f"ico:{k}") for k in (2, 4, 5, 6)] + [
        ism.spherical_conformal_map(brain.vertices, brain.faces)
    ]


def test_constants_and_integrals_are_kept_on_brains(brain):
    data = np.random.default_rng(0).gamma(2.0, size=(len(brain.sphere), 3))
    for target in targets(brain):
        weights = transfer_matrix(brain, target, method="adaptive-area")
        carried = weights.matrix @ data
        assert weights.matrix.data.min() > 0
        assert np.abs(weights.matrix.sum(axis=1) - 1).max() < 1e-12
        kept = weights.received @ carried / (weights.source_areas @ data) - 1
        assert np.abs(kept).max() < 1e-12
        assert weights.received.min() > 0
        assert np.array_equal(transfer(brain, data, target, method="adaptive-area"), carried)
    # the same surface by its own areas
    assert abs(weights.areas.sum() / weights.source_areas.sum() - 1) < 1e-12


def test_no_vertex_is_left_out(dino):
    """Linear weights on a coarser mesh skip most vertices; these take all."""
    target = regular_mesh("ico:2")
    assert (transfer_matrix(dino, target).matrix.sum(axis=0) == 0).sum() > 1000
    assert (transfer_matrix(dino, target, method="adaptive-area").matrix.sum(axis=0) > 0).all()


def test_a_mesh_to_itself_is_the_identity(dino):
    for method in ("linear", "adaptive-area"):
        matrix = transfer_matrix(dino, dino, method=method).matrix
        assert matrix.nnz == len(dino.sphere)
        assert np.abs(matrix.diagonal() - 1).max() < 1e-14
    weights = transfer_matrix(dino, dino, method="adaptive-area")
    assert np.allclose(weights.received, weights.source_areas, rtol=1e-14)


@pytest.mark.parametrize("method", ["linear", "adaptive-area"])
def test_the_matrix_is_the_transfer(dino, method):
    values = np.random.default_rng(1).normal(size=(len(dino.sphere), 2, 2))
    matrix = transfer_matrix(dino, "ico:3", method=method).matrix
    carried = transfer(dino, values, "ico:3", method=method)
    assert matrix.shape == (642, len(values))
    assert np.allclose(
        (matrix @ values.reshape(-1, 4)).reshape(642, 2, 2), carried, rtol=0, atol=1e-14
    )
    labels = np.random.default_rng(2).integers(0, 9, len(values))
    parts = transfer(dino, labels, "ico:3", labels=True, method=method)
    assert parts.dtype == labels.dtype
    assert np.array_equal(parts, labels[matrix.toarray().argmax(axis=1)])
    assert np.array_equal(
        transfer_matrix(dino, "ico:3", labels=True, method=method).matrix @ labels, parts
    )


def test_vertices_without_area_take_part(dino):
    """The target's surface is a point on half of the sphere: its areas are 0 there, and nothing is divided by them."""
    x, f = regular_mesh("ico:3")
    flat = ism.sphere_map(np.where(x[:, 2:] > 0, x, 0.0), f, x)
    weights = transfer_matrix(dino, flat, method="adaptive-area")
    assert (weights.areas == 0).any()
    assert np.abs(weights.matrix.sum(axis=1) - 1).max() < 1e-12
    assert abs(weights.received.sum() / weights.source_areas.sum() - 1) < 1e-12


def test_refusals(dino):
    values = np.zeros(len(dino.sphere))
    with pytest.raises(ValueError, match="choose linear or adaptive-area"):
        transfer(dino, values, "ico:2", method="nearest")
    with pytest.raises(TypeError, match="needs the faces of the target"):
        transfer(dino, values, dino.sphere, method="adaptive-area")
    with pytest.raises(TypeError, match="give a SphereMap first"):
        transfer(
            ism.SphereLocator(dino.sphere, dino.faces), values, "ico:2", method="adaptive-area"
        )
    for method in ("linear", "adaptive-area"):
        with pytest.raises(ism.MeshError, match="0 values for 3"):
            transfer(dino, [], "ico:2", method=method)


@pytest.mark.skipif(
    shutil.which("wb_command") is None, reason="Connectome Workbench is not installed"
)
@pytest.mark.parametrize("k", [3, 4, 6])
def test_workbench_takes_the_same_weights(brain, k, tmp_path, monkeypatch):
    """Workbench projects to the nearest point of a face, not along the ray, and computes in float32."""
    monkeypatch.chdir(tmp_path)
    x, f = regular_mesh(f"ico:{k}")
    data = np.random.default_rng(3).normal(size=len(brain.sphere))
    surfaces = {"a": brain.vertices, "b": transfer(brain, brain.vertices, x)}
    for name, sphere, faces in (("a", brain.sphere, brain.faces), ("b", x, f)):
        write_mesh(f"{name}.surf.gii", surfaces[name], faces)
        write_mesh(f"{name}.sphere.surf.gii", 100 * sphere, faces)
    write_scalars("data.func.gii", {"data": data}, metadata={"structure": "CortexLeft"})
    subprocess.run(
        [
            "wb_command",
            "-metric-resample",
            "data.func.gii",
            "a.sphere.surf.gii",
            "b.sphere.surf.gii",
            "ADAP_BARY_AREA",
            "out.func.gii",
            "-area-surfs",
            "a.surf.gii",
            "b.surf.gii",
        ],
        check=True,
    )
    theirs = read_scalars("out.func.gii").popitem()[1]
    assert np.abs(theirs - transfer(brain, data, (x, f), method="adaptive-area")).max() < 2e-3
