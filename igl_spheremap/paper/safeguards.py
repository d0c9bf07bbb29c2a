"""What Algorithm 1 calls that is not the paper's: a step where eq. (12) has no value, and safeguards."""

from __future__ import annotations

from collections import Counter

import numpy as np

from ..descent.line_search import NonmonotoneSearch
from ..descent.problem import Problem
from ..mesh.arrays import FloatArray
from ..mesh.check import Mesh
from ..result.run import Iterate
from ..untangle.local_repair import has_few_foldings, repair_locally
from ..verify.certificate import Certificate
from ..verify.signs import folded_faces

#: The Moebius gauge is restored when the weighted mean of the map is farther than this from the origin. The second
#: number is for runs in which no step may add foldings: a larger Moebius map of the corners can fold a thin face.
_OFF_CENTRE, _OFF_CENTRE_CONFINED = 1e-2, 1e-9


class AsPrinted:
    """The paper's algorithms as they are: only a step that eq. (12) leaves without a value is filled in.

    Subclasses alter more. What was altered is counted, by the names of `igl_spheremap.result.run.SAFEGUARDS`.
    """

    def __init__(self) -> None:
        self._acted: Counter[str] = Counter()

    def _count(self, name: str, times: int = 1) -> None:
        """Add to the count of a safeguard."""
        self._acted[name] += int(times)

    def acted(self) -> dict[str, int] | None:
        """How often each safeguard has acted since the last call; None if none has."""
        acted, self._acted = +self._acted, Counter()
        return dict(acted) or None

    def start(self, x: FloatArray) -> FloatArray:
        """The map that Algorithm 1 starts from."""
        return x

    def search(self, energy: float, rho: float, delta: float, xi: float) -> NonmonotoneSearch:
        """The search of step 3, from the energy of the start."""
        return NonmonotoneSearch(energy, rho, delta, xi)

    def trial(self, y: FloatArray) -> FloatArray | None:
        """The map that the search tries; None refuses it."""
        return y

    def settled(self, last: Iterate) -> bool:
        """Whether the run ends here, though its gradient is above the tolerance of step 2."""
        return False

    def step(self, tau: float, taken: float) -> float:
        """The quotient of eq. (12), or the step taken before where the quotient is 0, infinite or 0/0."""
        if 0 < tau < np.inf:
            return tau
        self._count("undefined")
        return taken


def nonzero(**counts: int) -> dict[str, int] | None:
    """The counts that are not 0; None if all are."""
    return {name: count for name, count in counts.items() if count} or None


class Safeguards(AsPrinted):
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
