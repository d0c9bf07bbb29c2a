"""Maps of a coarse body to choose from: layouts without one face or another, in gauges that fold few faces.

On coarse bodies the choice of the hole, the face that is cut out, changes angle differences by factors. A layout has
straight sides in the plane. On the sphere sides are arcs of great circles, and hundreds of vertices may lie between a
long arc and the image of the straight side. So which faces fold depends on the gauge, and it is chosen before anything
is repaired.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain, islice
from operator import itemgetter

import numpy as np

from ..mesh.arrays import FloatArray
from ..mesh.check import Mesh
from ..mesh.measure import by_blocks, corner_angles, face_areas, spread
from ..newton.system import VertexSystem
from ..sphere.moebius import moebius
from ..start.punctured import candidate_faces
from ..untangle.local_repair import small_moves
from ..verify.distortion import mean_difference
from ..verify.signs import folded_faces, signed_volumes
from .angles import close_angles, proper_angles
from .layout import Layout, Placed, centred, onto_sphere
from .match_angles import covers_once

#: Nepers: on a body whose limbs are at most this deep rounding turns edges by at most .001 (float64's eps times e^29).
#: With 18 a part of a robot ends at 11.8 degrees, not 9.2.
_DEEPEST = 29.0
#: Gauges are compared by the angles of at most this many faces. With 250 every second part of the set tune ends alike,
#: 2 worse and 2 better (`python -m benchmarks versions . FOLDER/tune --every 2 --set angles.candidates._SAMPLE=250`).
_SAMPLE = 1000
#: Where gauges are compared, this mean angle difference, in degrees, counts as much as a fold of all faces. With 10
#: every eighth part of the set tune ends 2.7 percent higher, with 100 the same.
_FOLDED = 30.0
#: Number of Moebius maps that are tried, enough for the search to settle, and how far the first ones move the sphere's
#: centre. Of every eighth part of the set tune only three depend on these numbers, too few to choose by: they end 1.3
#: percent lower with 30 maps, .2 percent lower with .2, and 2.4 percent higher with .8.
_GAUGES, _FIRST = 60, 0.4


def unfolded_first(
    mesh: Mesh, maps: Iterable[FloatArray]
) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Yield each map in the Moebius gauge that folds fewest faces, and the same map after small moves.

    Maps that still fold after small moves come last, the least bad first: embedding spoils many of them.
    """
    badness, folded = Badness(mesh), list[tuple[float, FloatArray, FloatArray]]()
    for y in maps:
        after_moves = small_moves(y, mesh.f)
        if badness.folded(after_moves):
            y = least_folded(y, badness)
            after_moves = small_moves(y, mesh.f)
        if folded_faces(after_moves, mesh.f).any():
            folded.append((badness(y), y, after_moves))
        else:
            yield y, after_moves
    for _, y, after_moves in sorted(folded, key=itemgetter(0)):
        yield y, after_moves


def layouts(
    mesh: Mesh, placed: Placed | None, system: VertexSystem, holes: int
) -> Iterator[FloatArray]:
    """Yield the map of a layout, then those of layouts around up to `holes` other faces, by the mesh's own angles.

    Layouts with limbs that are too deep for Moebius maps are left out.
    """
    if placed is not None:
        yield onto_sphere(placed, placed.points)
    source = proper_angles(mesh.angles)
    # Well-shaped faces of middling size, and the largest, in turn.
    pairs = zip(
        candidate_faces(mesh),
        np.argsort(-face_areas(mesh.unit, mesh.f), kind="stable").tolist(),
        strict=False,
    )
    for hole in islice(dict.fromkeys(chain.from_iterable(pairs)), holes):
        closed = close_angles(system, source, hole)
        if closed is not None:
            placed = centred(mesh, Layout.of(mesh.f, closed, hole))
            if placed.depth.max() < _DEEPEST:
                yield onto_sphere(placed, placed.points)


class Badness:
    """Measures how bad maps of a mesh are: their mean angle difference and their foldings, in degrees."""

    def __init__(self, mesh: Mesh) -> None:
        self.f, self.sample = mesh.f, mesh.f[spread(len(mesh.f), _SAMPLE)]
        self.source = corner_angles(mesh.unit, self.sample)

    def __call__(self, x: FloatArray) -> float:
        """Mean angle difference of a sample of faces, plus .3 degrees for each percent of faces that fold."""
        return mean_difference(self.source, x, self.sample) + _FOLDED * self.folded(x)

    def folded(self, x: FloatArray) -> float:
        """Share of the faces that fold; 1 where the degree is not 1.

        A map of degree 0 may fold a single face, within whose image all others lie.
        """
        return (
            float((by_blocks(signed_volumes, x, self.f) <= 0).mean())
            if covers_once(x, self.f)
            else 1.0
        )


def least_folded(x: FloatArray, badness: Badness) -> FloatArray:
    """The Moebius image of a map with the least badness; the map itself if that image folds no fewer faces."""
    from scipy.optimize import minimize  # takes .2 s, which maps without foldings don't need

    def moved(b: FloatArray) -> FloatArray:
        return moebius(x, b / np.sqrt(1 + b @ b))

    simplex = np.vstack((np.zeros(3), _FIRST * np.eye(3)))
    options = {"maxfev": _GAUGES, "initial_simplex": simplex, "xatol": 0.01, "fatol": 0.001}
    found = minimize(lambda b: badness(moved(b)), simplex[0], method="Nelder-Mead", options=options)
    y = moved(found.x)
    return y if badness.folded(y) < badness.folded(x) else x
