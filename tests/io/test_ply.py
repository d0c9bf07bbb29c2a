"""PLY in text and binary, of this and other programs, with more than a mesh in it, and damaged."""

from __future__ import annotations

import struct

import numpy as np
import pytest

from igl_spheremap import FileError, MeshError
from igl_spheremap.draw.palette import colours
from igl_spheremap.io.files import read_mesh, read_sphere
from igl_spheremap.io.write_mesh import write_mesh
from igl_spheremap.io.written_map import write_map
from igl_spheremap.mesh_repair.polygons import cut_polygons
from igl_spheremap.verify.distortion import vertex_maps


@pytest.mark.parametrize("binary", [True, False])
def test_ply_of_another_program_with_colours(binary, ball, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    v, f = ball
    mesh = trimesh.Trimesh(
        v, f, process=False, vertex_colors=np.full((len(v), 4), 77, dtype=np.uint8)
    )
    mesh.export(tmp_path / "ball.ply", encoding="binary" if binary else "ascii")
    back = read_mesh(tmp_path / "ball.ply")
    assert np.allclose(back.v, v, atol=1e-6)
    assert np.array_equal(back.f, f)


def test_colours_in_a_ply(result, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    values = vertex_maps(result.vertices, result.faces, result.sphere)["factor"]
    kept = {"vertex_properties": {**colours(values), "quality": values}}
    write_mesh(tmp_path / "a.ply", result.vertices, result.faces, metadata=kept)
    assert np.array_equal(read_mesh(tmp_path / "a.ply").v, result.vertices)
    body = trimesh.load(tmp_path / "a.ply", process=False)
    assert np.array_equal(body.visual.vertex_colors[:, 0], kept["vertex_properties"]["red"])
    assert (
        values[body.visual.vertex_colors[:, 1].argmax()]
        > values[body.visual.vertex_colors[:, 1].argmin()]
    )


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
            f"{order}BB{len(corners)}iB{texture}f",
            1,
            len(corners),
            *corners,
            texture,
            *[0.5] * texture,
        )
    (tmp_path / "mesh.ply").write_bytes(head.encode() + body)
    mesh = read_mesh(tmp_path / "mesh.ply", triangulate=True)
    assert np.array_equal(mesh.v, v)
    assert mesh.f.tolist() == [[0, 1, 2], [3, 0, 1], [3, 1, 2], [3, 2, 1]]
    assert mesh.triangulated == 1


HEAD = """ply
format {}
element vertex 3
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
"""
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype=float)
LITTLE = HEAD.format("binary_little_endian 1.0").encode()
BINARY = LITTLE + CORNERS.astype("<f4").tobytes() + struct.pack("<B3i", 3, 0, 1, 2)
TEXT = HEAD.format("ascii 1.0") + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"


def read(tmp_path, data):
    (tmp_path / "a.ply").write_bytes(data if isinstance(data, bytes) else data.encode())
    return read_mesh(tmp_path / "a.ply")


@pytest.mark.parametrize(
    "data",
    [
        BINARY,
        TEXT,
        TEXT.replace("\n", "\r\n"),
        TEXT.replace("\n", "\r"),
        BINARY.replace(LITTLE, LITTLE.replace(b"\n", b"\r\n")),
        BINARY.replace(b"end_header\n", b"end_header\r\n"),
        BINARY.replace(LITTLE, LITTLE[:-1].replace(b"\n", b"\r\n") + b"\n"),
        TEXT.replace("element vertex", "comment créé à la main\nelement vertex"),
        BINARY.replace(b"element vertex", "comment créé à la main\nelement vertex".encode()),
        TEXT.replace("end_header", "element edge 1\nproperty int vertex1\nend_header") + "7\n",
        BINARY.replace(b"end_header", b"element edge 1\nproperty int vertex1\nend_header")
        + b"\0\0\0\0",
        BINARY.replace(b"element vertex", b"element edge 0\nproperty int vertex1\nelement vertex"),
        BINARY.replace(b"end_header", b"element edge 0\nproperty list uchar int ends\nend_header"),
        TEXT.replace("0 1 0\n", "\n0 1 0\n# a remark\n"),
        TEXT.replace("property float z\n", "property float z\nproperty uchar red\n").replace(
            "0 0 0\n1 0 0\n0 1 0\n", "0 0 0 9\n1 0 0 9\n0 1 0 9\n"
        ),
    ],
)
def test_dialects(data, tmp_path):
    mesh = read(tmp_path, data)
    assert np.array_equal(mesh.v, CORNERS)
    assert mesh.f.tolist() == [[0, 1, 2]]


@pytest.mark.parametrize(
    ("before", "row", "longer"),
    [
        ("property float x", "1 0 0\n", "2 7 8 1 0 0\n"),
        ("property list uchar int", "3 0 1 2\n", "2 7 8 3 0 1 2\n"),
    ],
)
def test_lists_before_what_is_wanted_are_refused_in_text(before, row, longer, tmp_path):
    """Else numbers of the list would be taken for coordinates or indices."""
    text = TEXT.replace(before, f"property list uchar float weights\n{before}").replace(row, longer)
    with pytest.raises(MeshError, match="not read from text"):
        read(tmp_path, text)


def test_lists_before_what_is_wanted_are_passed_over_in_binary(tmp_path):
    head = LITTLE.replace(
        b"property float x", b"property list uchar float weights\nproperty float x"
    ).replace(
        b"property list uchar int", b"property list uchar short flags\nproperty list uchar int"
    )
    vertices = b"".join(
        struct.pack(f"<B{k}f", k, *[9] * k) + p.astype("<f4").tobytes()
        for k, p in enumerate(CORNERS)
    )
    mesh = read(tmp_path, head + vertices + struct.pack("<BhhB3i", 2, 7, 8, 3, 0, 1, 2))
    assert np.array_equal(mesh.v, CORNERS)
    assert mesh.f.tolist() == [[0, 1, 2]]


@pytest.mark.parametrize("sizes", [[3, 3], [4, 4, 4], [5, 5], [3, 4, 5], []])
def test_faces_of_any_size_are_read(sizes, tmp_path):
    rng = np.random.default_rng(0)
    faces = [rng.integers(0, 3, size).tolist() for size in sizes]
    head = LITTLE.replace(b"face 1", b"face %d" % len(sizes))
    body = CORNERS.astype("<f4").tobytes() + b"".join(
        struct.pack(f"<B{len(f)}i", len(f), *f) for f in faces
    )
    (tmp_path / "a.ply").write_bytes(head + body)
    mesh = read_mesh(tmp_path / "a.ply", triangulate=True)
    expected = faces
    if max(sizes, default=3) > 3:
        corners = np.concatenate(faces)
        cut = cut_polygons(mesh.v, corners, np.array(sizes))
        expected = corners[cut.triangles].tolist()
        assert np.bincount(cut.polygon).tolist() == [size - 2 for size in sizes]
    assert mesh.f.tolist() == expected


def test_digits_beyond_the_announced_type_are_kept_in_text(tmp_path):
    assert (
        read(tmp_path, TEXT.replace("1 0 0\n", "0.1234567890123 0 0\n")).v[1, 0] == 0.1234567890123
    )


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (TEXT.replace("vertex 3", "vertex 999999999999"), "cut off"),
        (TEXT.replace("vertex 3", "vertex 5"), "cut off"),
        (BINARY.replace(b"vertex 3", b"vertex 999999999999"), "cut off"),
        (BINARY.replace(b"face 1", b"face 3"), "rows of face: damaged: 0 bytes follow"),
        (BINARY.replace(b"face 1", b"face 40"), "rows of face: damaged: 0 bytes follow"),
        (BINARY.replace(b"face 1", b"face -1"), "-1 rows of face"),
        (TEXT.replace("face 1", "face -1"), "-1 rows of face"),
        (
            BINARY.replace(b"list uchar", b"list char").replace(b"\x03\0\0\0\0", b"\xff\0\0\0\0"),
            "where -4 are announced",
        ),
        (TEXT.replace("3 0 1 2", "-1 0 1 2"), "reads '-1 0 1 2'"),
        (TEXT.replace("3 0 1 2", "4 0 1 2"), "reads '4 0 1 2'"),
        (TEXT.replace("list uchar int vertex_indices", "int red"), "no list vertex_indices"),
        (TEXT.replace("list uchar int", "list uchar float"), "of whole numbers"),
        (TEXT.replace("element face", "element cell"), "no face element"),
        (TEXT.replace("property float z", "property float w"), "no x, y, z"),
        (TEXT.replace("ascii 1.0", "morse 1.0"), "morse"),
        (TEXT.replace("vertex 3", "vertex many"), "element vertex many"),
        (TEXT.replace("property float x", "property complex x"), "complex"),
        (BINARY.replace(b"list uchar", b"list \xf5char"), "ufffdchar"),
        (TEXT.replace("end_header\n", ""), "no PLY header"),
        ("ply\n" + "x" * 300000, "no PLY header"),
    ],
)
def test_the_fault_is_named(data, words, tmp_path):
    with pytest.raises(MeshError, match=words):
        read(tmp_path, data)


def test_a_sphere_beside_its_surface_is_written_and_read(result, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    path = tmp_path / "both.ply"
    check = write_map(path, result, surface=True)
    assert check.folding_free
    assert (
        b"property double z\nproperty double px\nproperty double py\nproperty double pz\n"
        in path.read_bytes()[:400]
    )
    assert np.array_equal(read_mesh(path).v, result.vertices)
    assert np.array_equal(read_sphere(path).v, result.sphere)
    assert np.array_equal(trimesh.load(path, process=False).vertices, result.vertices)
    with pytest.raises(FileError, match="no sphere beside"):
        write_map(tmp_path / "both.obj", result, surface=True)
    assert not (tmp_path / "both.obj").exists()


@pytest.mark.parametrize("order", ["", "<", ">"])
def test_a_sphere_of_moebius_registration_is_read(order, ball, tmp_path):
    """As its SphereMap writes: floats, colours behind."""
    v, f = ball
    kind = {"": "ascii", "<": "binary_little_endian", ">": "binary_big_endian"}[order]
    floats = "".join(f"property float {name}\n" for name in ("x", "y", "z", "px", "py", "pz"))
    colours = "".join(f"property uchar {name}\n" for name in ("red", "green", "blue"))
    head = (
        f"ply\nformat {kind} 1.0\nelement vertex {len(v)}\n{floats}{colours}element face {len(f)}\n"
        "property list uchar int vertex_indices\nend_header\n"
    ).encode()
    rows = np.column_stack([v * [1, 2, 3], v]).astype("f4")
    if order:
        body = b"".join(struct.pack(f"{order}6f3B", *row, 1, 2, 3) for row in rows.tolist())
        body += b"".join(struct.pack(f"{order}B3i", 3, *face) for face in f.tolist())
    else:
        body = "".join(" ".join(map(repr, row)) + " 1 2 3\n" for row in rows.tolist()).encode()
        body += "".join("3 {} {} {}\n".format(*face) for face in f.tolist()).encode()
    (tmp_path / "a.ply").write_bytes(head + body)
    assert np.array_equal(read_mesh(tmp_path / "a.ply").v, rows[:, :3])
    assert np.array_equal(read_sphere(tmp_path / "a.ply").v, rows[:, 3:])
    assert np.array_equal(read_sphere(tmp_path / "a.ply").f, f)
