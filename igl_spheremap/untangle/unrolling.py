"""From a map that may be folded to a layout by closed angles: where to cut the hole, and which angles to aim at."""

from __future__ import annotations

import numpy as np

from ..mesh.arrays import FloatArray, IntArray
from ..mesh.check import Mesh
from ..mesh.measure import corner_angles, log_edges
from ..sphere.rows import to_chart, unit_rows
from ..start.punctured import candidate_faces
from ..verify.signs import folded_faces
from .angles import CLOSED, close_angles, proper_angles
from .blocks import VertexBlocks
from .layout import Inverted, Layout
from .placed import Placed, centred, plane_angles

#: Number of faces, those with the largest images, of which the best shaped one is cut out.
_LARGEST = 60
#: Faces with shorter edges keep the mesh's own angles: projection changes theirs by less than its rounding does.
_SMALL = np.log(1e-4)
#: Angles of a map with a larger share of faces folded are not used, not even around the hole (needle, dumbbell).
_LOST = 0.25


def unroll(mesh: Mesh, x: FloatArray, blocks: VertexBlocks) -> Placed | None:
    """The body laid out in the plane by closed angles, a face of its middle at infinity; None if they do not close."""
    source = proper_angles(corner_angles(mesh.v, mesh.f))
    lost = bool(folded_faces(x, mesh.f).mean() > _LOST)
    hole = next(candidate_faces(mesh)) if lost else _hole(mesh.f, source, -log_edges(x, mesh.f))
    closed = close_angles(blocks, source if lost else _targets(mesh.f, source, x, hole), hole)
    if closed.residual > CLOSED:
        return None
    layout = Layout(mesh.f, closed.angles, hole)
    placed = centred(mesh, layout)
    if hole in _largest(mesh.f, placed.depth):
        return placed
    return centred(mesh, Inverted(layout, _hole(mesh.f, source, placed.depth)))


def _hole(f: IntArray, source: FloatArray, depth: FloatArray) -> int:
    """The best shaped of the faces with the largest images."""
    largest = _largest(f, depth)
    return int(largest[np.argmax(source[largest].min(axis=1))])


def _largest(f: IntArray, depth: FloatArray) -> IntArray:
    """Faces with the largest images."""
    return np.argsort(depth[f].max(axis=1), kind="stable")[:_LARGEST]


def _targets(f: IntArray, source: FloatArray, x: FloatArray, hole: int) -> FloatArray:
    """What stereographic projection from the hole makes of the mesh's angles, by a map that is good around it."""
    pole = -unit_rows(x[f[hole]].sum(axis=0, keepdims=True))
    z = to_chart(x, pole)
    plane, ball = plane_angles(z[f]), corner_angles(x, f)
    known = np.isfinite(plane + ball).all(axis=1) & (log_edges(x, f)[f].min(axis=1) > _SMALL)
    usable = known & ~folded_faces(x, f) & (plane > 0).all(axis=1)
    return proper_angles(source + np.where(usable[:, None], plane - ball, 0))
