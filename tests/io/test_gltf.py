"""glTF scenes that would take too much memory or time."""

from __future__ import annotations

import base64
import json
import os
from urllib.parse import quote

import numpy as np
import pytest

from igl_spheremap import (
    FileError,
    MeshError,
    check_mesh,
    repair_mesh,
    samples,
    spherical_conformal_map,
)
from igl_spheremap.io.files import read_mesh
from igl_spheremap.io.textured import read_textured, write_textured
from igl_spheremap.io.write_mesh import write_mesh
from igl_spheremap.resampling.texture import checker_image, texture_atlas

pytest.importorskip("trimesh")


@pytest.fixture
def tree(ball, tmp_path):
    write_mesh(tmp_path / "ball.gltf", *ball)
    return json.loads((tmp_path / "ball.gltf").read_text())


def read(tree, tmp_path):
    (tmp_path / "scene.gltf").write_text(json.dumps(tree))
    return read_mesh(tmp_path / "scene.gltf")


def only_mesh(tree):
    """The node that holds the mesh."""
    return next(node for node in tree["nodes"] if "mesh" in node)


def test_nodes_move_their_meshes(tree, ball, tmp_path):
    only_mesh(tree)["translation"] = [1, 2, 3]
    assert np.allclose(read(tree, tmp_path).v, ball[0] + [1, 2, 3], atol=1e-6)


@pytest.mark.parametrize("depth", [100, 30_000])
def test_deep_scenes_are_refused(depth, tree, tmp_path):
    first = len(tree["nodes"])
    tree["nodes"] += [{"children": [first + k + 1]} for k in range(depth)] + [dict(only_mesh(tree))]
    tree["scenes"][0]["nodes"] = [first]
    with pytest.raises(MeshError, match="deep"):
        read(tree, tmp_path)


def test_circles_are_refused(tree, tmp_path):
    only_mesh(tree)["children"] = [tree["nodes"].index(only_mesh(tree))]
    with pytest.raises(MeshError, match="circle"):
        read(tree, tmp_path)


def test_deeply_nested_text_is_refused(tmp_path):
    (tmp_path / "a.gltf").write_text("[" * 30_000 + "]" * 30_000)
    with pytest.raises(MeshError, match="damaged"):
        read_mesh(tmp_path / "a.gltf")


def test_scenes_that_expand_are_refused(tmp_path):
    """A mesh shown 100,000 times, an array of zeros that is stored nowhere, views of the same bytes."""
    write_mesh(tmp_path / "ball.gltf", *samples.sphere(2562))
    tree = json.loads((tmp_path / "ball.gltf").read_text())
    node = dict(only_mesh(tree), name="")
    many = tree | {"nodes": tree["nodes"] + [node] * 100_000}
    many["scenes"] = [{"nodes": list(range(len(many["nodes"])))}]
    zeros = tree | {
        "accessors": [*tree["accessors"], {"count": 10**10, "type": "VEC3", "componentType": 5126}]
    }
    views = tree | {"bufferViews": tree["bufferViews"] * 5_000}
    for scene in (many, zeros, views):
        with pytest.raises(MeshError, match="expand to"):
            read(scene, tmp_path)


@pytest.mark.posix
def test_buffers_in_files_of_their_own_count(tree, ball, tmp_path):
    """And only regular files beside the scene are read."""
    for k, buffer in enumerate(tree["buffers"]):
        data = base64.b64decode(buffer["uri"].partition(",")[2])
        (tmp_path / f"part{k}.bin").write_bytes(data)
        buffer["uri"] = f"part{k}.bin"
    assert np.array_equal(read(tree, tmp_path).f, ball[1])
    (tmp_path / "part0.bin").unlink()
    with pytest.raises(FileError, match=r"part0\.bin: No such file"):
        read(tree, tmp_path)
    os.mkfifo(tmp_path / "part0.bin")
    with pytest.raises(FileError, match="device or a pipe"):
        read(tree, tmp_path)


@pytest.mark.parametrize("suffix", [".gltf", ".glb"])
def test_sparse_values_are_put_in_their_places(suffix, tree, ball, tmp_path):
    """In an array that is stored, and in one of zeros; moved vertices are doubled, so that all can be compared."""
    moved = np.array([3, 7, 8], dtype="<u2")
    content = [moved.tobytes() + bytes(2), (2 * ball[0][moved]).astype("<f4").tobytes()]
    where = len(tree["bufferViews"])
    for each in content:
        tree["bufferViews"].append({"buffer": len(tree["buffers"]), "byteLength": len(each)})
        tree["buffers"].append(
            {"uri": "data:;base64," + base64.b64encode(each).decode(), "byteLength": len(each)}
        )
    place = next(k for k, entry in enumerate(tree["accessors"]) if entry["type"] == "VEC3")
    sparse = {
        "count": 3,
        "indices": {"bufferView": where, "componentType": 5123},
        "values": {"bufferView": where + 1},
    }
    tree["accessors"][place]["sparse"] = sparse
    expected = ball[0].copy()
    expected[moved] *= 2

    def found():
        if suffix == ".gltf":
            return read(tree, tmp_path).v
        binary = base64.b64decode(tree["buffers"][0]["uri"].partition(",")[2])
        head = json.dumps(
            tree | {"buffers": [{"byteLength": len(binary)}, *tree["buffers"][1:]]}
        ).encode()
        head += b" " * (-len(head) % 4)
        chunks = [head, b"JSON"], [binary + bytes(-len(binary) % 4), b"BIN\0"]
        body = b"".join(len(each).to_bytes(4, "little") + kind + each for each, kind in chunks)
        head = (2).to_bytes(4, "little") + (12 + len(body)).to_bytes(4, "little")
        (tmp_path / "a.glb").write_bytes(b"glTF" + head + body)
        return read_mesh(tmp_path / "a.glb").v

    assert np.allclose(found(), expected, atol=1e-6)
    del tree["accessors"][place]["bufferView"]
    expected[np.setdiff1d(np.arange(len(expected)), moved)] = 0
    assert np.allclose(found(), expected, atol=1e-6)
    tree["accessors"][place]["sparse"] = sparse | {"count": 10**10}
    with pytest.raises(MeshError, match="expand to"):
        found()


@pytest.mark.posix
def test_pictures_beside_a_scene_are_regular_files(tmp_path):
    pytest.importorskip("PIL")
    v, f = samples.sphere(42)
    write_textured(tmp_path / "a.glb", v, f, texture_atlas(v, f, cut=False), checker_image(16))
    data = (tmp_path / "a.glb").read_bytes()
    size = int.from_bytes(data[12:16], "little")
    tree, binary = json.loads(data[20 : 20 + size]), data[28 + size :]
    tree["buffers"][0]["uri"] = "data:;base64," + base64.b64encode(binary).decode()
    view = tree["bufferViews"][tree["images"][0]["bufferView"]]
    start = view.get("byteOffset", 0)
    (tmp_path / "a.png").write_bytes(binary[start : start + view["byteLength"]])
    tree["images"] = [{"uri": "a.png"}]
    (tmp_path / "a.gltf").write_text(json.dumps(tree))
    assert np.array_equal(read_textured(tmp_path / "a.gltf").image, checker_image(16))
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "a.gltf").write_text(json.dumps(tree | {"images": [{"uri": "pipe"}]}))
    assert len(read_mesh(tmp_path / "a.gltf").v) == len(texture_atlas(v, f, cut=False).vertex)
    with pytest.raises(FileError, match="device or a pipe"):
        read_textured(tmp_path / "a.gltf")


def test_textured_scenes_are_read_without_their_pictures(tmp_path):
    pytest.importorskip("PIL")
    v, f = samples.make("spheroid", n_vertices=300)
    atlas = texture_atlas(spherical_conformal_map(v, f).sphere, f)
    write_textured(tmp_path / "a.glb", v, f, atlas, checker_image(16))
    assert np.array_equal(read_mesh(tmp_path / "a.glb").f, atlas.f)


def test_a_seam_that_a_turned_node_opens_is_welded(ball, tmp_path):
    """trimesh writes half of a ball under a node that turns it by a right angle, whose cosine is 6e-17."""
    import trimesh

    v, f = ball
    v = v.astype(np.float32).astype(float)
    turn = trimesh.transformations.rotation_matrix(np.pi / 2, [0, 0, 1])
    lower = v[f][..., 2].mean(axis=1) < 0
    scene = trimesh.Scene([trimesh.Trimesh(v, f[lower], process=False)])
    scene.add_geometry(
        trimesh.Trimesh(v @ np.rint(turn[:3, :3]), f[~lower], process=False), transform=turn
    )
    scene.export(tmp_path / "halves.glb")
    mesh = read_mesh(tmp_path / "halves.glb")
    with pytest.raises(MeshError, match="nearly coincide") as caught:
        check_mesh(mesh)
    repaired = repair_mesh(mesh, **caught.value.remedy.options)
    assert repaired.caps is None
    assert repaired.v.shape == v.shape


def test_the_work_on_sparse_values_is_in_proportion_to_the_file(tree, ball, tmp_path, monkeypatch):
    """Each buffer is decoded once, however many accessors take values from it."""
    decoded, decode = [], base64.b64decode
    monkeypatch.setattr(base64, "b64decode", lambda text: decoded.append(len(text)) or decode(text))
    where = {"bufferView": 0}
    sparse = {"count": 1, "indices": where | {"componentType": 5123}, "values": where}
    one = {"count": 1, "type": "SCALAR", "componentType": 5121, "sparse": sparse}
    tree["accessors"] += [one] * 500
    read(tree, tmp_path)
    assert sum(decoded) < (tmp_path / "scene.gltf").stat().st_size


@pytest.mark.parametrize("name", ["a b.bin", "ä.bin", "100%.bin"])
def test_names_of_buffers_are_percent_encoded(name, tree, ball, tmp_path):
    for k, buffer in enumerate(tree["buffers"]):
        data = base64.b64decode(buffer["uri"].partition(",")[2])
        (tmp_path / f"{k}{name}").write_bytes(data)
        buffer["uri"] = quote(f"{k}{name}")
    assert np.array_equal(read(tree, tmp_path).f, ball[1])


def test_bytes_of_other_folders_are_not_handed_out(tree, tmp_path):
    os.mkdir(tmp_path / "upload")
    (tmp_path / "secret").write_bytes(bytes(10_000))
    for uri in ("../secret", "%2e%2e/secret", str(tmp_path / "secret")):
        tree["buffers"][0]["uri"] = uri
        (tmp_path / "upload" / "scene.gltf").write_text(json.dumps(tree))
        with pytest.raises(FileError, match="not in its folder"):
            read_mesh(tmp_path / "upload" / "scene.gltf")


def test_names_may_be_of_another_encoding(ball, tmp_path):
    path = tmp_path / "ball.glb"
    write_mesh(path, *ball, metadata={"name": "Koerper"})
    content = path.read_bytes()
    path.write_bytes(content.replace(b"Koerper", b"K\xf6\xf6rper"))
    assert b"Koerper" in content
    assert np.array_equal(read_mesh(path).f, ball[1])
