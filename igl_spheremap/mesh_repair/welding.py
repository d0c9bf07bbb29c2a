"""Vertices along open edges that coincide or nearly do, and the tolerance that joins them."""

from __future__ import annotations

import numpy as np

from ..mesh.arrays import FloatArray, IntArray, own_unit, weld
from ..mesh.edges import components, shared_edges, sides
from . import LARGEST_WELD


def welded(v: FloatArray, f: IntArray, tolerance: float) -> tuple[IntArray, IntArray]:
    """The vertices on open edges, and for each the first vertex of its joined group.

    Vertices within `tolerance` diagonals of the bounding box are joined, and so all that such pairs link.
    """
    rows, _, edges, own = open_edges(v, f)
    rim = np.unique(edges)
    places, index = weld(own[rim])
    first = np.arange(len(places))
    if tolerance > 0:
        from scipy.spatial import cKDTree  # takes .1 s, which closed meshes don't need

        finite = np.flatnonzero(np.isfinite(places).all(axis=1))
        pairs = cKDTree(places[finite]).query_pairs(
            tolerance * diagonal(own), output_type="ndarray"
        )
        label = components(finite[pairs[:, 0]], finite[pairs[:, 1]], len(places))[1]
        first = np.unique(label, return_index=True)[1][label]
    return rows[rim], rows[rim[np.unique(index, return_index=True)[1]]][first][index]


def weld_tolerance(v: FloatArray, f: IntArray) -> float | None:
    """The tolerance for `welded` that the distances of a mesh suggest, a power of ten, or None.

    Distances from vertices on open edges to their nearest ones, and lengths of these edges: where vertices nearly
    coincide, a wide gap lies between both. The tolerance lies in the middle of the widest.
    """
    _, _, edges, own = open_edges(v, f)
    places = weld(own[np.unique(edges)])[0]
    if len(places) < 2 or not np.isfinite(own).all():
        return None
    length = np.linalg.norm(own[edges[0]] - own[edges[1]], axis=1)
    steps = np.log10(np.sort(np.concatenate((gaps(places), length[length > 0]))) / diagonal(own))
    widest = int(np.argmax(np.diff(steps)))
    low, high = steps[widest], steps[widest + 1]
    tolerance = 10.0 ** round((low + high) / 2)
    # between them lies a power of ten
    if high - low < 1 or tolerance > LARGEST_WELD:
        return None
    return tolerance


def gaps(places: FloatArray) -> FloatArray:
    """The distance from each place to the nearest other one; infinite if there is no other.

    >>> gaps(np.array([[0.0, 0, 0], [1, 0, 0], [4, 0, 0]])).tolist()
    [1.0, 1.0, 3.0]
    """
    from scipy.spatial import cKDTree  # takes .1 s, which maps don't need

    return np.asarray(cKDTree(places).query(places, k=2)[0][:, 1])


def open_edges(v: FloatArray, f: IntArray) -> tuple[IntArray, IntArray, IntArray, FloatArray]:
    """The vertices of faces, half-edges (k,) with one face, their ends (2, k), and positions in the mesh's own unit.

    Ends and positions are places among the vertices of faces.
    """
    rows, corners = np.unique(f, return_inverse=True)
    corners = corners.reshape(-1, 3)
    edge = shared_edges(corners, len(rows))[1]
    half = np.flatnonzero(np.bincount(edge)[edge] == 1)
    ends = np.stack(sides(corners))
    return rows, half, ends[:, half], own_unit(v[rows])[0]


def diagonal(own: FloatArray) -> float:
    """The diagonal of the bounding box of the positions that are finite."""
    finite = own[np.isfinite(own).all(axis=1)]
    if not len(finite):
        return 0.0
    return float(np.linalg.norm(np.ptp(finite, axis=0)))
