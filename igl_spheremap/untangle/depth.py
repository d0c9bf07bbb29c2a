"""How small the image of each part of a surface will be, known before it can be computed.

A limb of length l and circumference c shrinks like exp(-2 pi l / c), soon below what an absolute solver error
leaves. Its logarithm is the solution of a linear equation and suffers from neither underflow nor that error.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..mesh.measure import angle_defects, corner_angles
from ..operators.factor import Factor
from ..operators.limb_scale import flat_scale

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

#: The scale is fitted where the image is larger than this, and away from the pole.
_RELIABLE = np.log(1e-6)
_NEAR_POLE = 0.3


def log_edges(v: FloatArray, f: IntArray) -> FloatArray:
    """Mean logarithm of the lengths of the edges around each vertex.

    Parameters
    ----------
    v : (n, 3) float64 array
        Positions.
    f : (m, 3) int64 array
        Faces of a closed mesh.

    Returns
    -------
    (n,) float64 array
        Natural logarithms; lengths below 1e-300 count as that.
    """
    u, w = f[:, [0, 1, 2]].ravel(), f[:, [1, 2, 0]].ravel()
    d = v[u] - v[w]
    log = np.log(np.maximum(np.sqrt(np.einsum("ij,ij->i", d, d)), 1e-300))
    n = len(v)  # every edge is met from both its faces: once from u to w and once back
    return np.asarray(np.bincount(u, log, n) / np.bincount(u, minlength=n))


def predicted_log_edges(v: FloatArray, f: IntArray, x: FloatArray, factor: Factor,
                        A: FloatArray) -> FloatArray:
    """Logarithm of the image's edge lengths that a conformal map in the gauge of `x` has.

    In the flat metric of the surface punctured at a pole p, of which the stereographic projection from p has the
    factor |x - x_p|^2.

    Parameters
    ----------
    v : (n, 3) float64 array
        Source.
    f : (m, 3) int64 array
        Faces.
    x : (n, 3) float64 array
        A map that is good where its image is not tiny.
    factor : Factor
        Inverse of the Laplacian.
    A : (n,) float64 array
        Vertex areas.

    Returns
    -------
    (n,) float64 array
        Natural logarithms, one per vertex.
    """
    source, image = log_edges(v, f), log_edges(x, f)
    large = np.median(A) <= A
    pole = int(np.argmax(np.where(large, image - source, -np.inf)))
    away = np.sqrt(np.einsum("ij,ij->i", x - x[pole], x - x[pole]))
    scale = flat_scale(_defects(v, f), factor, pole) + 2 * np.log(np.maximum(away, np.exp(image[pole])))
    known = (away > _NEAR_POLE) & (image > _RELIABLE)
    if not known.any():
        known[:] = True
    return np.asarray(scale + np.median((image - source - scale)[known]) + source)


def _defects(v: FloatArray, f: IntArray) -> FloatArray:
    return angle_defects(corner_angles(v, f), f, len(v))
