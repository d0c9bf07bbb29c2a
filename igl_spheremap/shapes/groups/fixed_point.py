"""The mean of surfaces that are registered to it: m = mean of F_k(m), by rounds of registration and averaging.

F_k(m) are member k's points by its registration to m, aligned with the others' by generalised Procrustes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...balance.balanced_spherical_map import balanced_spherical_map
from ...maps.given_sphere import certified
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.check import check_mesh
from ...sphere.moebius import best_rotation
from ...sphere.rows import row_lengths, weighted_sum
from ...untangle.local_repair import unfolded
from .procrustes import fitted, generalised_procrustes
from .turns import NO_RESTARTS, Restarts, Turns


class Registered(NamedTuple):
    """Members at points that correspond by their registration to a template.

    Attributes
    ----------
    members : list
        The members as given.
    shapes : (k, n, 3) float64 array
        The points, in each member's own position.
    areas : (n,) float64 array
        The members' own area around each point, on average.
    turned : int
        Number of members that a search for other rotations has moved.
    """

    members: list[Any]
    shapes: FloatArray
    areas: FloatArray
    turned: int


#: Registers members to a template, from where they are, and tries the restarts of each.
Register = Callable[[Sequence[Any], SphereMap, Sequence[Restarts]], Registered]


class FixedPoint(NamedTuple):
    """Members registered to their mean.

    Attributes
    ----------
    members : list
        The members as given.
    mean : (n, 3) float64 array
        Their mean.
    changes : tuple of float
        Its movement in each round, as a share of its root mean square radius.
    settled : bool
        Whether the last one is less than the distance of the mesh's faces from the sphere.
    axis : (3,) float64 array or None
        If the mean is round about an axis, its point of the sphere.
    turns : list of (3, 3) float64 arrays
        Turns of the members' spheres about it, to the least distance from the mean; the identity if there is none.
    """

    members: list[Any]
    mean: FloatArray
    changes: tuple[float, ...]
    settled: bool
    axis: FloatArray | None
    turns: list[FloatArray]


def fixed_point(
    register: Register,
    members: Sequence[Any],
    first: FloatArray,
    x: FloatArray,
    f: IntArray,
    *,
    balance: float,
    rigid: bool,
    rounds: int = 10,
    patience: int = 5,
    searches: int = 3,
) -> FixedPoint:
    """Register members to a first template (n, 3), on the mesh x, f of the sphere, and to their mean until it stays.

    The mean keeps the rotation of the first template's sphere. When it has settled, or has not for `patience` rounds,
    members are registered again from rotated and mirrored poses, until none of these fits better. It ends after at most
    `rounds`; three to five are usual, each of which moves it by a quarter of the one before. If the mean is round about
    an axis, each member's best turn about it is found, too.
    """
    # distance of the mesh's faces from the sphere
    finest = 1 - float(row_lengths(x[f].mean(axis=1)).min())
    before, target, turns = first, certified(check_mesh(first, f), x), Turns(x)
    axis: FloatArray | None = None
    restarts = [NO_RESTARTS] * len(members)
    changes, step, began = list[float](), 0, 0
    while True:
        step += 1
        found = register(members, target, restarts)
        members, aligned = found.members, generalised_procrustes(found.shapes, found.areas, rigid)
        changes.append(_change(before, aligned.mean, found.areas))
        settled = changes[-1] < finest
        if found.turned:
            began = step
        elif set(restarts) != {NO_RESTARTS}:
            searches = 0  # none was better
        restarts = [NO_RESTARTS] * len(members)
        if searches and (settled or step - began >= patience):
            searches -= 1
            axis, restarts = turns.restarts(aligned.mean, aligned.shapes)
            if set(restarts) == {NO_RESTARTS}:
                searches = 0
        searching = searches > 0 or set(restarts) != {NO_RESTARTS}
        if not searching and (settled or step - began >= rounds):
            about = [np.eye(3)] * len(members)
            if axis is not None:
                about = turns.about(axis, aligned.mean, aligned.shapes)
            return FixedPoint(members, aligned.mean, tuple(changes), settled, axis, about)
        before = aligned.mean
        target = balanced_spherical_map(before, f, balance=balance)
        as_before = best_rotation(target.sphere, x, found.areas)
        target = certified(target.mesh, unfolded(target.mesh, target.sphere @ as_before))


def _change(before: FloatArray, mean: FloatArray, areas: FloatArray) -> float:
    """Distance of a mean from the one before, over its root mean square radius."""
    moved = fitted(before, mean, areas)[0] - mean
    offset = mean - weighted_sum(areas / areas.sum(), mean)
    return float(np.sqrt((areas @ moved**2).sum() / (areas @ offset**2).sum()))
