"""Weights of a mapped surface's vertices in a target's data, as a sparse matrix; and weights that keep integrals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array, diags_array

from ..errors import MeshError
from ..maps.sphere_map import SphereMap
from ..mesh.arrays import (
    EPS,
    AnyArray,
    FloatArray,
    IntArray,
    check_directions,
    own_unit,
    plain_array,
)
from ..mesh.measure import vertex_areas
from ..sphere.rows import unit_rows
from .locate import Location, SphereLocator, locator_of

#: A target takes data from the corners of the face that holds it, or so that integrals are kept.
Resampling = Literal["linear", "adaptive-area"]


@dataclass(frozen=True, eq=False)
class TransferMatrix:
    """Weights that carry data at the vertices of a source to a target.

    Attributes
    ----------
    matrix : (k, n) scipy.sparse.csr_array
        Targets by sources; rows are non-negative and sum to 1, so that ``matrix @ values`` are the data at the target.
    received : (k,) float64 array or None
        Area of the source that came to each target, in the source's squared units, by "adaptive-area" only: these areas
        keep integrals, ``received @ (matrix @ values)`` is ``source_areas @ values``.
    areas : (k,) float64 array or None
        The target's own areas, in its squared units; their integrals deviate by the difference of the two surfaces;
        likewise.
    source_areas : (n,) float64 array or None
        Areas of the source's vertices, a third of the faces around each; caps have none. Likewise.
    """

    matrix: csr_array
    received: FloatArray | None = None
    areas: FloatArray | None = None
    source_areas: FloatArray | None = None

    def __repr__(self) -> str:
        return f"TransferMatrix({self.matrix.shape[1]} vertices to {self.matrix.shape[0]})"


def linear_matrix(f: IntArray, location: Location, n_vertices: int) -> csr_array:
    """Lay barycentric weights of the corners of faces out as a (k, n) matrix without zeros."""
    k = len(location.face)
    start = np.arange(0, 3 * k + 1, 3)
    entries = location.weights.ravel(), f[location.face].ravel(), start
    # entries are sorted in place: not the caller's
    matrix = csr_array(entries, shape=(k, n_vertices), copy=True)
    matrix.eliminate_zeros()
    matrix.sort_indices()
    return matrix


def largest(matrix: csr_array) -> csr_array:
    """A matrix with a single 1 in each row, at the row's largest weight; of several, at the first.

    >>> largest(csr_array([[0.2, 0.5, 0.3], [0.5, 0.0, 0.5]])).toarray()
    array([[0., 1., 0.],
           [1., 0., 0.]])
    """
    peak = np.maximum.reduceat(matrix.data, matrix.indptr[:-1])
    row = np.repeat(np.arange(matrix.shape[0]), np.diff(matrix.indptr))
    at = np.flatnonzero(matrix.data == peak[row])
    first = at[np.searchsorted(row[at], np.arange(matrix.shape[0]))]
    ones = np.ones(matrix.shape[0])
    return csr_array((ones, matrix.indices[first], np.arange(len(ones) + 1)), shape=matrix.shape)


def apply_matrix(matrix: csr_array, values: ArrayLike, labels: bool = False) -> AnyArray:
    """Apply a matrix to data (n, ...); of labels each row takes the one of its largest weight."""
    data = plain_array(values, "values")
    if len(data) != matrix.shape[1]:
        raise MeshError(f"{len(data)} values for {matrix.shape[1]} vertices; give one for each")
    if labels:
        return data[largest(matrix).indices]
    return np.asarray(
        (matrix @ data.reshape(len(data), -1)).reshape(matrix.shape[0], *data.shape[1:])
    )


def adaptive_area(
    source: SphereMap, x: FloatArray, f: IntArray, v: FloatArray | None = None
) -> TransferMatrix:
    """Compute weights that keep integrals, at the vertices of a surface v: by default the source's resampled there."""
    here, there = locator_of(source), SphereLocator(unit_rows(check_directions(x)), f)
    forward = linear_matrix(here.f, here.locate(there.x), len(here.x))
    reverse = csr_array(linear_matrix(there.f, there.locate(here.x), len(there.x)).T)
    if v is None:
        v = forward @ source.vertices
    v, unit = own_unit(v)
    own, source_unit = own_unit(source.vertices)
    source_areas = vertex_areas(own, source.faces[source.mesh.surface])
    areas = vertex_areas(v, there.f)

    both = (forward > 0).multiply(reverse > 0).sum(axis=1)
    # rows of `forward` that leave out vertices of the source
    skipping = (both < (reverse > 0).sum(axis=1)).astype(np.float64)
    gathered = diags_array(1 - skipping) @ forward + diags_array(skipping) @ reverse
    scattered = diags_array(_positive(areas)) @ gathered
    scattered = csr_array(scattered @ diags_array(_positive(source_areas) / scattered.sum(axis=0)))
    received = scattered.sum(axis=1)
    matrix = csr_array(diags_array(1 / received) @ scattered)
    matrix.eliminate_zeros()
    matrix.sort_indices()
    received, source_areas = (np.ldexp(each, 2 * source_unit) for each in (received, source_areas))
    return TransferMatrix(matrix, received, np.ldexp(areas, 2 * unit), source_areas)


def _positive(areas: FloatArray) -> FloatArray:
    """Raise areas above 0, so that every vertex takes part: those at needles may be 0 by rounding."""
    return np.maximum(areas, EPS * areas.mean())


def check_resampling(method: str) -> None:
    """Raise a ValueError for an unknown method."""
    if method not in get_args(Resampling):
        raise ValueError(f"unknown method {method!r}: choose {' or '.join(get_args(Resampling))}")
