"""Maps that are free of foldings as float32 numbers, as file formats of that precision hold them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..angles.deep_limbs import floor_of, shorten_limbs
from ..angles.layout import Placed, onto_sphere
from ..mesh.arrays import FloatArray, IntArray
from ..mesh.measure import corner_angles, face_areas, log_edges
from ..sphere.log_plane import logarithm
from ..sphere.rows import tangent_axes, to_chart, unit_rows
from ..untangle.embedding import embed_locally
from ..verify.certificate import Certificate
from ..verify.signs import orientation_signs

Float32Array = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Float32Map:
    """A map as float32 numbers.

    Attributes
    ----------
    positions : (n, 3) float32 array
        On a sphere of the radius that was asked for.
    certificate : Certificate
        Of these very numbers, as directions from the origin. If it is not free of foldings, float32 can't hold
        the map.
    moved : (k,) int64 array
        Vertices that are not simply rounded.
    """

    positions: Float32Array
    certificate: Certificate
    moved: IntArray


def certified_float32(x: FloatArray, f: IntArray, radius: float = 1.0) -> Float32Map:
    """Round a map without foldings to float32 on a sphere of some radius, and repair folds from rounding, on that grid.

    If that fails the rounded map is returned, with a certificate that names its foldings.

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
        for trial in _trials(x, f):
            y = embed_locally(grid(trial), f, grid)
            judged = _certificate(y, f)
            if judged.folding_free:
                repaired, certificate = y, judged
                break
    moved = np.flatnonzero((repaired != rounded).any(axis=1))
    return Float32Map((repaired * scale).astype(np.float32), certificate, moved)


def _trials(x: FloatArray, f: IntArray) -> Iterator[FloatArray]:
    """The map with its limbs shortened, then as it is."""
    pole = unit_rows(-x[f[np.argmax(face_areas(x, f))]].sum(axis=0, keepdims=True))
    placed, angles = as_mapped(x, f, pole), corner_angles(x, f)
    yield onto_sphere(placed, shorten_limbs(placed, angles, floor_of(np.float32))[0])
    yield x


def as_mapped(x: FloatArray, f: IntArray, pole: FloatArray) -> Placed:
    """Stereographic image of a map in the plane, from the point opposite to a pole, a (1, 3) unit row."""
    # in a chart the plane touches the sphere, for `to_ball` it holds the equator
    z = to_chart(x, pole) / 2
    turn = np.vstack((*tangent_axes(pole), pole))
    return Placed(f, logarithm(z), -log_edges(x, f), lambda tip: logarithm(z - z[tip]), turn=turn)


def _certificate(x: FloatArray, f: IntArray) -> Certificate:
    """Certificate of directions, whatever the length of the rows."""
    signs = orientation_signs(x, f)
    return Certificate(
        np.flatnonzero(signs < 0),
        np.flatnonzero(signs == 0),
        Certificate.of(x, f).degree,
        faces=len(f),
    )
