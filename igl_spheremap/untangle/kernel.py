"""Stars of vertices, and points in their kernels: positions of a vertex that fold no face around it.

The star of a vertex is given by its outer edges (a, b), in any order, so that stars of all valences are treated alike.
A position x is in the kernel if det(x, a, b) > 0 for all of them. In the gnomonic chart x = c + z_1 e_1 + z_2 e_2, the
central projection at a unit vector c, each is a half-plane:

    det(x, a, b) = det(c, a, b) + z . (det(e_1, a, b), det(e_2, a, b)) > 0.

The determinants are computed from a - c and b - c, so that stars of size 1e-12 keep as many digits as large ones.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..mesh.arrays import BoolArray, FloatArray, IntArray
from ..mesh.edges import next_corners
from ..sphere.rows import row_crosses, row_dets, row_dots, tangent_axes, unit_rows


@dataclass(frozen=True)
class Stars:
    """Stars of several vertices, edge by edge, also in open patches that change, which `HalfEdges` does not describe.

    Attributes
    ----------
    vertices : (k,) int64 array
        The centres.
    start : (k,) int64 array
        First entry of each star in `a`, `b` and `faces`.
    a, b : (e,) int64 arrays
        Outer edges, counterclockwise: the faces are (vertex, a, b).
    faces : (e,) int64 array
        Index of each face in the array that the stars were taken from.
    """

    vertices: IntArray
    start: IntArray
    a: IntArray
    b: IntArray
    faces: IntArray

    @cached_property
    def valence(self) -> IntArray:
        """Number of faces around each centre."""
        return np.diff(np.append(self.start, len(self.a)))

    @cached_property
    def owner(self) -> IntArray:
        """Row of `vertices` that each outer edge belongs to."""
        return np.repeat(np.arange(len(self.vertices)), self.valence)

    def take(self, rows: IntArray) -> Stars:
        """Stars of the given rows of `vertices`, in that order."""
        valence = self.valence[rows]
        start = np.cumsum(valence) - valence
        edges = np.arange(valence.sum()) + np.repeat(self.start[rows] - start, valence)
        return Stars(self.vertices[rows], start, self.a[edges], self.b[edges], self.faces[edges])


def stars_of(f: IntArray, chosen: BoolArray, face_ids: IntArray | None = None) -> Stars:
    """Stars of the chosen vertices of a triangle mesh.

    >>> f = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    >>> stars_of(f, np.array([True, False, False, False])).valence
    array([3])
    """
    flat = f.ravel()
    corner = np.flatnonzero(chosen.take(flat))
    centre = flat.take(corner)
    order = np.argsort(centre, kind="stable")
    corner, centre = corner.take(order), centre.take(order)
    face = corner // 3
    if face_ids is not None:
        face = face_ids[face]
    start = np.flatnonzero(np.diff(centre, prepend=-1))
    after, before = next_corners(corner)
    return Stars(centre.take(start), start, flat.take(after), flat.take(before), face)


@dataclass(frozen=True)
class _HalfPlanes:
    """Half-planes {z : offset + normal . z > 0} of stars in charts x = centre + size (z_1 e_1 + z_2 e_2).

    `size` is the star's: its corners have coordinates z of about 1.
    """

    normal: FloatArray  # (e, 2), unit
    offset: FloatArray  # (e,)
    owner: IntArray
    start: IntArray
    centre: FloatArray
    axes: FloatArray  # (k, 2, 3), size times e_1 and e_2
    size: FloatArray  # (k,)

    def lift(self, z: FloatArray) -> FloatArray:
        """Unit vectors of the chart's points."""
        return unit_rows(self.centre + np.einsum("ki,kij->kj", z, self.axes))


def _half_planes(x: FloatArray, stars: Stars, centre: FloatArray) -> _HalfPlanes:
    """The condition det(., a, b) > 0 of every outer edge, in the chart of central projection at `centre`."""
    owner = stars.owner
    at = centre[owner]
    da, db = x[stars.a] - at, x[stars.b] - at
    reach = np.maximum.reduceat(np.abs(da).max(axis=1), stars.start)
    size = np.where(reach > 0, reach, 1.0)[:, None]
    da, db = da / size[owner], db / size[owner]
    e1, e2 = tangent_axes(unit_rows(centre))
    # (a x b)/size = centre x (db - da) + size (da x db)
    c = row_crosses(at, db - da) + size[owner] * row_crosses(da, db)
    slope = np.stack((row_dots(c, e1[owner]), row_dots(c, e2[owner])), axis=1)
    level = row_dets(at, da, db)
    length = np.sqrt(row_dots(slope, slope))
    length = np.where(length > 0, length, 1.0)
    return _HalfPlanes(
        slope / length[:, None],
        level / length,
        owner,
        stars.start,
        centre,
        np.stack((e1, e2), axis=1) * size[:, None],
        size[:, 0],
    )


def analytic_centres(x: FloatArray, stars: Stars) -> FloatArray:
    """The analytic centre of each star's kernel: the point x that maximises the product of det(x, a, b).

    So all faces around get area. For stars that are small on the sphere the centre moves with any affine map of the
    star, so that it is found in thin kernels, too.
    """
    planes = _half_planes(x, stars, x[stars.vertices])
    return planes.lift(_newton(planes, np.zeros((len(stars.vertices), 2))))


def centres_beside(
    x: FloatArray, stars: Stars, target: IntArray, wanted: FloatArray | None = None
) -> FloatArray:
    """A point in each star's kernel: its analytic centre, or a point on the way from there to the `wanted` one.

    `target` is the corner of the star to which the vertex was collapsed. If the faces of the fan from there are
    positively oriented, the target lies in the closure of the kernel, which near it is the angle between the two outer
    edges at the target.
    """
    planes = _half_planes(x, stars, x[target])
    touching = (stars.a == target[planes.owner]) | (stars.b == target[planes.owner])
    normal = np.where(touching[:, None], planes.normal, 0.0)
    direction = np.add.reduceat(normal, planes.start, axis=0)
    length = np.sqrt(row_dots(direction, direction))
    direction /= np.where(length > 0, length, 1.0)[:, None]
    # The others limit the way along the bisector of the two half-planes at the target; half of it is taken.
    approach = -row_dots(planes.normal, direction[planes.owner])
    limiting = ~touching & (approach > 0)
    room = np.where(limiting, planes.offset, 1.0) / np.where(limiting, approach, 1.0)
    room = np.minimum.reduceat(np.maximum(room, 0.0), planes.start)
    offset = np.where(touching, 0.0, planes.offset)
    planes = replace(planes, offset=offset)
    z = _newton(planes, direction * 0.5 * room[:, None])
    if wanted is None:
        return planes.lift(z)
    return _towards(planes, z, wanted)


def _towards(
    planes: _HalfPlanes,
    z: FloatArray,
    wanted: FloatArray,
    in_view: float = 0.1,
    reach: float = 0.7,
) -> FloatArray:
    """The wanted points, bit for bit, if they lie well inside; else points on the way there from `z`.

    The way ends at the share `reach` of the distance to the kernel's boundary: vertices that are inserted or moved
    later need part of the kernel. A point whose angle from the chart's centre has a cosine above `in_view` is at most
    10 from there in the chart, and rounding moves it by at most 100 eps.
    """
    ahead = row_dots(planes.centre, wanted)
    seen = ahead > in_view
    ahead = np.where(seen, ahead, 1.0)
    size = planes.size[:, None]
    away = (
        np.einsum("ki,kji->kj", (wanted - planes.centre) / size, planes.axes / size[..., None])
        / ahead[:, None]
    )
    way = np.where(seen[:, None], away - z, 0.0)
    h = planes.offset + row_dots(planes.normal, z[planes.owner])
    approach = -row_dots(planes.normal, way[planes.owner])
    share = np.where(approach > 0, h, np.inf) / np.where(approach > 0, approach, 1.0)
    share = reach * np.minimum.reduceat(np.maximum(share, 0.0), planes.start)
    inside = planes.lift(z + np.minimum(share, 1.0)[:, None] * way)
    return np.where((seen & (share >= 1))[:, None], wanted, inside)


def _newton(planes: _HalfPlanes, z: FloatArray, steps: int = 8, radius: float = 1.5) -> FloatArray:
    """Damped Newton steps towards the maximum of sum log det(x, a, b) over unit x, within the chart's disc.

    8 steps bring all but pathological kernels to 1e-3 of their width. Kernels may be unbounded: the disc has this
    radius, so that it ends 56 degrees from the chart's centre, where lengths are 3.25 times those on the sphere.
    """
    valence = np.bincount(planes.owner)
    bend = planes.size**2
    for _ in range(steps):
        h = planes.offset + row_dots(planes.normal, z[planes.owner])
        unit = planes.normal / np.where(h > 0, h, np.inf)[:, None]
        square = bend * row_dots(z, z)
        # Determinants are divided by the length of x, above 1 in the chart; the disc's barrier has the weight 2.
        pull = bend * (valence / (1 + square) + 2 / (radius**2 - square))
        g = np.add.reduceat(unit, planes.start, axis=0) - pull[:, None] * z
        xx, xy, yy = (
            np.add.reduceat(unit[:, i] * unit[:, j], planes.start)
            for i, j in ((0, 0), (0, 1), (1, 1))
        )
        step = solve_symmetric(xx + pull, xy, yy + pull, g)
        decrement = np.sqrt(np.maximum(row_dots(g, step), 0.0))
        # Below a decrement of 1/4 full steps converge quadratically (Nesterov and Nemirovski 1994).
        z = z + step / (1 + np.where(decrement > 0.25, decrement, 0.0))[:, None]
    return z


def solve_symmetric(
    xx: FloatArray, xy: FloatArray, yy: FloatArray, g: FloatArray, least: float = 0.0
) -> FloatArray:
    """Solutions (k, 2) of k symmetric systems of two unknowns; 0 if determinant over trace^2 is `least` or less."""
    det = xx * yy - xy * xy
    scale = np.where(det > least * (xx + yy) ** 2, det, np.inf)
    return (
        np.stack((yy * g[:, 0] - xy * g[:, 1], xx * g[:, 1] - xy * g[:, 0]), axis=1)
        / scale[:, None]
    )
