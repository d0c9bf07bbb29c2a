"""Meshes: written files read back, here and in other programs; one line names damage."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import numpy as np
import pytest
from file_names import ALL, EXACT, ROUNDED, needs

from igl_spheremap import FileError, MeshError, check_mesh, io, samples
from igl_spheremap.io.files import read_mesh
from igl_spheremap.io.formats import FORMATS, READ_ONLY, format_in, format_of
from igl_spheremap.io.write_mesh import write_mesh


@pytest.mark.parametrize("name", EXACT)
def test_exact_formats_keep_every_bit(name, ball, tmp_path):
    v, f = ball
    v = v * np.array([1e-300, 1.0, 1e300]) + np.array([0.0, 1 / 3, 0.0])
    write_mesh(tmp_path / name, v, f)
    mesh = read_mesh(tmp_path / name)
    assert np.array_equal(mesh.v, v)
    assert np.array_equal(mesh.f, f)
    assert mesh.v.dtype == np.float64
    assert mesh.f.dtype == np.int64


@pytest.mark.parametrize("name", [*ROUNDED, "ball.stl"])
@pytest.mark.parametrize("size", [1e39, 1e300, 1e-40, 1e-300])
def test_positions_beyond_float32_are_refused_by_its_formats(name, size, ball, tmp_path):
    """They would be infinite, or all in one place."""
    needs(name)
    v, f = ball
    with pytest.raises(MeshError, match="can't hold positions of size"):
        write_mesh(tmp_path / name, size * v, f)
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("name", ROUNDED)
def test_rounded_formats_keep_float32_and_the_order(name, ball, tmp_path):
    needs(name)
    v, f = ball
    write_mesh(tmp_path / name, v, f)
    mesh = read_mesh(tmp_path / name)
    assert np.array_equal(mesh.v, v.astype(np.float32).astype(np.float64))
    assert np.array_equal(mesh.f, f)
    assert mesh.v.dtype.isnative
    assert mesh.f.dtype == np.int64


@pytest.mark.parametrize("name", [*EXACT[:3], "ball.stl", *ROUNDED[:2]])
def test_other_programs_read_what_is_written(name, ball, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    v, f = ball
    write_mesh(tmp_path / name, v, f)
    other = trimesh.load(tmp_path / name, force="mesh", process=False)
    assert np.allclose(np.asarray(other.vertices)[np.asarray(other.faces)], v[f], atol=1e-6)


@pytest.mark.parametrize("name", ["ball.obj", "ball.off", "ball.ply"])
def test_meshio_reads_and_is_read(name, ball, tmp_path):
    meshio = pytest.importorskip("meshio")
    v, f = ball
    write_mesh(tmp_path / name, v, f)
    other = meshio.read(tmp_path / name)
    assert np.allclose(other.points, v, atol=1e-12)
    assert np.array_equal(other.cells_dict["triangle"], f)
    meshio.write(tmp_path / f"other-{name}", meshio.Mesh(v, [("triangle", f)]))
    back = read_mesh(tmp_path / f"other-{name}")
    assert np.allclose(back.v, v, atol=1e-6)
    assert np.array_equal(back.f, f)


def test_the_same_run_writes_the_same_bytes(ball, tmp_path):
    for name in ALL:
        needs(name)
        write_mesh(tmp_path / name, *ball)
        first = (tmp_path / name).read_bytes()
        write_mesh(tmp_path / name, *ball, force=True)
        assert (tmp_path / name).read_bytes() == first


def mesh_bytes(name, tmp_path, ball):
    needs(name)
    write_mesh(tmp_path / name, *ball)
    data = (tmp_path / name).read_bytes()
    (tmp_path / name).unlink()
    return data


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("damage", ["empty", "half", "noise", "tail"])
def test_damaged_files_give_one_line(name, damage, ball, tmp_path, capfd):
    data = mesh_bytes(name, tmp_path, ball)
    noise = np.random.default_rng(1).integers(0, 256, 3000, dtype=np.uint8).tobytes()
    broken = {
        "empty": b"",
        "half": data[: len(data) // 2],
        "noise": noise,
        "tail": data[:300] + noise,
    }[damage]
    (tmp_path / name).write_bytes(broken)
    with pytest.raises(MeshError) as caught:
        # half a text file may be a mesh, but not a closed one
        check_mesh(*read_mesh(tmp_path / name))
    assert "\n" not in str(caught.value)
    assert capfd.readouterr() == ("", "")


def test_unknown_and_missing(tmp_path):
    with pytest.raises(FileError, match="No such file"):
        read_mesh(tmp_path / "none.obj")
    with pytest.raises(FileError, match="directory"):
        read_mesh(tmp_path)
    (tmp_path / "mesh.doc").write_text("hello")
    with pytest.raises(
        FileError, match=r"unknown format.*OBJ \(.obj\).*glTF \(.glb, .gltf\).*FreeSurfer \(.pial, "
    ):
        read_mesh(tmp_path / "mesh.doc")
    with pytest.raises(FileError, match="unknown format"):
        write_mesh(tmp_path / "out.xyz", np.zeros((3, 3)), [[0, 1, 2]])


@pytest.mark.parametrize(
    ("module", "name", "extra"),
    [("nibabel", "a.gii", "io"), ("nibabel", "lh.pial", "io"), ("trimesh", "a.glb", "io")],
)
def test_a_missing_package_is_named(module, name, extra, ball, tmp_path, monkeypatch):
    """With a command that installs it, from a clone of this package, too."""
    for known in [key for key in sys.modules if key.partition(".")[0] == module]:
        monkeypatch.setitem(sys.modules, known, None)
    monkeypatch.setitem(sys.modules, module, None)
    hint = rf" \(the extra '{extra}' of igl_spheremap" if extra else "$"
    with pytest.raises(FileError, match=rf"needs {module}, .*: pip install {module}{hint}"):
        write_mesh(tmp_path / name, *ball)
    assert os.listdir(tmp_path) == []


def test_faces_of_another_shape_are_refused_and_not_cut_anew(ball, tmp_path):
    v, f = ball
    for faces in (np.column_stack([f, f])[:3], f + 0.5, f.ravel()):
        with pytest.raises(MeshError, match="faces"):
            write_mesh(tmp_path / "ball.obj", v, faces)
    assert list(tmp_path.iterdir()) == []


def test_every_format_is_in_the_table_once():
    suffixes = [suffix for entry in FORMATS for suffix in entry.suffixes]
    assert len(suffixes) == len(set(suffixes))
    package = Path(io.__file__).parent
    texts = {path.stem: path.read_text("utf-8") for path in package.glob("*.py")}
    readers = {name for name, text in texts.items() if "\ndef read(" in text}
    assert readers == {entry.module for entry in FORMATS}
    for entry in FORMATS:
        if "\ndef write(" not in texts[entry.module]:
            assert {*entry.suffixes} <= {*READ_ONLY}


def test_files_without_a_telling_name_are_known_by_their_first_bytes(ball, tmp_path):
    for name in (
        "ball.off",
        "ball.ply",
        "ball.npz",
        "ball.glb",
        "ball.surf.gii",
        "ball.surf.gii.gz",
        "lh.sphere",
    ):
        needs(name)
        write_mesh(tmp_path / name, *ball)
        (tmp_path / name).rename(tmp_path / "mystery")
        assert format_in(tmp_path / "mystery") is format_of(name)
        assert len(read_mesh(tmp_path / "mystery").f) == len(ball[1])
        (tmp_path / "mystery").unlink()


def test_names_of_results_are_known_and_not_those_of_freesurfer_s_own_files():
    for name in ("lh.sphere.conformal", "rh.sphere.balanced", "lh.sphere.balanced.reg"):
        assert format_of(name).name == "FreeSurfer"
        assert name.removeprefix("lh.").removeprefix("rh.") not in ("sphere", "sphere.reg")
    for name in ("lh.on_right", "rh.my.sphere.v2", "surf/rh.left.reg.2"):
        assert format_of(name).name == "FreeSurfer"


def test_a_part_is_of_the_file_that_is_there(tmp_path, monkeypatch):
    """Whatever its name, size and time: also of a file that replaces another one, and in another folder."""
    v, f = samples.sphere(12)
    for k, folder in enumerate(("a", "b")):
        (tmp_path / folder).mkdir()
        monkeypatch.chdir(tmp_path / folder)
        write_mesh("two.off", np.vstack((v, v + 4 + k)), np.vstack((f, f + 12)))
        os.utime("two.off", (1e9, 1e9))
        assert np.allclose(read_mesh("two.off:1").v, v + 4 + k)
    write_mesh("two.off", np.vstack((v, v + 6)), np.vstack((f, f + 12)), force=True)
    os.utime("two.off", (1e9, 1e9))
    assert np.allclose(read_mesh("two.off:1").v, v + 6)
