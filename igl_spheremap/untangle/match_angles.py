"""Lower the angle differences of a whole map without changing the sign of any face, by Newton steps.

Relaxation vertex by vertex takes thousands of sweeps to move the end of a limb; one sparse solve moves it at once. The
loss is the sum of sizes, not of squares (iteratively reweighted), so that single bad faces do not dominate. Moebius
maps, which change flat angles only a little, are excluded: the centroid of the source's area goes to a given point.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..mesh.arrays import HALF_DIGITS, FloatArray, IntArray
from ..mesh.check import Mesh
from ..mesh.edges import marked, touching
from ..mesh.measure import by_blocks, corner_angles, log_edges, spread
from ..mesh.timings import stage
from ..newton.loop import Levenberg, Model, Trial, newton
from ..newton.system import VertexSystem, gram_blocks
from ..sphere.rows import column_axes, column_crosses, column_dots, sizes, unit_rows, weighted_sum
from ..verify.distortion import mean_angle_difference, mean_difference
from ..verify.signs import folded_faces, signed_volumes
from .effort import Effort
from .embedding import dilate, embed_locally
from .local_repair import FEW, RINGS, small_moves
from .relax import AngleLoss, relax_angles

#: Smoothing of the angle differences, in units of their mean: of a sample's sweep, and of steps, which stall with less.
_SMOOTHING, _STEP_SMOOTHING = 0.03, 0.1
#: A map without foldings takes no steps if its mean angle difference is below GOOD degrees, or the prediction below
#: WORTH: steps then gain 7 percent up to 2,000 vertices, where they cost milliseconds, and 10 to 20 above.
GOOD, _WORTH = 1.2, (0.006, 0.028)
#: Mean least angle of the faces of a harmonic map of which steps gain as much as of any other map.
_THIN = np.radians(30)
#: Vertices up to which most of the time of a step is the overhead of calls. Samples that decide on steps are half as
#: large: faces for the mean, stars of vertices for the gain of a sweep. With twice the faces 231 meshes decide alike.
SMALL = 1000


@stage("polish")
def polish_map(mesh: Mesh, x: FloatArray, effort: Effort = Effort()) -> FloatArray:  # noqa: B008 - it is frozen
    """Lower the mean size of the angle differences of a map that is certified free of foldings.

    The mean falls by 10 to 20 percent on many meshes; that is partly fitting the measure. Runs go on while they gain.
    """
    effort = replace(effort, least_gain=min(effort.polish_gain, effort.least_gain))
    system, centroid = VertexSystem(mesh.f, len(x), limbs=True), weighted_sum(mesh.A, x)
    before, mean = np.inf, mean_angle_difference(mesh, x)
    while mean < (1 - effort.least_gain) * before:
        y = match_angles(mesh, x, centroid, system, effort, damping=HALF_DIGITS)
        before, mean = mean, mean_angle_difference(mesh, y)
        x = y if mean < before else x
    return x


def match_angles(mesh: Mesh, x: FloatArray, centroid: FloatArray, system: VertexSystem, effort: Effort, *,
                 damping: float, rough: bool = False) -> FloatArray:
    """Lower the angle differences of a map free of foldings, by damped Newton steps.

    The centroid of the source's area goes to `centroid`. If gains g_k fall by the same factor q from step to step, all
    further steps together gain g_k q / (1 - q) (Aitken). Steps end when that is below the least gain. The
    gain of one that had to be damped more than the first predicts little: after it they end when it is below the square
    of the least gain. If `rough`, what steps fold is repaired by small moves only.
    """
    problem = AngleProblem(mesh.f, mesh.angles.T, mesh.A, centroid, rough=rough)
    steps = Levenberg(system, np.full(len(x), damping), effort.systems)
    mean, gains = problem.value(x), list[float]()
    for trial in newton(problem, steps, x) if effort.systems else ():
        gains.append(1 - trial.value / max(mean, np.degrees(HALF_DIGITS)))
        x, mean = trial.x, trial.value
        if gains[-1] <= 0 or not steps.systems:
            break
        further, undamped = _further(gains[-3:]), steps.at_once and steps.damping.min() <= damping
        if further < effort.least_gain if undamped else gains[-1] < effort.least_gain**2:
            break
    return x


def _further(gains: list[float]) -> float:
    """What all further steps gain; the factor is a mean over two, as gains jump where faces fold."""
    q = (gains[-1] / gains[0]) ** (1 / (len(gains) - 1)) if len(gains) > 1 else 0.5
    return gains[-1] * q / (1 - q) if q < 1 else np.inf


def is_worth_steps(mesh: Mesh, x: FloatArray, harmonic: bool = False) -> bool:
    """True if steps are predicted to lower the angle differences of a map without foldings enough, by a sample.

    The prediction is what a sweep gains, times the share of the differences that can be lowered: those at a vertex add
    up to its curvature, less that of the image. A harmonic map is conformal already where faces are well shaped.
    """
    sample = mesh.f[spread(len(mesh.f), SMALL // 2)]
    source = corner_angles(mesh.v, sample)
    if mean_difference(source, x, sample) <= GOOD:
        return False
    thin = _THIN / source.min(axis=1).mean() if harmonic else 1.0
    movable = marked(np.arange(0, len(x), max(1, len(x) // (SMALL // 2))), len(x))
    around = mesh.f[touching(mesh.f, movable)]
    source = corner_angles(mesh.v, around)
    difference, own = corner_angles(x, around) - source, movable[around]
    curvature = np.bincount(around[own], difference[own], len(x))
    lowerable = 1 - np.abs(curvature).sum() / np.abs(difference[own]).sum()
    mean = float(np.degrees(np.abs(difference).mean()))
    y = relax_angles(x, around, AngleLoss(source.T, _SMOOTHING * np.radians(mean)), movable, sweeps=1)
    gain = 1 - mean_difference(source, y, around) / mean
    return bool(gain * lowerable * thin > _WORTH[len(x) > 2 * SMALL])


class AngleProblem:
    """Given corner angles, which a map free of foldings is to come near.

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
        Whether foldings of a step are repaired by small moves only, and nothing is relaxed around them.
    """

    def __init__(self, f: IntArray, source: FloatArray, A: FloatArray, centroid: FloatArray,
                 smoothing: float | None = None, rough: bool = False) -> None:
        self.f, self.source, self.A, self.centroid, self._fixed = f, source, A, centroid, smoothing
        self._smoothing, self._rough = smoothing or 0.0, rough

    def value(self, x: FloatArray) -> float:
        """Mean size of the angle differences of a map, in degrees."""
        return mean_difference(self.source.T, x, self.f)

    def model(self, x: FloatArray) -> Model:
        """Gauss-Newton with iteratively reweighted squares; steps are in units of the edges around a vertex."""
        axes = column_axes(x.T) * np.exp(log_edges(x, self.f))
        difference, J = self.linearised(x, axes)
        mean = float(np.degrees(np.abs(difference).mean()))
        self._smoothing = self._fixed or _STEP_SMOOTHING * np.radians(max(mean, np.degrees(HALF_DIGITS)))
        weight = 1 / np.sqrt(difference**2 + self._smoothing**2)
        corners, slopes = self.f.T.ravel(), np.einsum("im,ijam->ajm", weight * difference, J)
        gradient = np.array([np.bincount(corners, slope.ravel(), len(x)) for slope in slopes], dtype=np.float64)
        off_centre = weighted_sum(self.A, x) - self.centroid
        return Model(mean, axes, gradient, gram_blocks(weight[:, None, None] * J, J),
                     border=(self.A * axes.transpose(1, 0, 2), -off_centre))

    def move(self, x: FloatArray, model: Model, step: FloatArray) -> FloatArray:
        """Displacements of a step along the axes."""
        return np.asarray(np.einsum("an,ain->ni", step, model.axes))

    def accept(self, x: FloatArray, move: FloatArray) -> Trial:
        """The map x + move; if it folds few faces, they are embedded and relaxed with what is around them."""
        y = unit_rows(x + move)
        bad = folded = folded_faces(y, self.f)
        if bad.sum() > FEW * len(self.f):
            return Trial(x, np.inf, folded)
        if bad.any():
            z = small_moves(y, self.f)
            bad = folded_faces(z, self.f)
            if not self._rough and bad.any():
                z = embed_locally(z, self.f, persistent=False)
                bad = folded_faces(z, self.f)
            if not self._rough and not bad.any():
                movable = dilate(self.f, (z != y).any(axis=1), RINGS)
                around = touching(self.f, movable)
                loss = AngleLoss(self.source[:, around], self._smoothing)
                z = relax_angles(z, self.f[around], loss, movable, sweeps=2)
            y = z
        if bad.any() or not covers_once(y, self.f):
            return Trial(x, np.inf, folded)
        return Trial(y, self.value(y), folded)

    def linearised(self, x: FloatArray, axes: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Angle differences (3, m), and their derivatives (angle, corner, axis, face) as corners move along axes."""
        corners = self.f.T
        p = np.ascontiguousarray(x.T).take(corners, axis=1)  # coordinate, corner, face
        side = p[:, [2, 0, 1]] - p[:, [1, 2, 0]]  # opposite each corner
        along = axes.take(corners, axis=2)  # axis, coordinate, corner, face
        if (side * side).sum(axis=0).min() < np.finfo(float).tiny ** 0.25:  # products of four sides underflow
            size = sizes(np.abs(side).sum(axis=1).T)
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
    """Whether the degree of a map is 1: the solid angles of faces, negative where they fold, sum to 4 pi times it."""
    return abs(float(by_blocks(_half_solid_angles, x, f).sum()) - 2 * np.pi) < np.pi


def _half_solid_angles(corners: FloatArray) -> FloatArray:
    """Half the solid angles of faces (coordinate, corner, face), by van Oosterom and Strackee's formula."""
    a, b, c = corners.transpose(1, 0, 2)
    dots = column_dots(a, b) + column_dots(b, c) + column_dots(c, a)
    return np.asarray(np.arctan2(signed_volumes(corners), 1 + dots))
