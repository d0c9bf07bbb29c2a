"""Algorithm 1, Cayley updates with Barzilai-Borwein steps, and the descent of Gu and Yau that it is compared with."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count

import numpy as np
import scipy.sparse as sp

from ..mesh.arrays import FloatArray
from ..result.run import Iterate
from ..sphere.rows import unit_rows
from .line_search import BarzilaiBorwein, NonmonotoneSearch, Stop
from .problem import Diagonal, Problem, remove_boosts

#: The weighted mean of the map may move this far from the origin before the Moebius gauge is restored; where the map is
#: kept free of foldings, hardly at all: a larger Moebius map of the corners can fold a thin face.
_OFF_CENTRE = 1e-2
_OFF_CENTRE_INJECTIVE = 1e-9
#: Distance of the weighted mean from the origin at which a Moebius map brings it back in the descent of Gu and Yau.
_OFF_CENTRE_PROJECTED = 1e-4
#: First step tried at the start, in units of the source's area; the paper suggests 1.
_FIRST_TAU = 1.0
#: Bounds of later steps: the quotients of eq. (12) can be anything where the curvature vanishes.
_LEAST_TAU, _LARGEST_TAU = 1e-12, 1e12
#: Trials of a search in Wen and Yin's program OptStiefelGBB, of which the last is taken.
_TRIALS = 5


@dataclass(frozen=True)
class CayleyBB:
    """The paper's Algorithm 1.

    Three things are added to the paper's, because a mesh is not smooth; each has a switch. Moebius boosts are kept out
    of the gradient and the map is re-centred when it has drifted (`Problem.gauge`): the discrete energy falls for ever
    along them. A start that has no foldings is kept so unless it `may_fold`: a step that would fold counts as one of
    infinite energy, for "the minimization must be confined to the set of diffeomorphisms" (section 1), and limbs, whose
    image is tiny, fold for next to no energy. The quotients of eq. (12) are bounded. What the paper leaves open, that
    there is no h in step 3, ends the run; by the rule of Wen and Yin's program the fifth trial is taken.

    Lai et al., Algorithm 1; Wen and Yin 2013, *A feasible method for optimization with orthogonality constraints*.
    """

    #: Options of `NonmonotoneSearch`.
    rho: float = 1e-4
    delta: float = 0.1
    xi: float = 0.85
    #: Which quotient is the first step tried; "alternating" takes tau_1 at odd iterations and tau_2 at even ones.
    bb: BarzilaiBorwein = "alternating"
    #: If False, steps that fold are refused where the start has no foldings.
    may_fold: bool = True
    #: If True, the quotients of eq. (12) are bounded.
    bound_tau: bool = True
    #: By "wen-yin" a search ends with its fifth trial, which is taken.
    stop: Stop = "gradient"

    def iterates(self, problem: Problem, x: FloatArray) -> Iterator[Iterate]:
        """Yield the start and every iterate after it; end where no step is acceptable.

        Their residual is `Problem.residual`, by eq. (9) the L2 norm of A F in the L2 metric.
        """
        given, x = x, problem.centred(x)
        acted = Counter(centred=int(x is not given))
        energy, gradient = problem.evaluate(x)
        search = NonmonotoneSearch(energy, self.rho, self.delta, self.xi)  # Algorithm 1, step 1
        if self.stop == "wen-yin":
            search.trials, search.takes_last = _TRIALS, True
        tau, taken, k = _FIRST_TAU, 0.0, 0
        injective = not self.may_fold and problem.is_injective(x)
        off_centre = _OFF_CENTRE_INJECTIVE if injective else _OFF_CENTRE
        while True:
            square = problem.metric.inner(gradient, gradient)
            safeguards = {name: count for name, count in acted.items() if count} or None
            yield Iterate("harmonic", 0, k, x, energy, problem.residual(gradient), taken, safeguards=safeguards)
            acted = Counter(bounded=self.bound_tau and not _LEAST_TAU <= tau <= _LARGEST_TAU)
            tau = min(max(tau, _LEAST_TAU), _LARGEST_TAU) if self.bound_tau else tau
            trial = problem.cayley_path(x, gradient, off_centre, injective, acted)
            step = search.search(trial, tau, -square)  # Algorithm 1, step 3: E'(Y(0)) = -|A F|^2
            if step is None:
                return
            y, derivative = step.trial  # Algorithm 1, step 4
            search.record(step.energy)  # Algorithm 1, step 5
            new_gradient = problem.gradient(y, derivative)
            D, W = y - x, new_gradient - gradient
            x, gradient, energy, taken, k = y, new_gradient, step.energy, step.tau, k + 1  # Algorithm 1, step 6
            tau = self._barzilai_borwein(problem, D, W, k, taken)

    def _barzilai_borwein(self, problem: Problem, D: FloatArray, W: FloatArray, k: int, last: float) -> float:
        """First step to try at iteration k, eq. (12)."""
        DW = abs(problem.metric.inner(D, W))
        if DW == 0:
            return last
        if self.bb == "tau_1" or (self.bb == "alternating" and k % 2):
            return problem.metric.inner(D, D) / DW  # eq. (12), tau_{k,1}
        return DW / problem.metric.inner(W, W)  # eq. (12), tau_{k,2}


@dataclass(frozen=True)
class ProjectedDescent:
    """Descent by the "absolute derivative" with fixed steps, and zero mass-centre by a Moebius map.

    Gu and Yau 2002, *Computing conformal structures of surfaces* (reference [1] of Lai et al.); Gu, Wang, Chan,
    Thompson, Yau 2004, *Genus zero surface conformal mapping and its application to brain surface mapping*,
    algorithms 1 and 2. They leave the step to the user.
    """

    #: In the problem's metric, see `step_metric`. Up to 1 no step can raise the energy, for normalising
    #: ``x - step K^-1 L x`` minimises a quadratic upper bound of it row by row. From 2 on the iteration is unstable.
    step: float = 1.8
    #: What the iterates are called.
    stage: str = "harmonic"

    def iterates(self, problem: Problem, x: FloatArray) -> Iterator[Iterate]:
        """Yield the start, centred, and every iterate after it, without end.

        Their residual is that of `CayleyBB` in any metric: the L2 norm of the gradient without boosts.
        """
        L2 = Diagonal(problem.areas)
        for k in count():
            x = problem.centred(x, _OFF_CENTRE_PROJECTED)
            energy, derivative = problem.energy.evaluate(x)
            gradient = remove_boosts(x, L2.gradient(x, derivative), problem.A)
            residual = float(np.sqrt(L2.inner(gradient, gradient)))
            yield Iterate(self.stage, 0, k, x, energy, residual, self.step if k else 0.0)
            x = unit_rows(x - self.step * problem.metric.gradient(x, derivative))


def step_metric(L: sp.csr_matrix) -> Diagonal:
    """The diagonal metric that bounds a Laplacian from above, in which steps up to 1 are safe.

    The derivative of Gu and Yau is L x without division by areas: the weights of a Laplacian in the plane have no
    scale, so that this is the better conditioned one where vertices are unevenly spread. Each vertex is bounded by the
    sum of the sizes of its row; a step that is the same for all would be as small as the worst vertex demands.
    """
    return Diagonal(np.maximum(np.asarray(abs(L).sum(axis=1)).ravel(), np.finfo(float).tiny))
