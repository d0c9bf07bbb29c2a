"""Layouts of a body to choose from: without one face or another, in gauges that fold few faces.

On coarse bodies the choice of the hole, the face that is cut out, changes angle differences by factors. A layout has
straight sides in the plane. On the sphere sides are arcs of great circles, and hundreds of vertices may lie between a
long arc and the image of the straight side. So the gauge determines the folded faces; it is chosen before any repair.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
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
from ..verify.certificate import Certificate
from ..verify.distortion import mean_difference
from ..verify.signs import folded_faces, signed_volumes
from .close_angles import close_angles, proper_angles
from .layout import Layout, Placed, centred, onto_sphere
from .match_angles import covers_once


@dataclass(frozen=True, eq=False)
class Start:
    """A map that may fold, before it is certified or repaired.

    Attributes
    ----------
    name : str
        How it was made, see `Round`.
    x : (n, 3) float64 array
        Unit rows.
    after_moves : (n, 3) float64 array, optional
        The same map after small moves, if these were tried.
    stretch, gauge : float, str
        Of its limbs, see `Run`.
    certificate : Certificate, optional
        Its certificate, if that is known.
    """

    name: str
    x: FloatArray
    after_moves: FloatArray | None = None
    stretch: float = 1.0
    gauge: str = "centred"
    certificate: Certificate | None = None


def from_the_best(mesh: Mesh, starts: Iterable[Start]) -> Iterator[Start]:
    """Yield starts in the Moebius gauges that fold fewest faces, after comparing all by their angles.

    Those that fold even after small moves come last: embedding spoils many of them.
    """
    badness, ranked = Badness(mesh), list[tuple[bool, float, Start]]()
    for start in starts:
        x = start.x
        after_moves = small_moves(x, mesh.f)
        if badness.folded(after_moves):
            x = least_folded(x, badness)
            after_moves = small_moves(x, mesh.f)
        start = replace(start, x=x, after_moves=after_moves)
        folds = bool(folded_faces(after_moves, mesh.f).any())
        ranked.append((folds, badness(after_moves), start))
    for _, _, start in sorted(ranked, key=itemgetter(0, 1)):
        yield start


def layouts(
    mesh: Mesh, placed: Placed | None, system: VertexSystem, holes: int, deepest: float = 29.0
) -> Iterator[Start]:
    """Yield a placement, then layouts around up to `holes` other faces, by the mesh's own angles.

    Layouts with limbs deeper than `deepest` nepers are left out: Moebius maps round them, and turn edges by more than
    .001, float64's eps times e^29.
    """
    first = None
    if placed is not None:
        first = placed.hole
        yield Start("angles", onto_sphere(placed, placed.points))
    source = proper_angles(mesh.angles)
    # Well-shaped faces of middling size, and the largest, in turn.
    pairs = zip(
        candidate_faces(mesh),
        np.argsort(-face_areas(mesh.unit, mesh.f), kind="stable").tolist(),
        strict=False,
    )
    others = (hole for hole in dict.fromkeys(chain.from_iterable(pairs)) if hole != first)
    for hole in islice(others, holes):
        closed = close_angles(system, source, hole)
        if closed is not None:
            placed = centred(mesh, Layout.of(mesh.f, closed, hole))
            if placed.depth.max() < deepest:
                yield Start("angles", onto_sphere(placed, placed.points))


class Badness:
    """Measures how bad maps of a mesh are: their mean angle difference and their foldings, in degrees.

    At most `sample` faces are measured, and each face that folds counts as `per_fold` degrees.
    """

    def __init__(self, mesh: Mesh, sample: int = 1000, per_fold: float = 0.03) -> None:
        self.f, self.sample = mesh.f, mesh.f[spread(len(mesh.f), sample)]
        self.per_fold = per_fold
        self.source = corner_angles(mesh.unit, self.sample)

    def __call__(self, x: FloatArray) -> float:
        """Mean angle difference of a sample of faces, plus a part for each face that folds."""
        return mean_difference(self.source, x, self.sample) + self.per_fold * self.folded(x)

    def folded(self, x: FloatArray) -> int:
        """Number of faces that fold; all if the degree is not 1.

        A map of degree 0 may fold a single face, within whose image all others lie.
        """
        if covers_once(x, self.f):
            return int((by_blocks(signed_volumes, x, self.f) <= 0).sum())
        return len(self.f)


def least_folded(
    x: FloatArray, badness: Badness, tried: int = 60, first: float = 0.4
) -> FloatArray:
    """The Moebius image of a map with the least badness, or the map itself if that folds no fewer faces.

    `tried` Moebius maps are enough for the search to settle; the first ones move the sphere's centre by `first`.
    """
    from scipy.optimize import minimize  # takes .2 s, which maps without foldings don't need

    def moved(b: FloatArray) -> FloatArray:
        return moebius(x, b / np.sqrt(1 + b @ b))

    simplex = np.vstack((np.zeros(3), first * np.eye(3)))
    options = {"maxfev": tried, "initial_simplex": simplex, "xatol": 0.01, "fatol": 0.001}
    found = minimize(lambda b: badness(moved(b)), simplex[0], method="Nelder-Mead", options=options)
    y = moved(found.x)
    if badness.folded(y) < badness.folded(x):
        return y
    return x
