"""Distances in space between two shapes after turns of their spheres, by few harmonics of positions.

A turn R of the sphere takes the shape f to f(R^-1 x); then a rotation of space lays it on the other shape.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from ...mesh.arrays import FloatArray
from ...sphere.moebius import best_rotation
from ..harmonics.basis import degree_of, terms
from ..harmonics.rotation import on_grid, padded, rotate

_APART = np.cos(np.radians(25.0))  # between turns that are two: more than a step of the grid
# turns about an axis: harmonics of the last degree repeat after 45 degrees
_ABOUT = np.radians(np.arange(0, 360, 10))


Rows = tuple[tuple[float, ...], ...]


class Restarts(NamedTuple):
    """Further starts of a registration beside the end of the last.

    Attributes
    ----------
    turns : tuple of rows of (3, 3) matrices
        Rotations of the sphere that may lead to a smaller distance.
    mirror : bool
        Whether the mirror image may.
    """

    turns: tuple[Rows, ...] = ()
    mirror: bool = False


#: No start besides the end of the registration before.
NO_RESTARTS = Restarts()


class Turns:
    """Finds the turns that a registration of aligned shapes should try; shapes are given at points x of the sphere."""

    def __init__(self, x: FloatArray, band: int = 9) -> None:
        """Degrees are below `band`: 9 has those of an octopus' eight arms, and larger parts."""
        band = min(band, int(np.sqrt(len(x) / 2)))  # two points for each function
        self._project = np.linalg.pinv(sum(terms(np.eye(band**2), x)))

    def restarts(
        self, mean: FloatArray, shapes: Iterable[FloatArray]
    ) -> tuple[FloatArray | None, list[Restarts]]:
        """The restarts by which each shape may come nearer to a mean.

        Also the axis, if any, about which turns move the mean by less than the median distance of the shapes from it.
        """
        f, *others = map(self._coefficients, (mean, *shapes))
        axis = _free_axis(f, float(np.median([_off(f, g) for g in others])))
        return axis, [_rivals(f, g, axis) for g in others]

    def about(
        self, axis: FloatArray, mean: FloatArray, shapes: Iterable[FloatArray], rounds: int = 5
    ) -> list[FloatArray]:
        """Turns of shapes about an axis to the least distance from their mean, which begins as the given one."""
        f, *others = map(self._coefficients, (mean, *shapes))
        for _ in range(rounds):
            turns = [_nearest_about(axis, f, g) for g in others]
            turned = [rotate(g, R) for g, R in zip(others, turns, strict=True)]
            f = np.mean([g @ best_rotation(g, f, np.ones(len(f))) for g in turned], axis=0)
        return turns

    def _coefficients(self, shape: FloatArray) -> FloatArray:
        """Coefficients ((L + 1)^2, 3) of a shape (n, 3), without its centre, of unit size."""
        c = np.concatenate((np.zeros((1, 3)), (self._project @ shape)[1:]))
        return c / np.linalg.norm(c)


def _rivals(
    f: FloatArray, g: FloatArray, axis: FloatArray | None = None, further: float = 2.5
) -> Restarts:
    """Other turns and the mirror image of g that come as near to f as g; turns up to `further` times as far.

    Turns about an axis count as one: a shape that may turn freely about it is its own mirror image, too.
    """
    parity = np.concatenate(
        [np.full(2 * ell + 1, (-1.0) ** (ell + 1)) for ell in range(degree_of(f) + 1)]
    )
    mirrored = axis is None and len(_near(f, parity[:, None] * g, _off(f, g), axis)) > 0
    near = [R for R in _near(f, g, further * _off(f, g), axis) if _differ(R, np.eye(3), axis)]
    return Restarts(tuple(map(rows, near)), mirrored)


def _near(
    f: FloatArray, g: FloatArray, least: float, axis: FloatArray | None, most: int = 4
) -> list[FloatArray]:
    """Turns of g that leave it nearer to f than `least`: the best ones near turns of a grid within twice that.

    At most `most` besides the best: arms of an octopus are exchanged with the next ones.
    """
    distances, found = _on_grid(f, g), list[FloatArray]()
    nearest = np.argsort(distances)[: np.count_nonzero(distances < 2 * least)]
    for R in _rotations(degree_of(f) + 1)[nearest]:
        if len(found) <= most and all(_differ(R, other, axis) for other in found):
            found.append(R)
    refined = [_refined(f, g, R) for R in found]
    return [
        R
        for k, R in enumerate(refined)
        if _off(f, rotate(g, R)) < least and all(_differ(R, other, axis) for other in refined[:k])
    ]


def _differ(R: FloatArray, other: FloatArray, axis: FloatArray | None) -> bool:
    """Whether two turns, or their images of an axis, are more than a step of the grid from each other."""
    if axis is None:
        likeness = (np.trace(R @ other.T) - 1) / 2
    else:
        likeness = R @ axis @ other @ axis
    return bool(likeness < _APART)


def _refined(f: FloatArray, g: FloatArray, R: FloatArray, steps: int = 3) -> FloatArray:
    """Gauss and Newton's method for the turn near R, and the rotation of space, that leave the least distance."""
    for _ in range(steps):
        turned = rotate(g, R)
        space = best_rotation(turned, f, np.ones(len(f)))
        columns = np.concatenate((_moves(turned) @ space, _spins(turned @ space))).reshape(6, -1).T
        R = _turn(np.linalg.lstsq(columns, (f - turned @ space).ravel())[0][:3]) @ R
    return R


def _moves(f: FloatArray, small: float = 0.01) -> FloatArray:
    """Movement of a shape as its sphere turns about each axis, (3, (L + 1)^2, 3); off by the square of a `small`
    turn."""
    turns = small * np.eye(3)
    return np.stack([rotate(f, _turn(w)) - rotate(f, _turn(-w)) for w in turns]) / (2 * small)


def _spins(f: FloatArray) -> FloatArray:
    """Movement of a shape as space turns about each axis, (3, (L + 1)^2, 3)."""
    return np.cross(np.eye(3)[:, None], f)


def _free_axis(f: FloatArray, least: float) -> FloatArray | None:
    """The axis, if any, about which no turn takes a shape as far from itself as `least`."""
    spun = np.linalg.qr(_spins(f).reshape(3, -1).T)[0]
    moved = _moves(f).reshape(3, -1).T
    axis = np.linalg.svd(moved - spun @ (spun.T @ moved), full_matrices=False)[2][2]
    if _distances_about(axis, f, f).max() < least:
        return axis
    return None


def _nearest_about(axis: FloatArray, f: FloatArray, g: FloatArray) -> FloatArray:
    """The turn about an axis that brings g nearest to f."""
    distances = _distances_about(axis, f, g)
    k = int(np.argmin(distances))
    before, here, after = distances[[k - 1, k, (k + 1) % len(distances)]]
    bend, shift = before - 2 * here + after, 0.0
    if bend > 0:
        shift = (before - after) / (2 * bend)  # of the parabola through the three
    return _turn((_ABOUT[k] + shift * _ABOUT[1]) * axis)


def _distances_about(axis: FloatArray, f: FloatArray, g: FloatArray) -> FloatArray:
    """Distances of f from g after turns about an axis."""
    return np.array([_off(f, rotate(g, _turn(angle * axis))) for angle in _ABOUT])


def rows(R: FloatArray) -> Rows:
    """A matrix as a value, which a job can hold."""
    return tuple(map(tuple, R.tolist()))


def _turn(w: ArrayLike) -> FloatArray:
    return Rotation.from_rotvec(w).as_matrix()


@lru_cache(maxsize=1)
def _rotations(band: int) -> FloatArray:
    """The turns at which `_on_grid` has distances, (k, 3, 3)."""
    steps = np.indices((2 * band, band + 1, 2 * band)).reshape(3, -1).T
    return Rotation.from_euler("ZYZ", np.pi / band * steps).as_matrix()


def _on_grid(f: FloatArray, g: FloatArray) -> FloatArray:
    """Distances (k,) of f from g after turns that lie evenly."""
    band = degree_of(f) + 1
    columns = [[padded(each[:, [k]], band) for k in range(3)] for each in (f, g)]
    products = [[on_grid(a, b)[:, : band + 1].ravel() for b in columns[1]] for a in columns[0]]
    return _distances(f, g, np.moveaxis(np.array(products), 2, 0))


def _off(f: FloatArray, g: FloatArray) -> float:
    """Root mean square distance of two shapes as they lie, after the best rotation of space."""
    return float(_distances(f, g, f.T @ g))


def _distances(f: FloatArray, g: FloatArray, products: FloatArray) -> FloatArray:
    """Root mean square distances after the best rotation of space, by the products (..., 3, 3) of coordinates."""
    fits = np.linalg.svd(products, compute_uv=False)
    fits[..., 2] *= np.sign(np.linalg.det(products))
    return np.sqrt(np.maximum((f**2).sum() + (g**2).sum() - 2 * fits.sum(axis=-1), 0) / (4 * np.pi))
