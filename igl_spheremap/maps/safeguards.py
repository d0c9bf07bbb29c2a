"""Checks that keep the maps of Algorithm 1 from folding or collapsing."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from ..descent.line_search import NonmonotoneSearch
from ..descent.problem import Problem
from ..errors import FactorisationFailed
from ..mesh.arrays import FloatArray
from ..mesh.check import Mesh
from ..mesh.measure import surface_area
from ..paper.hooks import Hooks
from ..paper.optm import TRIALS
from ..paper.star_map import EigenProjection, project_unweighted
from ..result.run import Iterate, Stage
from ..start.punctured import is_coarse
from ..verify.certificate import Certificate
from ..verify.distortion import mean_angle_difference
from ..verify.signs import folded_faces

#: The Moebius gauge is restored when the weighted mean of the map is farther than this from the origin. The second
#: number is for runs in which no step may add foldings: a larger Moebius map of the corners can fold a thin face.
_OFF_CENTRE, _OFF_CENTRE_CONFINED = 1e-2, 1e-9
#: Iterations between two checks of whether the map has shrunk.
_LOOK = 20


class Confined(Hooks):
    """Keep the map centred, and a start without foldings free of them, unless the map `may_fold`.

    Moebius maps that crowd the mesh into a point bring the discrete energy down to 0. So, if the problem says so
    (`Problem.fixes_gauge`), the map is centred at the start and after drifts.

    Limbs have tiny images, which fold for next to no energy, though "the minimization must be confined to the set of
    diffeomorphisms" (section 1). So a step that folds more faces than allowed is refused.
    """

    def __init__(self, mesh: Mesh, problem: Problem, may_fold: bool) -> None:
        super().__init__()
        self._mesh, self._problem, self._may_fold = mesh, problem, may_fold

    def start(self, x: FloatArray) -> FloatArray:
        """The map in the Moebius gauge."""
        # by columns, so that inner loops are long
        x = np.asfortranarray(self._centred(x, 0.0))
        self._most = self._bound(x)
        return x

    def trial(self, y: FloatArray) -> FloatArray | None:
        """The map in the Moebius gauge; None, a refusal, if too many faces fold."""
        if self._most == np.inf:
            return self._centred(y, _OFF_CENTRE)
        y = self._centred(y, _OFF_CENTRE_CONFINED)
        if self._foldings(y) <= self._most:
            return y
        self._count("refused")
        return None

    def _bound(self, x: FloatArray) -> float:
        """Number of faces that may fold on the way from a start: none from a start without folds."""
        if self._may_fold or self._foldings(x):
            return np.inf
        return 0

    def _centred(self, x: FloatArray, off: float) -> FloatArray:
        """The map in the Moebius gauge; the map itself if its weighted mean is at most `off` from the origin."""
        y = self._problem.centred(x, off)
        self._count("centred", y is not x)
        return y

    def _foldings(self, x: FloatArray) -> int:
        """Number of faces that fold."""
        return int(folded_faces(x, self._mesh.f).sum())


class Safeguards(Confined):
    """For Algorithm 2: minimise first, then correct. The weights of a shrunken map may be left out.

    The first minimisation is not confined: half of the faces of a Gauss map are folded, and on the way there may be
    more. No step may fold more faces than the star map from which it starts.

    As a map shrinks to a point its degree becomes 0, and its energy falls below 4 pi, the least of a smooth map of
    degree 1. Then its conformal factor may be useless, so a star map with the weight e^{2u} = 1 is tried, too.
    """

    def __init__(self, mesh: Mesh, problem: Problem, may_fold: bool) -> None:
        super().__init__(mesh, problem, may_fold)
        self._is_first = True

    def end(self, start: Iterate, last: Iterate) -> Iterate:
        """The last map, or the star map if the last one is too coarse for chord energies and keeps angles worse."""
        begins_at_star_map = start.stage is Stage.STAR_MAP and not self._may_fold
        if not begins_at_star_map or not is_coarse(surface_area(last.x, self._mesh.f)):
            return last
        star_map = np.asfortranarray(self._problem.centred(start.x, 0.0))
        before, after = (mean_angle_difference(self._mesh, x) for x in (star_map, last.x))
        if after <= before:
            return last
        energy = self._problem.energy.evaluate(star_map)[0]
        return replace(last, iteration=0, x=star_map, energy=energy)

    def search(self, energy: float, rho: float, delta: float, xi: float) -> NonmonotoneSearch:
        """A search that soon gives up when folds are refused: the next step would fold the same faces."""
        if self._most == np.inf:
            return super().search(energy, rho, delta, xi)
        return NonmonotoneSearch(energy, rho, delta, xi, TRIALS)

    def settled(self, last: Iterate) -> bool:
        """Whether the map has shrunk to nothing."""
        if last.iteration % _LOOK or last.energy > 4 * np.pi:
            return False
        return Certificate.of(last.x, self._mesh.f).degree == 0

    def project(
        self, mesh: Mesh, L: sp.csr_matrix, x: FloatArray, collapsed: bool
    ) -> EigenProjection:
        """The star map; after a map that has shrunk, the better one of the star maps with and without weights."""
        if not collapsed:
            return super().project(mesh, L, x, collapsed)
        unweighted = project_unweighted(mesh, L, x, self._problem.centred)
        found = [unweighted]
        with suppress(FactorisationFailed):  # a map to two points has no weights
            found.append(super().project(mesh, L, x, collapsed))
        best = min(found, key=self._off)
        self._count("restarted", best is unweighted)
        return best

    def _off(self, found: EigenProjection) -> tuple[int, float]:
        """Distance of a star map from a conformal one: by its degree, then by its angles."""
        degree = Certificate.of(found.star_map, self._mesh.f).degree
        return abs(degree - 1), mean_angle_difference(self._mesh, found.star_map)

    def _bound(self, x: FloatArray) -> float:
        is_first, self._is_first = self._is_first, False
        if self._may_fold or is_first:
            return np.inf
        return self._foldings(x)
