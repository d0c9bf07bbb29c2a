"""A member registered to a template, by the rotation of its sphere with the least energy times distance."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...maps.given_sphere import certified
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray
from ...resampling.transfer import resample
from ...untangle.local_repair import unfolded
from ..correspondence.registration import RegistrationDescent, reflected
from ..harmonics.rotation import rotation_angle
from .turns import NO_RESTARTS, Restarts, Turns


class MemberRegistration(NamedTuple):
    """A member's registration to a template.

    Attributes
    ----------
    sphere : (n, 3) float64 array
        The member's points on the template's sphere.
    correlation : float
        Of its depth potential with the template's.
    turned : bool
        Whether its position changed by a restart.
    rival : float
        Energy times distance of the second best turn over that of the best; infinite if none comes near.
    angle : float
        Degrees from the best rotation to the second.
    mirrored : float
        Distance of the mirror image's registration over that of the best; infinite if the mirror image does not come
        nearer by a rotation alone.
    """

    sphere: FloatArray
    correlation: float
    turned: bool = False
    rival: float = np.inf
    angle: float = np.nan
    mirrored: float = np.inf

    @property
    def has_rival(self) -> bool:
        """Whether another rotation fits nearly as well.

        A turn that puts exchanged arms of an octopus right divides energy times distance by 1.3. For correct members
        any other rotation multiplies it by 4 or more.
        """
        return self.rival < 1.5


def register_member(
    source: SphereMap,
    target: SphereMap,
    before: FloatArray | None = None,
    restarts: Restarts = NO_RESTARTS,
) -> MemberRegistration:
    """Register from the end of the registration before, perhaps turned, or from the best rotation."""
    problem = RegistrationDescent(source, target)
    if before is None:
        y = problem.registered(_best_start(problem))
        return MemberRegistration(y, problem.correlation(y))
    starts, outlooks = [before], np.ones(1)
    if restarts.turns:
        for turn in restarts.turns:  # rounding may fold slivers
            starts.append(unfolded(source.mesh, before @ np.array(turn).T))
        outlooks = np.array([problem.outlook(start) for start in starts])
    best, *others = np.argsort(outlooks).tolist()
    if best:
        y = problem.registered(starts[best])
    else:
        y = problem.continued(before)
    found = MemberRegistration(y, problem.correlation(y), best > 0)
    if others:
        turns = np.array([np.eye(3), *restarts.turns])
        found = found._replace(
            rival=_beside(outlooks[others[0]], outlooks[best]),
            angle=rotation_angle(turns[others[0]] @ turns[best].T),
        )
    if restarts.mirror:
        image = RegistrationDescent(reflected(source), target)
        nearest = image.registered(image.turned(image.turns()[0].rotation))
        found = found._replace(mirrored=_beside(image.distance(nearest), problem.distance(y)))
    return found


def _beside(other: float, taken: float) -> float:
    """Ratio of another result to the chosen one: infinite if only the latter is 0, and 1 if both are."""
    if taken > 0:
        return float(other / taken)
    if other > 0:
        return np.inf
    return 1.0


def register_with_restarts(source: SphereMap, target: SphereMap) -> MemberRegistration:
    """Register a surface to one on the same points of the sphere, and try rivals."""
    first = register_member(source, target)
    shape = resample(certified(source.mesh, first.sphere), (target.sphere, target.faces)).v
    _, (restarts,) = Turns(target.sphere).restarts(target.vertices, [shape])
    return register_member(source, target, first.sphere, restarts)


def _best_start(problem: RegistrationDescent, further: float = 1.5, most: int = 4) -> FloatArray:
    """The rotation with the least energy times distance, of those that bring the surfaces nearly nearest in space.

    The right one of an octopus with its arms exchanged may leave 1.05 times the distance of the nearest. At most `most`
    others are tried: arms are exchanged with the next ones.
    """
    nearest, *others = problem.turns()
    near = [turn for turn in others if turn.distance <= further * nearest.distance]
    starts = [problem.turned(turn.rotation) for turn in (nearest, *near[:most])]
    if len(starts) == 1:
        return starts[0]
    return min(starts, key=problem.outlook)
