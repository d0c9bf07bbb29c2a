"""Pictures, and surfaces with a texture: OBJ with its MTL and PNG beside it, or all in one GLB."""

from __future__ import annotations

from pathlib import Path

import igl
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import FileError, import_optional
from ..mesh.arrays import FloatArray
from ..mesh.check import check_mesh
from ..shapes.texture import Atlas
from .formats import PathLike
from .reading import check_regular
from .replacing import check_writable, replacing
from .text import write_text


def read_picture(path: PathLike) -> NDArray[np.uint8]:
    """An image (height, width, 3) of any format that pillow knows, rows from above."""
    pillow = import_optional("PIL.Image", "a picture", "io")
    try:
        check_regular(Path(path))
        with pillow.open(path) as image:
            return np.asarray(image.convert("RGB"))
    except FileError:
        raise
    except Exception as error:  # pillow raises many kinds on damaged or huge pictures
        raise FileError(f"can't read {path} as a picture: {getattr(error, 'strerror', None) or error}") from None


def write_picture(path: PathLike, image: NDArray[np.uint8], *, force: bool = False) -> None:
    """Write an image (height, width, 3), rows from above."""
    pillow = import_optional("PIL.Image", "writing a picture", "io")
    with replacing(path, force) as partial:
        pillow.fromarray(image).save(partial, format="png")


def write_textured(
    path: PathLike, v: ArrayLike, f: ArrayLike, atlas: Atlas, image: NDArray[np.uint8], *, force: bool = False
) -> None:
    """Write a surface with texture coordinates, vertex normals and a texture.

    Parameters
    ----------
    path : str or path-like
        A new .glb file, or an .obj file, which gets an .mtl and a .png file beside it.
    v : (n, 3) array_like
        Source positions.
    f : (m, 3) array_like
        Faces of the source.
    atlas : Atlas
        From `texture_atlas` of its map.
    image : (height, width, 3) uint8 array
        The texture, rows from above.
    force : bool
        Replace existing files.

    Raises
    ------
    FileError
        If the suffix is another one, a file exists and `force` is not set, or writing fails.
    MeshError
        If `v, f` is not a closed genus-0 mesh.
    """
    mesh = check_mesh(v, f)
    normals = atlas.carry(igl.per_vertex_normals(mesh.unit, mesh.f))
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)
    target = Path(path)
    writers = {".obj": _write_obj, ".glb": _write_glb}
    if target.suffix.lower() not in writers:
        raise FileError(f"{path}: textures are written to .obj and .glb files")
    writers[target.suffix.lower()](target, atlas.carry(mesh.v), normals, atlas, image, force)


def _write_obj(
    path: Path, v: FloatArray, normals: FloatArray, atlas: Atlas, image: NDArray[np.uint8], force: bool
) -> None:
    material, picture = path.with_suffix(".mtl"), path.with_suffix(".png")
    for each in (path, material, picture):
        check_writable(each, force)
    write_picture(picture, image, force=force)
    with replacing(material, force) as partial:
        partial.write_text(f"newmtl texture\nKd 1 1 1\nKa 0 0 0\nKs 0 0 0\nillum 1\nmap_Kd {picture.name}\n",
                           encoding="utf-8")
    _, one = np.unique(atlas.vertex, return_index=True)  # OBJ counts texture coordinates apart from vertices
    corners = np.stack([atlas.vertex[atlas.f], atlas.f, atlas.vertex[atlas.f]], axis=-1).reshape(-1, 9)
    parts = (("v %r %r %r\n", v[one]), ("vt %r %r\n", atlas.uv), ("vn %r %r %r\n", normals[one]),
             ("f %r/%r/%r %r/%r/%r %r/%r/%r\n", corners + 1))
    with replacing(path, force) as partial:
        write_text(partial, f"mtllib {material.name}\nusemtl texture\n", {}, *parts)


def _write_glb(
    path: Path, v: FloatArray, normals: FloatArray, atlas: Atlas, image: NDArray[np.uint8], force: bool
) -> None:
    trimesh, pillow = import_optional("trimesh", "glTF", "io"), import_optional("PIL.Image", "writing a texture", "io")
    material = trimesh.visual.material.PBRMaterial(
        baseColorTexture=pillow.fromarray(image), metallicFactor=0.0, roughnessFactor=1.0
    )
    visual = trimesh.visual.TextureVisuals(uv=atlas.uv, material=material)
    body = trimesh.Trimesh(v, atlas.f, vertex_normals=normals, visual=visual, process=False, validate=False)
    with replacing(path, force) as partial:
        partial.write_bytes(trimesh.exchange.gltf.export_glb(trimesh.Scene(body), include_normals=True))
