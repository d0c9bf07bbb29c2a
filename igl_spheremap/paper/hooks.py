"""Deviations of a run of Algorithm 1 from the printed one: `Hooks` changes nothing, its subclasses do."""

from __future__ import annotations

from collections import Counter

import numpy as np
import scipy.sparse as sp

from ..descent.line_search import NonmonotoneSearch
from ..mesh.arrays import FloatArray
from ..mesh.check import Mesh
from ..result.run import Iterate
from .star_map import EigenProjection, project


class Hooks:
    """The paper's algorithms as printed: only a step that eq. (12) leaves without a value is filled in.

    Subclasses alter more. Alterations are counted by the names of `igl_spheremap.result.run.SAFEGUARDS`.
    """

    def __init__(self) -> None:
        self._acted: Counter[str] = Counter()

    def _count(self, name: str, times: int = 1) -> None:
        """Add to the count of a safeguard."""
        self._acted[name] += int(times)

    def acted(self) -> dict[str, int] | None:
        """How often each safeguard has acted since the last call; None if none has."""
        acted, self._acted = self._acted, Counter()
        return nonzero(**acted)

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

    def end(self, start: Iterate, last: Iterate) -> Iterate:
        """The map with which Algorithm 1 ends, from its start and its last iterate."""
        return last

    def project(
        self, mesh: Mesh, L: sp.csr_matrix, x: FloatArray, collapsed: bool
    ) -> EigenProjection:
        """The star map from which Algorithm 2 goes on after the map x, which may have collapsed to degree 0."""
        return project(mesh, L, x)

    def step(self, tau: float, taken: float) -> float:
        """The quotient of eq. (12); if it is 0, infinite or 0/0, the step taken before."""
        if 0 < tau < np.inf:
            return tau
        self._count("undefined")
        return taken


def nonzero(**counts: int) -> dict[str, int] | None:
    """The counts that are not 0; None if all are."""
    found = {name: count for name, count in counts.items() if count}
    if not found:
        return None
    return found
