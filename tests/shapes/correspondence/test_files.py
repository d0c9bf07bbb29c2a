"""Archives of maps between surfaces: all of it comes back, and damage is named."""

from __future__ import annotations

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.io.npz import read_arrays, write_arrays
from igl_spheremap.resampling.locate import Location


@pytest.fixture(scope="module")
def onto():
    a, b = (
        ism.balanced_spherical_map(*ism.samples.make(name, n_vertices=300), balance=1)
        for name in ("pear", "spheroid")
    )
    found = ism.shapes.match(a, b)
    goals = Location(np.array([3, 40]), np.array([[1.0, 0, 0], [0.25, 0.5, 0.25]]))
    return ism.shapes.SurfaceMap(found.map, b, np.array([7, 90]), goals, ("doubtful",))


def test_all_of_it_comes_back(onto, tmp_path):
    ism.shapes.write_surface_map(tmp_path / "onto.npz", onto)
    again = ism.shapes.read_surface_map(tmp_path / "onto.npz")
    for one, other in ((onto.map, again.map), (onto.target, again.target)):
        for name in ("vertices", "faces", "sphere"):
            assert np.array_equal(getattr(one, name), getattr(other, name))
        assert other.certificate.folding_free
        assert one.run.settings == other.run.settings
    assert np.array_equal(again.landmarks, onto.landmarks)
    assert np.array_equal(again.goals.weights, onto.goals.weights)
    assert np.array_equal(again.positions, onto.positions)
    assert np.array_equal(again.landmark_errors, onto.landmark_errors)
    assert again.notes == ("doubtful",)


def test_a_s_map_is_read_from_the_same_file(onto, tmp_path):
    ism.shapes.write_surface_map(tmp_path / "onto.npz", onto)
    assert np.array_equal(ism.read_map(tmp_path / "onto.npz").sphere, onto.map.sphere)
    assert np.array_equal(read_arrays(tmp_path / "onto.npz")["positions"], onto.positions)


def test_a_file_stays_unless_it_may_be_replaced(onto, tmp_path):
    (tmp_path / "onto.npz").write_bytes(b"mine")
    with pytest.raises(ism.FileError):
        ism.shapes.write_surface_map(tmp_path / "onto.npz", onto)
    assert (tmp_path / "onto.npz").read_bytes() == b"mine"
    ism.shapes.write_surface_map(tmp_path / "onto.npz", onto, force=True)
    with pytest.raises(ism.FileError, match=r"\.npz"):
        ism.shapes.write_surface_map(tmp_path / "onto.ply", onto)


@pytest.mark.parametrize(("name", "value"), [
    ("landmarks", np.array([7, 900])), ("landmarks", np.array([[7, 9]])), ("landmarks", np.array([7])),
    ("goal_weights", np.array([[1.0, 0, 0], [2, 0, 0]])), ("goal_faces", np.array([3, 4000])),
    ("target_sphere", np.zeros((5, 3))), ("sphere", np.zeros((5, 3))),
    ("target_faces", np.zeros((5, 3))),
])  # fmt: skip
def test_damage_is_named(onto, tmp_path, name, value):
    ism.shapes.write_surface_map(tmp_path / "onto.npz", onto)
    write_arrays(tmp_path / "onto.npz", read_arrays(tmp_path / "onto.npz") | {name: value})
    with pytest.raises(ism.MeshError, match=r"onto\.npz"):
        ism.shapes.read_surface_map(tmp_path / "onto.npz")


def test_a_sphere_map_is_no_map_between_surfaces(onto, tmp_path):
    ism.write_map(tmp_path / "map.npz", onto.map)
    with pytest.raises(ism.MeshError, match="no map between surfaces"):
        ism.shapes.read_surface_map(tmp_path / "map.npz")
