"""Gradient descent in the tangent spaces with projection back to the sphere: the algorithm of Gu and Yau."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count

import numpy as np
import scipy.sparse as sp

from ..mesh.arrays import FloatArray
from ..result.run import Iterate
from ..sphere.rows import unit_rows
from .problem import Diagonal, Problem, remove_boosts

#: The mass centre may be this far from the origin before a Moebius map brings it back.
_OFF_CENTRE = 1e-4


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

        Their residual is that of `CayleyBB` whatever the metric: the L2 norm of the gradient without boosts.
        """
        L2 = Diagonal(problem.areas)
        for k in count():
            x = problem.centred(x, _OFF_CENTRE)
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
