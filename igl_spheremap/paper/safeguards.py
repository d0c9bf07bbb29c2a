"""What is not the paper's and stands beside its algorithms: where a formula has no value, and safeguards."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import numpy as np

from ..descent.problem import Problem
from ..mesh.arrays import FloatArray
from ..mesh.check import Mesh
from ..result.run import Iterate
from ..untangle.local_repair import has_few_foldings, repair_locally
from ..verify.certificate import Certificate
from ..verify.signs import folded_faces

#: The weighted mean of the map may move this far from the origin before the Moebius gauge is restored; where the map is
#: kept free of foldings, hardly at all: a larger Moebius map of the corners can fold a thin face.
_OFF_CENTRE, _OFF_CENTRE_INJECTIVE = 1e-2, 1e-9
#: Eigen-projections of a round at most, and the change of the energy, as a share of it, at which they end: Algorithm 1,
#: which follows, lowers it by far more.
_PROJECTIONS, _SETTLED = 40, 1e-4


class AsPrinted:
    """The paper's algorithms as they are: nothing is altered but a step that eq. (12) does not give.

    What acts is counted by the names of `igl_spheremap.result.run.SAFEGUARDS`.
    """

    def __init__(self) -> None:
        self._acted: Counter[str] = Counter()

    def _count(self, name: str, times: int = 1) -> None:
        """Count what acted."""
        self._acted[name] += int(times)

    def acted(self) -> dict[str, int] | None:
        """What has acted since the last call, and how often; None if nothing has."""
        acted, self._acted = +self._acted, Counter()
        return dict(acted) or None

    def start(self, x: FloatArray) -> FloatArray:
        """The map that Algorithm 1 starts from."""
        return x

    def trial(self, y: FloatArray) -> FloatArray | None:
        """The map that the search tries; None refuses it."""
        return y

    def step(self, tau: float, taken: float) -> float:
        """The quotient of eq. (12), or the step taken before where that is 0, infinite or 0/0."""
        if 0 < tau < np.inf:
            return tau
        self._count("undefined")
        return taken

    def star_map(self, star: Iterate, projected: Callable[[FloatArray], Iterate]) -> Iterate:
        """The star map that a round starts from; the function makes one of any map."""
        return star


def nonzero(**counts: int) -> dict[str, int] | None:
    """The counts that are not 0; None if all are."""
    return {name: count for name, count in counts.items() if count} or None


class Safeguards(AsPrinted):
    """Moebius maps are held fixed, maps without foldings are kept so, and star maps are made until they settle.

    The discrete energy falls for ever where a Moebius map crowds the mesh into a point, so the map is centred at the
    start and when it has drifted, if the problem says so (`Problem.gauge`). A start without foldings is kept so, unless
    it `may_fold`: a step that would fold is refused, for "the minimization must be confined to the set of
    diffeomorphisms" (section 1), and limbs, whose image is tiny, fold for next to no energy. A start of which few faces
    fold is repaired if it `may_repair`, since only one without any is kept so.
    """

    def __init__(self, mesh: Mesh, problem: Problem, may_fold: bool, may_repair: bool = True) -> None:
        super().__init__()
        self._mesh, self._problem, self._may_fold, self._may_repair = mesh, problem, may_fold, may_repair

    def start(self, x: FloatArray) -> FloatArray:
        """The map in the Moebius gauge, repaired where at most 1 percent of its faces fold."""
        y = self._centred(x, 0.0)
        certificate = Certificate.of(y, self._mesh.f)
        if self._may_repair and certificate.foldings and has_few_foldings(certificate, self._mesh.f):
            self._count("repaired", certificate.foldings)
            y = repair_locally(self._mesh, y)
        self._injective = not self._may_fold and not folded_faces(y, self._mesh.f).any()
        return y

    def trial(self, y: FloatArray) -> FloatArray | None:
        """The map in the Moebius gauge, unless it folds where the start did not."""
        y = self._centred(y, _OFF_CENTRE_INJECTIVE if self._injective else _OFF_CENTRE)
        if self._injective and folded_faces(y, self._mesh.f).any():
            self._count("refused")
            return None
        return y

    def _centred(self, x: FloatArray, off: float) -> FloatArray:
        """The map in the Moebius gauge; itself where it is at most that far off."""
        y = self._problem.centred(x, off)
        self._count("centred", y is not x)
        return y

    def star_map(self, star: Iterate, projected: Callable[[FloatArray], Iterate]) -> Iterate:
        """Star maps of star maps, until their energy settles: they approach a conformal map."""
        for _ in range(_PROJECTIONS):
            before, star = star, projected(star.x)
            if abs(star.energy - before.energy) < _SETTLED * before.energy:
                break
        return star
