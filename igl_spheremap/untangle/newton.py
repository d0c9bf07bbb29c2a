"""Damped Gauss-Newton steps of a whole map on its angle differences (Levenberg and Marquardt).

Relaxation vertex by vertex takes thousands of sweeps to move the end of a limb; one sparse solve moves it at once. The
loss is the sum of sizes, not of squares (iteratively reweighted), so that single bad faces do not dominate. Each vertex
has its own damping, which grows around what a step folds: most vertices may take long steps. Moebius maps, which change
flat angles only a little, are excluded: the centroid of the source's area goes to a given point.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from ..errors import FactorisationFailed
from ..mesh.arrays import FloatArray
from ..mesh.measure import log_edges
from ..sphere.rows import column_crosses, tangent_axes, unit_rows, weighted_sum
from ..verify.distortion import mean_difference
from ..verify.signs import folded_faces
from .blocks import VertexBlocks
from .embedding import dilate, embed_locally
from .local_repair import FEW, RINGS, small_moves
from .relax import AngleLoss, relax_angles

#: Damping with which most steps succeed; on maps of deep limbs less of it folds hundreds of faces.
DAMPED = 3e-4
#: Factors of the damping: around what a step folds, everywhere after a step that failed, and after one that succeeds
#: at once. At the largest damping a vertex moves by less than a tenth of its undamped step: then the search gives up.
_AROUND, _EVERYWHERE, _FALLS, _LARGEST = 10.0, 4.0, 0.3, 10.0
#: Residual at which conjugate gradients stop, after some 10 iterations: a step gains .9 to 1 of what an exact one does.
_ACCURACY = 0.1


@dataclass(eq=False)
class AngleNewton:
    """Newton steps towards given corner angles that keep a map free of foldings.

    Attributes
    ----------
    blocks : VertexBlocks
        Assembly of the steps' matrices, and the faces.
    source : (3, m) float64 array
        Corner angles to reach, in radians.
    A : (n,) float64 array
        Vertex areas, of sum 1.
    centroid : (3,) float64 array
        Centroid that their images are to have.
    damping : (n,) float64 array
        Share of the Hessian's diagonal that is added at each vertex. Moves are in units of the vertex's edges, so it
        bounds them.
    systems : int
        How many more may be solved.
    exact : bool
        Whether they are factorised, as limbs require, which move as wholes; else conjugate gradients stop early.
    """

    blocks: VertexBlocks
    source: FloatArray
    A: FloatArray
    centroid: FloatArray
    damping: FloatArray
    systems: int
    exact: bool = True
    #: Whether the last step was taken with the damping that it began with, so that its gain predicts the next.
    at_once: bool = True

    def step(self, x: FloatArray, smoothing: float) -> tuple[FloatArray, float]:
        """A map free of foldings with a smaller mean difference, and that mean in degrees; `x` itself if none is found.

        Differences below `smoothing`, in radians, count by their squares.
        """
        f, axes = self.blocks.f, np.stack(tangent_axes(x), axis=1) * np.exp(log_edges(x, self.blocks.f))[:, None, None]
        difference, J = self._linearised(x, axes)
        weight = 1 / np.sqrt(difference**2 + smoothing**2)
        H = self.blocks.gram(J * weight[:, None], J)
        g = self.blocks.load((J * (weight * difference)[:, None]).sum(axis=0))
        mean, self.at_once = float(np.degrees(np.abs(difference).mean())), True
        while self.systems > 0:
            self.systems -= 1
            try:
                y = unit_rows(x + self._move(x, axes, H, g))
            except FactorisationFailed:
                break
            folded = folded_faces(y, f)
            taken = folded.sum() <= FEW * len(f)
            if taken and folded.any():
                y = self._embedded(y, smoothing)
                taken = not folded_faces(y, f).any()
            after = self.difference(y) if taken else np.inf
            around = np.zeros(len(x), dtype=bool)
            around[f[folded]] = True
            self.damping = np.minimum(_LARGEST, np.where(dilate(f, around, 1), _AROUND, 1) * self.damping)
            if after < mean:
                self.damping *= _FALLS if self.at_once else 1
                return y, after
            if self.damping.min() >= _LARGEST:
                break
            self.damping, self.at_once = np.maximum(_EVERYWHERE * self.damping, DAMPED), False
        return x, mean

    def _move(self, x: FloatArray, axes: FloatArray, H: sp.csr_matrix, g: FloatArray) -> FloatArray:
        """The damped step that takes the centroid to its place."""
        n = len(x)
        factor = self.blocks.factorize(H, np.repeat(self.damping, 2), 1e-12, self.exact)
        C = self.A[:, None, None] * axes  # how the centroid moves
        # The centroid gets to its place by any inverse in the columns of C, so that one that is not exact will do.
        solved = np.column_stack((factor.solve(g.ravel(), _ACCURACY), factor.apply(C.reshape(2 * n, 3))))
        solved = solved.reshape(n, 2, 4)
        shift = np.einsum("nai,nak->ik", C, solved)
        off_centre = weighted_sum(self.A, x) - self.centroid
        multipliers = np.linalg.lstsq(shift[:, 1:], shift[:, 0] - off_centre, rcond=None)[0]
        steps = np.einsum("nak,k->na", solved, np.append(-1.0, multipliers))
        return np.asarray(np.einsum("na,nai->ni", steps, axes))

    def _embedded(self, x: FloatArray, smoothing: float) -> FloatArray:
        """Undo the foldings of a step, and relax what that moved with its surroundings."""
        y = embed_locally(small_moves(x, self.blocks.f), self.blocks.f, persistent=False)
        movable = dilate(self.blocks.f, (y != x).any(axis=1), RINGS)
        around = movable[self.blocks.f].any(axis=1)
        return relax_angles(y, self.blocks.f[around], AngleLoss(self.source[:, around], smoothing), movable, sweeps=2)

    def difference(self, x: FloatArray) -> float:
        """Mean size of the angle differences of a map, in degrees."""
        return mean_difference(self.source.T, x, self.blocks.f)

    def _linearised(self, x: FloatArray, axes: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Angle differences (3, m), and their derivatives (3, 6, m) as the corners move along their axes."""
        corners = self.blocks.f.T
        p = np.ascontiguousarray(x.T).take(corners, axis=1)  # coordinate, corner, face
        side = p[:, [2, 0, 1]] - p[:, [1, 2, 0]]  # opposite each corner
        normal = column_crosses(side[:, 0], side[:, 1])
        double_area = np.sqrt((normal * normal).sum(axis=0))
        normal /= np.where(double_area > 0, double_area, 1.0)
        angles = np.arctan2(double_area, -(side[:, [1, 2, 0]] * side[:, [2, 0, 1]]).sum(axis=0))
        square = (side * side).sum(axis=0)
        turn = column_crosses(normal[:, None], side) / np.where(square > 0, square, 1.0)
        along = np.ascontiguousarray(axes.transpose(1, 2, 0)).take(corners, axis=2)  # axis, coordinate, corner, face
        J = np.empty((3, 3, 2, len(self.blocks.f)))
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            for a in range(2):
                J[i, j, a] = -(turn[:, k] * along[a, :, j]).sum(axis=0)
                J[i, k, a] = -(turn[:, j] * along[a, :, k]).sum(axis=0)
                J[i, i, a] = ((turn[:, j] + turn[:, k]) * along[a, :, i]).sum(axis=0)
        return angles - self.source, J.reshape(3, 6, -1)
