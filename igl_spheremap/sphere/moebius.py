"""Moebius maps of the sphere, the balance of given weights by one, and the gauge of every result.

The gauge picks one of all maps that differ by a Moebius map: the centred one, turned to agree best with the Gauss map.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..errors import MeshError
from ..mesh.arrays import EPS, ROUNDING, FloatArray
from ..mesh.check import Mesh
from ..timings import phase
from .rows import row_dots, weighted_moment, weighted_sum


def moebius(x: FloatArray, c: ArrayLike) -> FloatArray:
    """Apply to unit rows the Moebius map of the ball that takes `c`, a point inside it, to the centre.

    The points near c / |c| are spread out. Raises MeshError for a `c` that is not inside the unit ball.

    >>> moebius(np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]), [0.0, 0.0, 0.5]).round(12)
    array([[ 0. ,  0. ,  1. ],
           [ 0.6,  0. , -0.8]])
    """
    c = np.asarray(c, dtype=np.float64)
    cc = float(c @ c)
    if not cc < 1:
        raise MeshError(
            f"the Moebius centre has length {np.sqrt(cc):g}; give a point inside the unit ball"
        )
    y = x - c
    y *= ((1 - cc) / row_dots(y, y))[:, None]  # algorithm (18)
    y -= c
    # If c is near the boundary, rounding leaves the sphere by some units in the last place: normalise.
    y /= np.sqrt(row_dots(y, y))[:, None]
    return y


def conformal_barycentre(x: FloatArray, weights: FloatArray) -> FloatArray:
    """Point of the ball whose Moebius map to the centre balances non-negative weights at unit rows.

    It is unique (Douady and Earle 1986; Baden, Crane, Kazhdan 2018, *Moebius Registration*) unless half of the weight
    or more is at one point: then there is none, and the search ends near the boundary.

    >>> x = np.vstack((np.eye(3), -np.eye(3)))
    >>> moved = moebius(x, [0.1, 0.2, 0.3])
    >>> c = conformal_barycentre(moved, np.ones(6))
    >>> bool(np.abs(moebius(moved, c).mean(axis=0)).max() < 1e-9)
    True
    """
    return _balance(x, weights)[0]


def _balance(
    x: FloatArray,
    weights: FloatArray,
    within: float = ROUNDING,
    steps: int = 50,
    rounding: float = 1e-14,
) -> tuple[FloatArray, FloatArray]:
    """The conformal barycentre, and the rows moved by the Moebius map that takes it to the origin.

    Newton's steps end when the weighted mean is at most `within`, or a step is `rounding`: 45 ulps of the unit ball. No
    map took more than 12.
    """
    w = weights / weights.sum()
    centre, y, mean = np.zeros(3), x, weighted_sum(w, x)
    for _ in range(steps):
        size = float(np.linalg.norm(mean))
        if size <= within:
            break
        # Newton on the convex energy of the hyperbolic ball, whose gradient is the mean of the moved points. Without
        # the rounding on its diagonal it is singular if all weight is at one point.
        hessian = 2 * (np.eye(3) - weighted_moment(w, y, y)) + rounding * np.eye(
            3
        )  # algorithm (19)
        step: FloatArray = np.asarray(np.linalg.solve(hessian, mean), dtype=np.float64)
        length = float(np.linalg.norm(step))
        if length > 0.5:  # tanh keeps long steps inside the unit ball, up to .96 of its radius
            step = step * (np.tanh(min(length, 2.0)) / length)
        while True:
            trial = _compose(centre, step)
            # On the boundary 1 - |c|^2, by which the map of c scales, has less than three digits left.
            if trial @ trial > 1 - 512 * EPS:
                return centre, y
            moved = moebius(x, trial)
            moved_mean = weighted_sum(w, moved)
            if float(np.linalg.norm(moved_mean)) < size or length < rounding:
                break
            step, length = step / 2, length / 2
        centre, y, mean = trial, moved, moved_mean
        if length < rounding:
            break
    return centre, y


def _compose(first: FloatArray, then: FloatArray) -> FloatArray:
    """Point that goes to the centre under ``moebius(moebius(., first), then)``."""
    # The inverse of the first map, taken at `then`: hyperbolic translation of `then` by `first`.
    dot, ff, tt = float(first @ then), float(first @ first), float(then @ then)
    # algorithm (20)
    return ((1 + 2 * dot + tt) * first + (1 - ff) * then) / (1 + 2 * dot + ff * tt)


def center(x: FloatArray, weights: FloatArray, within: float = ROUNDING) -> FloatArray:
    """Moebius map of `x` for which the barycentre of `weights` is at most `within` from the origin.

    It is computed in one step from `x`, so that rounding does not add up; a centred `x` is returned itself.

    >>> x = moebius(np.vstack((np.eye(3), -np.eye(3))), [0.5, 0, 0])
    >>> bool(np.abs(center(x, np.ones(6)).sum(axis=0)).max() < 1e-9)
    True
    """
    return _balance(x, weights, within)[1]


@phase("gauge")
def fix_gauge(mesh: Mesh, x: FloatArray) -> FloatArray:
    """Moebius map of `x` in the package's gauge.

    The source's area has its barycentre at the origin, and the rotation agrees best with the Gauss map, in the source's
    area.
    """
    return turn_to_gauss_map(mesh, center(x, mesh.A))


def turn_to_gauss_map(mesh: Mesh, x: FloatArray) -> FloatArray:
    """`x` rotated to agree best with the Gauss map, weighted by the source's area."""
    turned = np.einsum(
        "jk,ji->ki", best_rotation(x, orientation_target(mesh), mesh.A), np.ascontiguousarray(x.T)
    )
    # rounding in the lengths adds up over a run's steps
    turned /= np.sqrt(row_dots(turned.T, turned.T))
    return np.ascontiguousarray(turned.T)


def orientation_target(mesh: Mesh) -> FloatArray:
    """The vectors that a map in the gauge is turned to: normals plus 1/1000 of the position from the barycentre.

    If normals leave the rotation open (a flat body has only two), positions decide it; elsewhere they can't be seen.
    """
    outward = mesh.unit - weighted_sum(mesh.A, mesh.unit)
    inside_out = np.vdot(mesh.A, row_dots(mesh.normals, outward)) < 0
    outward *= 1e-3
    if inside_out:
        outward *= -1
    outward += mesh.normals  # algorithm (21)
    return outward


def best_rotation(x: FloatArray, target: FloatArray, weights: FloatArray) -> FloatArray:
    """Rotation R, never a reflection, that brings ``x @ R`` closest to `target` in weighted squares (Kabsch).

    >>> quarter = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    >>> bool(np.allclose(best_rotation(np.eye(3), quarter, np.ones(3)), quarter))
    True
    """
    u, _, vt = np.linalg.svd(weighted_moment(weights, x, target))
    if np.linalg.det(u) * np.linalg.det(vt) < 0:
        u[:, -1] *= -1
    return np.asarray(u @ vt)  # algorithm (22)
