"""Lower the angle differences of a whole map without changing the sign of any face."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..mesh.arrays import FloatArray
from ..mesh.check import Mesh
from ..mesh.measure import corner_angles, spread
from ..mesh.timings import stage
from ..sphere.rows import weighted_sum
from ..verify.distortion import mean_difference
from .blocks import VertexBlocks
from .effort import Effort
from .newton import AngleNewton
from .relax import AngleLoss, relax_angles

#: Smoothing of the angle differences, in units of their mean: of sweeps, and of steps, which stall with less.
_SMOOTHING, _STEP_SMOOTHING = 0.03, 0.1
#: Damping of the first step where most angles of the map fit already: almost none.
UNDAMPED = 1e-8
#: Mean differences in degrees below this are rounding.
_EXACT = 1e-6
#: A map without foldings is left alone if its mean angle difference is below the first, in degrees, or if the gain of a
#: sweep times (median / mean of the differences)^2, or times the third if that is larger, is below the second. Steps
#: lower differences that are alike everywhere (median near the mean), which sweeps do not.
_GOOD, _WORTH_STEPS, _ALIKE = 1.2, 0.006, 0.3
#: That is measured on a sample: the mean on so many faces, what a sweep gains on the stars of so many vertices.
_FACES, _STARS = 999, 500


@stage("polish")
def polish_map(mesh: Mesh, x: FloatArray, effort: Effort = Effort()) -> FloatArray:  # noqa: B008 - it is frozen
    """Lower the mean size of the angle differences of a map that is certified free of foldings.

    The mean falls by 10 to 20 percent on many meshes; that is partly fitting the measure.
    """
    effort = replace(effort, least_gain=min(effort.polish_gain, effort.least_gain))
    return match_angles(mesh, x, weighted_sum(mesh.A, x), VertexBlocks(mesh.f), effort, damping=UNDAMPED)


def match_angles(mesh: Mesh, x: FloatArray, centroid: FloatArray, blocks: VertexBlocks, effort: Effort, *,
                 damping: float, quick: bool = False) -> FloatArray:
    """Lower the angle differences of a map free of foldings, by damped Newton steps and sweeps over the vertices.

    The centroid of the source's area goes to `centroid`. If gains g_k fall by the same factor q = g_k / g_{k-1}, all
    further steps together gain g_k q / (1 - q) (Aitken). Steps end when that is below the least gain, but not after
    one that had to be shortened, whose gain predicts nothing. Sweeps help where limbs are too fine for steps. If
    `quick`, steps are not exact, and there are no sweeps.
    """
    loss = AngleLoss.of(mesh.v, mesh.f)
    newton = AngleNewton(blocks, loss.source, mesh.A, centroid, np.full(len(x), damping), effort.systems,
                         exact=not quick)
    mean, last = newton.difference(x), 0.0
    while newton.systems:
        before = mean
        x, mean = newton.step(x, _STEP_SMOOTHING * np.radians(max(mean, _EXACT)))
        gain = 1 - mean / max(before, _EXACT)
        falls = (last or 2 * gain) - gain
        if gain <= 0 or (newton.at_once and gain**2 < effort.least_gain * falls):
            break
        last = gain
    return x if quick else relax_angles(x, mesh.f, _smoothed(loss, mean), sweeps=effort.sweeps,
                                    tolerance=effort.least_gain)


def is_worth_steps(mesh: Mesh, x: FloatArray) -> bool:
    """True if the angle differences of a map without foldings are large and steps would lower them, by a sample."""
    sample = mesh.f[spread(len(mesh.f), _FACES)]
    if mean_difference(corner_angles(mesh.v, sample), x, sample) <= _GOOD:
        return False
    movable = np.zeros(len(x), dtype=bool)
    movable[:: max(1, len(x) // _STARS)] = True
    around = mesh.f[movable[mesh.f].any(axis=1)]
    source = corner_angles(mesh.v, around)
    difference = np.degrees(np.abs(corner_angles(x, around) - source))
    mean = float(difference.mean())
    y = relax_angles(x, around, _smoothed(AngleLoss(source.T), mean), movable, sweeps=1)
    gain = 1 - mean_difference(source, y, around) / mean
    return bool(gain * max(_ALIKE, (np.median(difference) / mean) ** 2) > _WORTH_STEPS)


def _smoothed(loss: AngleLoss, mean: float) -> AngleLoss:
    """The loss for a map whose mean difference is so many degrees."""
    return replace(loss, smoothing=_SMOOTHING * np.radians(max(mean, _EXACT)))
