"""The check of a mesh: once, in numpy, before libigl gets it."""

from __future__ import annotations

import weakref
from dataclasses import dataclass
from typing import Any, NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import breadth_first_order, connected_components

from ..errors import MeshError, own_errstate
from .arrays import FloatArray, IntArray
from .edges import HalfEdges, half_edges
from .explain import REPAIR, REPAIR_LARGEST, count, examples, explain_characteristic, explain_edges, listed
from .measure import face_areas, vertex_shares
from .timings import stage

_EPS = np.finfo(float).eps
#: Below this ratio of area to squared extent the area is rounding, and the extent sets the scale.
_FLAT = 512 * _EPS
#: Smallest vertex area, in units of the mean, that the L2 metric divides by: slivers may have none at all.
_LEAST_AREA = 1e-9
#: Those of the last mesh that was checked: the same faces come again when its map is certified, and when only its
#: positions change.
_last: weakref.ref[HalfEdges] | None = None


@dataclass(frozen=True, eq=False)
class Mesh:
    """A closed, oriented, connected genus-0 triangle mesh that `check_mesh` has passed.

    Attributes
    ----------
    vertices : (n, 3) float64 array
        The input's vertices, in the input's units.
    v : (n, 3) float64 array
        The vertices moved to the origin and scaled to unit total area.
    f : (m, 3) int64 array
        The input's faces, 0-based, in the input's order.
    edges : HalfEdges
        The pattern of sparse matrices on the mesh.
    A : (n,) float64 array
        Vertex areas A_i of eq. (13) with sum 1, none below a billionth of their mean; all equal where the surface has
        no area. What the gauge balances: weights given to `SphereMapper.map` take their place.
    """

    vertices: FloatArray
    v: FloatArray
    f: IntArray
    edges: HalfEdges
    A: FloatArray


@own_errstate
@stage("check")
def check_mesh(v: ArrayLike, f: ArrayLike) -> Mesh:
    """Check that `v, f` is a closed, oriented, connected genus-0 mesh, and normalise it.

    Parameters
    ----------
    v : (n, 3) array_like
        Vertex positions, any real dtype, byte order and memory layout. Never mutated.
    f : (m, 3) array_like
        Faces as 0-based vertex indices, any integer dtype (or floats that are whole numbers).

    Returns
    -------
    Mesh
        The checked mesh; it shares no memory with the input.

    Raises
    ------
    MeshError
        One line that says what is wrong, where, and what repairs it.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]
    >>> mesh = ism.check_mesh(v, [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    >>> mesh.v.shape, mesh.f.dtype
    ((4, 3), dtype('int64'))
    >>> ism.check_mesh(v, [[0, 1, 2], [0, 2, 3], [0, 3, 1]])
    Traceback (most recent call last):
        ...
    igl_spheremap.errors.MeshError: open surface: 3 boundary edges, e.g. 1-2, 2-3, 3-1; close the holes ...
    """
    vertices = _positions(v)
    faces = check_triangles(f)
    global _last
    edges = _sphere_edges(faces, len(vertices))
    _last = weakref.ref(edges)
    return _normalised(vertices, faces, edges)


@stage("check")
def move_mesh(mesh: Mesh, v: ArrayLike) -> Mesh:
    """The mesh with other positions; MeshError if their number differs."""
    vertices = _positions(v)
    check_rows(vertices, len(mesh.v), "vertices")
    return _normalised(vertices, mesh.f, mesh.edges)


@own_errstate
def check_faces(f: ArrayLike, n_vertices: int) -> IntArray:
    """Check that `f` is the face list of a closed, oriented, connected genus-0 mesh.

    Parameters
    ----------
    f : (m, 3) array_like
        Faces as 0-based vertex indices.
    n_vertices : int
        Number of vertices; each must be used.

    Returns
    -------
    (m, 3) int64 array
        A copy of the faces, C-contiguous.

    Raises
    ------
    MeshError
        One line that says what is wrong, where, and what repairs it.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> ism.check_faces([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], 4).shape
    (4, 3)
    """
    faces = check_triangles(f)
    _sphere_edges(faces, n_vertices)
    return faces


def plain_array(values: ArrayLike, name: str) -> NDArray[Any]:
    """`values` as an array, or MeshError where rows differ in length or entries are masked."""
    if isinstance(values, np.ma.MaskedArray):
        raise MeshError(f"{name} are a masked array; give plain numbers and fill what is masked")
    try:
        return np.asarray(values)
    except ValueError as error:
        raise MeshError(f"{name} are ragged: rows differ in length; triangulate polygons first") from error


def _real_array(values: ArrayLike, name: str) -> NDArray[Any]:
    array = plain_array(values, name)
    if array.dtype.kind not in "fiub":
        raise MeshError(f"{name} have dtype {array.dtype}; give real numbers")
    return array


def check_values(values: ArrayLike, n_vertices: int, name: str = "values") -> FloatArray:
    """Data at the vertices as (n, k) float64 rows, one for each; MeshError where one is missing or not finite."""
    array = _real_array(values, name)
    if array.ndim not in (1, 2) or len(array) != n_vertices:
        raise MeshError(f"{name} have shape {array.shape} but the mesh has {n_vertices} vertices; give one row each")
    array = array.reshape(n_vertices, -1).astype(np.float64)
    bad = np.flatnonzero(~np.isfinite(array).all(axis=1))
    if len(bad):
        raise MeshError(f"{name} are not finite at {len(bad)} vertices, e.g. {bad[:3].tolist()}; fill them in")
    return array


def check_rows(x: ArrayLike, n_vertices: int | None = None, name: str = "positions") -> FloatArray:
    """Real numbers of any dtype, byte order and layout as a C-contiguous (n, 3) float64 array, finite or not.

    Raises MeshError for anything else, and for another number of rows than `n_vertices` where that is given.
    """
    array = _real_array(x, name)
    if array.ndim != 2 or array.shape[1] != 3:
        raise MeshError(f"{name} have shape {array.shape}; give one row of three coordinates per "
                        f"vertex{_transposed(array)}")
    if n_vertices is not None and len(array) != n_vertices:
        raise MeshError(f"{name} have {len(array)} rows but the mesh has {n_vertices} vertices; give one row each")
    return np.ascontiguousarray(array, dtype=np.float64)


def check_directions(x: ArrayLike, n_vertices: int | None = None, name: str = "positions") -> FloatArray:
    """`check_rows`, and MeshError for rows that are zero or not finite."""
    rows = check_rows(x, n_vertices, name)
    bad = np.flatnonzero(~np.isfinite(rows).all(axis=1) | ~rows.any(axis=1))
    if len(bad):
        raise MeshError(f"{name} are zero or not finite in {count(bad, 'row')}, {examples(bad)}; give each a direction")
    return rows


def check_triangles(f: ArrayLike) -> IntArray:
    """Whole numbers of any dtype, byte order and layout as a new (m, 3) int64 array, in range or not.

    Raises MeshError for anything else, and where there are no faces.
    """
    array = plain_array(f, "faces")
    if array.size == 0:
        raise MeshError("no faces: the mesh is empty or a point cloud; give a closed triangle mesh")
    if array.ndim != 2 or array.shape[1] != 3:
        raise MeshError(f"faces have shape {array.shape}; give triangles, one row of three indices "
                        f"each{_transposed(array)}; triangulate polygons first")
    if array.dtype.kind == "f":
        if not np.isfinite(array).all() or (array != np.floor(array)).any():
            raise MeshError("faces are not whole numbers; give 0-based vertex indices")
    elif array.dtype.kind not in "iu":
        raise MeshError(f"faces have dtype {array.dtype}; give 0-based vertex indices")
    return np.array(array, dtype=np.int64, order="C")


def _transposed(array: NDArray[Any]) -> str:
    return " (it looks transposed)" if array.ndim == 2 and array.shape[0] == 3 else ""


def _positions(v: ArrayLike) -> FloatArray:
    vertices = np.array(check_rows(v, name="vertices"))
    if not np.isfinite(vertices).all():
        bad = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
        raise MeshError(f"not finite: {count(bad, 'vertex', 'vertices')} with NaN or infinite coordinates, "
                        f"{examples(bad)}; correct or remove them")
    return vertices


def _check_indices(f: IntArray, n: int) -> None:
    if n < 4:
        raise MeshError(f"{n or 'no'} vertices: a closed surface has at least 4, and 4 faces; give a closed mesh")
    low, high = int(f.min()), int(f.max())
    if low < 0 or high >= n:
        bad = np.flatnonzero(((f < 0) | (f >= n)).any(axis=1))
        one_based = low == 1 and high == n
        hint = "they look 1-based: subtract 1" if one_based else "correct the faces or add the missing vertices"
        raise MeshError(f"index out of range: {count(bad, 'face')} outside 0..{n - 1}, {examples(bad)}, e.g. "
                        f"{f[bad[0]].tolist()}; {hint}")


def _explain_half_edges(f: IntArray, n: int) -> NoReturn:
    repeated = (f[:, 0] == f[:, 1]) | (f[:, 1] == f[:, 2]) | (f[:, 2] == f[:, 0])
    if repeated.any():
        bad = np.flatnonzero(repeated)
        raise MeshError(f"degenerate: {count(bad, 'face')} with a repeated vertex index, {examples(bad)}; "
                        f"remove them ({REPAIR} does)")
    explain_edges(f, n)


def _sphere_edges(f: IntArray, n: int) -> HalfEdges:
    """`_check_sphere`, or its last result if that mesh still exists and has the same faces."""
    last = None if _last is None else _last()
    if last is not None and len(last.diagonal) == n and np.array_equal(last.faces, f):
        return last
    return _check_sphere(f, n)


def _check_sphere(f: IntArray, n: int) -> HalfEdges:
    """Half-edges; a MeshError unless each edge has two opposite faces, and the faces form one sphere.

    With faces connected across edges and every vertex used, V - E + F = 2 - 2 g - (extra vertex fans),
    so that the Euler characteristic 2 rules out handles and pinched vertices at once.
    """
    _check_indices(f, n)
    m, edges = len(f), half_edges(f, n)
    if edges is None:
        _explain_half_edges(f, n)
    alone = np.diff(edges.indptr) == 1
    if alone.any():
        bad = np.flatnonzero(alone)
        raise MeshError(f"unreferenced: {count(bad, 'vertex', 'vertices')} in no face, {examples(bad)}; "
                        f"remove them ({REPAIR} does)")
    twin = np.empty(3 * m + n, dtype=np.int32)
    twin[edges.half] = edges.twin
    twin = twin[: 3 * m]
    ones = np.broadcast_to(1.0, 3 * m)  # no memory, and scipy's graphs take no other type as it is
    neighbours = csr_matrix((ones, twin // 3, np.arange(0, 3 * m + 1, 3, dtype=np.int32)), shape=(m, m))
    if len(breadth_first_order(neighbours, 0, return_predecessors=False)) < m:
        components, label = connected_components(neighbours, directed=False)
        sizes = np.sort(np.bincount(label))[::-1]
        raise MeshError(f"{components} components of {listed(sizes)} faces; give one closed surface "
                        f"({REPAIR_LARGEST} does), face {int(np.argmax(label > 0))} is in the second one")
    if n - 3 * m // 2 + m != 2:
        explain_characteristic(f, twin, n)
    return edges


def _normalised(vertices: FloatArray, f: IntArray, edges: HalfEdges) -> Mesh:
    """The mesh about the origin, scaled to unit area (to unit extent where the area vanishes)."""
    size = float(np.abs(vertices).max())
    v = np.ascontiguousarray(vertices.T) / (size or 1.0)  # long inner loops
    v -= (v.min(axis=1, keepdims=True) + v.max(axis=1, keepdims=True)) / 2
    extent = float(np.abs(v).max())
    if extent < 4 * _EPS:
        raise MeshError("zero area: all vertices are at one point, e.g. 0, 1, 2; give positions with an extent")
    v /= extent
    areas, n = face_areas(v.T, f), len(vertices)
    area = float(areas.sum())
    A = np.full(n, 1 / n)
    if area > _FLAT:
        v /= np.sqrt(area)
        A = np.maximum(vertex_shares(areas, f, n), _LEAST_AREA * area / n)
        A /= A.sum()
    return Mesh(vertices, np.ascontiguousarray(v.T), f, edges, A)
