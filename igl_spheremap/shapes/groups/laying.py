"""A member registered to a template, by the rotation of its sphere that leads to the least energy times distance."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...maps.given_sphere import certified
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray
from ...sphere.moebius import best_rotation
from ...untangle.local_repair import unfolded
from ..correspondence.registration import Laying, Turn, reflected
from ..harmonics.rotation import rotation_angle

_TRY = 1.5  # times the distance of the nearest rotation: of an octopus with its arms exchanged the right one has 1.05
_TRIED = 4  # of them at most: arms of an octopus are exchanged with the next ones
_APART = 15.0  # degrees between rotations that are two, as of peaks of the correlation


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
        comes near, NaN if none was tried.
    angle : float
        Degrees from the rotation that was taken to that one.
    mirrored : float
        Distance of the mirror image's registration, over that of the one that was taken; infinite if the mirror image
        does not come nearer by a rotation alone.
    """

    sphere: FloatArray
    correlation: float
    turned: bool = False
    rival: float = np.nan
    angle: float = np.nan
    mirrored: float = np.nan


def laid(source: SphereMap, target: SphereMap, before: FloatArray | None = None, *, search: bool = False) -> Laid:
    """Register from where the registration before ended, or from the rotation that leads to least.

    With `search` other rotations of that are tried as well.
    """
    problem = Laying(source, target)
    if before is None:
        before = problem.laid(_best_start(problem))
    elif not search:
        before = problem.continued(before)
    return _searched(source, target, before) if search else Laid(before, problem.correlation(before))


def _best_start(problem: Laying) -> FloatArray:
    """Of the rotations that bring the surfaces near in space, the one that leads to least."""
    starts = [problem.turned(turn.rotation) for turn in _near(problem.turns())]
    return min(starts, key=problem.outlook) if starts[1:] else starts[0]


def _near(turns: list[Turn]) -> list[Turn]:
    """Rotations that bring surfaces nearly as near in space as the nearest one."""
    least = min(turn.distance for turn in turns)
    return [turn for turn in turns if turn.distance <= _TRY * least][: 1 + _TRIED]


def _searched(source: SphereMap, target: SphereMap, before: FloatArray) -> Laid:
    """Register from where the registration before ended, or from a rotation of that if it leads to less."""
    registered = certified(source.mesh, unfolded(source.mesh, before))
    lying, problem = Laying(registered, target), Laying(source, target)
    as_it_is = Turn(np.eye(3), lying.apart(np.eye(3)))
    turns = _near([as_it_is, *(turn for turn in lying.turns() if rotation_angle(turn.rotation) > _APART)])
    turns = [as_it_is, *(turn for turn in turns if turn is not as_it_is)]
    outlooks = np.array([problem.outlook(lying.turned(turn.rotation)) for turn in turns]) if turns[1:] else np.ones(1)
    best, *others = np.argsort(outlooks).tolist()
    y = problem.laid(lying.turned(turns[best].rotation)) if best else problem.continued(before)
    rival, angle = np.inf, np.nan
    if others:
        rival = outlooks[others[0]] / outlooks[best]
        angle = rotation_angle(turns[others[0]].rotation @ turns[best].rotation.T)
    mirror, mirrored = Laying(reflected(source), target), np.inf
    nearest = mirror.turns()[0]
    if nearest.distance < problem.apart(best_rotation(source.sphere, y, source.mesh.A).T):
        mirrored = mirror.distance(mirror.laid(mirror.turned(nearest.rotation))) / problem.distance(y)
    return Laid(y, problem.correlation(y), best > 0, rival, angle, mirrored)
