"""glTF 2.0 as one file (.glb) or with its buffers embedded (.gltf), by trimesh; float32."""

from __future__ import annotations

import base64
import json
import os
from io import BytesIO
from itertools import chain
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from ..draw.plot import vertical
from ..errors import MeshError, import_optional, printable
from ..mesh.arrays import AnyArray, FloatArray, IntArray
from .reading import Bytes, beside, check_complete, check_expansion
from .records import Metadata, RawMesh, of_triangles

_MAGIC = b"glTF"
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
#: Types of numbers.
_KINDS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_RGB = ("red", "green", "blue")


def read(path: Path) -> RawMesh:
    """All meshes of a scene as one, in the scene's coordinates; seams of textures hold their vertices twice."""
    v, f = joined(Scene(path).parts())
    return RawMesh(v, of_triangles(f))


class Scene:
    """The tree of a scene, and its buffers, each read once from the file or from those beside it."""

    def __init__(self, path: Path) -> None:
        text, chunk = path.read_bytes(), b""
        stored = len(text)
        if text.startswith(_MAGIC):
            file = Bytes(text, 12)
            text, chunk = _chunk(file), _chunk(file)
        # names may be of another encoding
        self.path, self.tree = path, json.loads(text.decode("utf-8-sig", "replace"))
        if str(self.tree.get("asset", {}).get("version", 2)).startswith("1."):
            raise MeshError("it is of version 1 of glTF; write it as glTF 2.0")
        entries = self.tree.get("buffers", [])
        named = [os.path.realpath(self._place(entry)) for entry in entries if _is_named(entry)]
        if len(set(named)) < len(named):
            raise MeshError("it names a file twice, for two buffers; write it anew")
        self.buffers = [self._content(entry, chunk) for entry in entries]
        _check_tree(self.tree, stored + sum(map(os.path.getsize, named)))

    def _place(self, entry: dict[str, Any]) -> Path:
        return beside(self.path, unquote(entry["uri"]))

    def _content(self, entry: dict[str, Any], otherwise: bytes) -> bytes:
        """The content of an entry's URI; of one without a URI, the given content."""
        if "uri" not in entry:
            return otherwise
        if _is_named(entry):
            return self._place(entry).read_bytes()
        return base64.b64decode(entry["uri"].partition(",")[2])

    def _view(self, number: int) -> bytes:
        """The part of a buffer that a view shows."""
        view = self.tree["bufferViews"][number]
        at, buffer = view.get("byteOffset", 0), self.buffers[view["buffer"]]
        end = at + view["byteLength"]
        check_complete(0 <= at <= end <= len(buffer), f"{len(buffer)} bytes", f"{end} of a buffer")
        return buffer[at:end]

    def parts(self) -> list[Any]:
        """The meshes as trimesh reads them, in the scene's coordinates; it sees neither other files nor pictures."""
        trimesh = import_optional("trimesh", "glTF", "io")
        accessors = [self._filled(entry) for entry in self.tree.get("accessors", [])]
        views = self.tree.get("bufferViews", [])
        content = [self._view(k) for k in range(len(views))]
        start = np.cumsum([0, *map(len, content)]).tolist()
        tree = self.tree | {
            "accessors": accessors,
            "bufferViews": [
                view | {"buffer": 0, "byteOffset": at}
                for view, at in zip(views, start[:-1], strict=True)
            ],
            "buffers": [{"byteLength": start[-1]}],
            "images": [],
            # texture coordinates come with a material only
            "materials": [{} for _ in self.tree.get("materials", [])],
        }
        scene = trimesh.load_scene(
            BytesIO(_glb(tree, b"".join(content))), file_type="glb", process=False
        )
        meshes = [part for part in scene.dump() if isinstance(part, trimesh.Trimesh)]
        if not meshes:
            raise MeshError("no triangles in the glTF file; give a closed triangle mesh")
        return meshes

    def _filled(self, accessor: dict[str, Any]) -> dict[str, Any]:
        """An accessor whose sparse values are put into its array, which becomes a buffer; trimesh leaves them out."""
        if "sparse" not in accessor:
            return accessor
        sparse, count, width = accessor["sparse"], accessor["count"], _WIDTHS[accessor["type"]]
        kind = _KINDS[accessor["componentType"]]
        array = np.zeros((count, width), dtype=kind)
        if "bufferView" in accessor:
            array[:] = self._rows(accessor, count, kind, width)
        indices = sparse["indices"]
        places = self._rows(indices, sparse["count"], _KINDS[indices["componentType"]], 1)
        array[places[:, 0]] = self._rows(sparse["values"], sparse["count"], kind, width)
        self.buffers.append(array.tobytes())
        views = self.tree["bufferViews"]
        views.append({"buffer": len(self.buffers) - 1, "byteLength": array.nbytes})
        full = {name: value for name, value in accessor.items() if name != "sparse"}
        return full | {"bufferView": len(views) - 1, "byteOffset": 0}

    def _rows(self, entry: dict[str, Any], count: int, kind: str, width: int) -> AnyArray:
        """Read `count` rows from the place in a buffer that an entry of the tree names."""
        view = self.tree["bufferViews"][entry["bufferView"]]
        at, size = view.get("byteOffset", 0) + entry.get("byteOffset", 0), np.dtype(kind).itemsize
        strides = view.get("byteStride", size * width), size
        return np.ndarray((count, width), kind, self.buffers[view["buffer"]], at, strides)

    def picture(self) -> bytes | None:
        """The content of the picture of all parts' base colour; None if a part has none."""
        tree, used = self.tree, set()
        shown = {node["mesh"] for node in tree.get("nodes", []) if "mesh" in node}
        for part in chain.from_iterable(tree["meshes"][k]["primitives"] for k in shown):
            if "material" not in part:
                return None
            texture = _base_colour(tree["materials"][part["material"]])
            if texture is None:
                return None
            entry = tree["textures"][texture["index"]]
            used.add(entry.get("extensions", {}).get("EXT_texture_webp", entry)["source"])
        found = set()
        for k in sorted(used):
            image = tree["images"][k]
            found.add(
                self._view(image["bufferView"])
                if "bufferView" in image
                else self._content(image, b"")
            )
        return only_picture(found)


def only_picture(contents: set[bytes]) -> bytes | None:
    """The one picture of a surface; a MeshError if there are several, None if there is none."""
    if len(contents) > 1:
        raise MeshError(
            f"{len(contents)} pictures; join them into one, as a renderer's baking does"
        )
    return next(iter(contents), None)


def _base_colour(material: dict[str, Any]) -> dict[str, Any] | None:
    """The texture of a material's colour; older files have it in an extension."""
    older = material.get("extensions", {}).get("KHR_materials_pbrSpecularGlossiness", {})
    return material.get("pbrMetallicRoughness", {}).get(
        "baseColorTexture", older.get("diffuseTexture")
    )


def joined(meshes: list[Any]) -> tuple[FloatArray, IntArray]:
    """The vertices and faces of several meshes."""
    append_faces = import_optional("trimesh.util", "glTF", "io").append_faces
    v, f = append_faces([part.vertices for part in meshes], [part.faces for part in meshes])
    return v, f


def _is_named(entry: dict[str, Any]) -> bool:
    """Whether the content of an entry of the tree lies in another file."""
    return not entry.get("uri", "data:").startswith("data:")


def _chunk(file: Bytes) -> bytes:
    """The content of the next chunk of a .glb file; none at its end."""
    if file.at >= len(file.data):
        return b""
    size, _ = file.array("<u4", 2).tolist()
    return file.take(size)


def _glb(tree: dict[str, Any], binary: bytes) -> bytes:
    """A .glb file of a tree and its one buffer."""
    head = json.dumps(tree).encode()
    pieces = [_MAGIC, (2).to_bytes(4, "little"), b""]
    for content, kind, filler in ((head, b"JSON", b" "), (binary, b"BIN\0", b"\0")):
        rest = -len(content) % 4
        pieces += [(len(content) + rest).to_bytes(4, "little"), kind, content, rest * filler]
    pieces[2] = (4 + sum(map(len, pieces))).to_bytes(4, "little")
    return b"".join(pieces)


def _check_tree(tree: dict[str, Any], stored: int, of_part: int = 512, deepest: int = 64) -> None:
    """Refuse scenes that ask for far more memory or time than their files are large.

    A part takes some 512 bytes at least where a node draws it, and nodes that lie `deepest` below one another take
    trimesh time by the square of their number.
    """
    sizes = [
        8
        * (abs(entry["count"]) + abs(entry.get("sparse", {}).get("count", 0)))
        * _WIDTHS[entry["type"]]
        for entry in tree.get("accessors", [])
    ]
    views = [abs(view["byteLength"]) for view in tree.get("bufferViews", [])]
    meshes = [
        sum(
            of_part + sizes[part["attributes"]["POSITION"]] + sizes[part.get("indices", 0)]
            for part in mesh["primitives"]
        )
        for mesh in tree.get("meshes", [])
    ]
    nodes = tree.get("nodes", [])
    drawn = [meshes[node["mesh"]] for node in nodes if "mesh" in node]
    check_expansion(sum(sizes) + sum(views) + sum(drawn), stored)
    level = set(range(len(nodes)))
    for _ in range(deepest):
        level = {child for k in level for child in nodes[k].get("children", [])}
    if level:
        raise MeshError(
            f"its nodes lie more than {deepest} deep, or in a cycle; write the mesh as one node"
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

    A node of its ``name`` turns the mesh so that the direction ``up``, as of `vertical`, is y, as in all glTF files.
    """
    trimesh = import_optional("trimesh", "glTF", "io")
    up, turn = vertical(body.vertices, metadata.get("up", "y")), np.eye(4)
    right = np.eye(3)[int(up[0] != 0)]
    turn[:3, :3] = right, up, np.cross(right, up)
    scene = trimesh.Scene()
    # the text of a scene is UTF-8, names of files may not be
    name = printable(metadata["name"]) if "name" in metadata else None
    scene.add_geometry(body, node_name=name, geom_name=name, transform=turn)

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
