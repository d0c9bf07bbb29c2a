"""A map to the plane that no single set of floating-point coordinates holds: charts, and an exact certificate."""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from ..errors import MeshError, own_errstate
from ..mesh.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from ..mesh.check import check_mesh
from ..mesh.measure import corner_angles
from .certificate import Certificate
from .signs import orientation_signs

_NOTHING = np.empty(0, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class ChartAtlas:
    """A map of a closed surface, less one face, to a triangle of the plane; the rest of the plane is that face.

    A chart is a translation of the plane: near its origin float64 is fine down to 1e-308. The plane with one point at
    infinity is a sphere, so that this is the map to the sphere, beyond what coordinates on a sphere hold.

    Attributes
    ----------
    hole : int
        The face that is mapped to the outside.
    chart : (n,) int64 array
        The chart of each vertex.
    z : (n,) complex array
        Its position there.
    parent : (k,) int64 array
        The chart in which each chart's origin is given, of a smaller number; -1 for the first chart.
    origin : (k,) complex array
        The translation of each chart, in its parent; 0 for the first.
    certificate : Certificate
        What exact arithmetic says of these numbers: every face positively oriented, the outer triangle closed.
    """

    hole: int
    chart: IntArray
    z: ComplexArray
    parent: IntArray
    origin: ComplexArray
    certificate: Certificate = field(default_factory=lambda: Certificate(_NOTHING, _NOTHING, 0))

    def sides(self, f: IntArray) -> ComplexArray:
        """Edges of each face from its first corner to its second and third, (m, 2), precise at every scale."""
        sides = self.z[f[:, 1:]] - self.z[f[:, :1]]
        for i in np.flatnonzero(self.across(f)):
            sides[i] = [complex(float(x), float(y)) for x, y in self._exact_sides(f[i])]
        return sides

    def across(self, f: IntArray) -> BoolArray:
        """Faces whose corners do not lie in one chart."""
        chart = self.chart[f]
        return np.asarray((chart != chart[:, :1]).any(axis=1))

    def exact_sign(self, face: IntArray) -> int:
        """Orientation of a face by rational arithmetic."""
        (ax, ay), (bx, by) = self._exact_sides(face)
        det = ax * by - ay * bx
        return (det > 0) - (det < 0)

    def _exact_sides(self, face: IntArray) -> list[tuple[Fraction, Fraction]]:
        (x, y), *others = (self._exact_position(int(v)) for v in face)
        return [(a - x, b - y) for a, b in others]

    def _exact_position(self, v: int) -> tuple[Fraction, Fraction]:
        x, y, k = Fraction(self.z[v].real), Fraction(self.z[v].imag), int(self.chart[v])
        while k > 0:
            x, y, k = x + Fraction(self.origin[k].real), y + Fraction(self.origin[k].imag), int(self.parent[k])
        return x, y


def certify_atlas(atlas: ChartAtlas, f: IntArray) -> Certificate:
    """Certify an atlas of checked faces, exactly; degree 1 means that the outer triangle closes it."""
    n, k = len(f) // 2 + 2, len(atlas.parent)
    parents = np.arange(k) > atlas.parent
    if (atlas.chart.shape, atlas.z.shape, atlas.origin.shape) != ((n,), (n,), (k,)) or not (
            0 <= atlas.hole < len(f) and k and parents.all() and (atlas.parent[1:] >= 0).all()
            and atlas.chart.min() >= 0 and atlas.chart.max() < k):
        raise MeshError("the atlas does not belong to this mesh: its charts, parents or positions do not fit")
    finite = np.isfinite(atlas.z) & np.isfinite(atlas.origin)[atlas.chart]
    if not (finite.all() and np.isfinite(atlas.origin).all()):
        return Certificate(_NOTHING, _NOTHING, 0, not_finite=np.flatnonzero(~finite))
    z = atlas.z[f]
    xy = np.stack((z.real, z.imag), axis=-1)
    exponent = np.frexp(np.abs(xy).max(axis=(1, 2)))[1][:, None, None]
    scaled = np.ldexp(xy, -exponent)  # a power of two for each face keeps its sign, and products in range
    rows = np.concatenate((scaled, np.ones((*scaled.shape[:2], 1))), axis=2)
    signs = orientation_signs(rows.reshape(-1, 3), np.arange(f.size).reshape(-1, 3))
    inexact = (np.ldexp(scaled, exponent) != xy).any(axis=(1, 2))
    for i in np.flatnonzero(inexact | atlas.across(f)):
        signs[i] = atlas.exact_sign(f[i])
    outer, signs[atlas.hole] = signs[atlas.hole], 1
    return Certificate(np.flatnonzero(signs < 0), np.flatnonzero(signs == 0), int(outer == -1))


@own_errstate
def atlas_angle_differences(v: ArrayLike, f: ArrayLike, atlas: ChartAtlas) -> FloatArray:
    """Change of every corner angle in an atlas, image minus source, in degrees.

    Parameters
    ----------
    v : (n, 3) array_like
        Source positions.
    f : (m, 3) array_like
        Faces as 0-based vertex indices.
    atlas : ChartAtlas
        Of a map of this mesh, ``result.atlas``.

    Returns
    -------
    (m, 3) float64 array
        Degrees, of flat triangles in the plane; NaN for the face that is the outside.

    Raises
    ------
    MeshError
        If `v, f` is no closed genus-0 mesh.

    Examples
    --------
    >>> import numpy as np
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("spheroid", n_vertices=5000)
    >>> atlas = ism.spherical_conformal_map(v, f, atlas=True).atlas
    >>> bool(np.nanmean(np.abs(ism.atlas_angle_differences(v, f, atlas))) < 2)
    True
    """
    mesh = check_mesh(v, f)
    a, b = atlas.sides(mesh.f).T
    angles = np.angle(np.stack((b / a, a / (a - b), (b - a) / b), axis=1))
    angles[atlas.hole] = np.nan
    return np.degrees(angles - corner_angles(mesh.v, mesh.f))
