"""The mean of surfaces that are registered to it: m = mean of F_k(m), by rounds of registration and averaging.

F_k(m) are member k's points by its registration to m, laid on the others' by generalised Procrustes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import count
from typing import NamedTuple

import numpy as np

from ...balance.balanced_spherical_map import balanced_spherical_map
from ...maps.given_sphere import certified
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.check import check_mesh
from ...sphere.moebius import best_rotation
from ...sphere.rows import row_lengths, weighted_sum
from ...untangle.local_repair import unfolded
from .procrustes import generalised_procrustes, placed
from .turns import NO_RESTARTS, Restarts, Turns

# at most: 3 to 5 are usual, each of which moves the mean by a quarter of what the one before did
_ROUNDS = 10
_PATIENCE = 5  # rounds after which other rotations are tried, also if the mean does not settle
_LOOKS = 3  # at most; after the first one most groups have nobody who lies wrong


class Registered(NamedTuple):
    """Members at points that correspond by their registration to a template.

    Attributes
    ----------
    members : list of int
        Their numbers.
    shapes : (k, n, 3) float64 array
        The points, where each member lies.
    areas : (n,) float64 array
        The members' own area around each point, on average.
    turned : int
        How many lie otherwise than before, after a search for other rotations.
    """

    members: list[int]
    shapes: FloatArray
    areas: FloatArray
    turned: int


#: Registers members to a template, from where they are, and tries the restarts of each.
Register = Callable[[Sequence[int], SphereMap, Sequence[Restarts]], Registered]


class FixedPoint(NamedTuple):
    """Members registered to their mean.

    Attributes
    ----------
    members : list of int
        Their numbers.
    mean : (n, 3) float64 array
        Their mean.
    changes : tuple of float
        How far it moved in each round, as a share of its root mean square radius.
    settled : bool
        Whether that is less, in the last one, than the mesh's faces are from the sphere.
    axis : (3,) float64 array or None
        The point of the sphere about which the mean is round, if there is one.
    turns : list of (3, 3) float64 arrays
        Turns of the members' spheres about it, to the least distance from the mean; the identity if there is none.
    """

    members: list[int]
    mean: FloatArray
    changes: tuple[float, ...]
    settled: bool
    axis: FloatArray | None
    turns: list[FloatArray]


def fixed_point(
    register: Register,
    members: Sequence[int],
    first: FloatArray,
    x: FloatArray,
    f: IntArray,
    *,
    balance: float,
    rigid: bool,
) -> FixedPoint:
    """Register members to a first template (n, 3), on the mesh x, f of the sphere, and to their mean until it stays.

    The mean keeps the rotation of the first template's sphere. Once it stays, or if it will not for some rounds, turns
    and mirror images of members are tried that may fit as well, until none of them fits better. If the mean is round
    about an axis, it says by which turn about that each member comes nearest.
    """
    # how far the mesh's faces are from the sphere
    finest = 1 - float(row_lengths(x[f].mean(axis=1)).min())
    before, target = first, certified(check_mesh(first, f), x)
    turns, axis = Turns(x), None
    restarts = nothing = [NO_RESTARTS] * len(members)
    changes, looks, quiet, began = list[float](), 0, False, 0
    for step in count(1):
        found = register(members, target, restarts)
        members, aligned = found.members, generalised_procrustes(found.shapes, found.areas, rigid)
        changes.append(_change(before, aligned.mean, found.areas))
        settled, began = changes[-1] < finest, step if found.turned else began
        quiet = quiet or looks == _LOOKS or (restarts != nothing and not found.turned)
        restarts = nothing = [NO_RESTARTS] * len(members)
        if not quiet and (settled or step - began >= _PATIENCE):
            looks += 1
            axis, restarts = turns.restarts(aligned.mean, aligned.shapes)
            quiet = restarts == nothing
        if quiet and (settled or step - began >= _ROUNDS):
            about = (
                [np.eye(3)] * len(members)
                if axis is None
                else turns.about(axis, aligned.mean, aligned.shapes)
            )
            return FixedPoint(members, aligned.mean, tuple(changes), settled, axis, about)
        before = aligned.mean
        target = balanced_spherical_map(before, f, balance=balance)
        as_before = best_rotation(target.sphere, x, found.areas)
        target = certified(target.mesh, unfolded(target.mesh, target.sphere @ as_before))
    raise AssertionError  # the rounds are counted without end


def _change(before: FloatArray, mean: FloatArray, areas: FloatArray) -> float:
    """How far a mean lies from the one before, over its root mean square radius."""
    moved = placed(before, mean, areas)[0] - mean
    offset = mean - weighted_sum(areas / areas.sum(), mean)
    return float(np.sqrt((areas @ moved**2).sum() / (areas @ offset**2).sum()))
