"""How strongly a conformal map shrinks limbs, predicted by linear solves without a map.

A limb of length l and circumference c shrinks like exp(-2 pi l / c), soon below what float64 can hold. Its logarithm
solves a linear equation, which does not underflow.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from ..mesh.arrays import FloatArray
from ..mesh.check import Mesh
from ..mesh.measure import angle_defects, corner_angles
from .operators import Operators

#: Next to coordinates of size 1, image edges below this length have less than three digits in float64.
FLOAT64_LIMIT = float(512 * np.finfo(float).eps)


@dataclass(frozen=True)
class Limb:
    """A part of the surface that the map shrinks strongly."""

    tip: int  # its vertex of smallest scale
    vertices: int  # their number
    edge: float  # predicted length of the shortest image edge at the tip


def log_scale(mesh: Mesh, operators: Operators) -> FloatArray:
    """Predicted logarithm of the map's scale at each vertex, relative to the body: about -2 pi l / c at a limb's tip.

    It is that of the map to the plane punctured in the body, the flat metric e^{2u} g with L u = 4 pi delta - K, K the
    angle defects (Springborn, Schroeder, Pinkall 2008, *Conformal Equivalence of Triangle Meshes*); that to the sphere
    is about the same away from there.
    Where two bodies of equal area are joined by a neck, the map halves the difference between them, and this gives
    the whole of it to one of the two.
    """
    defects = angle_defects(corner_angles(mesh.v, mesh.f), mesh.f, len(mesh.v))
    middle = 0
    for _ in range(2):  # from anywhere, then from the middle of the body as seen from there
        load = -defects
        load[middle] += 4 * np.pi
        u = operators.factor.solve(load)
        order = np.argsort(u)
        middle = int(order[np.searchsorted(np.cumsum(mesh.A[order]), 0.5)])
    return np.asarray(u - u[middle])


def deep_limbs(mesh: Mesh, scale: FloatArray, limit: float = FLOAT64_LIMIT) -> tuple[Limb, ...]:
    """Limbs whose image has edges below a length on the unit sphere, the deepest first."""
    i, j = mesh.f.ravel(), mesh.f[:, [1, 2, 0]].ravel()
    edge = shortest_image_edges(mesh, scale)
    deep = edge < limit
    inside = deep[i] & deep[j]
    n = len(mesh.v)
    _, label = connected_components(csr_matrix((np.ones(inside.sum()), (i[inside], j[inside])), shape=(n, n)))
    where = np.flatnonzero(deep)
    tips = where[np.argsort(edge[where], kind="stable")]
    _, first = np.unique(label[tips], return_index=True)
    size = np.bincount(label[where], minlength=label.max() + 1)
    return tuple(Limb(int(tip), int(size[label[tip]]), float(edge[tip])) for tip in tips[np.sort(first)])


def shortest_image_edges(mesh: Mesh, scale: FloatArray) -> FloatArray:
    """Predicted length of the shortest image edge at each vertex; source edges of zero length are left out."""
    i, j = mesh.f.ravel(), mesh.f[:, [1, 2, 0]].ravel()
    length = np.linalg.norm(mesh.v[i] - mesh.v[j], axis=1)
    shortest = np.full(len(mesh.v), np.inf)
    np.minimum.at(shortest, i, np.where(length > 0, length, np.inf))  # a closed mesh runs through each edge both ways
    return np.asarray(np.sqrt(4 * np.pi) * np.exp(np.minimum(scale, 0)) * shortest)
