"""How much limbs will shrink, foretold by two linear solves and no map."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from ..mesh.check import Mesh
from ..mesh.measure import corner_angles
from .operators import Operators

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

#: Image edges below this can't be told from none next to coordinates of size 1 in float64.
FLOAT64_LIMIT = 1e-13


@dataclass(frozen=True)
class Limb:
    """A part of the surface that the map shrinks strongly.

    Attributes
    ----------
    tip : int
        Its vertex of smallest scale.
    vertices : int
        How many vertices it has.
    edge : float
        Foretold length of the shortest image edge at the tip.
    """

    tip: int
    vertices: int
    edge: float


def log_scale(mesh: Mesh, operators: Operators) -> FloatArray:
    """Foretell the logarithm of the map's local scale at each vertex, relative to the body.

    With a puncture at p in the body, ``L u = 4 pi delta_p - K`` makes the surface flat: u is the logarithm of
    the scale of the map to the plane, that to the sphere is about the same away from p.
    Where two bodies of equal area hang together by a neck, the map halves the difference between them; this
    foretells the whole of it for one of the two.

    Parameters
    ----------
    mesh : Mesh
        The checked source.
    operators : Operators
        Its Laplacian, factorised.

    Returns
    -------
    (n,) float64 array
        About 0 on the body, strongly negative in limbs: about -2 pi l / c at the tip of one of length l and
        circumference c.

    References
    ----------
    Springborn, Schroeder, Pinkall 2008, *Conformal Equivalence of Triangle Meshes*, for curvature and scale.
    """
    n = len(mesh.v)
    angles = corner_angles(mesh.v, mesh.f)
    curvature = 2 * np.pi - np.bincount(mesh.f.ravel(), angles.ravel(), minlength=n)
    curvature += (4 * np.pi - curvature.sum()) * operators.A  # 0 but for rounding
    p = 0
    for _ in range(2):  # from anywhere, then from the middle of the body as seen from there
        load = -curvature
        load[p] += 4 * np.pi
        u = operators.factor.solve(load)
        order = np.argsort(u)
        middle = order[np.searchsorted(np.cumsum(operators.A[order]), 0.5)]
        u -= u[middle]
        p = int(middle)
    return np.asarray(u)


def deep_limbs(mesh: Mesh, scale: FloatArray, limit: float = FLOAT64_LIMIT) -> tuple[Limb, ...]:
    """Limbs whose image has edges below a limit.

    Parameters
    ----------
    mesh : Mesh
        The checked source.
    scale : (n,) float64 array
        From `log_scale`.
    limit : float
        Length on the unit sphere.

    Returns
    -------
    tuple of Limb
        The deepest first.
    """
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
    """Foretold length of the shortest image edge at each vertex.

    Parameters
    ----------
    mesh : Mesh
        The checked source.
    scale : (n,) float64 array
        From `log_scale`.

    Returns
    -------
    (n,) float64 array
        On the unit sphere; edges of zero length in the source are left out.
    """
    i, j = mesh.f.ravel(), mesh.f[:, [1, 2, 0]].ravel()
    length = np.linalg.norm(mesh.v[i] - mesh.v[j], axis=1)
    length = np.where(length > 0, length, np.inf)
    shortest = np.full(len(mesh.v), np.inf)
    np.minimum.at(shortest, i, length)
    np.minimum.at(shortest, j, length)
    return np.asarray(np.sqrt(4 * np.pi) * np.exp(np.minimum(scale, 0)) * shortest)
