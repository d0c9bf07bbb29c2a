"""The stated, deterministic gauge of every result: Moebius-centred, and turned to the Gauss map."""

from __future__ import annotations

import numpy as np

from ..mesh.arrays import FloatArray
from ..mesh.check import Mesh
from ..mesh.measure import vertex_normals
from ..mesh.timings import stage
from .moebius import center
from .rows import row_dots, weighted_moment, weighted_sum

#: Weight of the position from the barycentre beside that of the normal. It decides where normals leave the
#: rotation open (a flat body has only two of them), and is too small to be seen where they don't.
_TIE_BREAK = 1e-3


@stage("gauge")
def fix_gauge(mesh: Mesh, x: FloatArray) -> FloatArray:
    """Moebius map of `x` in the package's gauge.

    The source's area has its barycentre at the origin, and the rotation is the one that agrees best with the Gauss
    map, in the source's area.
    """
    return turn_to_gauss_map(mesh, center(x, mesh.A))


def turn_to_gauss_map(mesh: Mesh, x: FloatArray) -> FloatArray:
    """`x` rotated to agree best with the Gauss map, weighted by the source's area."""
    turned = np.einsum("jk,ji->ki", best_rotation(x, orientation_target(mesh), mesh.A), np.ascontiguousarray(x.T))
    turned /= np.sqrt(row_dots(turned.T, turned.T))  # steps and Moebius maps add up rounding in the lengths
    return np.ascontiguousarray(turned.T)


def orientation_target(mesh: Mesh) -> FloatArray:
    """The vectors that a map in the gauge is turned to: normals plus 1/1000 of the position from the barycentre."""
    normals = vertex_normals(mesh.v, mesh.f)
    outward = mesh.v - weighted_sum(mesh.A, mesh.v)
    inside_out = np.vdot(mesh.A, row_dots(normals, outward)) < 0
    outward *= -_TIE_BREAK if inside_out else _TIE_BREAK
    outward += normals  # algorithm (21)
    return outward


def best_rotation(x: FloatArray, target: FloatArray, weights: FloatArray) -> FloatArray:
    """Rotation R, never a reflection, that brings ``x @ R`` closest to `target` in weighted squares (Kabsch).

    >>> quarter = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    >>> bool(np.allclose(best_rotation(np.eye(3), quarter, np.ones(3)), quarter))
    True
    """
    u, _, vt = np.linalg.svd(weighted_moment(weights, x, target))
    u[:, -1] *= np.sign(np.linalg.det(u) * np.linalg.det(vt)) or 1.0
    return np.asarray(u @ vt)  # algorithm (22)
