"""The Gauss map: unit normals at the vertices."""

from __future__ import annotations

import igl
import numpy as np
from numpy.typing import ArrayLike

from ..errors import own_errstate
from .arrays import FloatArray, IntArray
from .check import Mesh, check_mesh

#: Shorter normals have lost digits, for their squares underflow.
_SHORTEST = np.sqrt(np.finfo(float).tiny)
#: Sums of unit vectors shorter than this are rounding.
_CANCELLED = 4096 * np.finfo(float).eps


@own_errstate
def gauss_map(v: ArrayLike, f: ArrayLike) -> FloatArray:
    """Gauss map: each vertex goes to its unit normal, Definition 1.

    Parameters
    ----------
    v : (n, 3) array_like
        Source positions.
    f : (m, 3) array_like
        Faces as 0-based vertex indices.

    Returns
    -------
    (n, 3) float64 array
        Unit rows: libigl's area-weighted vertex normals. Where all faces around a vertex have no area, the mean of
        its neighbours' normals stands in.

    Raises
    ------
    MeshError
        If `v, f` is no closed genus-0 mesh.

    References
    ----------
    Lai et al., Definition 1.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]
    >>> ism.gauss_map(v, [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])[0].round(3)
    array([0.577, 0.577, 0.577])
    """
    return mesh_gauss_map(check_mesh(v, f))


def mesh_gauss_map(mesh: Mesh) -> FloatArray:
    """`gauss_map` of a checked mesh."""
    normals = igl.per_vertex_normals(mesh.v, mesh.f, igl.PER_VERTEX_NORMALS_WEIGHTING_TYPE_AREA)  # Definition 1
    return fill_directions(normals, mesh.f)


def fill_directions(x: FloatArray, f: IntArray) -> FloatArray:
    """Unit rows along those of `x`; rows without direction take the mean of their neighbours', ring by ring.

    Where nothing has a direction, all get the z axis.
    """
    length = np.sqrt(np.einsum("ij,ij->i", x, x))
    known = (length > _SHORTEST) & (length < np.inf)
    if known.all():
        return x / length[:, None]
    x = np.where(known[:, None], x / np.where(known, length, 1)[:, None], 0.0)
    edges = np.vstack((f[:, [0, 1]], f[:, [1, 2]], f[:, [2, 0]]))
    while not known.all():
        reach = edges[known[edges[:, 0]] & ~known[edges[:, 1]]]
        if not len(reach):
            x[~known] = [0.0, 0.0, 1.0]
            break
        total = np.column_stack([np.bincount(reach[:, 1], x[reach[:, 0], k], minlength=len(x)) for k in range(3)])
        new = np.unique(reach[:, 1])
        size = np.linalg.norm(total[new], axis=1)
        flat = size < _CANCELLED
        if flat.any():  # opposite neighbours cancel: any one of them will do then
            _, first = np.unique(reach[:, 1], return_index=True)
            total[new[flat]] = x[reach[first[flat], 0]]
        x[new] = total[new] / np.linalg.norm(total[new], axis=1, keepdims=True)
        known[new] = True
    return x
