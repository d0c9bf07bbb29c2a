"""Pictures come back; a GLB file is taken apart by the words of the glTF 2.0 specification."""

from __future__ import annotations

import base64
import io
import json
import os
import struct
import zlib

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap import FileError, MeshError
from igl_spheremap.io.files import read_mesh
from igl_spheremap.io.pictures import read_picture, write_picture
from igl_spheremap.io.textured import read_textured, write_textured
from igl_spheremap.resampling.texture import checker_image, texture_atlas

pytest.importorskip("trimesh")
image = pytest.importorskip("PIL.Image")

TYPES = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


@pytest.fixture(scope="module", params=["equirectangular", "octahedral"])
def written(request, tmp_path_factory):
    v, f = ism.samples.make("spheroid", n_vertices=1000)
    atlas = ism.texture_atlas(ism.spherical_conformal_map(v, f).sphere, f, projection=request.param)
    path = tmp_path_factory.mktemp("glb") / "body.glb"
    write_textured(path, v, f, atlas, checker_image(64))
    return v, f, atlas, path.read_bytes()


def chunks(data):
    """The JSON and the binary chunk; every length must add up."""
    magic, version, length = struct.unpack_from("<4sII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data))
    found, at = {}, 12
    while at < length:
        size, kind = struct.unpack_from("<I4s", data, at)
        assert size % 4 == 0
        found[kind] = data[at + 8 : at + 8 + size]
        at += 8 + size
    assert at == length
    assert list(found) == [b"JSON", b"BIN\0"]
    return json.loads(found[b"JSON"]), found[b"BIN\0"]


def accessor(tree, binary, number):
    """The numbers of an accessor, which must lie within its view, aligned, with true bounds."""
    entry = tree["accessors"][number]
    view = tree["bufferViews"][entry["bufferView"]]
    dtype, width = np.dtype(TYPES[entry["componentType"]]), WIDTHS[entry["type"]]
    assert "byteStride" not in view
    start = view.get("byteOffset", 0) + entry.get("byteOffset", 0)
    assert start % dtype.itemsize == 0
    assert (
        entry.get("byteOffset", 0) + entry["count"] * width * dtype.itemsize <= view["byteLength"]
    )
    assert (
        view.get("byteOffset", 0) + view["byteLength"]
        <= tree["buffers"][view["buffer"]]["byteLength"]
    )
    values = np.frombuffer(binary, dtype, entry["count"] * width, start).reshape(-1, width)
    assert "min" not in entry or np.array_equal(
        np.float32(entry["min"]), values.min(axis=0).astype(np.float32)
    )
    assert "max" not in entry or np.array_equal(
        np.float32(entry["max"]), values.max(axis=0).astype(np.float32)
    )
    return values


def test_the_surface_is_all_there(written):
    v, _, atlas, data = written
    tree, binary = chunks(data)
    assert tree["asset"]["version"] == "2.0"
    (mesh,) = tree["meshes"]
    (part,) = mesh["primitives"]
    assert part.get("mode", 4) == 4
    assert {"min", "max"} <= tree["accessors"][part["attributes"]["POSITION"]].keys()
    stored = {name: accessor(tree, binary, number) for name, number in part["attributes"].items()}
    faces = accessor(tree, binary, part["indices"]).reshape(-1, 3)
    assert np.array_equal(faces, atlas.f)
    assert np.array_equal(stored["POSITION"], atlas.carry(v).astype(np.float32))
    assert np.allclose(np.linalg.norm(stored["NORMAL"], axis=1), 1, atol=1e-6)
    corners = stored["POSITION"][faces].astype(float)
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    middle = stored["NORMAL"][faces].mean(axis=1)
    assert (np.einsum("ij,ij->i", flat, middle)[np.linalg.norm(flat, axis=1) > 1e-9] > 0).all()
    # glTF counts rows of a picture from above.
    assert np.allclose(
        stored["TEXCOORD_0"], np.column_stack([atlas.uv[:, 0], 1 - atlas.uv[:, 1]]), atol=1e-6
    )


def test_the_picture_is_the_one_that_was_given(written):
    tree, binary = chunks(written[3])
    primitive = tree["meshes"][0]["primitives"][0]
    texture = tree["materials"][primitive["material"]]["pbrMetallicRoughness"]["baseColorTexture"][
        "index"
    ]
    picture = tree["images"][tree["textures"][texture]["source"]]
    view = tree["bufferViews"][picture["bufferView"]]
    start = view.get("byteOffset", 0)
    assert picture["mimeType"] == "image/png"
    with image.open(io.BytesIO(binary[start : start + view["byteLength"]])) as found:
        assert np.array_equal(np.asarray(found.convert("RGB")), checker_image(64))


def test_the_scene_shows_the_mesh_as_it_is(written):
    tree, _ = chunks(written[3])
    assert len(tree["scenes"][tree.get("scene", 0)]["nodes"]) >= 1
    assert sum("mesh" in node for node in tree["nodes"]) == 1
    for node in tree["nodes"]:
        assert not {"rotation", "translation", "scale"} & node.keys()
        assert np.array_equal(node.get("matrix", np.eye(4).ravel()), np.eye(4).ravel())


@pytest.mark.parametrize("name", ["body.obj", "body.glb"])
@pytest.mark.parametrize("projection", ["equirectangular", "octahedral"])
def test_textures_in_another_program(name, projection, result, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    atlas = texture_atlas(result.sphere, result.faces, projection=projection)
    image = checker_image(64, 4)
    write_textured(tmp_path / name, result.vertices, result.faces, atlas, image)
    body = trimesh.load(tmp_path / name, force="mesh", process=False)
    f = np.asarray(body.faces)
    assert np.allclose(
        np.asarray(body.vertices)[f], atlas.carry(result.vertices)[atlas.f], atol=1e-6
    )
    assert np.allclose(np.asarray(body.visual.uv)[f], atlas.uv[atlas.f], atol=1e-6)
    material = body.visual.material
    picture = material.baseColorTexture if name.endswith("glb") else material.image
    assert np.array_equal(np.asarray(picture.convert("RGB")), image)
    outward = np.einsum("ij,ij->i", body.vertex_normals, np.asarray(body.vertices))
    assert (outward > 0).all()


def test_textures_are_not_overwritten(result, tmp_path):
    atlas = texture_atlas(result.sphere, result.faces)
    (tmp_path / "body.png").write_text("precious")
    with pytest.raises(FileError, match=r"body.png exists already"):
        write_textured(
            tmp_path / "body.obj", result.vertices, result.faces, atlas, checker_image(8, 2)
        )
    assert os.listdir(tmp_path) == ["body.png"]
    with pytest.raises(FileError, match=r"\.obj and \.glb"):
        write_textured(
            tmp_path / "body.off", result.vertices, result.faces, atlas, checker_image(8, 2)
        )


def test_pictures_come_back(tmp_path):
    image = np.random.default_rng(0).integers(0, 256, (5, 7, 3), dtype=np.uint8)
    write_picture(tmp_path / "a.png", image)
    assert np.array_equal(read_picture(tmp_path / "a.png"), image)


def textured_tree(folder):
    """The tree of a glTF file with a picture, whose buffer is embedded."""
    v, f = ism.samples.sphere(42)
    write_textured(folder / "a.glb", v, f, texture_atlas(v, f, cut=False), checker_image(16))
    tree, binary = chunks((folder / "a.glb").read_bytes())
    tree["buffers"][0]["uri"] = "data:;base64," + base64.b64encode(binary).decode()
    return tree


def huge_png():
    """A header that announces 10 gigapixels."""
    header = b"IHDR" + struct.pack(">2I5B", 100_000, 100_000, 8, 2, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + struct.pack(">I", 13)
        + header
        + struct.pack(">I", zlib.crc32(header))
    )


@pytest.mark.parametrize("data", [b"", b"no picture", huge_png()], ids=["empty", "text", "huge"])
def test_what_is_no_picture_is_one_line(data, tmp_path):
    (tmp_path / "a.png").write_bytes(data)
    with pytest.raises(FileError, match=r"can't read .* as a picture"):
        read_picture(tmp_path / "a.png")


@pytest.mark.posix
def test_no_program_is_started_for_a_picture(tmp_path, monkeypatch):
    """Pillow starts Ghostscript for EPS, whatever the file is called; so it does for a picture in a glTF file."""
    (tmp_path / "gs").write_text(f"#!/bin/sh\necho >> {tmp_path}/called\nexit 1\n")
    (tmp_path / "gs").chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    eps = b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 8 8\n%%EndComments\nshowpage\n%%EOF\n"
    for name in ("a.png", "a square.png"):
        (tmp_path / name).write_bytes(eps)
    (tmp_path / "a.obj").write_text(SQUARE)
    (tmp_path / "a square.mtl").write_text("map_Kd a square.png\n")
    tree = textured_tree(tmp_path)
    tree["images"] = [{"uri": "a%20square.png"}]
    (tmp_path / "a.gltf").write_text(json.dumps(tree))
    for reader, name in (
        (read_picture, "a.png"),
        (read_textured, "a.obj"),
        (read_textured, "a.gltf"),
    ):
        with pytest.raises(FileError, match="as a picture"):
            reader(tmp_path / name)
    assert not (tmp_path / "called").exists()
    write_picture(tmp_path / "a square.png", checker_image(16), force=True)
    assert np.array_equal(read_textured(tmp_path / "a.gltf").image, checker_image(16))


def test_pictures_are_bounded_in_pixels(tmp_path):
    """A file of 9 kB, whose colours would take 200 MB."""
    image.new("1", (8193, 8192)).save(tmp_path / "a.png")
    assert (tmp_path / "a.png").stat().st_size < 10_000
    with pytest.raises(FileError, match="8193 x 8192 pixels"):
        read_picture(tmp_path / "a.png")


@pytest.mark.posix
def test_a_picture_of_many_names_is_opened_once(tmp_path, monkeypatch):
    write_picture(tmp_path / "0.png", checker_image(16))
    for k in range(1, 9):
        (tmp_path / f"{k}.png").symlink_to("0.png")
    (tmp_path / "copy.png").write_bytes((tmp_path / "0.png").read_bytes())
    names = [*(f"{k}.png" for k in range(9)), "./0.png", "./././0.png", "copy.png"]
    (tmp_path / "a square.mtl").write_text("".join(f"map_Kd {name}\n" for name in names))
    (tmp_path / "a.obj").write_text(SQUARE)
    opened, open_picture = [], image.open
    monkeypatch.setattr(image, "open", lambda *_, **__: opened.append(1) or open_picture(*_, **__))
    assert np.array_equal(read_textured(tmp_path / "a.obj").image, checker_image(16))
    assert len(opened) == 1


@pytest.mark.posix
def test_devices_and_pipes_are_refused_without_reading(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path in ("/dev/zero", tmp_path / "pipe"):
        with pytest.raises(FileError, match="a device or a pipe"):
            read_picture(path)


@pytest.mark.posix
def test_a_material_that_is_a_pipe_is_refused_without_reading(tmp_path):
    os.mkfifo(tmp_path / "a square.mtl")
    (tmp_path / "a.obj").write_text(SQUARE)
    with pytest.raises(FileError, match="a device or a pipe"):
        read_textured(tmp_path / "a.obj")


SQUARE = """mtllib a square.mtl
v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0
vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1
f 1/1 2/2 3/3 4/4
"""


@pytest.mark.parametrize(
    ("material", "words"),
    [
        ("newmtl a\nmap_Kd -s 1 1 1 one picture.png\n", None),
        ("newmtl a\nmap_Kd one picture.png\nnewmtl b\nmap_Kd other.png\n", "2 pictures; join them"),
        ("newmtl a\nKd 1 1 1\n", "it names no texture"),
        ("newmtl a\nmap_Kd nowhere.png\n", "nowhere.png"),
        (None, "a square.mtl"),
    ],
)
def test_polygons_have_the_texture_that_their_material_names(material, words, tmp_path):
    for name, size in (("one picture.png", 8), ("other.png", 16)):
        write_picture(tmp_path / name, checker_image(size, 2))
    (tmp_path / "square.obj").write_text(SQUARE)
    if material is not None:
        (tmp_path / "a square.mtl").write_text(material)
    if words is not None:
        with pytest.raises((FileError, MeshError), match=words):
            read_textured(tmp_path / "square.obj")
        return
    found = read_textured(tmp_path / "square.obj")
    assert np.array_equal(found.image, checker_image(8, 2))
    assert np.array_equal(found.uv, found.v[..., :2])
    v, f = read_mesh(tmp_path / "square.obj", triangulate=True)
    assert np.array_equal(found.v, v[f])
