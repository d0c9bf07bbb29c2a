"""Lower the angle differences of a whole map without changing the sign of any face, by Newton steps.

Relaxation vertex by vertex takes thousands of sweeps to move the end of a limb; one sparse solve moves it at once. The
loss is the sum of sizes, not of squares (iteratively reweighted), so that single bad faces do not dominate. Moebius
maps, which change flat angles only a little, are excluded: the centroid of the source's area goes to a given point.
"""

from __future__ import annotations

import numpy as np

from ..mesh.arrays import HALF_DIGITS, TINY, FloatArray, IntArray
from ..mesh.check import Mesh
from ..mesh.edges import marked, touching
from ..mesh.measure import by_blocks, corner_angles, log_edges, spread
from ..newton.loop import Levenberg, Model, Trial, newton
from ..newton.system import VertexSystem, gram_blocks
from ..sphere.rows import (
    binary_sizes,
    column_axes,
    column_crosses,
    column_dots,
    unit_rows,
    weighted_sum,
)
from ..untangle.embedding import dilate, embed_nearby
from ..untangle.local_repair import RELAXED_RINGS, are_few, small_moves
from ..untangle.relax import AngleLoss, gain_of_single_moves, relax_angles
from ..verify.distortion import mean_difference
from ..verify.signs import folded_faces, signed_volumes


def match_angles(
    mesh: Mesh,
    x: FloatArray,
    centroid: FloatArray,
    system: VertexSystem,
    systems: int,
    least_gain: float,
    *,
    damping: float,
    rough: bool = False,
) -> tuple[FloatArray, float]:
    """Lower the angle differences of a map free of foldings by damped Newton steps, until `Aitken` ends them.

    The centroid of the source's area goes to `centroid`. Also returned is the share that further steps are predicted to
    gain.
    """
    problem = AngleProblem(mesh.f, mesh.angles.T, mesh.A, centroid, rough=rough)
    steps, end = Levenberg(system, np.full(len(x), damping), systems), Aitken(least_gain)
    mean = problem.value(x)
    for trial in newton(problem, steps, x):
        gain = 1 - trial.value / max(mean, np.degrees(HALF_DIGITS))
        x, mean = trial.x, trial.value
        if end.reached(gain, predicts=bool(steps.at_once and steps.damping.min() <= damping)):
            break
    return x, end.further


class Aitken:
    """Ends steps when all further ones together gain less than a share, supposing that gains fall by one factor.

    Attributes
    ----------
    further : float
        Gain of all further steps, as a share of the value; infinite if unknown.
    """

    def __init__(self, least_gain: float) -> None:
        self._least, self._gains, self.further = least_gain, list[float](), np.inf

    def reached(self, gain: float, predicts: bool = True) -> bool:
        """Whether steps end after one of this gain.

        Gains g_k that fall by a factor q sum to g_k q / (1 - q). The factor is a mean over two, as folding faces make
        gains jump. If the damping has grown since the first step, the gain `predicts` no others: it alone decides.
        """
        self._gains = [*self._gains[-2:], gain]
        q = 0.5
        if len(self._gains) > 1:
            q = (gain / self._gains[0]) ** (1 / (len(self._gains) - 1))
        self.further = np.inf
        if predicts and q < 1:
            self.further = gain * q / (1 - q)
        if predicts:
            return self.further < self._least
        return gain < self._least**2


def is_worth_steps(
    mesh: Mesh,
    x: FloatArray,
    price: float,
    *,
    good: float = 1.2,
    sampled: int = 500,
    few: int = 100,
) -> bool:
    """True if a sample predicts that steps lower a map's angle differences by more than the share `price`.

    A map of a mean below `good` degrees takes no steps, since they hardly show; `sampled` faces tell the mean. First
    `few` stars of vertices predict the gain. If it is at least a third of the price, `sampled` stars predict it again.
    """
    sample = mesh.f[spread(len(mesh.f), sampled)]
    if mean_difference(corner_angles(mesh.unit, sample), x, sample) <= good:
        return False
    if 3 * _predicted_gain(mesh, x, few) < price:
        return False
    return _predicted_gain(mesh, x, sampled) > price


def _predicted_gain(
    mesh: Mesh,
    x: FloatArray,
    sampled: int,
    smoothing: float = 0.03,
    thin: float = np.radians(30),
    steps_per_sweep: float = 4,
) -> float:
    """The share by which steps are predicted to lower a map's angle differences.

    It is the gain of a sweep over a sample of vertices, each moved alone, times the share of the differences that can
    be lowered. The sum of the differences at a vertex can't: it is the vertex's curvature less that of its image. If
    faces are better shaped than `thin`, in the mean of their least angles, the harmonic map is conformal already, and
    steps gain less.

    Parameters
    ----------
    smoothing
        Angle differences below this share of their mean count by their squares.
    steps_per_sweep
        Gain of the steps over that of a sweep: less than all samples gained.
    """
    vertices = np.arange(0, len(x), max(1, len(x) // sampled))
    movable, around = marked(vertices, len(x)), mesh.f[mesh.edges.faces_at(vertices)]
    source = corner_angles(mesh.unit, around)
    difference, own = corner_angles(x, around) - source, movable[around]
    curvature = np.bincount(around[own], difference[own], len(x))
    size = np.abs(difference)
    lowerable = 1 - np.abs(curvature).sum() / size[own].sum()
    loss = AngleLoss(source.T, smoothing * float(size.mean()))
    gain = gain_of_single_moves(x, around, loss, movable) / size.sum()
    return float(steps_per_sweep * gain * lowerable * thin / source.min(axis=1).mean())


class AngleProblem:
    """Differences of a map's corner angles from given ones, lowered without foldings.

    Parameters
    ----------
    f : (m, 3) int64 array
        Faces.
    source : (3, m) float64 array
        Corner angles to reach, in radians.
    A : (n,) float64 array
        Vertex areas, of sum 1.
    centroid : (3,) float64 array
        Centroid that their images are to have.
    smoothing : float, optional
        Differences below this, in radians, count by their squares; a share of their mean by default.
    rough : bool, optional
        Whether a step's folds are repaired by small moves only, without relaxation around them: for speed.
    """

    def __init__(
        self,
        f: IntArray,
        source: FloatArray,
        A: FloatArray,
        centroid: FloatArray,
        smoothing: float | None = None,
        rough: bool = False,
    ) -> None:
        self.f, self.source, self.A, self.centroid = f, source, A, centroid
        self._smoothing, self._rough = smoothing, rough

    def value(self, x: FloatArray) -> float:
        """Mean size of the angle differences of a map, in degrees."""
        return mean_difference(self.source.T, x, self.f)

    def model(self, x: FloatArray) -> Model:
        """Gauss-Newton with iteratively reweighted squares; steps are in units of the edges around a vertex."""
        axes = column_axes(x.T) * np.exp(log_edges(x, self.f))
        difference, J = self.linearised(x, axes)
        mean = float(np.degrees(np.abs(difference).mean()))
        smoothing = self._smoothing
        if smoothing is None:
            # with a smaller share steps stall
            smoothing = 0.1 * np.radians(max(mean, np.degrees(HALF_DIGITS)))
        weight = 1 / np.sqrt(difference**2 + smoothing**2)
        corners, slopes = self.f.T.ravel(), np.einsum("im,ijam->ajm", weight * difference, J)
        gradient = np.array(
            [np.bincount(corners, slope.ravel(), len(x)) for slope in slopes], dtype=np.float64
        )
        off_centre = weighted_sum(self.A, x) - self.centroid
        return Model(
            mean,
            axes,
            gradient,
            gram_blocks(weight[:, None, None] * J, J),
            border=(self.A * axes.transpose(1, 0, 2), -off_centre),
        )

    def move(self, x: FloatArray, model: Model, step: FloatArray) -> FloatArray:
        """Displacements of a step along the axes."""
        return np.asarray(np.einsum("an,ain->ni", step, model.axes))

    def accept(self, x: FloatArray, move: FloatArray) -> Trial:
        """The map x + move; if it folds few faces, they are repaired, and moved vertices relaxed."""
        y = unit_rows(x + move)
        folded = folded_faces(y, self.f)
        if not are_few(folded.sum(), self.f):
            return Trial(x, np.inf, folded)
        if folded.any():
            if self._rough:
                y = small_moves(y, self.f)
            else:
                y = self._mended(y)
            if folded_faces(y, self.f).any():
                return Trial(x, np.inf, folded)
        if not covers_once(y, self.f):
            return Trial(x, np.inf, folded)
        return Trial(y, self.value(y), folded)

    def _mended(self, y: FloatArray) -> FloatArray:
        """A map of few foldings, repaired, its moved vertices relaxed."""
        # only nearby: embedding in a larger region takes longer than a smaller step
        z = embed_nearby(small_moves(y, self.f), self.f)
        if folded_faces(z, self.f).any():
            return z
        movable = dilate(self.f, (z != y).any(axis=1), RELAXED_RINGS)
        around = touching(self.f, movable)
        loss = AngleLoss(self.source[:, around])
        # one sweep is too few on some meshes
        return relax_angles(z, self.f[around], loss, movable, sweeps=2)

    def linearised(self, x: FloatArray, axes: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Angle differences (3, m), and their derivatives (angle, corner, axis, face) as corners move along axes."""
        corners = self.f.T
        p = np.ascontiguousarray(x.T).take(corners, axis=1)  # coordinate, corner, face
        side = p[:, [2, 0, 1]] - p[:, [1, 2, 0]]  # opposite each corner
        along = axes.take(corners, axis=2)  # axis, coordinate, corner, face
        # products of four sides underflow
        if (side * side).sum(axis=0).min() < TINY**0.25:
            size = binary_sizes(np.abs(side).sum(axis=1).T)
            side, along = side / size, along / size
        normal = column_crosses(side[:, 0], side[:, 1])
        double_area = np.sqrt((normal * normal).sum(axis=0))
        normal /= np.where(double_area > 0, double_area, 1.0)
        angles = np.arctan2(double_area, -(side[:, [1, 2, 0]] * side[:, [2, 0, 1]]).sum(axis=0))
        square = (side * side).sum(axis=0)
        turn = column_crosses(normal[:, None], side) / np.where(square > 0, square, 1.0)
        J = np.empty((3, 3, 2, len(self.f)))
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            np.einsum("cm,acm->am", -turn[:, k], along[:, :, j], out=J[i, j])
            np.einsum("cm,acm->am", -turn[:, j], along[:, :, k], out=J[i, k])
            np.einsum("cm,acm->am", turn[:, j] + turn[:, k], along[:, :, i], out=J[i, i])
        return angles - self.source, J


def covers_once(x: FloatArray, f: IntArray) -> bool:
    """Whether the degree of a map is 1: the signed solid angles of faces sum to 4 pi times it."""
    return abs(float(by_blocks(_half_solid_angles, x, f).sum()) - 2 * np.pi) < np.pi


def _half_solid_angles(corners: FloatArray) -> FloatArray:
    """Half the solid angles of faces (coordinate, corner, face), by van Oosterom and Strackee's formula."""
    a, b, c = corners.transpose(1, 0, 2)
    dots = column_dots(a, b) + column_dots(b, c) + column_dots(c, a)
    return np.asarray(np.arctan2(signed_volumes(corners), 1 + dots))
