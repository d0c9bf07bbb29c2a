"""From angles that close to a layout in the plane, and from there onto the sphere.

Positions are sums along the tree of shortest edges, relative to any vertex. Between two neighbours the path in that
tree has no edge longer than the one that joins them. So positions relative to a tip are precise relative to the
distance from it, however small that is: the deepest limbs keep their shape. They are complex logarithms, the log
distance and the direction: distances range over thousands of nepers, and float64 ends at 709.

The depth of a vertex, in nepers, is minus the logarithm of the length of its edges on the sphere. Beside an end of an
axis with a tip (poles.py), coordinates are finer: there their length is divided by the distance from it.

`unroll` is the way through this file: it chooses the hole and the angles to aim at, closes these (close_angles.py),
lays the faces out by them (`Layout.of`), and puts the layout where the sphere is centred (`centred`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree

from ..mesh.arrays import ComplexArray, FloatArray, IntArray
from ..mesh.check import Mesh
from ..mesh.edges import half_edges, sides
from ..mesh.measure import corner_angles, log_edges, weighted_quantile
from ..newton.system import VertexSystem
from ..sphere.log_plane import (
    Anchored,
    exponential,
    log_sum,
    logarithm,
    plane_angles,
    rows_at,
    to_ball,
)
from ..sphere.moebius import best_rotation, conformal_barycentre, orientation_target
from ..sphere.rows import to_chart, unit_rows
from ..start.punctured import candidate_faces
from ..verify.signs import folded_faces
from .close_angles import close_angles, proper_angles

#: Logarithms of all positions relative to a vertex, precise relative to the distance from it.
About = Callable[[int], ComplexArray]


@dataclass(frozen=True, eq=False)
class Placed:
    """A layout whose place and size in the plane are chosen, for inverse stereographic projection to the sphere."""

    f: IntArray
    #: Logarithms of the positions.
    log: ComplexArray
    #: Depth of each vertex in nepers, as the head of this file says.
    depth: FloatArray
    about: About
    #: The point from which each position is measured: 0, or the end of an axis.
    anchor: ComplexArray | complex = 0j
    #: Nepers by which coordinates are finer at each vertex, because it is close to an end of an axis; infinite at the
    #: end.
    finer: FloatArray | float = 0.0
    #: Rotation of rows that follows inverse stereographic projection.
    turn: FloatArray = field(default_factory=lambda: np.eye(3))
    #: The face that was cut out, if one was.
    hole: int | None = None

    @property
    def inwards(self) -> FloatArray:
        """Depth of each vertex if coordinates were nowhere finer: it grows along a limb up to its tip."""
        return self.depth + self.finer

    @property
    def points(self) -> Anchored:
        """The positions with their anchors."""
        return Anchored(exponential(self.log), self.anchor)


def unroll(mesh: Mesh, x: FloatArray, system: VertexSystem, lost: float = 0.25) -> Placed | None:
    """The body laid out in the plane, a face of its middle at infinity; None if no closing angles are found.

    `x` is a map that may be folded; it shows the faces in the middle, and the change of angles there. If more than the
    share `lost` of its faces fold, it shows neither.
    """
    source = proper_angles(mesh.angles)
    if folded_faces(x, mesh.f).mean() > lost:
        hole, target = next(candidate_faces(mesh)), source
    else:
        hole = _hole(mesh.f, source, -log_edges(x, mesh.f))
        target = _targets(mesh.f, source, x, hole)
    closed = close_angles(system, target, hole)
    if closed is None:
        return None
    layout = Layout.of(mesh.f, closed, hole)
    placed = centred(mesh, layout)
    if hole in _largest(mesh.f, placed.depth):
        return placed
    return centred(mesh, layout.inverted(_hole(mesh.f, source, placed.depth)))


def _hole(f: IntArray, source: FloatArray, depth: FloatArray) -> int:
    """The best shaped of the faces with the largest images."""
    largest = _largest(f, depth)
    return int(largest[np.argmax(source[largest].min(axis=1))])


def _largest(f: IntArray, depth: FloatArray, number: int = 60) -> IntArray:
    """Faces with the largest images: many enough for a good shape, few enough to lie in the body's middle."""
    return np.argsort(depth[f].max(axis=1), kind="stable")[:number]


def _targets(
    f: IntArray, source: FloatArray, x: FloatArray, hole: int, short: float = 1e-4
) -> FloatArray:
    """The mesh's angles, changed as stereographic projection from the hole changes those of a map.

    Folded faces keep the mesh's angles, and so do those with `short` edges: projection changes angles by about the
    length of edges, there at most by a hundredth of a degree; rounding changes them by eps over the length.
    """
    pole = -unit_rows(x[f[hole]].sum(axis=0, keepdims=True))
    z = to_chart(x, pole)
    plane, ball = plane_angles(z[f]), corner_angles(x, f)
    known = np.isfinite(plane + ball).all(axis=1) & (log_edges(x, f)[f].min(axis=1) > np.log(short))
    usable = known & ~folded_faces(x, f) & (plane > 0).all(axis=1)
    return proper_angles(source + np.where(usable[:, None], plane - ball, 0))


@dataclass(frozen=True, eq=False)
class Layout:
    """A triangulated sphere without one face, laid out in the plane in any unit.

    Attributes
    ----------
    f : (m, 3) int64 array
        All faces.
    about : callable
        Positions relative to a vertex, see `About`.
    log_edge : (n,) float64 array
        Mean logarithm of the lengths of the edges around each vertex.
    hole : int
        The face that was cut out.
    """

    f: IntArray
    about: About
    log_edge: FloatArray
    hole: int

    @classmethod
    def of(cls, f: IntArray, angles: FloatArray, hole: int) -> Layout:
        """Lay the faces out by angles that close, without the face `hole`, along the shortest edges that join all."""
        n = len(f) // 2 + 2
        log_length, direction = lengths_and_directions(f, angles, hole)
        kept = np.repeat(np.arange(len(f)) != hole, 3)
        start, end = (vertices[kept] for vertices in sides(f))
        length, turn = log_length.ravel()[kept], direction.ravel()[kept]
        # each half-edge, and the way back
        key = np.append(start * n + end, end * n + start)
        order = np.argsort(key, kind="stable")
        steps = np.append(length, length)[order] + 1j * np.append(turn, turn + np.pi)[order]
        graph = sp.csr_matrix((length - length.min() + 1, (start, end)), shape=(n, n))
        tree = minimum_spanning_tree(graph.maximum(graph.T))
        about = partial(_summed, (tree + tree.T).tocsr(), key[order], steps)
        log_edge = np.bincount(start, length, n) / np.bincount(start, minlength=n)
        return cls(f, about, log_edge, hole)

    def inverted(self, face: int) -> Layout:
        """The layout after the inversion z -> 1 / (z - m) that takes the middle m of a face to infinity."""
        corner = int(self.f[face, 0])
        log, unit = self.about(corner), float(self.log_edge[corner])
        middle = np.exp(log[self.f[face]] - unit).mean()
        denominator = log_sum(log, unit + np.log(-middle))
        return Layout(
            self.f,
            about_images(self.about, denominator, 1j * np.pi),
            self.log_edge - 2 * denominator.real,
            self.hole,
        )


def about_images(about: About, denominator: ComplexArray, determinant: complex = 0j) -> About:
    """`About` the images under a Moebius map (a z + b) / (c z + d), given logarithms of c z + d and of a d - b c."""
    # algorithm (25)
    return lambda root: np.asarray(about(root) - denominator - denominator[root] + determinant)


def _summed(tree: sp.csr_matrix, key: IntArray, steps: ComplexArray, root: int) -> ComplexArray:
    """Positions relative to a vertex: sums along a tree of n vertices.

    The edge from i to j has the number n i + j, a `key`; its step is a log length and a direction.
    """
    n = tree.shape[0]
    order, parent = breadth_first_order(tree, root, directed=False)
    child = order[1:].astype(np.int64)
    above = parent[child].astype(np.int64)
    step = steps[np.searchsorted(key, above * n + child)]
    log, left, unit = np.full(n, -np.inf + 0j), np.ones(n, dtype=bool), step.real.max()
    # so that sums of thousands of edges, up to exp(9), are finite
    largest = np.log(np.finfo(float).max) - 9
    # sum in ever smaller units, until no distance underflows in one
    while left.sum() > 1 and unit > step.real.min() - largest:
        edge = np.exp(np.clip(step.real - unit, -largest, largest) + 1j * step.imag)
        z = [0j] * n
        for c, a, e in zip(child.tolist(), above.tolist(), edge.tolist(), strict=True):
            z[c] = z[a] + e
        here = logarithm(np.array(z))
        found = left & (here.real > -largest / 2)
        log[found], left[found] = here[found] + unit, False
        unit -= largest
    return log


def lengths_and_directions(
    f: IntArray, angles: FloatArray, hole: int
) -> tuple[FloatArray, FloatArray]:
    """Log length and direction of each half-edge, (m, 3): column k runs from corner k + 1 to k + 2.

    Faces take the length and the direction of an edge from a neighbour that has them, outwards from one beside the
    hole. The hole's own row is NaN.
    """
    m = len(f)
    sines = np.log(np.sin(angles))
    turn = np.column_stack(
        (np.zeros(m), np.pi - angles[:, 2], 2 * np.pi - angles[:, 2] - angles[:, 0])
    )
    edges = half_edges(f, m // 2 + 2)
    assert edges is not None, "the mesh is not closed"
    twin = edges.twins().astype(np.int64)
    scale, rotation = np.full(m, np.nan), np.zeros(m)
    front = twin[3 * hole : 3 * hole + 1] // 3
    done = np.zeros(m, dtype=bool)
    scale[front], done[front], done[hole] = 0.0, True, True
    while len(front):
        half = (3 * front[:, None] + np.arange(3)).ravel()
        other = twin[half]
        new = ~done[other // 3]
        front, first = np.unique(other[new] // 3, return_index=True)
        half, other = half[new][first], other[new][first]
        scale[front] = scale[half // 3] + sines.flat[half] - sines.flat[other]
        rotation[front] = rotation[half // 3] + turn.flat[half] + np.pi - turn.flat[other]
        done[front] = True
    return scale[:, None] + sines, rotation[:, None] + turn


def centred(mesh: Mesh, layout: Layout) -> Placed:
    """Place a layout so that inverse stereographic projection centres the area of the source."""
    log = layout.about(int(np.argmin(layout.log_edge)))
    unit = weighted_quantile(log.real, mesh.A)
    log -= unit
    # The conformal barycentre is a point (c, size) of the half-space over the plane: an affine map centres it.
    p = conformal_barycentre(rows_at(log), mesh.A)
    square = p[0] ** 2 + p[1] ** 2 + (1 + p[2]) ** 2
    size = np.log((1 - p @ p) / square)
    log, unit = log_sum(log, logarithm(-2 * (p[0] + 1j * p[1]) / square)) - size, unit + size
    # an edge of the plane is 2 / (1 + |z|^2) times as long on the sphere
    depth = unit + np.logaddexp(0, 2 * log.real) - np.log(2) - layout.log_edge
    turn = best_rotation(rows_at(log), orientation_target(mesh), mesh.A)
    return Placed(
        layout.f,
        log,
        depth,
        lambda tip: layout.about(tip) - unit,
        turn=turn,
        hole=layout.hole,
    )


def onto_sphere(placed: Placed, points: Anchored) -> FloatArray:
    """Unit rows at points of the plane of a placement."""
    x = to_ball(points) @ placed.turn.astype(np.longdouble)
    return (x / np.sqrt((x * x).sum(axis=1))[:, None]).astype(np.float64)
