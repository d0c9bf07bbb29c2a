"""A member registered to a template, by the rotation of its sphere that leads to the least energy times distance."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...maps.given_sphere import certified
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray
from ...resampling.transfer import resample
from ...untangle.local_repair import unfolded
from ..correspondence.registration import Laying, Turn, reflected
from ..harmonics.rotation import rotation_angle
from .turns import NO_RESTARTS, Restarts, Rows, Turns

# times the distance of the nearest rotation: of an octopus with its arms exchanged the right one has 1.05
_TRY = 1.5
_TRIED = 4  # of them at most: arms of an octopus are exchanged with the next ones


class Laid(NamedTuple):
    """A member's registration to a template.

    Attributes
    ----------
    sphere : (n, 3) float64 array
        Where the member's points lie on the template's sphere.
    correlation : float
        Of its depth potential with the template's.
    turned : bool
        Whether it was laid otherwise before.
    rival : float
        What the next best turn leads to, energy times distance, over that of the one that was taken; infinite if none
        comes near.
    angle : float
        Degrees from the rotation that was taken to that one.
    mirrored : float
        Distance of the mirror image's registration, over that of the one that was taken; infinite if the mirror image
        does not come nearer by a rotation alone.
    """

    sphere: FloatArray
    correlation: float
    turned: bool = False
    rival: float = np.inf
    angle: float = np.nan
    mirrored: float = np.inf


def laid(
    source: SphereMap,
    target: SphereMap,
    before: FloatArray | None = None,
    restarts: Restarts = NO_RESTARTS,
) -> Laid:
    """Register from where the registration before ended, perhaps turned, or from the rotation that leads to least."""
    problem = Laying(source, target)
    if before is None:
        y = problem.laid(_best_start(problem))
        return Laid(y, problem.correlation(y))
    starts = [before, *(_turned(source, before, turn) for turn in restarts.turns)]
    outlooks = (
        np.array([problem.outlook(start) for start in starts]) if restarts.turns else np.ones(1)
    )
    best, *others = np.argsort(outlooks).tolist()
    y = problem.laid(starts[best]) if best else problem.continued(before)
    found = Laid(y, problem.correlation(y), best > 0)
    if others:
        turns = np.array([np.eye(3), *restarts.turns])
        found = found._replace(
            rival=_beside(outlooks[others[0]], outlooks[best]),
            angle=rotation_angle(turns[others[0]] @ turns[best].T),
        )
    if restarts.mirror:
        image = Laying(reflected(source), target)
        nearest = image.laid(image.turned(image.turns()[0].rotation))
        found = found._replace(mirrored=_beside(image.distance(nearest), problem.distance(y)))
    return found


def _turned(source: SphereMap, y: FloatArray, turn: Rows) -> FloatArray:
    return unfolded(source.mesh, y @ np.array(turn).T)  # rounding may fold slivers


def _beside(other: float, taken: float) -> float:
    """What another way leads to over what was taken: infinite beside nothing, and 1 where both are nothing."""
    if taken > 0:
        return float(other / taken)
    return np.inf if other > 0 else 1.0


def tried(source: SphereMap, target: SphereMap) -> Laid:
    """Register a surface to one on the same points of the sphere, and try what comes as near."""
    first = laid(source, target)
    shape = resample(certified(source.mesh, first.sphere), (target.sphere, target.faces)).v
    _, (restarts,) = Turns(target.sphere).restarts(target.vertices, [shape])
    return laid(source, target, first.sphere, restarts)


def _best_start(problem: Laying) -> FloatArray:
    """Of the rotations that bring the surfaces near in space, the one that leads to least."""
    starts = [problem.turned(turn.rotation) for turn in _near(problem.turns())]
    return min(starts, key=problem.outlook) if starts[1:] else starts[0]


def _near(turns: list[Turn]) -> list[Turn]:
    """Rotations that bring surfaces nearly as near in space as the nearest one."""
    least = min(turn.distance for turn in turns)
    return [turn for turn in turns if turn.distance <= _TRY * least][: 1 + _TRIED]
