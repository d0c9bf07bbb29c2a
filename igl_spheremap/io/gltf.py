"""glTF 2.0 as one file (.glb) or with its buffers embedded (.gltf), by trimesh; float32."""

from __future__ import annotations

import base64
import json
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..draw.plot import vertical
from ..errors import MeshError, import_optional
from ..mesh.arrays import FloatArray, IntArray
from .reading import check_expansion, check_regular
from .records import Metadata, RawMesh, of_triangles

_MAGIC = b"glTF"
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
#: Types of numbers.
_KINDS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_RGB = ("red", "green", "blue")
_DEEPEST = 64  # nodes below one another; trimesh takes time by the square of their number


def read(path: Path) -> RawMesh:
    """All meshes of a scene as one, in the scene's coordinates; seams of textures hold their vertices twice."""
    v, f = joined(parts(path))
    return RawMesh(v, of_triangles(f))


def parts(path: Path, textures: bool = False) -> list[Any]:
    """The meshes of a scene as trimesh reads them, in the scene's coordinates."""
    trimesh = import_optional("trimesh", "glTF", "io")
    data = path.read_bytes()
    binary = data.startswith(_MAGIC)
    head = 20 + int.from_bytes(data[12:16], "little")
    tree = json.loads(data[20:head] if binary else data)
    if not textures:
        tree["images"] = []
    named = [
        entry
        for entry in (*tree.get("buffers", []), *tree.get("images", []))
        if not entry.get("uri", "data:").startswith("data:")
    ]
    stored = len(data)
    if len({entry["uri"] for entry in named}) < len(named):
        raise MeshError("it names a file twice, for two buffers or pictures; write it anew")
    for entry in named:  # trimesh reads pipes and devices, too
        check_regular(path.parent / entry["uri"])
        content = (path.parent / entry["uri"]).read_bytes()
        entry["uri"], stored = _embedded(content), stored + len(content)
    _check_tree(tree, stored)
    sparse = [entry for entry in tree.get("accessors", []) if "sparse" in entry]
    if named or sparse:
        if binary and "uri" not in tree["buffers"][0]:
            tree["buffers"][0]["uri"] = _embedded(data[head + 8 :])
        for entry in sparse:
            _fill(tree, entry)
        binary, data = False, json.dumps(tree).encode()
    scene = trimesh.load_scene(
        BytesIO(data),
        file_type="glb" if binary else "gltf",
        process=False,
        skip_materials=not textures,
    )
    meshes = [part for part in scene.dump() if isinstance(part, trimesh.Trimesh)]
    if not meshes:
        raise MeshError("no triangles in the glTF file; give a closed triangle mesh")
    return meshes


def joined(meshes: list[Any]) -> tuple[FloatArray, IntArray]:
    """The vertices and faces of several meshes."""
    offset = np.cumsum([0] + [len(part.vertices) for part in meshes])
    v = np.concatenate([part.vertices for part in meshes])
    return v, np.concatenate(
        [part.faces + start for part, start in zip(meshes, offset[:-1], strict=True)]
    )


def _embedded(content: bytes) -> str:
    return f"data:application/octet-stream;base64,{base64.b64encode(content).decode('ascii')}"


def _fill(tree: dict[str, Any], accessor: dict[str, Any]) -> None:
    """Put the sparse values of an accessor into its array, which becomes a buffer; trimesh leaves them out."""
    sparse, count, width = accessor.pop("sparse"), accessor["count"], _WIDTHS[accessor["type"]]
    kind = _KINDS[accessor["componentType"]]
    array = np.zeros((count, width), dtype=kind)
    if "bufferView" in accessor:
        array[:] = _rows(tree, accessor, count, kind, width)
    places = _rows(
        tree, sparse["indices"], sparse["count"], _KINDS[sparse["indices"]["componentType"]], 1
    )
    array[places[:, 0]] = _rows(tree, sparse["values"], sparse["count"], kind, width)
    tree["buffers"].append({"uri": _embedded(array.tobytes()), "byteLength": array.nbytes})
    tree["bufferViews"].append({"buffer": len(tree["buffers"]) - 1, "byteLength": array.nbytes})
    accessor |= {"bufferView": len(tree["bufferViews"]) - 1, "byteOffset": 0}


def _rows(
    tree: dict[str, Any], entry: dict[str, Any], count: int, kind: str, width: int
) -> NDArray[Any]:
    """Read `count` rows from the place in a buffer that an entry of the tree names."""
    view = tree["bufferViews"][entry["bufferView"]]
    data = base64.b64decode(tree["buffers"][view["buffer"]]["uri"].partition(",")[2])
    at, size = view.get("byteOffset", 0) + entry.get("byteOffset", 0), np.dtype(kind).itemsize
    return np.ndarray((count, width), kind, data, at, (view.get("byteStride", size * width), size))


def _check_tree(tree: dict[str, Any], stored: int) -> None:
    """Refuse scenes that ask for far more memory or time than their files are large."""
    sizes = [
        8
        * (abs(entry["count"]) + abs(entry.get("sparse", {}).get("count", 0)))
        * _WIDTHS[entry["type"]]
        for entry in tree.get("accessors", [])
    ]
    views = [abs(view["byteLength"]) for view in tree.get("bufferViews", [])]
    nodes = tree.get("nodes", [])
    parts = [
        part
        for node in nodes
        if "mesh" in node
        for part in tree["meshes"][node["mesh"]]["primitives"]
    ]
    drawn = [
        sizes[k] for part in parts for k in (part["attributes"]["POSITION"], part.get("indices", 0))
    ]
    check_expansion(sum(sizes) + sum(views) + sum(drawn), stored)
    level = set(range(len(nodes)))
    for _ in range(_DEEPEST):
        level = {child for k in level for child in nodes[k].get("children", [])}
    if level:
        raise MeshError(
            f"its nodes lie more than {_DEEPEST} deep, or in a cycle; write the mesh as one node"
        )


def write(path: Path, v: FloatArray, f: IntArray, metadata: Metadata) -> None:
    """Write one mesh in float32; the suffix decides which of the two kinds.

    Colours ``red``, ``green`` and ``blue`` of the metadata's ``vertex_properties`` become vertex colours; for the rest
    see `write_body`.
    """
    trimesh = import_optional("trimesh", "glTF", "io")
    properties = metadata.get("vertex_properties", {})
    rgb = (
        np.column_stack([properties[name] for name in _RGB])
        if set(_RGB) <= set(properties)
        else None
    )
    write_body(
        path, trimesh.Trimesh(v, f, process=False, validate=False, vertex_colors=rgb), metadata
    )


def write_body(path: Path, body: Any, metadata: Metadata) -> None:
    """Write a mesh of trimesh, with the metadata's mark as the generator and its ``extras`` as the mesh's extras.

    A node of its ``name`` turns the mesh so that what is ``up``, as of `vertical`, is y, as in all glTF files.
    """
    trimesh = import_optional("trimesh", "glTF", "io")
    up, turn = vertical(body.vertices, metadata.get("up", "y")), np.eye(4)
    right = np.eye(3)[int(up[0] != 0)]
    turn[:3, :3] = right, up, np.cross(right, up)
    scene = trimesh.Scene()
    scene.add_geometry(
        body, node_name=metadata.get("name"), geom_name=metadata.get("name"), transform=turn
    )

    def marked(tree: dict[str, Any]) -> None:
        tree["asset"]["generator"] = metadata.get("mark", tree["asset"]["generator"])
        if "extras" in metadata:
            tree["meshes"][0]["extras"] = metadata["extras"]

    if path.suffix.lower() == ".glb":
        path.write_bytes(trimesh.exchange.gltf.export_glb(scene, tree_postprocessor=marked))
    else:
        files = trimesh.exchange.gltf.export_gltf(
            scene, embed_buffers=True, tree_postprocessor=marked
        )
        path.write_bytes(files["model.gltf"])
