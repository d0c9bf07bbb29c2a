"""Deep limbs solved again relative to their own rings, so that an image 1e-10 wide keeps its relative
precision.

A disc whose image is small is the solution of the Laplace equation within its ring of neighbours, which is
linear: in a frame that is centred on the ring and scaled by it, nothing is small. Discs are nested, each
frame lies in the one around it, and positions are summed at the end. Where even the sum would be too fine for
float64, the weights of the equation drift away from the tip, which draws the limb out and keeps every vertex
in its neighbours' hull.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components, reverse_cuthill_mckee
from scipy.sparse.linalg import splu

from ..errors import FactorisationFailed
from ..sphere.charts import from_chart, to_chart
from ..sphere.rows import unit_rows

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

#: Discs begin where the image's edges are shorter than exp(-this), and again each `_STEP` nepers further.
_ONSET = 9.0
_STEP = 7.0
#: Limbs are stretched until no edge is shorter than exp(-this), about which float64 ends.
FLOOR = 36.0
_FLOOR_AT_TIPS = 230.0
#: Weights below this share of the largest in their row are raised to it: the matrix stays an M-matrix.
_LEAST_WEIGHT = 1e-6
#: Positions in a frame are about 1; what is larger than this is none.
_LARGEST = 1e100


@dataclass
class Limbs:
    """Where the vertices of deep limbs lie, each in the frame of its innermost disc.

    A frame is centred on the ring of its disc and scaled by it. Its centre is given in the frame around, or,
    for an outermost disc, in the chart of stereographic projection that touches the sphere at the disc's
    pole.

    Attributes
    ----------
    frame : (n,) int64 array
        Innermost frame of each vertex; -1 outside all discs.
    z : (n,) complex array
        Position in that frame.
    parent : (k,) int64 array
        Frame around each frame, of a smaller index; -1 for an outermost one.
    centre : (k,) complex array
        Its centre in the frame around.
    scale : (k,) float64 array
        Its unit in that of the frame around.
    pole : (k, 3) float64 array
        The point of the sphere at which its limb's chart touches.
    stretch : float
        How far the most stretched limb was stretched, as a ratio of lengths; 1 if none was.
    """

    frame: IntArray
    z: ComplexArray
    parent: IntArray
    centre: ComplexArray
    scale: FloatArray
    pole: FloatArray
    stretch: float = 1.0

    def add(self, parent: IntArray, centre: ComplexArray, scale: FloatArray, pole: FloatArray) -> None:
        """Append frames."""
        self.parent = np.append(self.parent, parent)
        self.centre = np.append(self.centre, centre)
        self.scale = np.append(self.scale, scale)
        self.pole = np.vstack((self.pole, pole))

    def onto_sphere(self, x: FloatArray, tips: Sequence[int] = ()) -> FloatArray:
        """Put the limbs into a map, those of the given tips with the tips at their charts' poles."""
        fixed, at = self._around(tips)
        origin, unit = self.centre.copy(), self.scale.copy()
        for k, around in enumerate(self.parent):  # parents come first
            if around >= 0:
                origin[k] = origin[around] + unit[around] * (self.centre[k] - at[around])
                unit[k] = unit[around] * self.scale[k]
            if fixed[k]:
                origin[k] = 0
        deep = np.flatnonzero(self.frame >= 0)
        frame = self.frame[deep]
        y = x.copy()
        y[deep] = from_chart(origin[frame] + unit[frame] * (self.z[deep] - at[frame]), self.pole[frame])
        return y

    def _around(self, tips: Sequence[int]) -> tuple[BoolArray, ComplexArray]:
        """Which frames hold a tip, and where in them it lies: everything else is put relative to it."""
        fixed, at = np.zeros(len(self.parent), dtype=bool), np.zeros(len(self.parent), dtype=complex)
        for tip in tips:
            k, z = self.frame[tip], self.z[tip]
            while k >= 0:
                fixed[k], at[k] = True, z
                z, k = self.centre[k] + self.scale[k] * z, self.parent[k]
        return fixed, at


def solve_limbs(x: FloatArray, L: sp.csr_matrix, depth: FloatArray, area: FloatArray,
                tips: Sequence[int] = (), floor: float = FLOOR) -> Limbs:
    """Solve the deep limbs of a map again, each disc relative to its ring.

    Parameters
    ----------
    x : (n, 3) float64 array
        Unit rows; only those outside the discs are read.
    L : (n, n) sparse matrix
        Laplacian, best with intrinsic Delaunay weights.
    depth : (n,) float64 array
        Minus the natural logarithm of the image's edge lengths, see `predicted_log_edges`.
    area : (n,) float64 array
        Vertex areas of the source.
    tips : sequence of int
        Vertices at (0, 0, 1) or (0, 0, -1), where floating point is far finer: their limbs are stretched only
        if it ends even there.
    floor : float
        Depth that the deepest edges of all other limbs are kept above.

    Returns
    -------
    Limbs
        Positions in nested frames.

    Raises
    ------
    FactorisationFailed
        If the map or the depths mean so little that no positions come out.
    """
    if not np.isfinite(x).all():
        raise FactorisationFailed("limbs: the map is not finite")
    W = _positive_weights(L)
    level = _levels(W, depth, area)
    n = len(x)
    limbs = Limbs(np.full(n, -1), np.zeros(n, dtype=complex), np.empty(0, dtype=np.int64),
                  np.empty(0, dtype=complex), np.empty(0), np.empty((0, 3)))
    drift = np.zeros(n)
    for k in range(1, int(level.max(initial=0)) + 1):
        inside = np.flatnonzero(level >= k)
        parts, disc = connected_components(W[inside][:, inside], directed=False)
        if k == 1:
            floors = np.full(parts, floor)
            floors[disc[np.isin(inside, tips)]] = _FLOOR_AT_TIPS
            kappa = _shortening(depth[inside], disc, floors)
            limbs.stretch = float(1 / kappa.min())
            drift[inside] = ((1 - kappa**2) / (2 * kappa))[disc]
        rows = W[inside].tocoo()
        i, j = rows.row, rows.col
        weight = rows.data * np.exp(np.clip(drift[inside[i]] * (depth[inside[i]] - depth[j]), -30, 30))
        ring = level[j] < k
        at_tips = np.isin(inside, tips) & (k == 1)
        poles = np.zeros((parts, 3))
        poles[disc[at_tips]] = np.round(x[inside[at_tips]])
        rim = _place_frames(limbs, x, disc[i[ring]], j[ring], poles)
        local = np.full(n, -1)
        local[inside] = np.arange(len(inside))
        matrix = sp.csr_matrix((weight[~ring], (i[~ring], local[j[~ring]])), shape=(len(inside),) * 2)
        total = np.bincount(i, weight, len(inside))
        limbs.z[inside] = _solve(sp.diags(total) - matrix, _sums(i[ring], weight[ring] * rim, len(inside)))
        limbs.frame[inside] = len(limbs.parent) - parts + disc
        if not (np.abs(limbs.z[inside]) < _LARGEST).all():
            raise FactorisationFailed("limbs: the map means nothing around them")
    return limbs


def _positive_weights(L: sp.csr_matrix) -> sp.csr_matrix:
    """Edge weights of a Laplacian, none vanishing or negative."""
    W = sp.csr_matrix(-L)
    W.setdiag(0)
    W.eliminate_zeros()
    largest = W.max(axis=1).toarray().ravel()
    row = np.repeat(np.arange(W.shape[0]), np.diff(W.indptr))
    W.data = np.maximum(W.data, _LEAST_WEIGHT * np.maximum(largest[row], largest[W.indices]))
    return W


def _levels(W: sp.csr_matrix, depth: FloatArray, area: FloatArray) -> IntArray:
    """How many nested discs each vertex lies in; neighbours differ by one at the most."""
    level = np.zeros(len(depth), dtype=np.int64)
    image = area * np.exp(-2 * np.maximum(depth, 0))
    for k in range(int(max(0.0, (depth.max() - _ONSET) / _STEP)) + 1):
        inside = depth > _ONSET + k * _STEP
        inside &= (level >= k) & ~(W @ (level < k).astype(float) > 0)
        outside = np.flatnonzero(~inside)
        if not len(outside):  # nothing to solve relative to: the whole map is a speck
            break
        part = connected_components(W[outside][:, outside], directed=False)[1]
        inside[outside[part != np.argmax(np.bincount(part, image[outside]))]] = True  # islands within a disc
        deeper = inside & (level == k)
        if not deeper.any():  # predicted depths can be anything where positions mean nothing
            break
        level[deeper] = k + 1
    return level


def _shortening(depth: FloatArray, disc: IntArray, floor: FloatArray) -> FloatArray:
    """The factor kappa by which the depth of each limb must shrink for its deepest edge to stay above the
    floor.

    Along a limb the equation f'' - 2 alpha k f' = k^2 f, with a drift alpha = (1 - kappa^2) / (2 kappa), has
    the solution exp(-kappa k s) in place of exp(-k s): it makes a limb of depth k s one of depth kappa k s.
    """
    deepest = np.zeros(len(floor))
    np.maximum.at(deepest, disc, depth)
    return np.asarray(np.clip((floor - _ONSET) / np.maximum(deepest - _ONSET, 1.0), 0.02, 1.0))


def _place_frames(limbs: Limbs, x: FloatArray, disc: IntArray, ring: IntArray,
                  poles: FloatArray) -> ComplexArray:
    """Append a frame for each disc, given pairs (disc, ring vertex); the ring's positions in these frames."""
    parts = len(poles)
    parent = np.full(parts, -1)
    parent[disc] = limbs.frame[ring]
    weight = 1 / np.bincount(disc, minlength=parts)[disc]
    if (parent < 0).all():
        middle = np.stack([np.bincount(disc, weight * x[ring, c], parts) for c in range(3)], axis=1)
        pole = unit_rows(np.where(poles.any(axis=1, keepdims=True), poles, middle))
        around = to_chart(x[ring], pole[disc])
    else:
        pole = limbs.pole[parent]
        around = limbs.z[ring]
    centre = _sums(disc, weight * around, parts)
    scale = np.zeros(parts)
    np.maximum.at(scale, disc, np.abs(around - centre[disc]))
    scale = np.where(scale > 0, scale, 1.0)
    limbs.add(parent, centre, scale, pole)
    return np.asarray((around - centre[disc]) / scale[disc])


def _sums(groups: IntArray, values: ComplexArray, n: int) -> ComplexArray:
    """Sum of complex values by group."""
    return np.asarray(np.bincount(groups, values.real, n) + 1j * np.bincount(groups, values.imag, n))


def _solve(matrix: sp.csr_matrix, load: ComplexArray) -> ComplexArray:
    """Solve for a diagonally dominant matrix, which needs no pivoting."""
    order = reverse_cuthill_mckee(matrix, symmetric_mode=False)
    try:
        lu = splu(sp.csc_matrix(matrix[order][:, order]), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0,
                  options={"SymmetricMode": True})
    except RuntimeError as error:
        raise FactorisationFailed(f"limbs: {error}") from error
    parts = lu.solve(np.column_stack((load.real, load.imag))[order])
    z = np.empty(len(load), dtype=complex)
    z[order] = parts[:, 0] + 1j * parts[:, 1]
    return z
