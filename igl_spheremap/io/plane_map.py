"""Maps to the plane in files: OBJ with texture coordinates, NPZ, FreeSurfer's patches, or the image as a mesh."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..errors import FileError, MeshError, shown
from ..gate import MeshLike, PathLike, gate
from ..mesh.arrays import AnyArray, FloatArray, IntArray, check_rows, check_triangles, plain_array
from ..mesh.disk import Disk, check_disk
from ..plane.plane_map import PlaneMap, given_map, unit_square
from ..resampling.texture import checker_image, plane_atlas
from ..verify.certificate import Certificate
from . import npz
from .files import read_mesh
from .formats import format_of
from .obj import ObjTexture, texture
from .objects import vertices_and_faces
from .patch import SUFFIXES, Patch, read_patch, write_patch
from .reading import reading
from .replacing import replacing
from .text import write_text
from .textured import texture_of, write_textured
from .write_mesh import write_mesh
from .written_map import make_mark


def is_patch(path: PathLike) -> bool:
    """Whether a file is a patch of FreeSurfer's, by its name."""
    return str(path).lower().endswith(SUFFIXES)


@gate
def write_plane_map(
    path: PathLike,
    result: PlaneMap,
    *,
    force: bool = False,
    rows: IntArray | None = None,
    up: str = "y",
) -> Certificate:
    """Write a map to the plane, read it back, and certify the file.

    Parameters
    ----------
    path : str or path-like
        The new file. OBJ and GLB hold the surface, and the map as texture coordinates in the unit square; a comment or
        the mesh's ``extras`` say ``factor`` and ``corner``: ``uv = factor * (plane - corner)``; GLB has a checkerboard,
        too. NPZ holds both, as arrays ``vertices``, ``faces`` and ``plane``; .patch.flat is FreeSurfer's; any other
        format holds the image as a mesh, whose third coordinate is 0.
    result : PlaneMap
        A `DiskMap` or `FlatMap`.
    force : bool
        Replace an existing file.
    rows : (n,) int64 array, optional
        For each vertex its row in the whole surface: ``vertex_source`` of what `repair_disk` made, -1 in caps. By
        default the surface is a whole one. Patches and NPZ hold them; OBJ has vertices of one row once, and coordinates
        by corner (``f v/vt``).
    up : str
        For GLB: the direction that is up in the surface's coordinates, as of `write_textured`.

    Returns
    -------
    Certificate
        Of the numbers in the file, which float32 rounds in some formats.

    Raises
    ------
    FileError
        If the file exists and `force` is not set, or it can't be written; nothing is left behind.
    MeshError
        If `rows` has no whole number for each vertex.

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
    vertex = np.arange(len(mesh.v))
    if rows is not None:
        vertex = plain_array(rows, "rows")
    if vertex.dtype.kind not in "iu" or vertex.shape != (len(mesh.v),):
        raise MeshError(
            f"rows is {shown(rows)}; give a whole number for each of the {len(mesh.v)} vertices"
        )
    uv, known = unit_square(result.plane)
    if is_patch(path):
        write_patch(path, _patch(path, result, vertex), force=force)
    elif format_of(path).name == "OBJ":
        with replacing(path, force) as partial:
            write_text(partial, f"# vt: {json.dumps(known)}\n", mark, *_obj_lines(mesh, vertex, uv))
    elif str(path).lower().endswith(".glb"):
        write_textured(
            path,
            mesh.v,
            mesh.f,
            plane_atlas(uv, mesh.f, np.arange(len(mesh.v)), len(mesh.v)),
            checker_image(),
            force=force,
            metadata={"up": up, "extras": known} | mark,
        )
    elif format_of(path).name == "NPZ":
        arrays: dict[str, Any] = {"vertices": mesh.v, "faces": mesh.f, "plane": result.plane}
        optional = {"vertex_source": rows, "caps": mesh.caps}
        arrays |= {name: array for name, array in optional.items() if array is not None}
        with replacing(path, force) as partial:
            npz.write_arrays(partial, arrays, mark)
    else:
        metadata = {"geometric_type": "Flat"} | mark
        write_mesh(path, result.image, mesh.f, force=force, metadata=metadata)
    return Certificate.of_plane(read_images(path).plane, mesh.f, mesh.rim)


def _patch(path: PathLike, result: PlaneMap, vertex: IntArray) -> Patch:
    """The map as a patch of the surface whose vertices these are."""
    if len(np.unique(vertex)) < len(vertex) or (vertex < 0).any():
        raise FileError(
            f"{path}: a patch holds vertices of the whole surface, each once; write a surface that was "
            "cut or filled to .obj, .glb or .npz"
        )
    border = np.zeros(len(vertex), dtype=bool)
    border[result.mesh.rim] = True
    return Patch(vertex, result.image, border)


def _obj_lines(mesh: Disk, vertex: IntArray, uv: FloatArray) -> Iterator[tuple[str, AnyArray]]:
    """Templates of the lines of an OBJ file, each with its rows: vertices once, coordinates by corner, caps apart."""
    first, number = _numbered(vertex)
    yield "v %r %r %r\n", mesh.v[first]
    yield "vt %r %r\n", uv
    corners = np.stack((number[mesh.f], mesh.f), axis=-1).reshape(-1, 6) + 1
    face = "f %r/%r %r/%r %r/%r\n"
    yield face, corners[mesh.surface]
    if mesh.caps is not None:
        yield "g caps\n", np.empty((1, 0))
        yield face, corners[mesh.caps]


@gate
def read_plane_map(path: PathLike, *, surface: MeshLike | None = None) -> PlaneMap:
    """Read a map to the plane from a file of any program, and certify it.

    Parameters
    ----------
    path : str or path-like
        An OBJ or GLB file with texture coordinates, an NPZ file with arrays ``vertices``, ``faces`` and ``plane``, a
        patch, or any mesh file whose third coordinate is the same everywhere. If texture coordinates have a seam, the
        map is that of the surface cut along it, with a row for each of them.
    surface : mesh object or (v, f), optional
        The mapped surface; of a patch the whole surface that it was cut from. By default the surface in the file: only
        OBJ, GLB and NPZ hold one.

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
    images = read_images(path)
    caps = None
    if surface is not None:
        v, f = vertices_and_faces(surface)
    elif not images.has_surface:
        raise MeshError(
            f"{path} holds no surface, only its image; give the surface: surface=read_mesh(...)"
        )
    else:
        (v, f), caps = (known := read_mesh(path)), known.caps
    v, f = images.cut(v, f, path)
    return given_map(check_disk(v, f, caps=caps), images.plane)


@dataclass(frozen=True, eq=False)
class PlaneImages:
    """Images (k, 2) in a file that holds a map to the plane, in the file's order.

    With them come the number of vertices of the surface, and whether the file holds it.

    Texture coordinates with a seam, and images of a part of the surface, come with the vertex (k,) that each is one of,
    and with faces (m, 3) of their own; patches find their faces in the surface.
    """

    plane: FloatArray
    size: int
    has_surface: bool = False
    vertex: IntArray | None = None
    faces: IntArray | None = None
    patch: Patch | None = None

    def cut(self, v: ArrayLike, f: ArrayLike, path: PathLike) -> tuple[FloatArray, IntArray]:
        """Cut the surface at a seam of the coordinates, or to its part; refuse another number of vertices."""
        if self.patch is not None:
            return self.patch.part(v, f)
        rows = check_rows(v, name="vertices")
        if len(rows) != self.size:
            raise MeshError(
                f"{path} has {self.size} vertices but the surface has {len(rows)}; give the surface that was "
                "mapped"
            )
        if self.vertex is None or self.faces is None:
            return rows, check_triangles(f)
        return rows[self.vertex], self.faces


def read_images(path: PathLike) -> PlaneImages:
    """The map to the plane in a file.

    A flat mesh with vertices in no face, as FreeSurfer's and HCP's, maps the part of the surface with faces.
    """
    path = Path(path)
    if is_patch(path):
        patch = read_patch(path)
        return replace(_flat(patch.positions, path), vertex=patch.rows, patch=patch)
    kind = format_of(path).name
    with reading(path):
        if kind == "OBJ" and (known := texture(path.read_bytes())) is not None:
            return _unseamed(known, len(read_mesh(path).v))
        if kind == "glTF" and (uv := texture_of(path)) is not None:
            return PlaneImages(uv, len(uv), True)
        if kind == "NPZ" and "plane" in (arrays := npz.read_arrays(path)):
            plane = check_rows(arrays["plane"], name="plane", columns=2)
            return PlaneImages(plane, len(plane), True)
    x, f = read_mesh(path)
    used, corners = np.unique(f, return_inverse=True)
    if len(used) == len(x) or used[0] < 0 or used[-1] >= len(x):
        return _flat(x, path)
    return replace(_flat(x[used], path), vertex=used, faces=corners.reshape(-1, 3), size=len(x))


def _flat(x: FloatArray, path: Path) -> PlaneImages:
    """Images whose third coordinates agree."""
    if np.ptp(x[:, 2]) != 0:
        raise MeshError(
            f"{path} holds no map to the plane: its third coordinates differ, and it has no texture "
            "coordinates; give a flat mesh, or a surface with texture coordinates"
        )
    return PlaneImages(np.ascontiguousarray(x[:, :2]), len(x))


def _numbered(vertex: IntArray) -> tuple[IntArray, IntArray]:
    """The first row of each distinct vertex, and for each row the number of its vertex; each -1 is a vertex.

    >>> _numbered(np.array([7, 3, 7, -1, -1]))[1].tolist()
    [0, 1, 0, 2, 3]
    """
    new = vertex < 0
    key = np.where(new, vertex.max() + np.cumsum(new), vertex)
    _, first, index = np.unique(key, return_index=True, return_inverse=True)
    return np.sort(first), np.searchsorted(np.sort(first), first[index])


def _unseamed(known: ObjTexture, n: int) -> PlaneImages:
    """Give each of n vertices its texture coordinates; cut the surface where some have several, or none."""
    vertex, row = known.vertex.ravel(), known.row.ravel()
    of = np.full(n, -1)
    of[vertex] = row
    if (of[vertex] == row).all() and (of >= 0).all():
        return PlaneImages(known.uv[of], n, True)
    pairs, corner = np.unique(np.column_stack((row, vertex)), axis=0, return_inverse=True)
    return PlaneImages(known.uv[pairs[:, 0]], n, True, pairs[:, 1], corner.reshape(-1, 3))
