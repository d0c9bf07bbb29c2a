"""Maps to the plane in files: OBJ with texture coordinates, NPZ, FreeSurfer's patches, or the image as a mesh."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from ..errors import MeshError, own_errstate
from ..mesh.arrays import FloatArray, IntArray, check_rows
from ..mesh.disk import check_disk
from ..mesh.objects import MeshLike, vertices_and_faces
from ..plane.plane_map import PlaneMap, given_map
from ..verify.certificate import Certificate
from . import npz
from .files import read_mesh, write_mesh
from .formats import PathLike, format_of
from .patch import SUFFIXES, Patch, read_patch, write_patch
from .reading import reading
from .replacing import replacing
from .text import numbers, read_rows, write_text
from .written_map import make_mark


def is_patch(path: PathLike) -> bool:
    """Whether a file is a patch of FreeSurfer's, by its name."""
    return str(path).lower().endswith(SUFFIXES)


@own_errstate
def write_plane_map(path: PathLike, result: PlaneMap, *, force: bool = False, rows: IntArray | None = None
                    ) -> Certificate:
    """Write a map to the plane, read it back, and certify what is in the file.

    Parameters
    ----------
    path : str or path-like
        The new file. OBJ holds the surface, and the map as texture coordinates (not scaled to the unit square); NPZ
        both, as arrays ``vertices``, ``faces`` and ``plane``; .patch.flat is FreeSurfer's; any other format holds the
        image as a mesh, whose third coordinate is 0.
    result : PlaneMap
        A `DiskMap` or `FlatMap`.
    force : bool
        Replace an existing file.
    rows : (n,) int64 array, optional
        For patches: rows of the whole surface that the vertices are; by default they are the whole.

    Returns
    -------
    Certificate
        Of the numbers in the file, which float32 rounds in some formats.

    Raises
    ------
    FileError
        If the file exists and `force` is not set, or it can't be written; nothing is left behind.

    Examples
    --------
    >>> import tempfile
    >>> import numpy as np
    >>> import igl_spheremap as ism
    >>> v, f = [[0, 0, 0], [1, 0, 0], [1, 1, 1], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]]
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     check = ism.write_plane_map(f"{folder}/flat.obj", ism.flatten(v, f))
    ...     again = ism.read_plane_map(f"{folder}/flat.obj")
    >>> check.folding_free, again.plane.shape
    (True, (4, 2))
    """
    mesh = result.mesh
    mark = {"mark": make_mark(mesh.v, mesh.f, result.run.method, result.run.settings)}
    if is_patch(path):
        border = np.zeros(len(mesh.v), dtype=bool)
        border[mesh.rim] = True
        write_patch(path, Patch(np.arange(len(mesh.v)) if rows is None else rows, result.image, border), force=force)
    elif format_of(path).name == "OBJ":
        corners = np.repeat(mesh.f + 1, 2, axis=1)
        with replacing(path, force) as partial:
            write_text(partial, "", mark, ("v %r %r %r\n", mesh.v), ("vt %r %r\n", result.plane),
                       ("f %r/%r %r/%r %r/%r\n", corners))
    elif format_of(path).name == "NPZ":
        with replacing(path, force) as partial:
            npz.write_arrays(partial, {"vertices": mesh.v, "faces": mesh.f, "plane": result.plane}, mark)
    else:
        write_mesh(path, result.image, mesh.f, force=force, metadata={"geometric_type": "Flat"} | mark)
    return Certificate.of_plane(read_images(path), mesh.f, mesh.rim)


@own_errstate
def read_plane_map(path: PathLike, *, surface: MeshLike | None = None) -> PlaneMap:
    """Read a map to the plane from a file of any program, and certify it.

    Parameters
    ----------
    path : str or path-like
        An OBJ file with texture coordinates, an NPZ file with arrays ``vertices``, ``faces`` and ``plane``, a patch, or
        any mesh file whose third coordinate is the same everywhere.
    surface : mesh object or (v, f), optional
        What was mapped; of a patch the whole surface that it was cut from. By default the surface in the file: only OBJ
        and NPZ hold one.

    Returns
    -------
    PlaneMap
        Of the numbers in the file, whose certificate says whether they fold; its method is "given".

    Raises
    ------
    FileError
        If the file can't be opened.
    MeshError
        If it is damaged or holds no map to the plane; if it holds no surface and none is given; or if the surface is
        not a disk, or has another number of vertices.

    Examples
    --------
    >>> import tempfile
    >>> import igl_spheremap as ism
    >>> roof, f = [[0, 0, 0], [1, 0, 0], [1, 1, 1], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]]
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     ism.write_mesh(f"{folder}/square.ply", [[0, 0, 5], [1, 0, 5], [1, 1, 5], [0, 1, 5]], f)
    ...     square = ism.read_plane_map(f"{folder}/square.ply", surface=(roof, f))
    >>> square.plane.tolist(), square.certificate.folding_free
    ([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], True)
    """
    p = read_images(path)
    if surface is not None:
        v, f = vertices_and_faces(surface)
        if is_patch(path):
            v, f = read_patch(path).part(v, f)
    elif is_patch(path) or format_of(path).name not in ("OBJ", "NPZ"):
        raise MeshError(f"{path} holds no surface, only its image; give the surface: surface=read_mesh(...)")
    else:
        v, f = read_mesh(path)
    mesh = check_disk(v, f)
    if len(p) != len(mesh.v):
        raise MeshError(f"{path} has {len(p)} vertices but the surface has {len(mesh.v)}; give the surface that was "
                        "mapped")
    return given_map(mesh, p)


def read_images(path: PathLike) -> FloatArray:
    """Images (n, 2) of the vertices in a file that holds a map to the plane, in the file's order."""
    path = Path(path)
    if is_patch(path):
        x = read_patch(path).positions
    else:
        kind = format_of(path).name
        with reading(path):
            if kind == "OBJ" and (uv := _texture(path.read_bytes())) is not None:
                return uv
            if kind == "NPZ" and "plane" in (arrays := npz.read_arrays(path)):
                return check_rows(arrays["plane"], name="plane", columns=2)
        x = read_mesh(path).v
    if np.ptp(x[:, 2]) != 0:
        raise MeshError(f"{path} holds no map to the plane: its third coordinates differ, and it has no texture "
                        "coordinates; give a flat mesh, or a surface with texture coordinates")
    return np.ascontiguousarray(x[:, :2])


def _texture(data: bytes) -> FloatArray | None:
    """Texture coordinates of each vertex of an OBJ file; None if it has none."""
    rows = read_rows(data)
    uv = rows.starting_with(b"vt")
    if not len(uv):
        return None
    text = rows.starting_with(b"f").bytes()
    pairs = re.findall(rb"(?<!\S)(\d+)/(\d+)(?=[/\s])", text)
    if len(pairs) != len(text.split()):
        raise MeshError("faces without texture coordinates, or with negative numbers; write it anew")
    vertex, place = np.array(pairs, dtype=np.int64).T - 1
    n = len(rows.starting_with(b"v"))
    of = np.full(n, -1)
    of[vertex] = place
    if (of[vertex] != place).any():
        raise MeshError("texture coordinates have seams: vertices with several; give a map that is in one piece")
    if (of < 0).any():
        raise MeshError(f"vertex {int((of < 0).argmax())} has no texture coordinates; remove it")
    return numbers(uv, 2, "texture coordinate")[of]
