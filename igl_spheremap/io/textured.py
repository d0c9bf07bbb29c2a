"""Surfaces with a texture: OBJ with its MTL and PNG beside it, or all in one GLB."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import igl
import numpy as np
from numpy.typing import ArrayLike

from ..errors import FileError, MeshError, import_optional
from ..gate import PathLike
from ..mesh.arrays import TINY, FloatArray, PixelArray, check_triangles, own_unit
from ..mesh.check import check_indices, check_positions
from ..resampling.texture import Atlas
from .formats import format_of
from .gltf import Scene, joined, only_picture, write_body
from .obj import read, texture
from .pictures import picture, write_picture
from .reading import beside, reading
from .records import Metadata
from .replacing import check_writable, replacing
from .text import write_text


@dataclass(frozen=True, eq=False)
class TexturedMesh:
    """The texture of a file.

    Attributes
    ----------
    uv : (m, 3, 2) float64 array
        Coordinates of the corners of its faces, in the order in which `read_mesh` has them.
    v : (m, 3, 3) float64 array
        Positions of these corners.
    image : (height, width, 3) uint8 array
        The picture, rows from above; it repeats beyond 0 and 1.
    """

    uv: FloatArray
    v: FloatArray
    image: PixelArray

    def __repr__(self) -> str:
        return f"TexturedMesh({len(self.uv)} faces, {self.image.shape[1]} x {self.image.shape[0]} texels)"


def read_textured(path: PathLike) -> TexturedMesh:
    """Read the texture of a file.

    Parameters
    ----------
    path : str or path-like
        A .glb, .gltf or .obj file, whose .mtl names the picture.

    Returns
    -------
    TexturedMesh
        Coordinates and positions of corners, and the picture.

    Raises
    ------
    FileError
        If the file or its picture can't be read, or it is of another format.
    MeshError
        If it is damaged, or has no texture or several pictures.

    Examples
    --------
    >>> import tempfile
    >>> import igl_spheremap as ism
    >>> from igl_spheremap.io.textured import read_textured, write_textured
    >>> from igl_spheremap.resampling.texture import checker_image, texture_atlas
    >>> x, f = ism.samples.sphere(42)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_textured(f"{folder}/ball.obj", x, f, texture_atlas(x, f, cut=False), checker_image(64))
    ...     read_textured(f"{folder}/ball.obj")
    TexturedMesh(80 faces, 64 x 64 texels)
    """
    path = Path(path)
    kind = format_of(path).name
    if kind not in ("OBJ", "glTF"):
        raise FileError(f"{path}: textures are read from .obj, .glb and .gltf files")
    with reading(path):
        if kind == "OBJ":
            return _read_obj(path)
        scene = Scene(path)
        found = scene.parts()
        v, f = joined(found)
        if any(getattr(part.visual, "uv", None) is None for part in found):
            raise MeshError("a part without texture coordinates; give all of them a texture")
        uv = np.concatenate([part.visual.uv for part in found])
        return TexturedMesh(uv[f], v[f], _image(scene.picture(), path))


def texture_of(path: Path) -> FloatArray | None:
    """Texture coordinates (n, 2) of the vertices of a glTF file; None if it has none."""
    found = Scene(path).parts()
    uv: list[Any] = [getattr(part.visual, "uv", None) for part in found]
    if any(each is None for each in uv):
        return None
    return np.concatenate(uv).astype(np.float64)


def _read_obj(path: Path) -> TexturedMesh:
    data = path.read_bytes()
    known = texture(data)
    if known is None:
        raise MeshError("no texture coordinates; give a file that has them")
    materials = _beside([path], b"mtllib")
    pictures = _beside(materials, b"map_Kd")
    image = _image(only_picture({place.read_bytes() for place in pictures}), path)
    return TexturedMesh(known.uv[known.row], read(path).v[known.vertex], image)


def _beside(paths: Iterable[Path], word: bytes) -> set[Path]:
    """The files that lines with a word name, each once, by whatever names."""
    return {
        beside(path, name).resolve() for path in paths for name in _named(path.read_bytes(), word)
    }


def _named(data: bytes, word: bytes) -> list[str]:
    """The files that lines with a word name; before the name of a picture there may be options."""
    found = re.findall(
        rb"^[ \t]*" + word + rb"[ \t]+(?:-\S+[ \t]+(?:[-.\d]+[ \t]+)*)*([^\r\n]+)", data, re.M
    )
    return [name.decode(errors="replace").strip() for name in dict.fromkeys(found)]


def _image(content: bytes | None, path: Path) -> PixelArray:
    """The picture of a surface."""
    if content is None:
        raise MeshError("no picture: it names no texture; give a file with a texture")
    return picture(content, f"the texture of {path}")


def write_textured(
    path: PathLike,
    v: ArrayLike,
    f: ArrayLike,
    atlas: Atlas,
    image: PixelArray,
    *,
    force: bool = False,
    metadata: Metadata | None = None,
) -> None:
    """Write a surface with texture coordinates, vertex normals and a texture.

    Parameters
    ----------
    path : str or path-like
        A new .glb file, or an .obj file, which gets an .mtl and a .png file beside it.
    v : (n, 3) array_like
        Source positions, any units.
    f : (m, 3) array_like
        Faces of the source.
    atlas : Atlas
        From `texture_atlas` of its map.
    image : (height, width, 3) uint8 array
        The texture, rows from above.
    force : bool
        Replace existing files.
    metadata : dict, optional
        Of a .glb file: ``up``, the direction that is up, "x", "-x", "y" (the default) and so on, or "auto" for the
        direction in which the surface stands best (a node turns the surface so that y is); ``name`` of the node, by
        default the file's; ``mark``; and ``extras`` of the mesh, which in .obj files are a comment.

    Raises
    ------
    FileError
        If the suffix is another one, a file exists and `force` is not set, or writing fails.
    MeshError
        If `v, f` are not triangles with finite vertices.
    """
    vertices, faces = check_positions(v), check_triangles(f)
    check_indices(faces, len(vertices))
    normals = atlas.carry(igl.per_vertex_normals(own_unit(vertices)[0], faces))
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), TINY)
    target = Path(path)
    known = {"name": target.stem} | dict(metadata or {})
    if target.suffix.lower() == ".obj":
        _write_obj(target, atlas.carry(vertices), normals, atlas, image, force, known)
    elif target.suffix.lower() == ".glb":
        body = _textured_body(atlas.carry(vertices), normals, atlas, image)
        with replacing(target, force) as partial:
            write_body(partial, body, known)
    else:
        raise FileError(f"{path}: textures are written to .obj and .glb files")


def _write_obj(
    path: Path,
    v: FloatArray,
    normals: FloatArray,
    atlas: Atlas,
    image: PixelArray,
    force: bool,
    known: Metadata,
) -> None:
    material, picture = path.with_suffix(".mtl"), path.with_suffix(".png")
    for each in (path, material, picture):
        check_writable(each, force)
    write_picture(picture, image, force=force)
    with replacing(material, force) as partial:
        partial.write_text(
            f"newmtl texture\nKd 1 1 1\nKa 0 0 0\nKs 0 0 0\nillum 1\nmap_Kd {picture.name}\n",
            encoding="utf-8",
        )
    # OBJ counts texture coordinates apart from vertices
    _, one = np.unique(atlas.vertex, return_index=True)
    corners = np.stack([atlas.vertex[atlas.f], atlas.f, atlas.vertex[atlas.f]], axis=-1).reshape(
        -1, 9
    )
    parts = (
        ("v %r %r %r\n", v[one]),
        ("vt %r %r\n", atlas.uv),
        ("vn %r %r %r\n", normals[one]),
        ("f %r/%r/%r %r/%r/%r %r/%r/%r\n", corners + 1),
    )
    with replacing(path, force) as partial:
        comment = f"# {json.dumps(known['extras'])}\n" if "extras" in known else ""
        write_text(partial, f"{comment}mtllib {material.name}\nusemtl texture\n", {}, *parts)


def _textured_body(v: FloatArray, normals: FloatArray, atlas: Atlas, image: PixelArray) -> Any:
    """A mesh of trimesh's with a texture."""
    trimesh, pillow = (
        import_optional("trimesh", "glTF", "io"),
        import_optional("PIL.Image", "writing a texture", "io"),
    )
    material = trimesh.visual.material.PBRMaterial(
        baseColorTexture=pillow.fromarray(image), metallicFactor=0.0, roughnessFactor=1.0
    )
    visual = trimesh.visual.TextureVisuals(uv=atlas.uv, material=material)
    return trimesh.Trimesh(
        v, atlas.f, vertex_normals=normals, visual=visual, process=False, validate=False
    )
