"""Descent on the angle differences vertex by vertex, with exact signs as the acceptance test.

Vertices that are not neighbours of each other move together, a colour class at a time. Each takes a Newton step of its
own in its tangent plane, and keeps it if its loss falls and every face around it stays positively oriented. Sweeps
hardly move limbs, but work with edges too short or angles too bad for steps of the whole map.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..mesh.arrays import TINY, BoolArray, FloatArray, IntArray
from ..mesh.edges import next_corners
from ..sphere.rows import binary_sizes, column_axes, column_crosses, column_dots, unit_rows
from ..verify.signs import column_signs
from .collapse import colour_classes
from .kernel import Stars, solve_symmetric, stars_of


@dataclass(frozen=True)
class AngleLoss:
    """Sum of the sizes of the three angle differences of faces (p, a, b), against the corner angles of a source.

    A difference d counts as sqrt(d^2 + smoothing^2): smooth at zero, and nearly its size elsewhere.
    """

    source: FloatArray  # (3, e), radians: at p, a, b
    smoothing: float = np.radians(0.5)

    def at(self, corner: IntArray) -> AngleLoss:
        """The loss of faces turned so that p is the given corner, an index into the flattened faces."""
        flat = np.ascontiguousarray(self.source.T).ravel()
        return AngleLoss(
            np.stack([flat.take(each) for each in (corner, *next_corners(corner))]), self.smoothing
        )

    def take(self, faces: IntArray) -> AngleLoss:
        """The loss of some of the faces."""
        return AngleLoss(self.source.take(faces, axis=1), self.smoothing)

    def values(self, u: FloatArray, w: FloatArray) -> FloatArray:
        """Loss of each face, given the columns of its sides u = a - p and w = b - p, (3, e), in any unit."""
        d = self._differences(u, w)[0]
        return np.asarray(np.sqrt(d * d + self.smoothing**2).sum(axis=0))

    def model(
        self, u: FloatArray, w: FloatArray, axes: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Loss of each face, its gradient (2, e) as p moves along two axes (2, 3, e), and a Hessian (3, e): xx, xy, yy.

        The gradient is sum d (grad d) / size and the Hessian sum (grad d) (grad d)^T / size, that of Gauss and Newton
        for squares with fixed weights 1 / size. As p moves by h, the angle at a corner c grows by h . (n x (p - c)) /
        |p - c|^2 up to its sign, n the unit normal.
        """
        d, normal, double_area = self._differences(u, w)
        normal /= np.where(double_area > 0, double_area, 1)
        # a side without length does not turn
        turn_a = -column_crosses(normal, u) / np.maximum(column_dots(u, u), TINY)
        turn_b = column_crosses(normal, w) / np.maximum(column_dots(w, w), TINY)
        turns = np.empty((2, *d.shape))  # axis, corner, face
        for turn, axis in zip(turns, axes, strict=True):
            turn[1], turn[2] = column_dots(turn_a, axis), column_dots(turn_b, axis)
            turn[0] = -turn[1] - turn[2]
        size = np.sqrt(d * d + self.smoothing**2)
        gradient = (d / size * turns).sum(axis=1)
        hessian = np.stack(
            [(turns[i] * turns[j] / size).sum(axis=0) for i, j in ((0, 0), (0, 1), (1, 1))]
        )
        return size.sum(axis=0), gradient, hessian

    def _differences(
        self, u: FloatArray, w: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Angle differences at p, a, b (3, e), and normals of the flat faces with their lengths."""
        normal = column_crosses(u, w)
        double_area = np.sqrt(column_dots(normal, normal))
        across = w - u
        angles = np.arctan2(
            double_area, (column_dots(u, w), -column_dots(u, across), column_dots(w, across))
        )
        return angles - self.source, normal, double_area


def relax_angles(
    x: FloatArray,
    f: IntArray,
    loss: AngleLoss,
    movable: BoolArray | None = None,
    *,
    sweeps: int,
    tolerance: float = 2e-3,
) -> FloatArray:
    """Lower the angle differences vertex by vertex, keeping a map that is free of foldings so.

    It ends after this many sweeps, or after one that gains at most the share `tolerance`.

    Examples
    --------
    >>> import igl
    >>> from igl_spheremap.mesh.measure import corner_angles
    >>> v, f = igl.icosahedron()
    >>> x = unit_rows(v)
    >>> noisy = unit_rows(x + 0.1 * np.cos(np.arange(36.0)).reshape(12, 3))
    >>> y = relax_angles(noisy, f, AngleLoss(corner_angles(x, f).T), sweeps=30)
    >>> bool(np.degrees(np.abs(corner_angles(y, f) - corner_angles(x, f)).mean()) < 0.5)
    True
    """
    columns = x.T.copy()  # so that loops run over faces, not over three coordinates
    if movable is None:
        movable = np.ones(len(x), dtype=bool)
    stars = stars_of(f, movable)
    parts = map(stars.take, colour_classes(stars, len(x)))
    classes = [(part, _around(part, f, loss)) for part in parts]
    for _ in range(sweeps):
        before = after = 0.0
        for each in classes:
            old, new = _step(columns, *each)
            before, after = before + old, after + new
        if before - after <= tolerance * before:
            break
    return columns.T


def gain_of_single_moves(x: FloatArray, f: IntArray, loss: AngleLoss, movable: BoolArray) -> float:
    """The sum of what each movable vertex lowers the loss by if it moves and all others stay."""
    stars = stars_of(f, movable)
    old, new = _step(x.T.copy(), stars, _around(stars, f, loss))
    return old - new


def _around(stars: Stars, f: IntArray, loss: AngleLoss) -> AngleLoss:
    """The loss of the faces of stars, turned so that p is the centre."""
    centre = stars.vertices[stars.owner]
    return loss.at(3 * stars.faces + (f[stars.faces] == centre[:, None]).argmax(axis=1))


def _step(
    x: FloatArray,
    stars: Stars,
    loss: AngleLoss,
    lengths: tuple[float, ...] = (1.8, 0.7, 0.2),
    reach: float = 0.7,
) -> tuple[float, float]:
    """Move one class of vertices of a map (3, n), in place, by the first of `lengths` that succeeds; both losses."""
    owner = stars.owner
    p, a, b = (x.take(ids, axis=1) for ids in (stars.vertices, stars.a, stars.b))
    at, axes = p.take(owner, axis=1), column_axes(p)
    u, w = a - at, b - at
    # products underflow near ends of axes, in other units
    size = np.maximum.reduceat(binary_sizes(u.T), stars.start)
    unit = size.take(owner)
    u, w = u / unit, w / unit
    old, gradient, hessian = (
        np.add.reduceat(part, stars.start, axis=-1)
        for part in loss.model(u, w, axes.take(owner, axis=2))
    )
    # Flatter models are rounding.
    steps = solve_symmetric(hessian[0], hessian[1], hessian[2], -gradient.T, least=1e-12).T
    nearest, squared = (
        np.minimum.reduceat(column_dots(u, u), stars.start),
        (steps * steps).sum(axis=0),
    )
    share = np.minimum(1, reach * np.sqrt(nearest / np.maximum(squared, TINY)))
    move = size * share * (steps[0] * axes[0] + steps[1] * axes[1])
    # all lengths at once: calls cost more than the work on few faces
    trials = (p[:, None] + np.array(lengths)[:, None] * move[:, None]).reshape(3, -1)
    y = unit_rows(trials.T.copy()).T.reshape(3, len(lengths), -1)  # coordinate, length, vertex
    at, every = y.take(owner, axis=2).reshape(3, -1), np.tile(np.arange(len(owner)), len(lengths))
    a, b, unit = a.take(every, axis=1), b.take(every, axis=1), unit.take(every)
    values = loss.take(every).values((a - at) / unit, (b - at) / unit)
    signs = column_signs(np.stack((at, a, b), axis=1))
    values, signs = values.reshape(len(lengths), -1), signs.reshape(len(lengths), -1)
    values = np.add.reduceat(values, stars.start, axis=1)
    better = (values < old) & (np.minimum.reduceat(signs, stars.start, axis=1) > 0)
    moved = np.flatnonzero(better.any(axis=0))
    first = better.argmax(axis=0)[moved]
    x[:, stars.vertices[moved]] = y[:, first, moved]
    new = old.copy()
    new[moved] = values[first, moved]
    return float(old.sum()), float(new.sum())
