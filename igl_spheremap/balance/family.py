"""The family of maps from conformal (balance 0) to area-preserving (balance 1)."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np

from ..descent.minimize import Minimum, minimize
from ..mesh.arrays import FloatArray
from ..mesh.check import Mesh
from ..result.run import Listener, Status
from .energy import Energy, log_areas
from .newton import newton
from .newton_system import NewtonSystem
from .source import Source, lay_flat
from .stretched import stretched

#: Weight of the areas at the most: at 1 nothing would hold the angles, and .03 costs areas two percent.
_MOST_WEIGHT = 0.97
#: k of the final energy. 1 is polyconvex, .9 up to s1 = 5 s2, but areas and angles end 6 percent and .1 degrees lower
#: (medians of 11 meshes); at .8 single faces and the tips of limbs stay distorted (docs/balance.md).
POWER = 0.9
#: The squares of logarithms are minimised first (stage "opening") where the energy is this many times theirs.
_FAR = 1.05
#: In that stage areas count no more than angles, and a rough minimum is enough.
_OPENING_WEIGHT, _OPENING_TOLERANCE = 0.5, 0.05
#: Share of the energy that the last step may gain at the end.
TOLERANCE = 0.005
#: Steps of each stage: what converges took at most 32.
_STEPS = 40
#: Averages over neighbours that take the noise of single faces out of the conformal factor.
_SMOOTHINGS = 2


class Family:
    """All balances of one mesh; what they share is made at the first use."""

    def __init__(self, mesh: Mesh) -> None:
        self._mesh = mesh

    @cached_property
    def source(self) -> Source:
        """The mesh's triangles."""
        return lay_flat(self._mesh.v, self._mesh.f)

    @cached_property
    def system(self) -> NewtonSystem:
        """Newton's equations on the mesh, analysed."""
        return NewtonSystem(self.source.f, self.source.n)

    def energy(self, conformal: FloatArray, balance: float) -> Energy:
        """The energy of a balance, docs/balance.md (3) and (10), for a conformal map without foldings."""
        area, factor = self.source.area, log_factor(self.source, conformal)
        target = (1 - balance) * factor
        target -= np.log((area * np.exp(target)).sum() / (area * np.exp(factor)).sum())  # balance (10)
        return Energy(self.source, min(balance, _MOST_WEIGHT), POWER, target)

    def minimize(self, energy: Energy, x: FloatArray, listener: Listener | None = None) -> Minimum:
        """Minimise from a map free of foldings; where its areas are far off, by squares of logarithms first."""
        x = stretched(self._mesh, x)
        squares = replace(energy, power=0)
        if energy.by_face(x).sum() > _FAR * squares.by_face(x).sum():
            opening = replace(squares, weight=min(energy.weight, _OPENING_WEIGHT))
            opened = minimize(newton(opening, self.system, x, "opening"), tolerance=_OPENING_TOLERANCE,
                              max_iterations=_STEPS, listener=listener)
            if opened.status is Status.STOPPED:
                return opened
            x = opened.last.x
        return minimize(newton(energy, self.system, x, "balance"), tolerance=TOLERANCE, max_iterations=_STEPS,
                        listener=listener)


def log_factor(source: Source, x: FloatArray) -> FloatArray:
    """Logarithm of image area over source area by face, averaged over neighbours, docs/balance.md (9)."""
    value = log_areas(source, x)
    corners, share = source.f.ravel(), np.repeat(source.area, 3)
    around = np.bincount(corners, share, source.n)
    for _ in range(_SMOOTHINGS):
        at_vertices = np.bincount(corners, share * np.repeat(value, 3), source.n) / around
        value = at_vertices[source.f].mean(axis=1)
    return value
