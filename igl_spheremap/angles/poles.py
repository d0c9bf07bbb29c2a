"""Where limbs too deep for float64 are put: the Moebius map that takes the deepest tips to ends of the coordinate axes.

Two of the three coordinates are about 0 there, and float64 is finer for such numbers: it holds a limb as deep as it
is, where elsewhere on the sphere edges end at exp(-35). Three points determine a Moebius map, so at most three
limbs are held so.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import permutations
from typing import TypeGuard

import numpy as np

from ..mesh.arrays import ComplexArray, FloatArray
from ..sphere.log_plane import exponential, log_sum, logarithm, rows_at
from ..sphere.riemann import projective_frame
from .candidates import Start
from .deep_limbs import floor_of, normal_range, shorten_limbs, tips_beyond
from .layout import Placed, about_images, onto_sphere


def is_too_deep(placed: Placed | None) -> TypeGuard[Placed]:
    """True if a placement has limbs too deep for float64."""
    return placed is not None and bool(placed.depth.max() > floor_of(np.float64))


def map_deep_limbs(placed: Placed, source: FloatArray, centred: bool) -> Start:
    """The map of a body with limbs too deep for float64, in the gauge "poles" unless it is to be centred."""
    floor, gauge = floor_of(np.float64), "centred"
    if not centred:
        placed, gauge = at_poles(placed, floor), "poles"
    points, stretch = shorten_limbs(placed, source, floor)
    return Start("angles", onto_sphere(placed, points), stretch=stretch, gauge=gauge)


def at_poles(placed: Placed, floor: float) -> Placed:
    """The body with the tips of the three deepest limbs beyond a floor at the nearest ends of axes.

    The positions z become (a z + b) / (c z + d). Each is measured from the nearest of those ends.
    """
    roots = [tip.vertex for tip in tips_beyond(placed, floor) if tip.meets < 0]
    tips = sorted(roots, key=lambda tip: -placed.depth[tip])[:3]
    on_sphere = rows_at(placed.log[tips]) @ placed.turn
    ends = _nearest_ends(on_sphere)
    turn = _away_from_infinity(ends)
    source, image = _completed(on_sphere, ends)
    # algorithm (24)
    M = _frame(image @ turn.T) @ np.linalg.inv(_frame(source @ placed.turn.T))
    (a, b), (c, d) = M / np.sqrt(np.linalg.det(M))
    numerator, denominator = (
        log_sum(placed.log + logarithm(p), logarithm(q)) for p, q in ((a, b), (c, d))
    )

    in_plane = ends @ turn.T
    nearest = (rows_at(numerator - denominator) @ in_plane.T).argmax(axis=1)
    anchor = (in_plane[:, 0] + 1j * in_plane[:, 1])[nearest]
    about = about_images(placed.about, denominator)
    log = np.choose(nearest, [about(tip) for tip in tips])

    from_end = log.real - np.log(np.abs(1 + np.abs(anchor) ** 2 + anchor.conj() * exponential(log)))
    finer = np.maximum(-from_end, 0)
    # a tip counts as far from the end as the vertex nearest to it
    from_end[tips] = [np.partition(from_end[nearest == k], 1)[1] for k in range(len(tips))]
    depth = placed.depth - np.logaddexp(0, 2 * placed.log.real)
    depth += np.logaddexp(2 * numerator.real, 2 * denominator.real)
    # Below the smallest normal number coordinates are no finer; edges at the floor must stay above it.
    depth += np.clip(from_end, -normal_range(floor), 0)
    return replace(placed, log=log, anchor=anchor, depth=depth, finer=finer, about=about, turn=turn)


def _nearest_ends(points: FloatArray) -> FloatArray:
    """Ends of axes, one for each of up to three points, that are nearest to them in squares."""
    choices = np.array(list(permutations(np.vstack((np.eye(3), -np.eye(3))), len(points))))
    return np.asarray(choices[np.einsum("pkj,kj->p", choices, points).argmax()])


def _away_from_infinity(ends: FloatArray) -> FloatArray:
    """Rotation of rows that permutes the axes and takes (0, 0, -1), infinity, to an end that is not one of these."""
    axes = np.vstack((np.eye(3), -np.eye(3)))
    free = axes[(axes @ ends.T).max(axis=1).argmin()]
    side = np.roll(free, 1)
    return np.vstack((side, np.cross(side, free), -free))


def _completed(points: FloatArray, ends: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Complete one to three points and their images to three: one by a rotation, two by the least boost."""
    if len(points) == 1:
        points, ends = np.vstack((points, -points)), np.vstack((ends, -ends))
    if len(points) == 2:
        middle, image = points.sum(axis=0), ends.sum(axis=0)
        # opposite tips: the middle would have lost half of its digits
        if np.linalg.norm(middle) < 1e-9:
            middle = np.cross(points[0], ends[0])
            if not middle.any():
                middle = np.roll(ends[0], 1)
        if not image.any():  # opposite ends
            image = middle - (middle @ ends[0]) * ends[0]
        points = np.vstack((points, middle / np.linalg.norm(middle)))
        ends = np.vstack((ends, image / np.linalg.norm(image)))
    return points, ends


def _frame(x: FloatArray) -> ComplexArray:
    """F(x) of algorithm (24), up to a factor, whose Moebius map takes infinity, 0 and 1 of the plane to three points.

    It is made of their spinors p. The plane is that of `to_ball`, whose infinity is the south pole.
    """
    across, north = x[:, 0] + 1j * x[:, 1], x[:, 2] >= 0
    p = np.where(north, [across, 1 + x[:, 2]], [1 - x[:, 2], across.conj()])  # algorithm (23)
    return projective_frame(p)
