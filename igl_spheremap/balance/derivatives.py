"""Gradient of a balanced energy, and a positive definite Hessian, in two tangent directions a vertex."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..mesh.arrays import ComplexArray, FloatArray
from ..sphere.rows import column_crosses
from .energy import Energy

#: Faces at a time: what they need stays in the processor's cache, which halves the time of a large mesh.
_CHUNK = 16384
#: Eigenvalues of a face's Hessian, in logarithms of stretches, are raised to this share of phi''.
_FLOOR = 1e-3
#: And those of a twist to this one: turning costs next to nothing, but along straight lines it strains by its square.
_TWIST_FLOOR = 0.05
#: Corner pairs of a face whose blocks are kept; the others are their transposes.
PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))


@dataclass(frozen=True, eq=False)
class Derivatives:
    """How an energy changes as vertices move along their tangent axes.

    Attributes
    ----------
    gradient : (2, n) float64 array
        First derivatives.
    blocks : (6, 2, 2, m) float64 array
        Blocks of each face's Hessian for the corner pairs `PAIRS`.
    """

    gradient: FloatArray
    blocks: FloatArray


def derivatives(energy: Energy, x: FloatArray, axes: FloatArray, convex: bool = True) -> Derivatives:
    """Differentiate at a map free of foldings; `convex` projects the Hessian of each face.

    `axes` are (2, 3, n): unit tangent vectors at the vertices. The Hessian is that of the flat triangles: it leaves out
    how axes turn on the sphere.
    """
    f, m = energy.source.f, len(energy.source.f)
    columns = np.ascontiguousarray(x.T)
    gradient, blocks = np.empty((2, 3, m)), np.empty((6, 2, 2, m))
    for first in range(0, m, _CHUNK):
        chunk = slice(first, first + _CHUNK)
        corners = f[chunk].T
        gradient[:, :, chunk], blocks[..., chunk] = _of_faces(energy, chunk, columns.take(corners, axis=1),
                                                              axes.take(corners, axis=2), convex)
    corners = f.T.ravel()
    return Derivatives(np.stack([np.bincount(corners, part.ravel(), energy.source.n) for part in gradient]), blocks)


def _of_faces(energy: Energy, chunk: slice, p: FloatArray, axes: FloatArray,
              convex: bool) -> tuple[FloatArray, FloatArray]:
    """Gradients (axis, corner, face) and blocks of some faces with corners `p` (coordinate, corner, face)."""
    area = energy.source.area[chunk]
    s1, s2, modes = _stretches(energy.source.hats[:, chunk], area, p, axes)
    w = energy.weight
    q1, q2 = ((1 - w) * slope for slope in energy.slopes(s1 / s2))
    p1, p2 = (w * slope for slope in energy.slopes(s1 * s2 * area / energy.aim[chunk]))
    r1, r2 = p1 + q1, p1 - q1  # balance (5)
    gradient = area * (r1 * modes[0] + r2 * modes[1])
    # Second derivatives along the moves that stretch, twist and shear a face.
    h11, h22, h12 = p2 + q2, p2 + q2, p2 - q2  # balance (6)
    if energy.power or not convex:
        h11, h22 = h11 - r1, h22 - r2
    half = (s1 - s2) / (s1 + s2)  # tanh(q / 2)
    round_face = half < 1e-6
    twist = p1 - q1 * half  # balance (7)
    shear = np.where(round_face, 2 * q2, q1 / np.where(round_face, 1.0, half)) - p1  # balance (8)
    if convex:
        h11, h22, h12 = _raised(h11, h22, h12, _FLOOR * (p2 + q2))
        twist = np.maximum(twist, _TWIST_FLOOR * (p2 + q2))
        shear = np.maximum(shear, _FLOOR * (p2 + q2))
    weighted = area * np.stack((h11, h22, twist, shear))[:, None, None] * modes
    weighted[:2] += area * h12 * modes[1::-1]
    blocks = np.empty((6, 2, 2, len(area)))
    for k, (i, j) in enumerate(PAIRS):
        np.einsum("kam,kbm->abm", weighted[:, :, i], modes[:, :, j], out=blocks[k])
    return gradient, blocks


def _stretches(hats: ComplexArray, area: FloatArray, p: FloatArray,
               axes: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Singular values of each face's map, and its modes (stretch 1, stretch 2, twist, shear) by axis and corner.

    A mode is the relative change of the map in the frame of its singular vectors.
    """
    side = p[:, [2, 0, 1]] - p[:, [1, 2, 0]]
    outward = p.sum(axis=1)
    length = np.sqrt(np.einsum("cm,cm->m", outward, outward))
    outward /= length
    height = np.einsum("cim,cm->im", side, outward)
    u = side[:, 2] - height[2] * outward
    u /= np.sqrt(np.einsum("cm,cm->m", u, u))
    w = column_crosses(outward, u)

    def seen(vectors: FloatArray) -> ComplexArray:
        """Coordinates in the plane of projection."""
        return np.asarray(np.einsum("...cim,cm->...im", vectors, u) + 1j * np.einsum("...cim,cm->...im", vectors, w))

    _, second, first = seen(side) * np.array([[1], [-1], [1]])  # corners 2 and 1 from corner 0
    # The map of the face is z -> (alpha z + beta conj(z)) / 2.
    alpha = first * hats[1].conj() + second * hats[2].conj()
    beta = first * hats[1] + second * hats[2]
    sizes = np.abs(alpha), np.abs(beta)
    s1 = (sizes[0] + sizes[1]) / 2
    s2 = (first.conj() * second).imag / (2 * area * s1)
    # It is left diag(s1, s2) right, with the squares of the two rotations known: one of the two roots will do.
    alpha /= sizes[0]
    beta = np.where(sizes[1] > 0, beta / np.where(sizes[1] > 0, sizes[1], 1.0), 1.0)
    square = alpha * beta.conj()
    right = np.where(square.real >= 0, 1 + square, 1j * (1 - square))
    right /= np.abs(right)
    # The plane of projection turns with the corners, by their sum's share across it.
    hats = right * (hats - (height[2] * hats[1] - height[1] * hats[2]) / length)
    moved = right * alpha.conj() * seen(axes)  # axis, corner, face
    mean = np.sqrt(s1 * s2)
    across, back = moved.real * (hats.imag / mean), moved.imag * (hats.real / mean)
    modes = np.stack((moved.real * (hats.real / s1), moved.imag * (hats.imag / s2),
                      (across - back) * np.sqrt(0.5), (across + back) * np.sqrt(0.5)))
    return s1, s2, modes


def _raised(h11: FloatArray, h22: FloatArray, h12: FloatArray,
            least: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Symmetric 2 by 2 matrices, their eigenvalues raised to `least`."""
    mean, half = (h11 + h22) / 2, (h11 - h22) / 2
    radius = np.hypot(half, h12)
    low, high = np.maximum(mean - radius, least), np.maximum(mean + radius, least)
    ratio = (high - low) / np.where(radius > 0, 2 * radius, 1.0)
    centre = (high + low) / 2
    return centre + ratio * half, centre - ratio * half, ratio * h12
