"""Descent vertex by vertex on what the stars lose in shape, with exact signs as the acceptance test.

Vertices that are no neighbours of each other move together, a colour class at a time. Each takes a Newton
step of its own in its tangent plane, and keeps it if its loss falls and every face around it stays positively
oriented.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

import igl
import numpy as np
from numpy.typing import NDArray

from ..distortion import corner_angles, face_areas
from ..laplacian import mollified_edge_lengths
from .collapse import independent
from .embedding import proper, unit_rows
from .kernel import Stars, cross, dot, stars_of, tangent_axes

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

Polish = Literal["angles", "mips"]

#: Steps are over-relaxed, shortened while they are not accepted, and given up until the next sweep.
_LENGTHS = (1.8, 0.7, 0.2)
#: Longest step, in units of the distance to the nearest neighbour.
_REACH = 0.7


class Loss(Protocol):
    """What faces (p, a, b) lose in shape, as a function of p."""

    def values(self, p: FloatArray, a: FloatArray, b: FloatArray, corner: IntArray) -> FloatArray:
        """Loss of each face; `corner` is that of p, as an index into the flattened faces."""

    def model(self, p: FloatArray, a: FloatArray, b: FloatArray, corner: IntArray,
              axes: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Gradient (e, 2) along the two axes, and a positive semidefinite Hessian (e, 3): xx, xy, yy."""


@dataclass(frozen=True)
class AngleLoss:
    """Sum of the sizes of the three angle differences, against the corner angles of a source.

    A difference d counts as sqrt(d^2 + smoothing^2): smooth at zero, and nearly its size elsewhere.
    """

    source: FloatArray  # (m, 3), radians
    smoothing: float = np.radians(0.5)

    @classmethod
    def of(cls, v: FloatArray, f: IntArray) -> AngleLoss:
        """Loss against the mesh `v, f`."""
        return cls(corner_angles(v, f))

    def values(self, p: FloatArray, a: FloatArray, b: FloatArray, corner: IntArray) -> FloatArray:
        """Smoothed sum of sizes."""
        d = self._differences(a - p, b - p, corner)[0]
        return np.asarray(np.sqrt(d * d + self.smoothing**2).sum(axis=0))

    def model(self, p: FloatArray, a: FloatArray, b: FloatArray, corner: IntArray,
              axes: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Gauss-Newton with iteratively reweighted squares."""
        d, turns = self.linearised(p, a, b, corner, axes)
        weight = 1 / np.sqrt(d * d + self.smoothing**2)
        gradient = np.einsum("ce,cek->ek", weight * d, turns)
        hessian = np.stack([np.einsum("ce,ce,ce->e", weight, turns[..., i], turns[..., j])
                            for i, j in ((0, 0), (0, 1), (1, 1))], axis=1)
        return gradient, hessian

    def linearised(self, p: FloatArray, a: FloatArray, b: FloatArray, corner: IntArray,
                   axes: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Angle differences at p, a, b (3, e), and their derivatives (3, e, 2) as p moves along the axes."""
        u, w = a - p, b - p
        d, normal = self._differences(u, w, corner)
        turn_a = -cross(normal, u) / dot(u, u)[:, None]
        turn_b = cross(normal, w) / dot(w, w)[:, None]
        return d, np.einsum("cei,eki->cek", (-turn_a - turn_b, turn_a, turn_b), axes)

    def _differences(self, u: FloatArray, w: FloatArray, corner: IntArray) -> tuple[FloatArray, FloatArray]:
        """Angle differences at p, a, b (3, e), and unit normals of the flat faces."""
        normal = cross(u, w)
        double_area = np.sqrt(dot(normal, normal))
        across = w - u
        angles = np.arctan2(double_area, (dot(u, w), -dot(u, across), dot(w, across)))
        face, k = corner // 3, corner % 3
        source = np.stack([self.source[face, (k + j) % 3] for j in range(3)])
        return angles - source, normal / np.where(double_area > 0, double_area, 1)[:, None]


@dataclass(frozen=True)
class MipsLoss:
    """MIPS energy: Dirichlet energy over image area, 1 where a face keeps its angles, weighted by the
    source's area.

    References
    ----------
    Hormann and Greiner 2000, *MIPS: An Efficient Global Parametrization Method*.
    """

    half_cotangents: FloatArray  # (m, 3)
    area: FloatArray  # (m,)

    @classmethod
    def of(cls, v: FloatArray, f: IntArray) -> MipsLoss:
        """Loss against the mesh `v, f`, slivers made harmless."""
        return cls(np.asarray(igl.cotmatrix_entries(mollified_edge_lengths(v, f))), face_areas(v, f))

    def values(self, p: FloatArray, a: FloatArray, b: FloatArray, corner: IntArray) -> FloatArray:
        """Weighted ratio of the face."""
        dirichlet, area, _, _ = self._parts(p, a, b, corner)
        loss = self.area[corner // 3] * dirichlet
        return np.divide(loss, area, out=np.full(len(area), np.inf), where=area > 0)

    def model(self, p: FloatArray, a: FloatArray, b: FloatArray, corner: IntArray,
              axes: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Exact gradient; Hessian of the Dirichlet energy alone, as the area is nearly bilinear."""
        dirichlet, area, normal, (_, at_a, at_b) = self._parts(p, a, b, corner)
        weight = self.area[corner // 3] / area
        slope = at_a[:, None] * (p - b) + at_b[:, None] * (p - a)
        gain = cross(normal, b - a) / 2  # of the area
        gradient = weight[:, None] * (slope - (dirichlet / area)[:, None] * gain)
        stiff = weight * (at_a + at_b)
        return np.einsum("ei,eki->ek", gradient, axes), np.stack((stiff, 0 * stiff, stiff), axis=1)

    def _parts(self, p: FloatArray, a: FloatArray, b: FloatArray, corner: IntArray
               ) -> tuple[FloatArray, FloatArray, FloatArray, tuple[FloatArray, FloatArray, FloatArray]]:
        """Dirichlet energy, flat area, unit normal, and half cotangents at p, a, b."""
        u, w = a - p, b - p
        normal = cross(u, w)
        double_area = np.sqrt(dot(normal, normal))
        face, k = corner // 3, corner % 3
        at_p, at_a, at_b = (self.half_cotangents[face, (k + j) % 3] for j in range(3))
        dirichlet = (at_p * dot(w - u, w - u) + at_a * dot(w, w) + at_b * dot(u, u)) / 2
        return (dirichlet, double_area / 2, normal / np.where(double_area > 0, double_area, 1)[:, None],
                (at_p, at_a, at_b))


LOSSES = {"angles": AngleLoss, "mips": MipsLoss}


def descend(x: FloatArray, f: IntArray, loss: Loss, movable: BoolArray | None = None, *,
            sweeps: int = 10, tolerance: float = 2e-3) -> FloatArray:
    """Lower a loss of shape vertex by vertex, keeping a map that is free of foldings so.

    Parameters
    ----------
    x : (n, 3) float64 array
        Unit rows, without folding around the movable vertices.
    f : (m, 3) int64 array
        Faces.
    loss : Loss
        `AngleLoss` or `MipsLoss` of the source.
    movable : (n,) bool array, optional
        Vertices that may move; all by default.
    sweeps : int
        Sweeps at the most.
    tolerance : float
        Ends when a sweep lowers the loss by less than this share.

    Returns
    -------
    (n, 3) float64 array
        Unit rows, without folding where there was none.

    Examples
    --------
    >>> import igl
    >>> v, f = igl.icosahedron()
    >>> x = unit_rows(v)
    >>> noisy = unit_rows(x + 0.1 * np.cos(np.arange(36.0)).reshape(12, 3))
    >>> y = descend(noisy, f, AngleLoss.of(x, f), sweeps=30)
    >>> bool(np.degrees(np.abs(corner_angles(y, f) - corner_angles(x, f)).mean()) < 0.5)
    True
    """
    x = x.copy()
    everywhere = np.ones(len(x), dtype=bool)
    classes = _colour_classes(f, everywhere if movable is None else movable)
    for _ in range(sweeps):
        before, after = np.sum([(0.0, 0.0), *(_step(x, stars, loss, f) for stars in classes)], axis=0)
        if before - after <= tolerance * before:
            break
    return x


def _colour_classes(f: IntArray, movable: BoolArray) -> list[Stars]:
    """Stars of the movable vertices, split into classes without neighbours."""
    stars, classes = stars_of(f, movable), []
    while len(stars.vertices):
        chosen = independent(stars, len(movable))
        classes.append(stars.take(chosen))
        stars = stars.take(np.setdiff1d(np.arange(len(stars.vertices)), chosen))
    return classes


def _step(x: FloatArray, stars: Stars, loss: Loss, f: IntArray) -> tuple[float, float]:
    """Move one class of vertices, in place; the loss before and after."""
    owner = stars.owner
    corner = 3 * stars.faces + np.argmax(f[stars.faces] == stars.vertices[owner][:, None], axis=1)
    p, a, b = x[stars.vertices], x[stars.a], x[stars.b]
    axes = np.stack(tangent_axes(p), axis=1)
    old = np.add.reduceat(loss.values(p[owner], a, b, corner), stars.start)
    gradient, hessian = (np.add.reduceat(part, stars.start, axis=0)
                         for part in loss.model(p[owner], a, b, corner, axes[owner]))
    nearest = np.minimum.reduceat(dot(a - p[owner], a - p[owner]), stars.start)
    move = np.einsum("ki,kij->kj", _newton(gradient, hessian, _REACH * np.sqrt(nearest)), axes)
    new, rows = old.copy(), np.arange(len(p))
    for factor in _LENGTHS:
        part = stars.take(rows)
        edges = np.isin(owner, rows)
        trial = unit_rows(p[rows] + factor * move[rows])
        x[part.vertices] = trial
        value = np.add.reduceat(loss.values(trial[part.owner], a[edges], b[edges], corner[edges]), part.start)
        better = (value < old[rows]) & proper(x, part)
        new[rows[better]] = value[better]
        x[part.vertices[~better]] = p[rows[~better]]
        rows = rows[~better]
        if not len(rows):
            break
    return float(old.sum()), float(new.sum())


def _newton(gradient: FloatArray, hessian: FloatArray, longest: FloatArray) -> FloatArray:
    """Minimiser of each quadratic model in the plane, within a radius."""
    xx, xy, yy = hessian.T
    det = xx * yy - xy * xy
    scale = np.where(det > 1e-12 * (xx + yy) ** 2, det, np.inf)
    step = -np.stack((yy * gradient[:, 0] - xy * gradient[:, 1], xx * gradient[:, 1] - xy * gradient[:, 0]),
                     axis=1) / scale[:, None]
    length = np.sqrt(dot(step, step))
    return step * np.minimum(1, longest / np.where(length > 0, length, 1))[:, None]
