"""Checks that keep the maps of Algorithm 1 from folding or collapsing."""

from __future__ import annotations

import numpy as np

from ..descent.problem import Problem
from ..mesh.arrays import FloatArray
from ..mesh.check import Mesh
from ..paper.hooks import Hooks
from ..untangle.local_repair import has_few_foldings, repair_locally
from ..verify.certificate import Certificate
from ..verify.signs import folded_faces

#: The Moebius gauge is restored when the weighted mean of the map is farther than this from the origin. The second
#: number is for runs in which no step may add foldings: a larger Moebius map of the corners can fold a thin face.
_OFF_CENTRE, _OFF_CENTRE_CONFINED = 1e-2, 1e-9


class Safeguards(Hooks):
    """Keep the map from collapsing, and from folding anew.

    Moebius maps that crowd the mesh into a point bring the discrete energy down to 0. So the map is centred at the
    start and where it has drifted, if the problem says so (`Problem.gauge`).

    Limbs have tiny images, which fold for next to no energy, though "the minimization must be confined to the set of
    diffeomorphisms" (section 1). So, unless the map `may_fold`, a step after which more faces fold than at the start is
    refused, and a star map of which few faces fold is repaired. The first start is exempt if it folds: half of the
    faces of a Gauss map are folded, and on the way to a minimum there may be more.
    """

    def __init__(self, mesh: Mesh, problem: Problem, may_fold: bool) -> None:
        super().__init__()
        self._mesh, self._problem, self._may_fold = mesh, problem, may_fold
        self._is_first = True

    def start(self, x: FloatArray) -> FloatArray:
        """The map in the Moebius gauge; a star map is repaired where at most 1 percent of its faces fold."""
        x = self._centred(x, 0.0)
        is_first, self._is_first = self._is_first, False
        self._most = np.inf
        if self._may_fold:
            return x
        certificate = Certificate.of(x, self._mesh.f)
        if not certificate.foldings:
            self._most = 0
        elif not is_first:
            if has_few_foldings(certificate, self._mesh.f):
                self._count("repaired", certificate.foldings)
                x, _ = repair_locally(self._mesh, x)
            self._most = self._foldings(x)
        return x

    def trial(self, y: FloatArray) -> FloatArray | None:
        """The map in the Moebius gauge; None, a refusal, if more faces fold than at the start."""
        y = self._centred(y, _OFF_CENTRE if self._most == np.inf else _OFF_CENTRE_CONFINED)
        if self._most == np.inf or self._foldings(y) <= self._most:
            return y
        self._count("refused")
        return None

    def _centred(self, x: FloatArray, off: float) -> FloatArray:
        """The map in the Moebius gauge; the map itself if its weighted mean is at most `off` from the origin."""
        y = self._problem.centred(x, off)
        self._count("centred", y is not x)
        return y

    def _foldings(self, x: FloatArray) -> int:
        """Number of faces that fold."""
        return int(folded_faces(x, self._mesh.f).sum())
