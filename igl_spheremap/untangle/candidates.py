"""Maps of a coarse body to choose from: layouts around several faces that are cut out, in gauges that fold little.

On coarse bodies the choice of the hole changes angles by factors. Angles close in the plane, where sides are straight;
on the sphere sides are great circles, which sweep over hundreds of vertices where they are long. So the gauge decides
what folds, and is chosen before anything is repaired.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain, islice

import numpy as np
from scipy.optimize import minimize

from ..mesh.arrays import HALF_DIGITS, FloatArray
from ..mesh.check import Mesh
from ..mesh.measure import by_blocks, corner_angles, face_areas, spread
from ..newton.system import VertexSystem
from ..sphere.moebius import moebius
from ..start.punctured import candidate_faces
from ..verify.distortion import mean_difference
from ..verify.signs import signed_volumes
from .angles import close_angles, proper_angles
from .layout import Layout, centred, onto_sphere
from .local_repair import SMALL_ANGLE
from .match_angles import SMALL, covers_once


def layouts(mesh: Mesh, system: VertexSystem, holes: int) -> Iterator[FloatArray]:
    """Maps laid out by the mesh's own angles around so many holes in turn; none of limbs too deep for Moebius maps."""
    source = proper_angles(mesh.angles)
    for hole in islice(_holes(mesh), holes):
        closed = close_angles(system, source, hole)
        if closed.residual <= HALF_DIGITS:
            placed = centred(mesh, Layout(mesh.f, closed.angles, hole))
            if placed.depth.max() < np.log(SMALL_ANGLE / np.finfo(float).eps):  # rounding turns edges by no more
                yield onto_sphere(placed, placed.z)


def _holes(mesh: Mesh) -> Iterator[int]:
    """Faces to cut out: well-shaped ones of middling size, and the largest."""
    largest = np.argsort(-face_areas(mesh.v, mesh.f), kind="stable")
    pairs = zip(candidate_faces(mesh), largest.tolist(), strict=False)
    yield from dict.fromkeys(chain.from_iterable(pairs))


class Badness:
    """Mean angle difference of maps of a mesh in degrees, by a sample of the faces, and what their foldings count."""

    def __init__(self, mesh: Mesh) -> None:
        self.f, self.sample = mesh.f, mesh.f[spread(len(mesh.f), SMALL)]
        self.source = corner_angles(mesh.v, self.sample)

    def __call__(self, x: FloatArray) -> float:
        """Badness of a map, by floating-point signs: a percent of folded faces counts as .3 degrees."""
        return mean_difference(self.source, x, self.sample) + 30 * self.folded(x)

    def folded(self, x: FloatArray) -> float:
        """Share of the faces that fold; all, unless the degree is 1: it is 0 if one face, folded, holds all others."""
        return float((by_blocks(signed_volumes, x, self.f) <= 0).mean()) if covers_once(x, self.f) else 1.0


def least_folded(x: FloatArray, badness: Badness) -> tuple[float, FloatArray]:
    """The least badness of Moebius maps of a map, and the map; itself if none folds fewer faces."""

    def moved(b: FloatArray) -> FloatArray:
        return moebius(x, b / np.sqrt(1 + b @ b))

    before = badness(x)
    if not badness.folded(x):
        return before, x
    simplex = np.vstack((np.zeros(3), 0.4 * np.eye(3)))
    options = {"maxfev": 60, "initial_simplex": simplex, "xatol": 0.01, "fatol": 0.001}
    found = minimize(lambda b: badness(moved(b)), simplex[0], method="Nelder-Mead", options=options)
    y = moved(found.x)
    return (float(found.fun), y) if badness.folded(y) < badness.folded(x) else (before, x)
