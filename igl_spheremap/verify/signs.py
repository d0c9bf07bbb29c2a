"""Exact signs of 3 x 3 determinants of finite floats: the orientation of a face as seen from the origin."""

from __future__ import annotations

from typing import Any

import igl.predicates
import numpy as np
from numpy.typing import NDArray

from ..mesh.arrays import EPS, TINY, BoolArray, FloatArray, IntArray
from ..mesh.measure import by_blocks

#: A determinant of numbers up to s in size, computed in floating point, is off by less than this times s^3. The
#: determinant of a corner and the two sides from there is off by less than this times the summed sizes of its six
#: products. Both bounds grow by the smallest normal number, the second by s times it if s > 1 (docs/guarantee.md).
_ERROR = 64 * EPS


def orientation_signs(x: FloatArray, f: IntArray) -> IntArray:
    """Orientation of each face: +1 outward, -1 inward (a folding), 0 if its plane holds the origin or a corner is NaN.

    >>> orientation_signs(np.eye(3), np.array([[0, 1, 2], [0, 2, 1]]))
    array([ 1, -1])
    """
    with np.errstate(over="ignore", invalid="ignore"):
        det, largest = by_blocks(signed_volumes, x, f), np.abs(x).max(initial=0.0)
        signs = _signs(det)
        unsure = np.flatnonzero(~(np.abs(det) > _ERROR * largest**3 + TINY))  # NaN included
        if len(unsure):
            signs[unsure] = column_signs(x[f[unsure]].T)
    return signs


def column_signs(corners: FloatArray) -> IntArray:
    """Orientation of faces by their corners (coordinate, corner, face), numbers whose cubes do not overflow."""
    sides = corners.copy()
    sides[:, 1:] -= corners[:, :1]
    det, largest = signed_volumes(sides), np.abs(corners).max(initial=1.0)
    (a0, b0, c0), (a1, b1, c1), (a2, b2, c2) = np.abs(sides)
    size = a0 * (b1 * c2 + b2 * c1) + a1 * (b2 * c0 + b0 * c2) + a2 * (b0 * c1 + b1 * c0)
    signs, unsure = _signs(det), ~(np.abs(det) > _ERROR * size + TINY * largest)
    if unsure.any():
        signs[unsure] = _exact_signs(corners[:, :, unsure].T.reshape(-1, 3))
    return signs


def _signs(det: NDArray[Any]) -> IntArray:
    """1, -1, or 0, as for NaN."""
    return (det > 0).astype(np.int64) - (det < 0)


def folded_faces(x: FloatArray, f: IntArray) -> BoolArray:
    """Whether the image of each face is flipped or degenerate."""
    return orientation_signs(x, f) <= 0


def signed_volumes(corners: NDArray[Any]) -> NDArray[Any]:
    """Determinants of the corners (coordinate, corner, face) of faces, in floating point, or of Python's integers."""
    (a0, b0, c0), (a1, b1, c1), (a2, b2, c2) = corners
    return np.asarray(
        a0 * (b1 * c2 - b2 * c1) + a1 * (b2 * c0 - b0 * c2) + a2 * (b0 * c1 - b1 * c0)
    )


def _exact_signs(x: FloatArray, block: int = 1 << 12) -> IntArray:
    """Signs of each three rows: if Shewchuk's predicates are exact, by these, else by integers.

    Coordinates and rows are multiplied by powers of two first: close to an end of an axis two coordinates are tiny.
    Integers, of up to 300 bytes each, are in memory for a `block` of faces at once.
    """
    # face, corner, coordinate; that of 0 is below all others
    exponent = np.where(x == 0, -(1 << 14), np.frexp(x)[1]).reshape(-1, 3, 3)
    column = exponent.max(axis=1, keepdims=True)
    row = (exponent - column).max(axis=2, keepdims=True)
    y = np.ldexp(x, -(column + row).reshape(-1, 3))
    plain = _in_range(y) & ((y == 0) == (x == 0))
    signs = np.asarray(
        igl.predicates.orient3d(*(y[k::3] for k in range(3)), np.zeros((1, 3))), dtype=np.int64
    )
    rest = np.flatnonzero(~plain.reshape(-1, 9).all(axis=1))
    for first in range(0, len(rest), block):
        faces = rest[first : first + block]
        signs[faces] = _integer_signs(x.reshape(-1, 3, 3)[faces])
    return signs


def determinant_signs(a: FloatArray, b: FloatArray, c: FloatArray) -> IntArray:
    """Sign of the determinant of each three rows.

    >>> determinant_signs(np.array([[5e-324, 0, 0]]), np.array([[0, 1e308, 0]]), np.array([[0, 0, -1.0]]))
    array([-1])
    """
    return orientation_signs(np.concatenate((a, b, c)), np.arange(3 * len(a)).reshape(3, -1).T)


def _in_range(x: FloatArray) -> BoolArray:
    """Numbers for which Shewchuk's predicates are exact.

    Those between are multiples of 2^-352, and products of three multiples of 2^-1056: nothing underflows, or overflows,
    on the way to the sign.
    """
    size = np.abs(x)
    return ((size > 2.0**-300) & (size < 2.0**300)) | (size == 0)


def _integer_signs(corners: FloatArray) -> IntArray:
    """Signs of the determinants of (k, 3, 3) floats, by Python's integers: rows are scaled until they are whole."""
    corners = np.where(np.isfinite(corners).all(axis=(1, 2), keepdims=True), corners, 0)
    mantissa, exponent = np.frexp(corners)
    whole = (mantissa * 2.0**53).astype(np.int64).astype(object)
    shift = (exponent - exponent.min(axis=2, keepdims=True)).astype(object)
    return _signs(signed_volumes((whole << shift).transpose(2, 1, 0)))
