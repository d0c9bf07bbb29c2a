"""What is written is certified as written."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from file_names import needs

from igl_spheremap import FileError, angle_differences, samples, spherical_conformal_map
from igl_spheremap.io import certify_radius, read_mesh, read_sphere, write_map
from igl_spheremap.untangle.rounding import Float32Map
from igl_spheremap.verify.certificate import certify


@pytest.mark.parametrize(
    ("name", "radius"),
    [("s.obj", 1), ("s.ply", 1), ("s.npz", 1), ("lh.sphere", 100), ("s.surf.gii", 100), ("s.stl", 1)],
)
def test_a_map_is_certified_as_written(name, radius, result, tmp_path):
    needs(name)
    check = write_map(tmp_path / name, result)
    assert check.certificate.folding_free
    assert check.radius == pytest.approx(radius, rel=1e-6)
    x, f = read_sphere(tmp_path / name)
    assert certify(x / np.linalg.norm(x, axis=1)[:, None], f).folding_free


@pytest.fixture
def tiny(result):
    """A certified map with one edge of 1e-10, which float32 can't hold."""
    x = result.sphere.copy()
    i, j = result.faces[0, :2]
    x[j] = x[i] + 1e-9 * (x[j] - x[i])
    x /= np.linalg.norm(x, axis=1)[:, None]
    certificate = certify(x, result.faces)
    assert certificate.folding_free
    return dataclasses.replace(result, sphere=x, certificate=certificate)


def plainly(x, f, radius=1.0, v=None):
    """Rounding to float32 that repairs nothing."""
    positions = (radius * x).astype(np.float32)
    return Float32Map(positions, certify(x, f), np.empty(0, dtype=np.int64))


def test_float32_folds_are_seen(tiny, tmp_path, monkeypatch):
    pytest.importorskip("nibabel")
    monkeypatch.setattr("igl_spheremap.io.written_map.certified_float32", plainly)
    assert not write_map(tmp_path / "s.surf.gii", tiny).certificate.folding_free
    assert write_map(tmp_path / "s.obj", tiny).certificate.folding_free
    with pytest.raises(FileError, match="too coarse"):
        write_map(tmp_path / "s.stl", tiny)
    assert not (tmp_path / "s.stl").exists()


@pytest.mark.parametrize("name", ["s.surf.gii", "lh.sphere", "s.stl", "s.glb"])
def test_float32_folds_are_repaired_in_the_file(name, tiny, tmp_path):
    needs(name)
    check = write_map(tmp_path / name, tiny)
    assert check.certificate.folding_free
    assert 0 < check.moved < 20
    if not name.endswith(".stl"):
        x, f = read_sphere(tmp_path / name)
        assert np.array_equal(f, tiny.faces)
        shift = np.linalg.norm(x / check.radius - tiny.sphere, axis=1)
        assert (shift > 1e-6).sum() <= check.moved


def test_nothing_is_moved_where_rounding_folds_nothing(result, tmp_path):
    pytest.importorskip("nibabel")
    assert write_map(tmp_path / "lh.sphere", result).moved == 0
    x, _ = read_sphere(tmp_path / "lh.sphere")
    assert np.array_equal(x, (100 * result.sphere).astype(np.float32))


def test_a_unit_sphere_has_radius_one_to_the_last_digit():
    x, f = samples.make("sphere", n_vertices=200)
    assert certify_radius(x * (1 + 1e-15), f).radius == 1
    assert certify_radius(100 * x, f).radius == pytest.approx(100)


def test_limbs_too_narrow_for_float32_are_stretched_with_hardly_a_loss_in_angles(tmp_path):
    v, f = samples.make("octopus", n_vertices=3000, arm_length=3.0)
    result = spherical_conformal_map(v, f)
    path = tmp_path / "map.surf.gii"
    check = write_map(path, result)
    assert check.certificate.folding_free
    assert check.moved > 100
    assert np.abs(angle_differences(v, f, read_mesh(path).v)).mean() < 1.3 * np.abs(result.angle_differences()).mean()
