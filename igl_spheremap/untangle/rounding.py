"""Positions that are free of foldings as float32 numbers, as file formats of that precision hold them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import FactorisationFailed
from ..mesh.measure import vertex_areas
from ..operators.laplacian import laplacian
from ..verify.certificate import Certificate, certify_checked, orientation_signs
from .depth import log_edges
from .embedding import embed_locally
from .nested import solve_limbs

FloatArray = NDArray[np.float64]
Float32Array = NDArray[np.float32]
IntArray = NDArray[np.int64]

#: Edges shorter than exp(-this) do not survive in float32: tried one after the other.
_FLOORS = (14.0, 13.0, 12.0, 11.0)


@dataclass(frozen=True, eq=False)
class Float32Map:
    """A map as float32 numbers.

    Attributes
    ----------
    positions : (n, 3) float32 array
        On a sphere of the radius that was asked for.
    certificate : Certificate
        Of these very numbers, directions from the origin. Where it is not free of foldings, float32 lost the
        map.
    moved : (k,) int64 array
        Vertices that are not simply rounded.
    """

    positions: Float32Array
    certificate: Certificate
    moved: IntArray


def certified_float32(x: FloatArray, f: IntArray, radius: float = 1.0,
                      v: FloatArray | None = None) -> Float32Map:
    """Round a map to float32, and repair what rounding folds, on the grid of float32 numbers.

    Parameters
    ----------
    x : (n, 3) float64 array
        Unit rows, free of foldings.
    f : (m, 3) int64 array
        Faces of a closed genus-0 mesh that passed the gate.
    radius : float
        Of the sphere that is written.
    v : (n, 3) float64 array, optional
        Source of the map. With it, limbs too narrow for float32 are stretched as conformally as that goes;
        without, they are only embedded.

    Returns
    -------
    Float32Map
        Positions and their certificate. What can't be repaired is left rounded, and the certificate says where.

    Examples
    --------
    >>> import igl
    >>> x, f = igl.icosahedron()
    >>> rounded = certified_float32(x, f, radius=100.0)
    >>> rounded.positions.dtype.name, rounded.certificate.folding_free, len(rounded.moved)
    ('float32', True, 0)
    """
    scale = 2.0 ** np.round(np.log2(radius))  # exact to divide by

    def grid(rows: FloatArray) -> FloatArray:
        return (radius * rows).astype(np.float32).astype(np.float64) / scale

    rounded = grid(x)
    repaired, certificate = rounded, _certificate(rounded, f)
    if not certificate.folding_free:
        for trial in _trials(x, f, v):
            y = embed_locally(grid(trial), f, grid)
            judged = _certificate(y, f)
            if judged.folding_free:
                repaired, certificate = y, judged
                break
    moved = np.flatnonzero((repaired != rounded).any(axis=1))
    return Float32Map((repaired * scale).astype(np.float32), certificate, moved)


def _trials(x: FloatArray, f: IntArray, v: FloatArray | None) -> Iterator[FloatArray]:
    """The map with its limbs stretched, ever farther, and as it is."""
    if v is not None:
        L, depth, area = laplacian(v, f, "delaunay"), -log_edges(x, f), vertex_areas(v, f)
        for floor in _FLOORS:
            with suppress(FactorisationFailed):
                yield solve_limbs(x, L, depth, area, floor=floor).onto_sphere(x)
    yield x


def _certificate(x: FloatArray, f: IntArray) -> Certificate:
    """Certificate of directions, whatever the length of the rows."""
    signs = orientation_signs(x, f)
    return Certificate(np.flatnonzero(signs < 0), np.flatnonzero(signs == 0), certify_checked(x, f).degree)
