"""CIFTI-2: each hemisphere has its own maps, the medial wall has none and stays where it is."""

from __future__ import annotations

import numpy as np
import pytest
from other_programs import cifti

import igl_spheremap as ism
from igl_spheremap import FileError, MeshError
from igl_spheremap.apps.cli import main
from igl_spheremap.io.records import Label
from igl_spheremap.io.scalars import read_labels, read_scalars, write_scalars
from igl_spheremap.io.write_mesh import write_mesh

pytest.importorskip("nibabel")
WALL = [3, 5, 8]
N = 42


@pytest.mark.parametrize(
    ("kind", "names"), [("scalar", ["place", "twice"]), ("series", ["0", "1"])]
)
def test_each_side_has_its_maps_and_none_on_the_wall(kind, names, tmp_path):
    path = tmp_path / f"a.d{kind.replace('series', 'tseries')}.nii"
    cifti(N, WALL, kind).to_filename(path)
    for structure, offset in (("CortexLeft", 0), ("CortexRight", 1000)):
        maps = read_scalars(path, structure=structure)
        assert list(maps) == names
        for factor, values in zip((1, 2), maps.values(), strict=True):
            assert np.flatnonzero(np.isnan(values)).tolist() == WALL
            assert np.array_equal(
                np.delete(values, WALL), factor * (offset + np.delete(np.arange(N), WALL))
            )


def test_labels_have_their_table(tmp_path):
    cifti(N, WALL, "label").to_filename(tmp_path / "a.dlabel.nii")
    assert [label.name for label in read_labels(tmp_path / "a.dlabel.nii")] == ["???", "odd"]
    cifti(N, WALL).to_filename(tmp_path / "a.dscalar.nii")
    assert read_labels(tmp_path / "a.dscalar.nii") is None


def test_the_only_side_needs_no_name_and_of_two_one_is_asked_for(tmp_path):
    cifti(N, WALL, structures=("RIGHT",)).to_filename(tmp_path / "one.dscalar.nii")
    assert read_scalars(tmp_path / "one.dscalar.nii")["place"][0] == 1000
    cifti(N, WALL).to_filename(tmp_path / "two.dscalar.nii")
    with pytest.raises(
        MeshError, match="data of CortexLeft, CortexRight, and the mesh does not say"
    ):
        read_scalars(tmp_path / "two.dscalar.nii")
    with pytest.raises(MeshError, match="no data of Cerebellum; it has CortexLeft, CortexRight"):
        read_scalars(tmp_path / "two.dscalar.nii", structure="Cerebellum")
    with pytest.raises(MeshError, match="data over surfaces"):
        ism.read_mesh(tmp_path / "two.dscalar.nii")


def test_what_is_written_is_read(tmp_path):
    values = np.arange(N, dtype=float)
    values[WALL] = np.nan
    for name in ("a.dscalar.nii", "a.dtseries.nii"):
        write_scalars(tmp_path / name, {"0": values}, metadata={"structure": "CortexRight"})
        (found,) = read_scalars(tmp_path / name, structure="CortexRight").values()
        assert np.array_equal(found, values, equal_nan=True)
    table = (Label(0, "none", (0.0, 0.0, 0.0, 0.0)), Label(70000, "V1", (1.0, 0.0, 0.0, 1.0)))
    known = {"structure": "CortexLeft", "labels": table}
    labels = np.where(np.isnan(values), np.nan, 70000.0)
    write_scalars(tmp_path / "a.dlabel.nii", {"areas": labels}, metadata=known)
    assert read_labels(tmp_path / "a.dlabel.nii") == table
    assert np.array_equal(read_scalars(tmp_path / "a.dlabel.nii")["areas"], labels, equal_nan=True)
    with pytest.raises(FileError, match="names the hemisphere"):
        write_scalars(tmp_path / "b.dscalar.nii", {"a": values})
    with pytest.raises(MeshError, match="no table"):
        write_scalars(
            tmp_path / "b.dlabel.nii", {"a": labels}, metadata={"structure": "CortexLeft"}
        )
    assert not list(tmp_path.glob("b.*"))


@pytest.fixture
def desk(tmp_path, monkeypatch):
    """Both hemispheres of a body, and data over them."""
    monkeypatch.chdir(tmp_path)
    v, f = ism.samples.make("pear", n_vertices=300)
    for side, mirror in (("lh", 1), ("rh", -1)):
        faces = f[:, ::mirror]
        write_mesh(f"{side}.white.gii", v * [mirror, 1, 1], faces)
        ism.write_map(f"{side}.sphere.gii", ism.spherical_conformal_map(v * [mirror, 1, 1], faces))
    wall = np.flatnonzero(v[:, 2] < np.quantile(v[:, 2], 0.2))
    for kind in ("scalar", "label"):
        cifti(len(v), wall, kind).to_filename(f"both.d{kind}.nii")
    return len(v), wall


@pytest.mark.parametrize("kind", ["scalar", "label"])
def test_data_of_both_sides_come_to_their_own_sphere_as_they_were(kind, desk):
    words = ["transfer", "{hemi}.white.gii", "{hemi}.sphere.gii", f"out.d{kind}.nii"]
    assert main([*words, "--data", f"both.d{kind}.nii", "--to", "{hemi}.sphere.gii", "-q"]) == 0
    for structure in ("CortexLeft", "CortexRight"):
        before, after = (
            read_scalars(f"{name}.d{kind}.nii", structure=structure) for name in ("both", "out")
        )
        for key, values in before.items():
            assert np.array_equal(values, after[key], equal_nan=True)
    assert read_labels(f"out.d{kind}.nii") == read_labels(f"both.d{kind}.nii")


def test_the_wall_is_as_large_on_a_finer_sphere_and_data_beside_it_are_no_mixture(desk, capsys):
    n, wall = desk
    words = ["lh.white.gii", "lh.sphere.gii", "out.dscalar.nii", "--data", "both.dscalar.nii:place"]
    assert main(["transfer", *words, "--to", "ico:4"]) == 0
    (values,) = read_scalars("out.dscalar.nii").values()
    assert 0.5 < np.isnan(values).mean() / (len(wall) / n) < 2
    known = values[~np.isnan(values)]
    assert known.min() >= 0
    assert known.max() < n
    assert "vertices without data" in capsys.readouterr().out
    words[2] = "out.label.gii"
    words[4] = "both.dlabel.nii"
    assert main(["transfer", *words, "--to", "ico:4", "-q"]) == 0
    (labels,) = read_scalars("out.label.gii").values()
    assert set(labels) == {0, 1}


def test_the_wall_counts_as_0_in_harmonics_and_that_is_said(desk, capsys):
    wall = desk[1]
    words = ["rh.white.gii", "rh.sphere.gii", "out.npz", "--data", "both.dscalar.nii:place"]
    assert main(["harmonics", *words, "--degree", "2", "-q"]) == 0
    assert (
        f"{len(wall)} vertices without data, the medial wall, count as 0" in capsys.readouterr().err
    )


def test_files_that_are_not_cifti_hold_one_side(desk, capsys):
    words = ["transfer", "{hemi}.white.gii", "{hemi}.sphere.gii", "a.shape.gii"]
    assert main([*words, "--data", "both.dscalar.nii", "--to", "ico:3"]) == 64
    assert "both sides go to one CIFTI file" in capsys.readouterr().err
