"""Data over the vertices, checked."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..errors import MeshError
from ..mesh.arrays import FloatArray
from ..mesh.check import plain_array


def check_values(values: ArrayLike, n_vertices: int, name: str = "values") -> FloatArray:
    """Take data as (n, k) float64 rows, one for each vertex, or raise a MeshError that says why not."""
    array = plain_array(values, name)
    if array.dtype.kind not in "fiub":
        raise MeshError(f"{name} have dtype {array.dtype}; give real numbers")
    if array.ndim not in (1, 2) or len(array) != n_vertices:
        raise MeshError(f"{name} have shape {array.shape} but the mesh has {n_vertices} vertices; give one row each")
    array = array.reshape(n_vertices, -1).astype(np.float64)
    bad = np.flatnonzero(~np.isfinite(array).all(axis=1))
    if len(bad):
        raise MeshError(f"{name} are not finite at {len(bad)} vertices, e.g. {bad[:3].tolist()}; fill them in")
    return array
