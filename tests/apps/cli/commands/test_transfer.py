"""`igl-spheremap transfer`: the result of `ism.transfer`, in a file."""

import json
from pathlib import Path

import numpy as np
import pytest
from file_names import NAMED, PLACED
from scipy.sparse import csr_array, load_npz
from shell import one_line

import igl_spheremap as ism
from igl_spheremap.apps.cli import main
from igl_spheremap.io.records import Label
from igl_spheremap.io.scalars import read_scalars, write_scalars
from igl_spheremap.io.write_mesh import write_mesh
from igl_spheremap.resampling.transfer import regular_mesh


@pytest.fixture
def desk(tmp_path, monkeypatch):
    """A surface, its map, and two scalar maps over it."""
    monkeypatch.chdir(tmp_path)
    result = ism.spherical_conformal_map(*ism.samples.make("pear", n_vertices=600))
    write_mesh("pear.ply", result.vertices, result.faces)
    write_mesh("sphere.ply", 3 * result.sphere, result.faces)
    height = result.vertices[:, 2]
    write_scalars("data.npz", {"height": height, "part": (height > 0).astype(float)})
    return result


def test_data_go_to_a_regular_sphere(desk, capsys):
    assert (
        main(
            ["transfer", "pear.ply", "sphere.ply", "out.npz", "--data", "data.npz", "--to", "ico:2"]
        )
        == 0
    )
    assert "height, -" in capsys.readouterr().out
    carried = read_scalars("out.npz")
    expected = ism.transfer(desk, desk.vertices[:, 2], regular_mesh("ico:2")[0])
    assert np.allclose(carried["height"], expected, atol=1e-9)


@pytest.mark.parametrize("name", [*NAMED, *PLACED])
def test_plain_arrays_go_in_and_out_as_archives_do(desk, name):
    height = desk.vertices[:, 2]
    write_scalars(name, {"height": height, "more": -height}, surface=(desk.vertices, desk.faces))
    column = "0" if name in PLACED else "height"
    words = ["transfer", "pear.ply", "sphere.ply", "--to", "ico:1", "-q"]
    assert main([*words, "expected.npz", "--data", "data.npz:height"]) == 0
    assert main([*words, f"out.{name}", "--data", f"{name}:{column}"]) == 0
    (carried,) = read_scalars(f"out.{name}").values()
    assert np.array_equal(carried, read_scalars("expected.npz")["height"])


def test_data_of_another_mesh_are_named_with_both_counts(desk, capsys):
    np.savetxt("short.csv", [1, 2, 3])
    assert main(["transfer", "pear.ply", "sphere.ply", "out.npz", "--data", "short.csv"]) == 2
    assert f"short.csv: 0 has 3 values but pear.ply has {len(desk.vertices)} vertices" in one_line(
        capsys
    )


def test_labels_stay_labels_on_another_map(desk):
    other = ism.spherical_conformal_map(*ism.samples.make("pear", n_vertices=400))
    write_mesh("other.ply", other.sphere, other.faces)
    words = [
        "transfer",
        "pear.ply",
        "sphere.ply",
        "out.npz",
        "--data",
        "data.npz:part",
        "--to",
        "other.ply",
    ]
    assert main([*words, "--labels", "-q"]) == 0
    ((name, carried),) = read_scalars("out.npz").items()
    assert name == "part"
    assert len(carried) == len(other.sphere)
    assert set(carried) == {0.0, 1.0}
    # the maps share the frame of their gauge
    assert ((other.vertices[:, 2] > 0) == carried).mean() > 0.97


@pytest.mark.parametrize(
    ("words", "status"),
    [
        (["out.xlsx"], 74),
        (["out.npz", "--to", "ico:99"], 64),
        (["data.npz", "-f"], 64),
        (["sphere.ply", "-f"], 64),
        (["out.npz", "--matrix", "matrix.csv"], 64),
        (["out.npz", "--matrix", "data.npz", "-f"], 64),
        (["out.npz", "--matrix", "no/matrix.npz"], 74),
    ],
)
@pytest.mark.parametrize("data", ["data.npz", "data.npz:part"])
def test_failures_are_one_line(desk, words, status, data, capsys):
    assert main(["transfer", "pear.ply", "sphere.ply", *words, "--data", data]) == status
    assert capsys.readouterr().err.count("\n") == 1


def test_the_matrix_is_written_as_nitransforms_keeps_it(desk):
    """Sources by targets: `values @ matrix`, what was read there."""
    words = [
        "transfer",
        "pear.ply",
        "sphere.ply",
        "out.npz",
        "--data",
        "data.npz:height",
        "--to",
        "ico:2",
    ]
    assert (
        main(
            [
                *words,
                "--matrix",
                "matrix.npz",
                "--method",
                "adaptive-area",
                "-q",
                "--json",
                "out.json",
            ]
        )
        == 0
    )
    matrix = load_npz("matrix.npz")
    assert isinstance(matrix, csr_array)
    assert matrix.shape == (len(desk.sphere), 162)
    height = desk.vertices[:, 2]
    assert np.allclose(height @ matrix, read_scalars("out.npz")["height"], atol=1e-12)
    again = ism.transfer(desk, height, "ico:2", method="adaptive-area")
    # the file holds the sphere at three times its size
    assert np.allclose(height @ matrix, again, atol=1e-12)
    figures = json.loads(Path("out.json").read_text())["integrals"]["height"]
    assert abs(figures["received"] - figures["source"]) < 1e-12
    words[5] = "data.npz:part"
    assert main([*words, "-f", "--matrix", "labels.npz", "--labels", "-q"]) == 0
    assert set(load_npz("labels.npz").data) == {1.0}


def test_nitransforms_takes_the_matrix(desk):
    surface = pytest.importorskip("nitransforms.surface")
    words = [
        "transfer",
        "pear.ply",
        "sphere.ply",
        "out.npz",
        "--data",
        "data.npz:height",
        "--to",
        "ico:2",
    ]
    assert main([*words, "--matrix", "matrix.npz", "-q"]) == 0
    here, there = (
        surface.SurfaceMesh.from_arrays(100 * x, f)
        for x, f in ((desk.sphere, desk.faces), regular_mesh("ico:2"))
    )
    resampler = surface.SurfaceResampler(there, here, mat=load_npz("matrix.npz"))
    assert np.allclose(
        resampler.apply(desk.vertices[:, 2]), read_scalars("out.npz")["height"], atol=1e-12
    )


@pytest.mark.parametrize("hemisphere", ["lh", "rh"])
def test_labels_keep_their_table_and_hemisphere(desk, hemisphere):
    """An annotation to a GIFTI file and back to an annotation, as labels without being asked for it."""
    nibabel = pytest.importorskip("nibabel")
    table = (Label(0, "below", (0.0, 0.0, 0.0, 1.0)), Label(1, "above", (1.0, 0.0, 0.0, 1.0)))
    write_scalars(
        f"{hemisphere}.parts.annot", {"parts": desk.vertices[:, 2] > 0}, metadata={"labels": table}
    )
    write_mesh(f"{hemisphere}.white", desk.vertices, desk.faces)
    words = ["transfer", f"{hemisphere}.white", "sphere.ply", "--to", "sphere.ply", "-q"]
    assert (
        main([*words, f"{hemisphere}.parts.label.gii", "--data", f"{hemisphere}.parts.annot"]) == 0
    )
    image = nibabel.load(f"{hemisphere}.parts.label.gii")
    assert (
        image.meta["AnatomicalStructurePrimary"]
        == {"lh": "CortexLeft", "rh": "CortexRight"}[hemisphere]
    )
    assert image.darrays[0].intent == nibabel.nifti1.intent_codes["NIFTI_INTENT_LABEL"]
    assert (
        main([*words, f"{hemisphere}.again.annot", "--data", f"{hemisphere}.parts.label.gii:parts"])
        == 0
    )
    assert (
        Path(f"{hemisphere}.again.annot").read_bytes()
        == Path(f"{hemisphere}.parts.annot").read_bytes()
    )


def test_labels_are_whole_numbers(desk, capsys):
    words = [
        "transfer",
        "pear.ply",
        "sphere.ply",
        "out.npz",
        "--data",
        "data.npz:height",
        "--labels",
    ]
    assert main(words) == 2
    assert "whole numbers" in capsys.readouterr().err
    assert not Path("out.npz").exists()
