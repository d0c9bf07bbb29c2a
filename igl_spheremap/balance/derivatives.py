"""Gradient of a balanced energy, and a positive definite Hessian, in two tangent directions a vertex."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .energy import Energy, cross

FloatArray = NDArray[np.float64]

#: Faces at a time: what they need stays in the processor's cache, which halves the time of a large mesh.
_CHUNK = 8192
#: Eigenvalues of a face's Hessian, in logarithms of stretches, are raised to this share of phi''.
_FLOOR = 1e-3
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
        gradient[:, :, chunk], blocks[..., chunk] = _of_faces(energy, chunk, columns[:, corners],
                                                              axes[:, :, corners], convex)
    corners = f.T.ravel()
    return Derivatives(np.stack([np.bincount(corners, part.ravel(), energy.source.n) for part in gradient]), blocks)


def _of_faces(energy: Energy, chunk: slice, p: FloatArray, axes: FloatArray,
              convex: bool) -> tuple[FloatArray, FloatArray]:
    """Gradients (axis, corner, face) and blocks of some faces with corners `p` (coordinate, corner, face)."""
    area = energy.source.area[chunk]
    s1, s2, modes = _stretches(energy.source.gradients[:, :, chunk], area, p, axes)
    w = energy.weight
    q1, q2 = ((1 - w) * slope for slope in energy.slopes(np.log(s1 / s2)))
    p1, p2 = (w * slope for slope in energy.slopes(np.log(s1) + np.log(s2) - energy.target[chunk]))
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
        least = _FLOOR * (p2 + q2)
        h11, h22, h12 = _raised(h11, h22, h12, least)
        twist, shear = np.maximum(twist, least), np.maximum(shear, least)
    weighted = area * np.stack((h11 * modes[0] + h12 * modes[1], h12 * modes[0] + h22 * modes[1],
                                twist * modes[2], shear * modes[3]))
    blocks = np.empty((6, 2, 2, len(area)))
    for k, (i, j) in enumerate(PAIRS):
        for a in range(2):
            for b in range(2):
                blocks[k, a, b] = (weighted[:, a, i] * modes[:, b, j]).sum(axis=0)
    return gradient, blocks


def _stretches(hats: FloatArray, area: FloatArray, p: FloatArray,
               axes: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Singular values of each face's map, and its modes (stretch 1, stretch 2, twist, shear) by axis and corner.

    A mode is the relative change of the map in the frame of its singular vectors.
    """
    side = p[:, [2, 0, 1]] - p[:, [1, 2, 0]]
    outward = p.sum(axis=1)
    length = np.sqrt((outward * outward).sum(axis=0))
    outward /= length
    u = side[:, 2] - (side[:, 2] * outward).sum(axis=0) * outward
    u /= np.sqrt((u * u).sum(axis=0))
    frame = np.stack((u, cross(outward, u)))
    first = (frame * side[:, 2]).sum(axis=1)  # corner 1 as seen from corner 0
    second = -(frame * side[:, 1]).sum(axis=1)  # corner 2
    J = first[:, None] * hats[1] + second[:, None] * hats[2]
    # The plane of projection turns with the corners, by their sum's share across it.
    hats = hats - ((side[:, 2] * outward).sum(axis=0) * hats[1] - (side[:, 1] * outward).sum(axis=0) * hats[2]) / length
    # Rotations U and V with U^T J V = diag(s1, s2), as of a complex linear map z -> alpha z + beta conj(z).
    alpha = J[0, 0] + J[1, 1], J[1, 0] - J[0, 1]
    beta = J[0, 0] - J[1, 1], J[1, 0] + J[0, 1]
    s1 = (np.hypot(*alpha) + np.hypot(*beta)) / 2
    s2 = (first[0] * second[1] - first[1] * second[0]) / (2 * area * s1)
    turn_alpha, turn_beta = np.arctan2(alpha[1], alpha[0]), np.arctan2(beta[1], beta[0])
    left, right = (turn_alpha + turn_beta) / 2, (turn_alpha - turn_beta) / 2
    cos_l, sin_l, cos_r, sin_r = np.cos(left), np.sin(left), np.cos(right), np.sin(right)
    moved = np.stack([(axes * direction[None, :, None]).sum(axis=1) for direction in frame])  # axis, corner, face
    moved = np.stack((cos_l * moved[0] + sin_l * moved[1], cos_l * moved[1] - sin_l * moved[0]))
    hats = np.stack((cos_r * hats[:, 0] - sin_r * hats[:, 1], sin_r * hats[:, 0] + cos_r * hats[:, 1]))
    mean = np.sqrt(s1 * s2)
    across, back = moved[0] * hats[1] / mean, moved[1] * hats[0] / mean
    modes = np.stack((moved[0] * hats[0] / s1, moved[1] * hats[1] / s2,
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
