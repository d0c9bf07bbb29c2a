"""Descent on the angle differences vertex by vertex, with exact signs as the acceptance test.

Vertices that are no neighbours of each other move together, a colour class at a time. Each takes a Newton step of its
own in its tangent plane, and keeps it if its loss falls and every face around it stays positively oriented. Sweeps move
limbs hardly, but work where edges are too short or angles too bad for steps of the whole map.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..mesh.arrays import BoolArray, FloatArray, IntArray
from ..mesh.measure import corner_angles
from ..sphere.rows import row_crosses, row_dots, sizes, tangent_axes, unit_rows
from .collapse import independent
from .embedding import proper
from .kernel import REACH, Stars, solve_symmetric, stars_of

#: Factors of a step, tried in turn; if none is accepted, the vertex stays until the next sweep. The first is an
#: over-relaxation, as neighbours will move the same way.
_LENGTHS = (1.8, 0.7, 0.2)


@dataclass(frozen=True)
class AngleLoss:
    """Sum of the sizes of the three angle differences of faces (p, a, b), against the corner angles of a source.

    A difference d counts as sqrt(d^2 + smoothing^2): smooth at zero, and nearly its size elsewhere.
    """

    source: FloatArray  # (3, e), radians: at p, a, b
    smoothing: float = np.radians(0.5)

    @classmethod
    def of(cls, v: FloatArray, f: IntArray) -> AngleLoss:
        """Loss against the mesh `v, f`."""
        return cls(corner_angles(v, f).T)

    def at(self, corner: IntArray) -> AngleLoss:
        """The loss of faces turned so that p is the given corner, an index into the flattened faces."""
        return replace(self, source=_turned(self.source, corner))

    def take(self, faces: BoolArray) -> AngleLoss:
        """The loss of some of the faces."""
        return replace(self, source=self.source[:, faces])

    def values(self, u: FloatArray, w: FloatArray) -> FloatArray:
        """Loss of each face, given its sides u = a - p and w = b - p in any unit."""
        d = self._differences(u, w)[0]
        return np.asarray(np.sqrt(d * d + self.smoothing**2).sum(axis=0))

    def model(self, u: FloatArray, w: FloatArray, axes: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Loss of each face, its gradient (e, 2) as p moves along two axes, and a Hessian (e, 3): xx, xy, yy.

        The gradient is sum d (grad d) / size and the Hessian sum (grad d) (grad d)^T / size, that of Gauss and Newton
        for squares with fixed weights 1 / size. As p moves by h, the angle at a corner c grows by h . (n x (p - c)) /
        |p - c|^2 up to its sign, n the unit normal.
        """
        d, normal = self._differences(u, w)
        turn_a = -row_crosses(normal, u) / row_dots(u, u)[:, None]
        turn_b = row_crosses(normal, w) / row_dots(w, w)[:, None]
        at_a, at_b = (np.stack([row_dots(turn, axes[:, k]) for k in range(2)]) for turn in (turn_a, turn_b))
        turns = np.stack((-at_a - at_b, at_a, at_b))  # corner, axis, face
        size = np.sqrt(d * d + self.smoothing**2)
        gradient = (d / size * turns.transpose(1, 0, 2)).sum(axis=1).T
        hessian = np.stack([(turns[:, i] * turns[:, j] / size).sum(axis=0)
                            for i, j in ((0, 0), (0, 1), (1, 1))], axis=1)
        return size.sum(axis=0), gradient, hessian

    def _differences(self, u: FloatArray, w: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Angle differences at p, a, b (3, e), and unit normals of the flat faces."""
        normal = row_crosses(u, w)
        double_area = np.sqrt(row_dots(normal, normal))
        across = w - u
        angles = np.arctan2(double_area, (row_dots(u, w), -row_dots(u, across), row_dots(w, across)))
        return angles - self.source, normal / np.where(double_area > 0, double_area, 1)[:, None]


def _turned(per_corner: FloatArray, corner: IntArray) -> FloatArray:
    """Rows (p, a, b) of a quantity given for the three corners of each face, p being the given corner."""
    face, k = corner // 3, corner % 3
    return np.stack([per_corner[(k + j) % 3, face] for j in range(3)])


def relax_angles(x: FloatArray, f: IntArray, loss: AngleLoss, movable: BoolArray | None = None, *,
                 sweeps: int, tolerance: float = 2e-3) -> FloatArray:
    """Lower the angle differences vertex by vertex, keeping a map that is free of foldings so.

    It ends after so many sweeps, or after one that gains at most the share `tolerance`.

    Examples
    --------
    >>> import igl
    >>> v, f = igl.icosahedron()
    >>> x = unit_rows(v)
    >>> noisy = unit_rows(x + 0.1 * np.cos(np.arange(36.0)).reshape(12, 3))
    >>> y = relax_angles(noisy, f, AngleLoss.of(x, f), sweeps=30)
    >>> bool(np.degrees(np.abs(corner_angles(y, f) - corner_angles(x, f)).mean()) < 0.5)
    True
    """
    x = x.copy()
    classes = _colour_classes(f, np.ones(len(x), dtype=bool) if movable is None else movable, loss)
    for _ in range(sweeps):
        before = after = 0.0
        for part in classes:
            old, new = _step(x, *part)
            before, after = before + old, after + new
        if before - after <= tolerance * before:
            break
    return x


def _colour_classes(f: IntArray, movable: BoolArray, loss: AngleLoss) -> list[tuple[Stars, AngleLoss]]:
    """Stars of the movable vertices, split into classes without neighbours, and the losses of their faces."""
    stars, classes = stars_of(f, movable), []
    while len(stars.vertices):
        chosen = np.zeros(len(stars.vertices), dtype=bool)
        chosen[independent(stars, len(movable))] = True
        part = stars.take(np.flatnonzero(chosen))
        corner = 3 * part.faces + np.argmax(f[part.faces] == part.vertices[part.owner][:, None], axis=1)
        classes.append((part, loss.at(corner)))
        stars = stars.take(np.flatnonzero(~chosen))
    return classes


def _step(x: FloatArray, stars: Stars, loss: AngleLoss) -> tuple[float, float]:
    """Move one class of vertices, in place; the loss before and after."""
    owner = stars.owner
    p, a, b = (x.take(ids, axis=0) for ids in (stars.vertices, stars.a, stars.b))
    at, axes = p.take(owner, axis=0), np.stack(tangent_axes(p), axis=1)
    u, w = a - at, b - at
    size = np.maximum.reduceat(sizes(u), stars.start)[:, None]  # products underflow near ends of axes, in other units
    u, w = u / size[owner], w / size[owner]
    old, gradient, hessian = (np.add.reduceat(part, stars.start, axis=0)
                              for part in loss.model(u, w, axes.take(owner, axis=0)))
    steps = _newton(gradient, hessian, REACH * np.sqrt(np.minimum.reduceat(row_dots(u, u), stars.start)))
    move = size * (steps[:, :1] * axes[:, 0] + steps[:, 1:] * axes[:, 1])
    new, rows, part = old.copy(), np.arange(len(p)), stars
    for length in _LENGTHS:
        trial = unit_rows(p[rows] + length * move[rows])
        x[part.vertices] = trial
        at, unit = trial.take(part.owner, axis=0), size[rows].take(part.owner, axis=0)
        value = np.add.reduceat(loss.values((a - at) / unit, (b - at) / unit), part.start)
        better = (value < old[rows]) & proper(x, part)
        new[rows[better]] = value[better]
        if better.all():
            break
        faces, part, rows = ~better[part.owner], part.take(np.flatnonzero(~better)), rows[~better]
        loss, a, b = loss.take(faces), a[faces], b[faces]
        x[part.vertices] = p[rows]
    return float(old.sum()), float(new.sum())


def _newton(gradient: FloatArray, hessian: FloatArray, longest: FloatArray) -> FloatArray:
    """Minimiser of each quadratic model in the plane, within a radius."""
    xx, xy, yy = hessian.T
    step = solve_symmetric(xx, xy, yy, -gradient, least=1e-12)  # flatter models are rounding
    length = np.sqrt(row_dots(step, step))
    return step * np.minimum(1, longest / np.where(length > 0, length, 1))[:, None]
