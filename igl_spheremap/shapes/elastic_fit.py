"""The elastic deformation that brings one surface's features closest to another's, a bijection at every step."""

from __future__ import annotations

import numpy as np

from ..balance.derivatives import PAIRS, Derivatives, derivatives
from ..balance.energy import Energy
from ..balance.newton_system import NewtonSystem
from ..balance.source import lay_flat
from ..balance.step import certified_step
from ..errors import FactorisationFailed
from ..mesh.arrays import FloatArray, IntArray
from ..sphere.rows import tangent_axes
from .features import Picture
from .moebius_fit import Notify, misfit

_STEPS = 20  # at each width; the next one starts from what there is
_SMALLEST_GAIN = 1e-3  # of the energy
_SHORTEST = 1e-3  # of a Newton step


class Elastic:
    """Stretching of a map of the sphere against the map x0, by angles and areas alike, and its Newton system."""

    def __init__(self, x0: FloatArray, f: IntArray) -> None:
        source = lay_flat(x0, f)
        self.energy = Energy(source, weight=0.5, power=1, target=np.zeros(len(f)))
        self._system = NewtonSystem(f, len(x0))
        self._valence = np.bincount(f.ravel(), minlength=len(x0))

    def fit(
        self, x: FloatArray, weights: FloatArray, features: FloatArray, fixed: Picture, stiffness: float, notify: Notify
    ) -> None:
        """Lower sum w |features - fixed(x)|^2 / 2 + stiffness * stretching by projected Newton steps.

        The features (n, k) have unit variance, the weights sum 1; `notify` takes the iterates.
        """
        w = 4 * np.pi * weights  # as the areas of the energy
        values, gradients = fixed(x)
        stretching = self.energy.by_face(x)
        total = misfit(w, features - values) / 2 + stiffness * stretching.sum()
        room = self.energy.source.area  # x0 has no energy: let every face grow as if it were strained by a neper
        length = 1.0
        for _ in range(_STEPS):
            axes = np.stack([axis.T for axis in tangent_axes(x)])
            try:
                step = self._step(x, axes, w, features - values, gradients, stiffness)
            except FactorisationFailed:
                return
            length = min(1.0, 2 * length)
            while length > _SHORTEST:
                taken = certified_step(self.energy, x, length * step, stretching + room)
                if taken is not None:
                    y, after = taken
                    new_values, new_gradients = fixed(y)
                    gain = total - misfit(w, features - new_values) / 2 - stiffness * after.sum()
                    if gain > 0:
                        break
                length /= 2
            else:
                return
            x, stretching, values, gradients, total = y, after, new_values, new_gradients, total - gain
            notify(x, total)
            if gain < _SMALLEST_GAIN * total:
                return

    def _step(
        self, x: FloatArray, axes: FloatArray, w: FloatArray, off: FloatArray, gradients: FloatArray, stiffness: float
    ) -> FloatArray:
        """Newton step (n, 3); the features' part by Gauss and Newton."""
        elastic = derivatives(self.energy, x, axes)
        slopes = np.einsum("nkd,adn->akn", gradients, axes)
        gradient = stiffness * elastic.gradient - np.einsum("n,akn,nk->an", w, slopes, off)
        blocks = stiffness * elastic.blocks
        squares = np.einsum("n,akn,bkn->abn", w / self._valence, slopes, slopes)  # shared out among a vertex's faces
        for k, (i, j) in enumerate(PAIRS):
            if i == j:
                blocks[k] += squares[:, :, self.energy.source.f[:, i]]
        return np.einsum("an,adn->nd", self._system.step(Derivatives(gradient, blocks)), axes)
