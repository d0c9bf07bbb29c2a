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
from numpy.typing import NDArray

from ..errors import FactorisationFailed
from ..operators.factor import factorize
from ..sphere.charts import tangent_axes
from ..sphere.rows import unit_rows, weighted_sum
from ..verify.certificate import certify_checked, orientation_signs
from ..verify.distortion import mean_difference
from .depth import log_edges
from .embedding import embed_locally
from .nudge import nudge

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

#: Added to the Hessian's diagonal, as a share: the Moebius group costs nothing.
_DAMPING = 1e-8
#: Steps tried; foldings that they make are mended if they are no more than this share of the faces.
_LENGTHS = (1.0, 0.5, 0.25)
_FEW_SHARE = 0.01


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

    def step(self, x: FloatArray, smoothing: float) -> FloatArray:
        """Take one step.

        Parameters
        ----------
        x : (n, 3) float64 array
            Unit rows, free of foldings.
        smoothing : float
            Differences below this, in radians, count by their squares.

        Returns
        -------
        (n, 3) float64 array
            Unit rows, free of foldings, of a smaller mean difference; `x` itself where no such step was found.
        """
        edge = np.exp(log_edges(x, self.f))
        axes = np.stack(tangent_axes(x), axis=1) * edge[:, None, None]
        difference, J = self._linearised(x, axes)
        weight = 1 / np.sqrt(difference**2 + smoothing**2)
        H = self._normal_equations(J, weight)
        load = (J * (weight * difference)[:, None]).sum(axis=0).reshape(3, 2, -1).transpose(1, 0, 2)
        g = np.column_stack([np.bincount(self.f.T.ravel(), part.ravel(), self.n) for part in load])
        try:
            factor = factorize(H + sp.diags_array(_DAMPING * H.diagonal() + 1e-12))
        except FactorisationFailed:
            return x
        if not factor.exact:  # multigrid is made for Laplacians
            return x
        C = self.A[:, None, None] * axes  # how the centroid moves
        solved = factor.solve(np.column_stack((g.ravel(), C.reshape(2 * self.n, 3)))).reshape(self.n, 2, 4)
        shift = np.einsum("nai,nak->ik", C, solved)
        astray = weighted_sum(self.A, x) - self.centroid
        multipliers = np.linalg.lstsq(shift[:, 1:], shift[:, 0] - astray, rcond=None)[0]
        steps = np.einsum("nak,k->na", solved, np.append(-1.0, multipliers))
        move = np.einsum("na,nai->ni", steps, axes)
        return self._search(x, move, float(np.degrees(np.abs(difference).mean())))

    def _search(self, x: FloatArray, move: FloatArray, before: float) -> FloatArray:
        """The longest of some steps that lowers the differences, few foldings mended."""
        for length in _LENGTHS:
            y = unit_rows(x + length * move)
            if (orientation_signs(y, self.f) <= 0).sum() > _FEW_SHARE * len(self.f):
                continue
            y = embed_locally(nudge(y, self.f), self.f)
            if certify_checked(y, self.f).folding_free and self.difference(y) < before:
                return y
        return x

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

    def _normal_equations(self, J: FloatArray, weight: FloatArray) -> sp.csr_matrix:
        """J^T diag(weight) J, two unknowns a vertex."""
        n, m = self.n, len(self.f)
        weighted = J * weight[:, None]

        def block(i: int, j: int) -> FloatArray:
            left, right = weighted[:, 2 * i:2 * i + 2], J[:, 2 * j:2 * j + 2]
            return np.stack([(left[:, a] * right[:, b]).sum(axis=0) for a in range(2) for b in range(2)])

        corners = self.f.T
        diagonal = np.zeros((4, n))
        half = np.empty((4, 3 * m))
        for k in range(3):
            for row, values in zip(diagonal, block(k, k), strict=True):
                row += np.bincount(corners[k], values, n)
            half[:, k * m:(k + 1) * m] = block(k, (k + 1) % 3)
        along, back, where = self._half_edges
        pairs = half[:, along] + half[[0, 2, 1, 3]][:, back]  # the block of (j, i) is that of (i, j), transposed
        data = np.empty((where.nnz, 4))
        loops = where.data < n
        data[loops], data[~loops] = diagonal.T, pairs.T
        return sp.bsr_matrix((data.reshape(-1, 2, 2), where.indices, where.indptr), shape=(2 * n, 2 * n)).tocsr()

    @cached_property
    def _half_edges(self) -> tuple[IntArray, IntArray, sp.csr_matrix]:
        """Half-edges in the order of a matrix's entries; their opposites; and the matrix's pattern, loops first."""
        n, start, end = self.n, self.f.T.ravel(), self.f.T[[1, 2, 0]].ravel()
        ids = np.arange(1, len(start) + 1)
        order = sp.csr_matrix((ids, (start, end)), shape=(n, n))
        order.sort_indices()
        loop = np.arange(n)
        pattern = sp.csr_matrix((np.append(loop, n + ids - 1), (np.append(loop, start), np.append(loop, end))),
                                shape=(n, n))
        pattern.sort_indices()
        return order.data - 1, order.T.tocsr().data - 1, pattern


def _cross(u: FloatArray, w: FloatArray) -> FloatArray:
    """Cross products along the first axis."""
    return np.stack((u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]))
