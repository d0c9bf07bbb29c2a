"""glTF 2.0 as one file (.glb) or with its buffers embedded (.gltf), by trimesh; float32."""

from __future__ import annotations

import json
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import MeshError, import_optional
from ..mesh.arrays import FloatArray, IntArray
from .reading import check_expansion, check_regular
from .records import Metadata, RawMesh, of_triangles

_MAGIC = b"glTF"
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_RGB = ("red", "green", "blue")
_Z_UP = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
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
    _check_tree(json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")] if binary else data), path, len(data))
    scene = trimesh.load_scene(BytesIO(data), file_type="glb" if binary else "gltf", process=False,
                               skip_materials=not textures, resolver=trimesh.resolvers.FilePathResolver(str(path)))
    meshes = [part for part in scene.dump() if isinstance(part, trimesh.Trimesh)]
    if not meshes:
        raise MeshError("no triangles in the glTF file; give a closed triangle mesh")
    return meshes


def joined(meshes: list[Any]) -> tuple[FloatArray, IntArray]:
    """The vertices and faces of several meshes."""
    offset = np.cumsum([0] + [len(part.vertices) for part in meshes])
    v = np.concatenate([part.vertices for part in meshes])
    return v, np.concatenate([part.faces + start for part, start in zip(meshes, offset[:-1], strict=True)])


def _check_tree(tree: dict[str, Any], path: Path, stored: int) -> None:
    """Refuse scenes that ask for far more memory or time than their files are large."""
    for buffer in tree.get("buffers", []):
        if not buffer.get("uri", "data:").startswith("data:"):
            check_regular(path.parent / buffer["uri"])
            stored += (path.parent / buffer["uri"]).stat().st_size
    sizes = [8 * abs(entry["count"]) * _WIDTHS[entry["type"]] for entry in tree.get("accessors", [])]
    views = [abs(view["byteLength"]) for view in tree.get("bufferViews", [])]
    nodes = tree.get("nodes", [])
    parts = [part for node in nodes if "mesh" in node for part in tree["meshes"][node["mesh"]]["primitives"]]
    drawn = [sizes[k] for part in parts for k in (part["attributes"]["POSITION"], part.get("indices", 0))]
    check_expansion(sum(sizes) + sum(views) + sum(drawn), stored)
    level = set(range(len(nodes)))
    for _ in range(_DEEPEST):
        level = {child for k in level for child in nodes[k].get("children", [])}
    if level:
        raise MeshError(f"its nodes lie more than {_DEEPEST} deep, or in a cycle; write the mesh as one node")


def standing(body: Any, up: str) -> Any:
    """The scene of a mesh, whose y is up, as the standard says: where it is z, a node turns the mesh about x."""
    scene = import_optional("trimesh", "glTF", "io").Scene()
    scene.add_geometry(body, transform=_Z_UP if up == "z" else None)
    return scene


def write(path: Path, v: FloatArray, f: IntArray, metadata: Metadata) -> None:
    """Write one mesh in float32, with the mark as the generator; the suffix decides which of the two kinds.

    Colours ``red``, ``green`` and ``blue`` of the metadata's ``vertex_properties`` become vertex colours. Where its
    ``up`` is "z", the scene turns the mesh.
    """
    trimesh = import_optional("trimesh", "glTF", "io")
    properties = metadata.get("vertex_properties", {})
    rgb = np.column_stack([properties[name] for name in _RGB]) if set(_RGB) <= set(properties) else None
    scene = standing(trimesh.Trimesh(v, f, process=False, validate=False, vertex_colors=rgb), metadata.get("up", "y"))

    def marked(tree: dict[str, Any]) -> None:
        tree["asset"]["generator"] = metadata.get("mark", tree["asset"]["generator"])

    if path.suffix.lower() == ".glb":
        path.write_bytes(trimesh.exchange.gltf.export_glb(scene, tree_postprocessor=marked))
    else:
        files = trimesh.exchange.gltf.export_gltf(scene, embed_buffers=True, tree_postprocessor=marked)
        path.write_bytes(files["model.gltf"])
