"""glTF 2.0 as one file (.glb) or with its buffers embedded (.gltf), by trimesh; float32."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..errors import MeshError, import_optional
from .polygons import of_triangles
from .records import FloatArray, Format, IntArray, Metadata, RawMesh


def read(path: Path) -> RawMesh:
    """Read all meshes of a glTF scene as one, in the scene's coordinates.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    RawMesh
        Positions as stored: files with texture coordinates hold the vertices along seams twice.

    Raises
    ------
    MeshError
        If it holds no triangles.
    FileError
        If trimesh is not installed.
    """
    trimesh = import_optional("trimesh", "glTF", "io")
    scene = trimesh.load_scene(path, process=False)
    meshes = [part for part in scene.dump() if isinstance(part, trimesh.Trimesh)]
    if not meshes:
        raise MeshError("no triangles in the glTF file; give a closed triangle mesh")
    offset = np.cumsum([0] + [len(part.vertices) for part in meshes])
    v = np.concatenate([np.asarray(part.vertices, dtype=np.float64) for part in meshes])
    f = np.concatenate(
        [
            np.asarray(part.faces, dtype=np.int64) + start
            for part, start in zip(meshes, offset[:-1], strict=True)
        ]
    )
    return RawMesh(v, of_triangles(f))


def write(path: Path, v: FloatArray, f: IntArray, metadata: Metadata) -> None:
    """Write one mesh in float32.

    Parameters
    ----------
    path : Path
        The file; its suffix tells which of the two kinds.
    v : (n, 3) float64 array
        Positions.
    f : (m, 3) int64 array
        Faces.
    metadata : dict
        Nothing of it can be kept.

    Returns
    -------
    None
    """
    trimesh = import_optional("trimesh", "glTF", "io")
    scene = trimesh.Scene(trimesh.Trimesh(v, f, process=False, validate=False))
    if path.suffix.lower() == ".glb":
        path.write_bytes(trimesh.exchange.gltf.export_glb(scene))
    else:
        files = trimesh.exchange.gltf.export_gltf(scene, embed_buffers=True)
        path.write_bytes(files["model.gltf"])


FORMAT = Format("glTF", (".glb", ".gltf"), read, write, magic=(b"glTF",), single=True)
