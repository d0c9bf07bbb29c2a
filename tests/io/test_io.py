"""Files: what is written reads back, here and in other programs; what is damaged is named in one line."""

from __future__ import annotations

import dataclasses
import os
import struct
import sys
from pathlib import Path

import numpy as np
import pytest

from igl_spheremap import FileError, MeshError, check_mesh, samples, spherical_conformal_map
from igl_spheremap import io as meshio_here
from igl_spheremap.io import FORMATS, certify_radius, format_of, read_map, read_mesh, read_sphere, write_map, write_mesh
from igl_spheremap.io.polygons import Polygons
from igl_spheremap.untangle.rounding import Float32Map
from igl_spheremap.verify.certificate import certify

EXACT = ("ball.obj", "ball.off", "ball.ply", "ball.npz")
ROUNDED = ("ball.glb", "ball.gltf", "ball.surf.gii", "ball.surf.gii.gz", "lh.sphere")


def needs(name: str) -> None:
    for suffix, module in ((".gl", "trimesh"), (".gii", "nibabel"), (".sphere", "nibabel")):
        if suffix in name:
            pytest.importorskip(module)


@pytest.fixture(scope="module")
def ball() -> tuple[np.ndarray, np.ndarray]:
    """Unit rows that need all their digits."""
    v, f = samples.sphere(162)
    turned = v @ np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    return turned, f


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


@pytest.mark.parametrize("binary", [True, False])
def test_stl_is_welded_in_order_of_appearance(binary, ball, tmp_path):
    v, f = ball
    path = tmp_path / "ball.stl"
    if binary:
        write_mesh(path, v, f)
    else:
        corners = "\n".join(
            "outer loop\n"
            + "\n".join("vertex {!r} {!r} {!r}".format(*v[i].tolist()) for i in face)
            + "\nendloop"
            for face in f
        )
        path.write_text(f"solid ball\n{corners}\nendsolid ball\n")
    mesh = read_mesh(path)
    assert mesh.v.shape == v.shape
    assert np.allclose(mesh.v[mesh.f], v[f], atol=1e-7)
    assert mesh.f[0].tolist() == [0, 1, 2]


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


@pytest.mark.parametrize("binary", [True, False])
def test_ply_of_another_program_with_colours(binary, ball, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    v, f = ball
    mesh = trimesh.Trimesh(v, f, process=False, vertex_colors=np.full((len(v), 4), 77, dtype=np.uint8))
    mesh.export(tmp_path / "ball.ply", encoding="binary" if binary else "ascii")
    back = read_mesh(tmp_path / "ball.ply")
    assert np.allclose(back.v, v, atol=1e-6)
    assert np.array_equal(back.f, f)


def test_gifti_keeps_structure_and_coordinate_system(ball, tmp_path):
    nibabel = pytest.importorskip("nibabel")
    v, f = ball
    xform = np.diag([2.0, 3.0, 4.0, 1.0])
    points = nibabel.gifti.GiftiDataArray(
        v.astype(np.float32),
        "NIFTI_INTENT_POINTSET",
        coordsys=nibabel.gifti.GiftiCoordSystem(dataspace=1, xformspace=4, xform=xform),
        meta=nibabel.gifti.GiftiMetaData(AnatomicalStructurePrimary="CortexLeft"),
    )
    triangles = nibabel.gifti.GiftiDataArray(f.astype(np.int32), "NIFTI_INTENT_TRIANGLE")
    nibabel.save(nibabel.gifti.GiftiImage(darrays=[points, triangles]), tmp_path / "in.surf.gii")
    mesh = read_mesh(tmp_path / "in.surf.gii")
    write_mesh(tmp_path / "out.surf.gii", mesh.v, mesh.f, metadata=mesh.metadata)
    out = nibabel.load(tmp_path / "out.surf.gii").darrays[0]
    assert out.meta["AnatomicalStructurePrimary"] == "CortexLeft"
    assert (out.coordsys.dataspace, out.coordsys.xformspace) == (1, 4)
    assert np.array_equal(out.coordsys.xform, xform)


def test_freesurfer_keeps_the_volume_geometry_and_is_big_endian(ball, tmp_path):
    freesurfer = pytest.importorskip("nibabel.freesurfer")
    v, f = ball
    volume = {
        "head": np.array([2, 0, 20]),
        "valid": "1  # volume info valid",
        "filename": "orig.mgz",
        "volume": np.array([256, 256, 256]),
        "voxelsize": np.array([1.0, 1.0, 1.0]),
        "xras": np.array([-1.0, 0, 0]),
        "yras": np.array([0, 0, -1.0]),
        "zras": np.array([0, 1.0, 0]),
        "cras": np.array([1.0, 2.0, 3.0]),
    }
    freesurfer.write_geometry(tmp_path / "lh.pial", v, f, volume_info=volume)
    mesh = read_mesh(tmp_path / "lh.pial")
    write_mesh(tmp_path / "lh.sphere", mesh.v, mesh.f, metadata=mesh.metadata)
    _, _, kept = freesurfer.read_geometry(tmp_path / "lh.sphere", read_metadata=True)
    assert np.array_equal(kept["cras"], volume["cras"])
    assert (tmp_path / "lh.sphere").read_bytes()[:3] == b"\xff\xff\xfe"


def test_the_same_run_writes_the_same_bytes(ball, tmp_path):
    for name in (*EXACT[:3], "ball.stl", "ball.gii.gz", "lh.sphere"):
        needs(name)
        write_mesh(tmp_path / name, *ball)
        first = (tmp_path / name).read_bytes()
        write_mesh(tmp_path / name, *ball, force=True)
        assert (tmp_path / name).read_bytes() == first


# What is written is certified as written


@pytest.fixture(scope="module")
def result():
    return spherical_conformal_map(*samples.make("spheroid", n_vertices=600))


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
    """Rounding to float32 that mends nothing."""
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
def test_float32_folds_are_mended_in_the_file(name, tiny, tmp_path):
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


def test_a_map_comes_back_whole(result, tmp_path):
    write_map(tmp_path / "map.npz", result)
    back = read_map(tmp_path / "map.npz")
    for name in ("vertices", "faces", "sphere"):
        assert np.array_equal(getattr(back, name), getattr(result, name))
        assert getattr(back, name).dtype == getattr(result, name).dtype
    for name in (
        "energy",
        "status",
        "iterations",
        "seconds",
        "method",
        "backend",
        "notes",
        "rounds",
        "settings",
    ):
        assert getattr(back, name) == getattr(result, name), name
    assert repr(back.history) == repr(result.history)  # NaN residuals are equal as text only
    assert str(back.certificate) == str(result.certificate)
    assert np.array_equal(read_mesh(tmp_path / "map.npz").v, result.vertices)
    assert np.array_equal(read_sphere(tmp_path / "map.npz").v, result.sphere)


def test_archives_that_hold_no_map(tmp_path):
    np.savez(tmp_path / "other.npz", a=np.arange(3))
    with pytest.raises(MeshError, match="no map"):
        read_map(tmp_path / "other.npz")
    with pytest.raises(MeshError, match="'vertices' and 'faces' but: a"):
        read_mesh(tmp_path / "other.npz")
    with pytest.raises(FileError, match="No such file"):
        read_map(tmp_path / "none.npz")


# Meaning that readers must not lose


def obj(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "mesh.obj"
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    "faces",
    [
        "f 1 2 3",
        "f 1/1 2/2 3/3",
        "f 1//1 2//2 3//3",
        "f -3 -2 -1",
        "f 1/1/1 \\\n 2/2/2 3/3/3",
        "  f 1 2 3 # done",
        "vt 0 0\nvn 0 0 1\ng part\nusemtl red\nf 1 2 3\nl 1 2",
    ],
)
def test_obj_dialects(faces, tmp_path):
    mesh = read_mesh(obj(tmp_path, f"# head\nv 0 0 0 1\r\nv 1 0 0 1 0 0\nv\t0 1e0 0\n{faces}\n"))
    assert mesh.v.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    assert mesh.f.tolist() == [[0, 1, 2]]


def test_negative_obj_indices_count_from_where_they_stand(tmp_path):
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 0 0 1\nf -4 -1 -2\n"
    assert read_mesh(obj(tmp_path, text)).f.tolist() == [[0, 1, 2], [0, 3, 2]]


@pytest.mark.parametrize("head", ["OFF\n3 1 0", "OFF 3 1 0", "# c\nCOFF\n3 1 3", "3 1 0", "OFF\n# c\n\n3 1"])
def test_off_dialects(head, tmp_path):
    (tmp_path / "mesh.off").write_text(
        f"{head}\n0 0 0 255 0 0\n1 0 0 255 0 0\n\n0 1 0 255 0 0\n3 0 1 2 9 9 9\n"
    )
    mesh = read_mesh(tmp_path / "mesh.off")
    assert mesh.v.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    assert mesh.f.tolist() == [[0, 1, 2]]


def test_not_finite_coordinates_reach_the_gate(tmp_path):
    mesh = read_mesh(obj(tmp_path, "v 0 nan 0\nv inf 0 0\nv 0 -INF 0\nf 1 2 3\n"))
    assert np.isnan(mesh.v[0, 1])
    assert np.isinf(mesh.v[[1, 2], [0, 1]]).all()


@pytest.mark.parametrize("order", ["<", ">"])
def test_ply_of_either_byte_order_with_more_than_a_mesh(order, tmp_path):
    encoding = "binary_little_endian" if order == "<" else "binary_big_endian"
    head = (
        f"ply\nformat {encoding} 1.0\ncomment c\nelement vertex 4\nproperty float x\nproperty uchar red\n"
        "property float y\nproperty float z\nelement face 3\nproperty uchar flag\n"
        "property list uchar int vertex_index\nproperty list uchar float texcoord\nend_header\n"
    )
    v = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    body = b"".join(struct.pack(f"{order}fBff", p[0], 7, p[1], p[2]) for p in v)
    for corners, texture in (((0, 1, 2), 2), ((0, 1, 2, 3), 0), ((3, 2, 1), 1)):
        body += struct.pack(
            f"{order}BB{len(corners)}iB{texture}f", 1, len(corners), *corners, texture, *[0.5] * texture
        )
    (tmp_path / "mesh.ply").write_bytes(head.encode() + body)
    mesh = read_mesh(tmp_path / "mesh.ply", triangulate=True)
    assert np.array_equal(mesh.v, v)
    assert mesh.f.tolist() == [[0, 1, 2], [0, 1, 2], [0, 2, 3], [3, 2, 1]]
    assert mesh.triangulated == 1


def test_polygons_are_refused_unless_asked(tmp_path):
    path = obj(tmp_path, "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 2 3 4\n")
    with pytest.raises(
        MeshError, match=r"faces are not triangles: 1 of 2 .* face 1 with 4; triangulate .*triangulate=True"
    ):
        read_mesh(path)
    assert read_mesh(path, triangulate=True).f.tolist() == [[0, 1, 2], [0, 1, 2], [0, 2, 3]]


def test_fans_of_any_size():
    sizes = np.array([3, 5, 4, 3])
    f = Polygons(np.arange(15), sizes).triangles(triangulate=True)
    slow = [
        [start, start + k, start + k + 1]
        for start, size in zip(np.cumsum(sizes) - sizes, sizes, strict=True)
        for k in range(1, size - 1)
    ]
    assert f.tolist() == slow


# Damage


def mesh_bytes(name: str, tmp_path: Path, ball) -> bytes:
    needs(name)
    write_mesh(tmp_path / name, *ball)
    data = (tmp_path / name).read_bytes()
    (tmp_path / name).unlink()
    return data


@pytest.mark.parametrize("name", [*EXACT, *ROUNDED, "ball.stl"])
@pytest.mark.parametrize("damage", ["empty", "half", "noise", "tail"])
def test_damaged_files_give_one_line(name, damage, ball, tmp_path, capfd):
    data = mesh_bytes(name, tmp_path, ball)
    noise = np.random.default_rng(1).integers(0, 256, 3000, dtype=np.uint8).tobytes()
    broken = {"empty": b"", "half": data[: len(data) // 2], "noise": noise, "tail": data[:300] + noise}[
        damage
    ]
    (tmp_path / name).write_bytes(broken)
    with pytest.raises(MeshError) as caught:
        check_mesh(*read_mesh(tmp_path / name))  # half a text file may be a mesh, but not a closed one
    assert "\n" not in str(caught.value)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.obj", "v 0 0\nf 1 2 3\n", "vertex 0 reads '0 0'"),
        ("a.obj", "v 0 0 0\nv 1 x 0\n", "vertex 1 reads '1 x 0'"),
        ("a.obj", "v 0 0 0\nf 1 2 c\n", "face 0 reads '1 2 c'"),
        ("a.obj", "v 0 0 0\nf 1 2 99999999999999999999\n", "face 0 reads"),
        ("a.obj", "v 0 0 0\nf 1 2\n", "not triangles"),
        ("a.off", "OFF\n8 6 0\n0 0 0\n", "1 lines follow"),
        ("a.off", "OFF BINARY\n", "no OFF header"),
        ("a.off", "OFF\n1 1 0\n0 0 0\n3 0 0\n", "as many whole numbers"),
        ("a.off", "OFF\n999999999999 6 0\n0 0 0\n", "1 lines follow"),
        (
            "a.ply",
            "ply\nformat ascii 1.0\nelement vertex 999999999999\nproperty float x\nproperty float y\n"
            "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n",
            "cut off",
        ),
        (
            "a.ply",
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n",
            "no face element",
        ),
        ("a.ply", "ply\nformat morse 1.0\nend_header\n", "unknown PLY encoding"),
        ("a.ply", "ply\nformat ascii 1.0\nelement vertex many\nend_header\n", "makes no sense"),
        ("a.stl", "solid a\nvertex 0 0 0\nvertex 1 0 0\n", "cut off"),
        ("a.stl", "no triangles here", "neither text STL nor binary"),
    ],
)
def test_the_fault_is_named(name, text, words, tmp_path):
    (tmp_path / name).write_text(text)
    with pytest.raises(MeshError, match=words):
        read_mesh(tmp_path / name)


def test_a_scalar_map_is_no_surface(tmp_path):
    nibabel = pytest.importorskip("nibabel")
    data = nibabel.gifti.GiftiDataArray(np.zeros(5, dtype=np.float32), "NIFTI_INTENT_SHAPE")
    nibabel.save(nibabel.gifti.GiftiImage(darrays=[data]), tmp_path / "a.shape.gii")
    with pytest.raises(MeshError, match="no surface"):
        read_mesh(tmp_path / "a.shape.gii")


# Files and folders


def test_unknown_and_missing(tmp_path):
    with pytest.raises(FileError, match="No such file"):
        read_mesh(tmp_path / "none.obj")
    with pytest.raises(FileError, match="directory"):
        read_mesh(tmp_path)
    (tmp_path / "mesh.xyz").write_text("hello")
    with pytest.raises(FileError, match=r"unknown format.*OBJ \(.obj\)"):
        read_mesh(tmp_path / "mesh.xyz")
    with pytest.raises(FileError, match="unknown format"):
        write_mesh(tmp_path / "out.xyz", np.zeros((3, 3)), [[0, 1, 2]])


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
        assert format_of(tmp_path / "mystery") is format_of(name)
        (tmp_path / "mystery").unlink()


def test_nothing_is_overwritten_without_force(ball, tmp_path):
    path = tmp_path / "ball.obj"
    path.write_text("precious")
    with pytest.raises(FileError, match="exists already"):
        write_mesh(path, *ball)
    assert path.read_text() == "precious"
    path.chmod(0o640)
    write_mesh(path, *ball, force=True)
    assert path.stat().st_mode & 0o777 == 0o640
    assert os.listdir(tmp_path) == ["ball.obj"]


def test_links_are_followed(ball, tmp_path):
    (tmp_path / "store").mkdir()
    (tmp_path / "store" / "real.obj").write_text("old")
    (tmp_path / "link.obj").symlink_to(tmp_path / "store" / "real.obj")
    write_mesh(tmp_path / "link.obj", *ball, force=True)
    assert (tmp_path / "link.obj").is_symlink()
    assert np.array_equal(read_mesh(tmp_path / "store" / "real.obj").v, ball[0])


@pytest.mark.parametrize("name", [*EXACT, *ROUNDED, "ball.stl"])
def test_a_full_disk_leaves_nothing_behind(name, ball, tmp_path, monkeypatch):
    """The temporary file is a link to a device that is always full."""
    needs(name)
    if not Path("/dev/full").exists():
        pytest.skip("no /dev/full")
    partial = tmp_path / f".part-{os.getpid()}-{name}"
    partial.symlink_to("/dev/full")
    with pytest.raises(FileError, match="No space left"):
        write_mesh(tmp_path / name, *ball)
    assert os.listdir(tmp_path) == []


def test_a_failed_rename_leaves_nothing_behind(ball, tmp_path, monkeypatch):
    def refuse(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(os, "replace", refuse)
    with pytest.raises(FileError, match="Permission denied"):
        write_mesh(tmp_path / "ball.obj", *ball)
    assert os.listdir(tmp_path) == []


def test_no_folder_and_no_file(ball, tmp_path):
    with pytest.raises(FileError, match="no folder"):
        write_mesh(tmp_path / "nowhere" / "ball.obj", *ball)
    (tmp_path / "folder.obj").mkdir()
    with pytest.raises(FileError, match="directory"):
        write_mesh(tmp_path / "folder.obj", *ball, force=True)
    if Path("/dev/full").exists():
        (tmp_path / "full.obj").symlink_to("/dev/full")
        with pytest.raises(FileError, match="no regular file"):
            write_mesh(tmp_path / "full.obj", *ball, force=True)


@pytest.mark.parametrize(
    ("module", "name"), [("nibabel", "a.gii"), ("nibabel", "lh.pial"), ("trimesh", "a.glb")]
)
def test_a_missing_extra_is_named(module, name, ball, tmp_path, monkeypatch):
    for known in [key for key in sys.modules if key.partition(".")[0] == module]:
        monkeypatch.setitem(sys.modules, known, None)
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(FileError, match=rf"needs {module}, .*: pip install {module} \(the extra 'io' of igl_spheremap"):
        write_mesh(tmp_path / name, *ball)
    assert os.listdir(tmp_path) == []


def test_every_format_is_in_the_table_once():
    suffixes = [suffix for entry in FORMATS for suffix in entry.suffixes]
    assert len(suffixes) == len(set(suffixes))
    package = Path(meshio_here.__file__).parent
    registered = {entry.read.__module__.rpartition(".")[2] for entry in FORMATS}
    assert registered == {p.stem for p in package.glob("*.py") if "\nFORMAT = " in p.read_text()}


def test_a_unit_sphere_has_radius_one_to_the_last_digit():
    x, f = samples.make("sphere", n_vertices=200)
    assert certify_radius(x * (1 + 1e-15), f).radius == 1
    assert certify_radius(100 * x, f).radius == pytest.approx(100)
