"""Limbs, thick curves of varying radius, and their smooth union."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..mesh.arrays import FloatArray

NEGLIGIBLE = 20.0  # limbs so many blend lengths apart are not blended: exp(-20) = 2e-9


@dataclass(frozen=True, eq=False)
class Limb:
    """Union of round balls along a polyline, their radius linear on each segment."""

    centres: FloatArray  # (k, 3)
    radii: FloatArray  # (k,)
    squash: tuple[float, float, float] = (1.0, 1.0, 1.0)  # space is divided by these: below 1, flat along an axis

    def __call__(self, points: FloatArray) -> FloatArray:
        """Lower bound of the distance of (k, 3) points to the limb, negative inside."""
        squash = np.array(self.squash)
        points, start = points / squash, self.centres[:-1] / squash
        along = np.diff(self.centres / squash, axis=0)
        squared = np.einsum("ij,ij->i", along, along)
        dot = points @ along.T - np.einsum("ij,ij->i", start, along)
        t = np.clip(dot / squared, 0.0, 1.0)
        square = (
            np.einsum("ij,ij->i", points, points)[:, None]
            - 2.0 * points @ start.T
            + np.einsum("ij,ij->i", start, start)
            + t * (t * squared - 2.0 * dot)
        )
        radius = self.radii[:-1] + t * np.diff(self.radii)
        return float(squash.min()) * np.min(np.sqrt(np.maximum(square, 0.0)) - radius, axis=1)

    def box(self) -> FloatArray:
        """(2, 3) corners of a box that holds the limb."""
        reach = self.radii[:, None] * np.array(self.squash)
        return np.stack([(self.centres - reach).min(axis=0), (self.centres + reach).max(axis=0)])


def limb(knots: Sequence[Sequence[float]], squash: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> Limb:
    """Limb along a spline through knots ``(x, y, z, radius)``."""
    from scipy.interpolate import CubicSpline, PchipInterpolator  # takes .2 s, which only limbs need

    k = np.array(knots, dtype=np.float64)
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(k[:, :3], axis=0), axis=1))])
    s = np.linspace(0.0, length[-1], 8 * (len(k) - 1) + 1)
    return Limb(CubicSpline(length, k[:, :3])(s), PchipInterpolator(length, k[:, 3])(s), squash)


@dataclass(frozen=True, eq=False)
class SmoothUnion:
    """Union of limbs, blended where they are closer than `NEGLIGIBLE` blend lengths."""

    limbs: tuple[Limb, ...]
    blend: float

    def __call__(self, points: FloatArray) -> FloatArray:
        """``-blend * log(sum(exp(-d / blend)))`` over the limbs' distances d."""
        distance = np.stack([self._distance(each, points) for each in self.limbs])
        nearest = distance.min(axis=0)
        return nearest - self.blend * np.log(np.sum(np.exp((nearest - distance) / self.blend), axis=0))

    def _distance(self, part: Limb, points: FloatArray) -> FloatArray:
        """Distance to the limb where it matters; farther off, that to its box, which is less."""
        lower, upper = part.box()
        distance = np.linalg.norm(points - np.clip(points, lower, upper), axis=1)
        near = distance < NEGLIGIBLE * self.blend
        distance[near] = part(points[near])
        return distance

    def box(self) -> FloatArray:
        """(2, 3) corners of a box that holds the union, the swelling of the blend included."""
        boxes = np.stack([each.box() for each in self.limbs])
        swell = self.blend * (1.0 + np.log(len(self.limbs)))
        return np.stack([boxes[:, 0].min(axis=0) - swell, boxes[:, 1].max(axis=0) + swell])
