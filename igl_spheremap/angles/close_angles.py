"""Corner angles that close up in the plane, nearest to given ones: without positions nothing can underflow.

One face, the hole, is cut out. Angles close if each face sums to pi, each inner vertex to 2 pi, and the ratios of sines
around each inner vertex multiply to 1. Then lengths and directions exist, at any depth of any limb. Gauss-Newton on the
angles: every step is one solve with two unknowns a vertex and the Laplacian's pattern.

References
----------
Sheffer and de Sturler 2001, *Parameterization of Faceted Surfaces for Meshing using Angle-Based Flattening*. Zayer,
Levy and Seidel 2007, *Linear Angle Based Parameterization*.
"""

from __future__ import annotations

import numpy as np

from ..errors import FactorisationFailed
from ..mesh.arrays import HALF_DIGITS, FloatArray
from ..newton.system import VertexSystem, gram_blocks


def proper_angles(angles: FloatArray, least: float = 1e-3) -> FloatArray:
    """Angles (m, 3) near the given ones, each three of sum pi, none much below the `least`: slivers can shrink."""
    angles = np.maximum(angles, least)
    return angles * (np.pi / angles.sum(axis=1))[:, None]


def close_angles(
    system: VertexSystem,
    target: FloatArray,
    hole: int,
    *,
    steps: int = 16,
    aiming: int = 2,
    longest: float = 1.2,
) -> FloatArray | None:
    """The angles (m, 3) nearest to the target, relative to their size, that close up in the plane without the hole.

    The first steps, `aiming`, aim at the target; later ones only close the conditions, and converge quadratically. A
    step changes no angle by more than a factor of exp(`longest`). Meshes whose angles close take half of the `steps` at
    most. The angles of the hole, a face, have no meaning. If a sum or a logarithm of a product stays off by more than
    half of float64's digits, None.
    """
    wheels = _Wheels(system, hole)
    a, aim = target.T.copy(), target.T
    residual = np.inf
    for step in range(steps):
        missing = wheels.missing(a)
        residual = float(np.abs(missing).max())
        if not HALF_DIGITS < residual < np.inf:
            break
        size, wanted = a, 0 * a
        if step < aiming:  # by weights that stay, for changing ones make the steps cycle
            size, wanted = aim, aim - a
        try:
            move = wheels.step(a, wanted, np.minimum(size, np.pi - size), missing)
        except FactorisationFailed:
            break
        a = a * np.exp(np.clip(move / a, -longest, longest))  # positive angles stay so
        a *= np.pi / a.sum(axis=0)
    if residual <= HALF_DIGITS:
        return a.T.copy()
    return None


class _Wheels:
    """The conditions at the vertices that are not corners of the hole."""

    def __init__(self, system: VertexSystem, hole: int) -> None:
        self.system, self.corners = system, system.f.T
        self.free = np.ones(system.n, dtype=bool)
        self.free[system.f[hole]] = False
        #: 1 at corners that are free vertices, 0 at others: corner, face
        self.inner = np.where(self.free[self.corners], 1.0, 0.0)

    def missing(self, a: FloatArray) -> FloatArray:
        """Deviation of each vertex from its two conditions, on the sum and on the product, (2, n)."""
        sines = np.log(np.sin(a))
        sums = self.system.gathered(np.stack((a, sines[[1, 2, 0]] - sines[[2, 0, 1]])))
        return np.where(self.free, np.array([[2 * np.pi], [0.0]]) - sums, 0.0)

    def step(
        self, a: FloatArray, wanted: FloatArray, compliance: FloatArray, missing: FloatArray
    ) -> FloatArray:
        """The change nearest to the wanted one that closes all conditions to first order.

        The square of each angle's deviation is weighted by one over its compliance.
        """
        cotangent, m = 1 / np.tan(a), a.shape[1]
        J = np.zeros((3, 3, 2, m))  # angle; corner; its sum, then its product; face
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            J[i, i, 0] = self.inner[i]
            J[j, i, 1], J[k, i, 1] = cotangent[j] * self.inner[i], -cotangent[k] * self.inner[i]
        share = compliance / compliance.sum(axis=0)
        # Angles of a face must keep their sum: their common change is taken out of the compliance.
        PJ = compliance[:, None, None] * (J - np.einsum("am,aikm->ikm", share, J))
        wanted = wanted - share * wanted.sum(axis=0)
        lack = missing - self.system.gathered(np.einsum("aikm,am->kim", J, wanted))
        # the ridge keeps nearly singular matrices positive definite in spite of rounding
        values = self.system.damped(
            self.system.assemble(gram_blocks(PJ, J)), 1e-12, np.where(self.free, 0.0, 1.0)
        )
        multipliers = self.system.solve(self.system.factorize(values, within_memory=True), lack)
        return wanted + np.einsum("aikm,kim->am", PJ, multipliers.take(self.corners, axis=1))
