"""Marks: what made a file from what, found in every format, the same run after run."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from file_names import ALL, needs

import igl_spheremap as ism
from igl_spheremap.io import make_mark, read_mark, read_mesh, write_map, write_mesh

V, F = ism.samples.sphere(42)


@pytest.mark.parametrize("name", ALL)
def test_every_format_keeps_the_mark_of_a_map(name, result, tmp_path):
    needs(name)
    write_map(tmp_path / name, result)
    assert read_mark(tmp_path / name) == make_mark(result.vertices, result.faces, "auto", {})
    write_mesh(tmp_path / f"plain-{name}", V, F)
    assert read_mark(tmp_path / f"plain-{name}") is None


@pytest.mark.parametrize("name", [name for name in ALL if not name.endswith(".npz")])
def test_a_second_run_writes_the_same_bytes(name, tmp_path):
    """Time, host, folder and process leave no trace."""
    needs(name)
    contents = []
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        write_map(tmp_path / folder / name, ism.spherical_conformal_map(V, F))
        contents.append((tmp_path / folder / name).read_bytes())
    assert contents[0] == contents[1]


def test_the_mark_distinguishes_input_method_options_and_version(monkeypatch):
    other = V.copy()
    other[0, 0] = np.nextafter(other[0, 0], 2)
    marks = [make_mark(V, F, "auto", {}), make_mark(other, F, "auto", {}), make_mark(V, F[:, [1, 2, 0]], "auto", {}),
             make_mark(V, F, "lai2014", {}), make_mark(V, F, "auto", {"polish": "angles"}),
             make_mark(V, F, "auto", {"weights": np.arange(3.0)}), make_mark(V, F, "auto", {"weights": np.arange(4.0)}),
             make_mark(V, F, "auto", {"a": "x" * 60}), make_mark(V, F, "auto", {"a": "x" * 61})]
    monkeypatch.setattr("igl_spheremap.io.marks.__version__", "0.0.0")  # nothing else changes a version
    marks.append(make_mark(V, F, "auto", {}))
    assert len(set(marks)) == len(marks)
    assert make_mark(V.astype(">f8"), F.astype(np.int32), "auto", {}) == marks[-1]


@pytest.mark.parametrize("value", [1, "two words", "\n", "<&>", "é", "x" * 500, {"b": [1]}])
def test_a_mark_is_one_short_line_of_ascii_whatever_the_options_are(value, result, tmp_path):
    """An STL header has 80 bytes, and FreeSurfer's programs read 199 bytes of a comment."""
    options = {"a": value}
    mark = make_mark(V, F, "stereographic", options)
    assert len(mark) <= 80
    assert mark.isascii()
    assert mark.isprintable()
    for name in ALL:
        needs(name)
        write_map(tmp_path / name, dataclasses.replace(result, settings=options), force=True)
        found = read_mark(tmp_path / name)
        assert found == make_mark(result.vertices, result.faces, "auto", options)


@pytest.mark.parametrize("name", ["ball.obj", "ball.off", "ball.ply", "ball.stl", "ball.glb"])
def test_other_programs_read_files_with_marks(name, result, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    write_map(tmp_path / name, result)
    other = trimesh.load(tmp_path / name, force="mesh", process=False)
    assert np.allclose(np.asarray(other.vertices)[other.faces], result.sphere[result.faces], atol=1e-6)


@pytest.mark.parametrize("name", ["ball.obj", "ball.off", "ball.ply"])
def test_libigl_reads_files_with_marks(name, result, tmp_path):
    igl = pytest.importorskip("igl")
    write_map(tmp_path / name, result)
    v, f = igl.read_triangle_mesh(str(tmp_path / name))[:2]
    assert np.allclose(v, read_mesh(tmp_path / name).v, atol=1e-9)
    assert np.array_equal(f, result.faces)


def test_freesurfer_s_own_reader_finds_the_mark_as_the_comment(result, tmp_path):
    freesurfer = pytest.importorskip("nibabel.freesurfer")
    write_map(tmp_path / "lh.sphere.conformal", result)
    *_, comment = freesurfer.read_geometry(tmp_path / "lh.sphere.conformal", read_stamp=True)
    assert comment == read_mark(tmp_path / "lh.sphere.conformal")


def test_damaged_files_have_no_mark(tmp_path):
    for name, data in (("a.gii.gz", b"\x1f\x8bxx"), ("a.npz", b"PK"), ("a.obj", b"")):
        (tmp_path / name).write_bytes(data)
        assert read_mark(tmp_path / name) is None
