"""The check of a mesh, once, in numpy, before libigl gets it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, Protocol, cast, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import breadth_first_order, connected_components

from .. import wings
from ..errors import MeshError, Remedy
from ..gate import MeshLike, gate, takes_mesh
from ..timings import phase
from .arrays import (
    EPS,
    BoolArray,
    FloatArray,
    IntArray,
    check_rows,
    check_triangles,
    count,
    examples,
    plain_array,
    plural,
)
from .edges import HalfEdges, half_edges
from .measure import corner_angles, face_areas, vertex_normals, vertex_shares

#: If area over squared extent is at most this, the area is rounding: the mesh is scaled to unit extent.
_NO_AREA = 512 * EPS
#: Least vertex area, in units of the mean: the L2 metric divides by areas, which slivers may lack. Raising them changes
#: the sum in the ninth digit at most.
LEAST_AREA = 1e-9


class CheckedFaces:
    """Base of `Mesh` and `Disk`: read-only arrays, on which certificates rest, and measures of their faces."""

    v: FloatArray
    unit: FloatArray
    f: IntArray
    caps: BoolArray | None

    def __post_init__(self) -> None:
        for array in vars(self).values():
            if isinstance(array, np.ndarray):
                array.flags.writeable = False

    @property
    def surface(self) -> slice | BoolArray:
        """The faces that are not caps, as an index of rows."""
        if self.caps is None:
            return slice(None)
        return ~self.caps

    @cached_property
    def angles(self) -> FloatArray:
        """Corner angles (m, 3), in radians."""
        return corner_angles(self.unit, self.f)

    @cached_property
    def normals(self) -> FloatArray:
        """Area-weighted unit normals at the vertices (n, 3): the Gauss map."""
        return vertex_normals(self.unit, self.f)


@dataclass(frozen=True, eq=False)
class Mesh(CheckedFaces):
    """A closed, oriented, connected genus-0 triangle mesh that `check_mesh` has passed.

    Attributes
    ----------
    v : (n, 3) float64 array
        The input's vertices, in the input's units. All arrays are read-only, since certificates are of them.
    unit : (n, 3) float64 array
        The vertices moved to the origin and scaled to unit total area.
    f : (m, 3) int64 array
        The input's faces, 0-based, in the input's order.
    edges : HalfEdges
        The pattern of sparse matrices on the mesh.
    A : (n,) float64 array
        Vertex areas A_i of eq. (13) with sum 1, none below a billionth of their mean; all equal if the surface has no
        area. Unless `SphereMapper.map` is given other weights, the Moebius gauge balances them. Caps have no share in
        them.
    areas : (n,) float64 array
        Vertex areas as `A`, with those of caps included.
    caps : (m,) bool array or None
        Faces that only close holes and cuts; None if there are none.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> mesh = ism.check_mesh(*ism.samples.sphere(42))
    >>> mesh.v.shape, round(float(mesh.A.sum()), 12)
    ((42, 3), 1.0)
    """

    v: FloatArray
    unit: FloatArray
    f: IntArray
    edges: HalfEdges
    A: FloatArray
    areas: FloatArray
    caps: BoolArray | None = None

    def __repr__(self) -> str:
        return f"Mesh({len(self.v)} vertices, {len(self.f)} faces)"


@takes_mesh
@phase("check")
def check_mesh(v: ArrayLike, f: ArrayLike, *, caps: ArrayLike | None = None) -> Mesh:
    """Check that `v, f` is a closed, oriented, connected genus-0 mesh, and normalise it.

    Parameters
    ----------
    v : (n, 3) array_like
        Vertex positions, any units, any real dtype whose numbers float64 holds, byte order and memory layout. Never
        mutated.
    f : (m, 3) array_like
        Faces as 0-based vertex indices, any integer dtype (or floats that are whole numbers).
    caps : (m,) array_like of bool, optional
        Faces that only close holes and cuts, ``mesh.face_source < 0`` of a `RepairedMesh`: they weigh nothing in the
        gauge and stay out of all figures. By default there are none.

    Returns
    -------
    Mesh
        The checked mesh; it shares no memory with the input.

    Raises
    ------
    MeshError
        One line that names the fault, its place and the repair.

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
    igl_spheremap.errors.MeshError: open surface: 1 hole (3 edges) near (-0.333, -0.333, -0.333), ...
    """
    return checked(v, f, caps, partial(wings.refusal, asked=Remedy("repair_mesh")))


def checked(
    v: ArrayLike, f: ArrayLike, caps: ArrayLike | None, refusal: Callable[..., Any]
) -> Mesh:
    """`check_mesh`, whose errors `refusal` makes, as of `_check_sphere`."""
    vertices = np.array(check_rows(v, name="vertices"))
    try:
        faces = check_triangles(f)
    except MeshError:
        wings.refuse_polygons(vertices, f)
        raise
    edges = _check_sphere(faces, len(vertices), vertices, refusal)
    closing = None
    if caps is not None:
        closing = check_caps(caps, len(faces))
    return _mesh(vertices, faces, edges, closing)


@phase("check")
def move_mesh(mesh: Mesh, v: ArrayLike) -> Mesh:
    """The mesh with other positions; MeshError if their number differs."""
    vertices = check_positions(v)
    check_rows(vertices, len(mesh.v), "vertices")
    return _mesh(vertices, mesh.f, mesh.edges, mesh.caps)


@runtime_checkable
class MapLike(Protocol):
    """Holds a checked mesh and a map of it to the sphere, as `SphereMap` does."""

    @property
    def mesh(self) -> Mesh: ...

    @property
    def sphere(self) -> FloatArray: ...


def rows_and_faces(
    x: ArrayLike | MapLike | MeshLike, f: ArrayLike | Mesh | MeshLike | None
) -> tuple[ArrayLike, ArrayLike | Mesh]:
    """Images and faces; a map or a mesh may be given for both, and a mesh for its faces.

    Missing faces are a TypeError.
    """
    rows, own = cast(ArrayLike, x), cast("ArrayLike | Mesh | None", None)
    if isinstance(x, MapLike):
        rows, own = x.sphere, x.mesh
    elif not isinstance(x, np.ndarray):
        rows, own = wings.sphere_and_faces(x)
    if f is None:
        f = own
    elif not isinstance(f, Mesh | np.ndarray):
        f = wings.faces_of(f)
    if f is None:
        raise TypeError(
            "faces are missing: give positions and faces, or a SphereMap or a mesh alone"
        )
    return rows, cast("ArrayLike | Mesh", f)


@gate
def check_faces(f: ArrayLike | Mesh, n_vertices: int) -> IntArray:
    """The faces of a closed, oriented, connected genus-0 mesh that uses all its vertices, copied; those of a `Mesh`.

    >>> check_faces([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], 4).shape
    (4, 3)
    """
    if isinstance(f, Mesh):
        if len(f.v) != n_vertices:
            raise MeshError(
                f"there are {n_vertices} rows but the mesh has {len(f.v)} vertices; give one row each"
            )
        return f.f
    faces = check_triangles(f)
    _check_sphere(faces, n_vertices, None, partial(wings.refusal, asked=Remedy("repair_mesh")))
    return faces


def check_positions(v: ArrayLike) -> FloatArray:
    """A copy of the positions; MeshError unless they are finite rows of three."""
    vertices = np.array(check_rows(v, name="vertices"))
    bad = not_finite(vertices)
    if len(bad):
        raise MeshError(
            f"not finite: {count(bad, 'vertex', 'vertices')} with NaN or infinite coordinates, "
            f"{examples(bad)}; correct or remove them"
        )
    return vertices


def not_finite(v: FloatArray) -> IntArray:
    """Rows with a coordinate that is NaN or infinite."""
    if np.isfinite(v).all():
        return np.empty(0, dtype=np.int64)
    return np.flatnonzero(~np.isfinite(v).all(axis=1))


def check_caps(caps: ArrayLike, m: int) -> BoolArray | None:
    """The faces that are caps; None if there are none."""
    array = plain_array(caps, "caps")
    if array.dtype != bool or array.shape != (m,):
        raise MeshError(
            f"caps have shape {array.shape} and dtype {array.dtype} but the mesh has {m} faces; give one "
            "boolean each"
        )
    if array.all():
        raise MeshError("all faces are caps; give the surface, too")
    if not array.any():
        return None
    return array.copy()


def check_indices(f: IntArray, n: int) -> None:
    """MeshError unless all indices are below n and none is negative."""
    low, high = int(f.min()), int(f.max())
    if low < 0 or high >= n:
        bad = np.flatnonzero(((f < 0) | (f >= n)).any(axis=1))
        hint = "correct the faces or add the missing vertices"
        if low == 1 and high == n:
            hint = "they look 1-based: subtract 1"
        raise MeshError(
            f"index out of range: {count(bad, 'face')} outside 0..{n - 1}, {examples(bad)}, e.g. "
            f"{f[bad[0]].tolist()}; {hint}"
        )


def _check_sphere(
    f: IntArray, n: int, v: FloatArray | None, refuse: Callable[..., Any]
) -> HalfEdges:
    """Half-edges; a MeshError unless each edge has two opposite faces, and the faces form one sphere.

    `refuse` makes a `mesh_repair.refusal.Refusal`, whose methods raise the errors of the faults. With faces connected
    across edges and every vertex used, V - E + F = 2 - 2 g - (extra vertex fans), so that the Euler characteristic 2
    rules out handles and pinched vertices at once.
    """
    if n < 4:
        raise MeshError(
            f"{plural(n, 'vertex', 'vertices')}: a closed surface has at least 4, and 4 faces; give a "
            "closed mesh"
        )
    check_indices(f, n)
    m = len(f)
    refusal = partial(refuse, f, n, v)
    if v is not None and len(bad := not_finite(v)):
        refusal().not_finite(bad)
    found = half_edges(f, n)
    if found is None:
        refusal().half_edges()
    edges = cast(HalfEdges, found)
    unused = np.diff(edges.indptr) == 1  # the diagonal only
    if unused.any():
        refusal().unreferenced(np.flatnonzero(unused))
    twin = edges.twins()
    # one number, broadcast; scipy's graph functions copy values that are not float64
    ones = np.broadcast_to(1.0, 3 * m)
    neighbours = csr_matrix(
        (ones, twin // 3, np.arange(0, 3 * m + 1, 3, dtype=np.int32)), shape=(m, m)
    )
    if len(breadth_first_order(neighbours, 0, return_predecessors=False)) < m:
        refusal().components(connected_components(neighbours, directed=False)[1])
    if n - 3 * m // 2 + m != 2:
        refusal().characteristic(twin)
    return edges


def _mesh(vertices: FloatArray, f: IntArray, edges: HalfEdges, caps: BoolArray | None) -> Mesh:
    v, areas = normalised(vertices, f)
    A = with_caps = area_weights(areas, f, len(vertices))
    if caps is not None:
        A = area_weights(np.where(caps, 0.0, areas), f, len(vertices))
    return Mesh(vertices, v, f, edges, A, with_caps, caps)


def normalised(vertices: FloatArray, f: IntArray) -> tuple[FloatArray, FloatArray]:
    """Vertices about the origin, scaled to unit area (if that vanishes, to unit extent), and areas of faces."""
    size = float(np.abs(vertices).max())
    if size == 0:
        size = 1.0
    v = np.ascontiguousarray(vertices.T) / size  # long inner loops
    v -= (v.min(axis=1, keepdims=True) + v.max(axis=1, keepdims=True)) / 2
    extent = float(np.abs(v).max())
    if extent < 4 * EPS:  # coordinates of up to 1 that differ by rounding
        raise MeshError(
            "zero area: all vertices are at one point, e.g. 0, 1, 2; give positions with an extent"
        )
    v /= extent
    areas = face_areas(v.T, f)
    area = float(areas.sum())
    if area > _NO_AREA:
        v /= np.sqrt(area)
    return np.ascontiguousarray(v.T), areas


def area_weights(areas: FloatArray, f: IntArray, n: int) -> FloatArray:
    """Areas of `n` vertices with sum 1, none below a billionth of their mean, from the areas of faces."""
    return normalised_weights(vertex_shares(areas, f, n), float(areas.sum()))


def normalised_weights(shares: FloatArray, area: float) -> FloatArray:
    """Shares of an area with sum 1, none below a billionth of their mean; without area all equal."""
    if not area > _NO_AREA:
        return np.full(len(shares), 1 / len(shares))
    A = np.maximum(shares, LEAST_AREA * area / len(shares))
    return np.asarray(A / A.sum())
