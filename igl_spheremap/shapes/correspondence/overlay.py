"""The common refinement of two surfaces that are mapped to one sphere."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from ...gate import gate
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import HALF_DIGITS, FloatArray, IntArray, own_unit
from ...mesh.edges import marked
from ...resampling.locate import Location, at_vertices, joined, take_points
from ...resampling.transfer import interpolate
from ...sphere.rows import row_crosses, row_dots, row_lengths, unit_rows
from ...verify.signs import orientation_signs
from .cells import SHORT, Coincidences, cell_triangles
from .walk import Segments, Triangulation, locate_exactly, walk


@dataclass(frozen=True, eq=False)
class Overlay:
    """A mesh whose faces each lie in one face of the source and in one of the target.

    Attributes
    ----------
    faces : (m, 3) int64 array
        Vertex indices. The first vertices are those of the source; then come those of the target that lie at none
        of these, then the crossings of edges.
    on_source, on_target : (k, 3) float64 arrays
        The vertices on each surface.
    source_location, target_location : Location
        The same as faces of each with barycentric weights, for other data at their vertices.
    source_face, target_face : (m,) int64 arrays
        The faces of source and target that contain each face.
    target_vertex : (n_target,) int64 array
        Numbers of the vertices of the target.
    unresolved : (int, int)
        Faces without area on the source, and on the target: parts of limbs of the other that float64 does not resolve.
    """

    faces: IntArray
    on_source: FloatArray
    on_target: FloatArray
    source_location: Location
    target_location: Location
    source_face: IntArray
    target_face: IntArray
    target_vertex: IntArray
    unresolved: tuple[int, int] = (0, 0)

    def __repr__(self) -> str:
        return f"Overlay({len(self.on_source)} vertices, {len(self.faces)} faces)"


@gate
def overlay(source: SphereMap, target: SphereMap) -> Overlay:
    """Refine two triangulations of the sphere, of a source A and a target B, until they are one.

    Every edge of one mesh is followed through the faces of the other by exact signs. The faces of the result are the
    nonempty intersections of a face of A and a face of B, polygons of three to six sides, cut into triangles. Vertices
    of A at a vertex or on an edge of B and edges along each other are found exactly and give no faces without area.
    Nodes that float64 can't tell apart are merged on purpose, and counted. Vertices of B within some 6e-14 of vertices
    of A, as those of a map that was turned there and back, move onto these. If faces would be flat or negative, edges
    up to that length on both surfaces are collapsed. Every step keeps a triangulated sphere and hands over areas of
    that order at most. So the result is a closed oriented sphere without negative faces on A or on B. Few faces have no
    area on one of them, by rounding. If a whole limb of one surface, shrunk by a conformal map, lies in a speck of one
    face of the other, its faces have none there. These are counted, too.

    Parameters
    ----------
    source, target : SphereMap
        Two surfaces and their maps, in one frame.

    Returns
    -------
    Overlay
        A mesh with positions on both surfaces: on each of its faces the map between them is linear.

    Raises
    ------
    FoldingsRemain
        If a map is not certified folding-free.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> from igl_spheremap.shapes.correspondence.overlay import overlay
    >>> a, b = (ism.spherical_conformal_map(*ism.samples.make(name, n_vertices=300)) for name in ("spheroid", "pear"))
    >>> common = overlay(a, b)
    >>> len(common.faces) == 2 * len(common.on_source) - 4
    True
    """
    A = Triangulation(source.mesh, source.sphere)
    B = Triangulation(target.mesh, _snapped(target, source.sphere))
    of_a, of_b = locate_exactly(A.x, B), locate_exactly(B.x, A)
    alone, own = of_b.corners > 1, np.arange(len(A.x))
    other = np.where(alone, len(own) + np.cumsum(alone) - 1, of_b.part)
    first = len(own) + int(alone.sum())
    cut_a, cut_b = walk(A, B, of_a, own, other, first), walk(B, A, of_b, other, own, first)
    half_a, half_b = A.forward[cut_a.crossed[:, 0]], cut_a.crossed[:, 1]
    crossed = _crossings(A, half_a, B, half_b)
    source_location = joined(at_vertices(A.f), take_points(of_b.location, alone), crossed[0])
    target_location = joined(of_a.location, take_points(at_vertices(B.f), alone), crossed[1])
    crossings = interpolate(A.x, A.f, take_points(source_location, slice(first, None)))
    x = np.concatenate((A.x, B.x[alone], unit_rows(crossings)))
    (own_a, unit_a), (own_b, unit_b) = own_unit(source.vertices), own_unit(target.vertices)
    on_a, on_b = interpolate(own_a, A.f, source_location), interpolate(own_b, B.f, target_location)
    on = np.stack((on_a, on_b))
    faces, owners = cell_triangles(A, B, cut_a, _same_crossings(cut_a, cut_b, A, B, first), x)
    merged = Coincidences(faces, owners, on, (own_a[A.f], own_b[B.f]), (own, other))
    merged.merge()
    without_area = merged.join_points()
    source_face, target_face = merged.owners[:, merged.left]
    target_vertex = merged.node[other]
    target_location.face[target_vertex], target_location.weights[target_vertex] = at_vertices(B.f)
    used, corners = np.unique(merged.faces[merged.left], return_inverse=True)
    return Overlay(
        corners.reshape(-1, 3),
        np.ldexp(on[0, used], unit_a),
        np.ldexp(on[1, used], unit_b),
        take_points(source_location, used),
        take_points(target_location, used),
        source_face,
        target_face,
        np.searchsorted(used, target_vertex),
        without_area,
    )


def _snapped(b: SphereMap, x: FloatArray) -> FloatArray:
    """Move vertices of a map, in a copy of its sphere, to other points that are as near as rounding.

    Their edges then coincide exactly, too. If its faces would fold otherwise, a vertex keeps its place.
    """
    y, own = b.sphere.copy(), np.arange(len(b.sphere))
    distance, nearest = cKDTree(x).query(y, distance_upper_bound=SHORT)
    near = np.flatnonzero(distance < np.inf)
    back = cKDTree(y).query(x[nearest[near]])[1]
    near = near[back == own[near]]
    while len(near):
        y[near] = x[nearest[near]]
        folded = marked(b.faces[orientation_signs(unit_rows(y), b.faces) <= 0], len(y))
        if not folded[near].any():
            break
        y[folded] = b.sphere[folded]
        near = near[~folded[near]]
    return y


def _same_crossings(
    cut_a: Segments, cut_b: Segments, A: Triangulation, B: Triangulation, first: int
) -> Segments:
    """Number the crossings in the segments of B as in the segments of A."""
    (edge_a, half_b), (edge_b, half_a) = cut_a.crossed.T, cut_b.crossed.T
    key = A.edge(A.forward[edge_a]) * len(B.twin) + B.edge(half_b)
    order = np.argsort(key)
    again = A.edge(half_a) * len(B.twin) + B.edge(B.forward[edge_b])
    number = np.arange(first + len(key))
    number[first:] += order[np.searchsorted(key, again, sorter=order)] - np.arange(len(key))
    return replace(cut_b, start=number[cut_b.start], end=number[cut_b.end])


def _crossings(
    A: Triangulation, half_a: IntArray, B: Triangulation, half_b: IntArray
) -> tuple[Location, Location]:
    """Compute the crossings of half-edges of A and half-edges of B, as points of both."""
    a, b, c, d = A.x[A.start[half_a]], A.x[A.end[half_a]], B.x[B.start[half_b]], B.x[B.end[half_b]]
    on_a, on_b = _crossed(a, b, c, d), _crossed(c, d, a, b)
    normal_a, normal_b = unit_rows(row_crosses(a, b - a)), unit_rows(row_crosses(c, d - c))
    flat = row_lengths(row_crosses(normal_a, normal_b)) < HALF_DIGITS
    # If they are as good as on one great circle, their distances are rounding: any common point will do.
    a, b, c, d, ahead = (each[flat] for each in (a, b, c, d, row_crosses(normal_a, a)))
    whole, *ends = (np.arctan2(row_dots(ahead, p), row_dots(a, p)) for p in (b, c, d))
    low, high = (
        np.sin(end) / (np.sin(end) + np.sin(whole - end))
        for end in np.clip(np.sort(ends, axis=0), 0, whole)
    )
    on_a[flat] = np.clip(on_a[flat], low, high)
    point = a + on_a[flat, None] * (b - a)
    start, end = (row_lengths(row_crosses(point, p)) for p in (c, d))
    on_b[flat] = start / (start + end)
    return _on_sides(half_a, on_a), _on_sides(half_b, on_b)


def _crossed(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> FloatArray:
    """Compute the weight of `b` at crossings of edges c-d and a-b."""
    normal = row_crosses(c, d - c)
    start, end = (np.abs(row_dots(normal, p - c)) for p in (a, b))
    total = start + end
    return np.divide(start, total, out=np.full(len(a), 0.5), where=total > 0)


def _on_sides(half: IntArray, end: FloatArray) -> Location:
    """Return points of half-edges as points of faces; `end` is the weight of the end."""
    weights, rows = np.zeros((len(half), 3)), np.arange(len(half))
    weights[rows, (half + 1) % 3], weights[rows, (half + 2) % 3] = 1 - end, end
    return Location(half // 3, weights)
