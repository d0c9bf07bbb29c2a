"""Gauss-Newton steps of a whole map on its angle differences.

What vertex by vertex takes thousands of sweeps to cross a limb, one sparse solve does at once. Sizes count, not
squares: iteratively reweighted, so that a few bad faces do not rule the rest. The Moebius group, which changes flat
angles but a little, is held: the centroid of the source's area stays where it was.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from ..errors import FactorisationFailed
from ..mesh.arrays import FloatArray, IntArray
from ..mesh.measure import log_edges
from ..operators.factor import factorize
from ..sphere.charts import tangent_axes
from ..sphere.rows import unit_rows, weighted_sum
from ..verify.certificate import certify_checked, orientation_signs
from ..verify.distortion import mean_difference
from .blocks import VertexBlocks
from .embedding import dilate, embed_locally
from .local_repair import FEW, RELAXED_RINGS
from .nudge import nudge
from .relax import AngleLoss, descend


@dataclass(frozen=True, eq=False)
class AngleNewton:
    """Newton steps towards given corner angles, which keep a map free of foldings so.

    Attributes
    ----------
    f : (m, 3) int64 array
        Faces.
    source : (3, m) float64 array
        Corner angles to reach, in radians.
    A : (n,) float64 array
        Vertex areas, of sum 1.
    centroid : (3,) float64 array
        Where their centroid is to be.
    """

    f: IntArray
    source: FloatArray
    A: FloatArray
    centroid: FloatArray

    @property
    def n(self) -> int:
        """Number of vertices of a closed genus-0 mesh."""
        return len(self.f) // 2 + 2

    @cached_property
    def _blocks(self) -> VertexBlocks:
        """Assembly of the steps' matrices."""
        return VertexBlocks(self.f)

    def step(self, x: FloatArray, smoothing: float, damping: float) -> FloatArray:
        """A map free of foldings with a smaller mean difference; `x` itself where the step does not lead to one.

        Differences below `smoothing`, in radians, count by their squares. `damping` is the share of the Hessian's
        diagonal that is added: as vertices move in units of their edges, it bounds how far they go.
        """
        edge = np.exp(log_edges(x, self.f))
        axes = np.stack(tangent_axes(x), axis=1) * edge[:, None, None]
        difference, J = self._linearised(x, axes)
        weight = 1 / np.sqrt(difference**2 + smoothing**2)
        H = self._blocks.gram(J * weight[:, None], J)
        g = self._blocks.load((J * (weight * difference)[:, None]).sum(axis=0))
        try:
            factor = factorize(H + sp.diags_array(damping * H.diagonal() + 1e-12))
        except FactorisationFailed:
            return x
        if not factor.exact:  # multigrid is made for Laplacians
            return x
        C = self.A[:, None, None] * axes  # how the centroid moves
        solved = factor.solve(np.column_stack((g.ravel(), C.reshape(2 * self.n, 3)))).reshape(self.n, 2, 4)
        shift = np.einsum("nai,nak->ik", C, solved)
        off_centre = weighted_sum(self.A, x) - self.centroid
        multipliers = np.linalg.lstsq(shift[:, 1:], shift[:, 0] - off_centre, rcond=None)[0]
        steps = np.einsum("nak,k->na", solved, np.append(-1.0, multipliers))
        y = unit_rows(x + np.einsum("na,nai->ni", steps, axes))
        before = float(np.degrees(np.abs(difference).mean()))
        folded = (orientation_signs(y, self.f) <= 0).sum()
        if folded > FEW * len(self.f):
            return x
        if folded:
            y = self._embedded(y, smoothing)
        return y if certify_checked(y, self.f).folding_free and self.difference(y) < before else x

    def _embedded(self, x: FloatArray, smoothing: float) -> FloatArray:
        """Undo the foldings of a step, and relax what that moved with its surroundings."""
        y = embed_locally(nudge(x, self.f), self.f)
        movable = dilate(self.f, (y != x).any(axis=1), RELAXED_RINGS)
        around = movable[self.f].any(axis=1)
        return descend(y, self.f[around], AngleLoss(self.source[:, around], smoothing), movable)

    def difference(self, x: FloatArray) -> float:
        """Mean size of the angle differences of a map, in degrees."""
        return mean_difference(self.source.T, x, self.f)

    def _linearised(self, x: FloatArray, axes: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Angle differences (3, m), and their derivatives (3, 6, m) as the corners move along their axes."""
        p = x.T[:, self.f.T]  # coordinate, corner, face
        side = p[:, [2, 0, 1]] - p[:, [1, 2, 0]]  # opposite each corner
        normal = _cross(side[:, 0], side[:, 1])
        double_area = np.sqrt((normal * normal).sum(axis=0))
        normal /= np.where(double_area > 0, double_area, 1.0)
        angles = np.arctan2(double_area, -(side[:, [1, 2, 0]] * side[:, [2, 0, 1]]).sum(axis=0))
        square = (side * side).sum(axis=0)
        turn = _cross(normal[:, None], side) / np.where(square > 0, square, 1.0)
        along = np.ascontiguousarray(axes.transpose(1, 2, 0))[:, :, self.f.T]  # axis, coordinate, corner, face
        J = np.empty((3, 3, 2, len(self.f)))
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            for a in range(2):
                J[i, j, a] = -(turn[:, k] * along[a, :, j]).sum(axis=0)
                J[i, k, a] = -(turn[:, j] * along[a, :, k]).sum(axis=0)
                J[i, i, a] = ((turn[:, j] + turn[:, k]) * along[a, :, i]).sum(axis=0)
        return angles - self.source, J.reshape(3, 6, -1)


def _cross(u: FloatArray, w: FloatArray) -> FloatArray:
    """Cross products along the first axis."""
    return np.stack((u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]))
