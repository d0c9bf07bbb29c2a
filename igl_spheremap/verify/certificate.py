"""Whether a map to the unit sphere, or of a disk to the plane, is free of foldings: exact signs and exact degree."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from ..errors import Remedy
from ..gate import gate
from ..mesh.arrays import EPS, FloatArray, IntArray, check_rows, check_triangles, plain_array
from ..mesh.check import MapLike, Mesh, check_faces, not_finite, rows_and_faces
from ..mesh.disk import disk_rim
from ..sphere.rows import row_lengths, scale_rows, unit_rows
from ..timings import phase
from .rim import plane_signs, rim_crossings, rim_direction
from .signs import determinant_signs, orientation_signs

#: Lengths of rows may differ from 1 by this: by the rounding of a float32 file, no more.
UNIT_TOLERANCE = 1e-6
#: Room for rounding in the choice of the faces that may hold a direction; each of them is then tested exactly.
_ROOM = 64 * EPS


@dataclass(frozen=True, eq=False)
class Certificate:
    """The verdict of exact arithmetic on a map to the sphere, or to the plane.

    Attributes
    ----------
    flipped : int64 array
        Faces whose image is oriented inwards, in the plane clockwise: the foldings.
    degenerate : int64 array
        Faces whose image is flat: on the sphere its plane holds the origin, in the plane it has no area.
    degree : int
        How often the image covers the sphere, or in the plane its boundary's interior, counted with sign; 1 for a
        bijection, 0 if it could not be counted.
    not_finite : int64 array
        Vertices with a NaN or infinite coordinate.
    off_sphere : int64 array
        Vertices whose distance from the origin differs from 1 by more than 1e-6.
    boundary_loops : int
        0 for a map of a closed surface to the sphere, 1 for one of a disk to the plane.
    crossings : int64 array
        In the plane, the first vertices of boundary edges that meet another one.
    faces : int
        Number of faces.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> x, f = ism.samples.sphere(42)
    >>> certificate = ism.certify(-x, f)
    >>> certificate.folding_free, len(certificate.flipped), certificate.degree, certificate.orientation
    (False, 80, -1, -1)
    """

    flipped: IntArray
    degenerate: IntArray
    degree: int
    not_finite: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    off_sphere: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    boundary_loops: int = 0
    crossings: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    faces: int = 0

    @classmethod
    @phase("certificate")
    def of(cls, x: FloatArray, f: IntArray) -> Certificate:
        """The certificate of float64 rows and the faces of a checked mesh; `certify` takes other arrays.

        Parameters
        ----------
        x : (n, 3) float64 array
            Images of the vertices.
        f : (m, 3) int64 array
            Faces, not checked again.

        Returns
        -------
        Certificate
            The foldings and the degree.
        """
        if len(bad := not_finite(x)):
            return cls(bad[:0], bad[:0], 0, bad, faces=len(f))
        signs = orientation_signs(x, f)
        off_sphere = np.flatnonzero(np.abs(row_lengths(x) - 1) > UNIT_TOLERANCE)
        scaled = x
        if len(off_sphere):
            scaled = scale_rows(x)
        degree, degrees = 0, _degrees(f, (x, scaled, signs))
        if degrees is not None:
            degree = degrees[0]
        return cls(
            np.flatnonzero(signs < 0),
            np.flatnonzero(signs == 0),
            degree,
            off_sphere=off_sphere,
            faces=len(f),
        )

    @classmethod
    @phase("certificate")
    def of_plane(cls, p: FloatArray, f: IntArray, rim: IntArray) -> Certificate:
        """The certificate of a map of a checked disk to the plane; `certify` takes other arrays.

        Parameters
        ----------
        p : (n, 2) float64 array
            Images of the vertices.
        f
            As of `of`.
        rim : (k,) int64 array
            Vertices of the boundary loop, in its direction.

        Returns
        -------
        Certificate
            The foldings, and where the boundary crosses itself.
        """
        if len(bad := not_finite(p)):
            return cls(bad[:0], bad[:0], 0, bad, boundary_loops=1, faces=len(f))
        signs, crossings = plane_signs(p, f), rim[rim_crossings(p, rim)]
        degree = 0
        if not len(crossings):
            degree = rim_direction(p, rim)
        return cls(
            np.flatnonzero(signs < 0),
            np.flatnonzero(signs == 0),
            degree,
            boundary_loops=1,
            crossings=crossings,
            faces=len(f),
        )

    @property
    def orientation(self) -> int | None:
        """1 or -1 if the map is proved to be a homeomorphism that keeps or reverses orientation; None if it is not.

        Its image is the unit sphere, or a part of the plane. One of orientation -1 is folding-free once a coordinate is
        negated.
        """
        if any(map(len, (self.degenerate, self.not_finite, self.off_sphere, self.crossings))):
            return None
        if self.degree == 1 and len(self.flipped) == 0:
            return 1
        if self.degree == -1 and len(self.flipped) == self.faces:
            return -1
        return None

    @property
    def folding_free(self) -> bool:
        """True if the map is proved to be a homeomorphism that keeps orientation."""
        return self.orientation == 1

    @property
    def foldings(self) -> int:
        """Number of faces that are flipped or degenerate."""
        return len(self.flipped) + len(self.degenerate)

    def __bool__(self) -> bool:
        return self.folding_free

    def __repr__(self) -> str:
        return f"Certificate(folding_free={self.folding_free}, {self.foldings} foldings, degree {self.degree})"

    def __str__(self) -> str:
        if self.boundary_loops:
            image, once, mended = "image", "the boundary crosses itself nowhere", ""
        else:
            repair = Remedy("repair_foldings", given="v, f, x")
            image, once, mended = "sphere", "the sphere is covered once", f" ({repair} does)"
        if self.orientation == 1:
            return f"folding-free: every face is positively oriented and {once} (exact)"
        if self.orientation == -1:
            return (
                f"a mirror image, not folded: every face is negatively oriented and {once} (exact); negate a "
                f"coordinate{mended}, or reverse the faces if the surface is inside out"
            )
        faults = [
            f"{len(bad)} {what}, e.g. {', '.join(map(str, bad[:3].tolist()))}"
            for bad, what in (
                (self.not_finite, "vertices not finite"),
                (self.off_sphere, "vertices off the unit sphere"),
                (self.flipped, "flipped faces"),
                (self.degenerate, "degenerate faces"),
                (self.crossings, "boundary edges that meet others"),
            )
            if len(bad)
        ]
        if self.degree != 1 and not len(self.not_finite) and not len(self.crossings):
            faults.append(f"the {image} is covered {self.degree} times")
        verdict = "no face folds, but"
        if self.foldings or self.degree != 1 or len(self.not_finite):
            verdict = "not folding-free"
        return f"{verdict}: {'; '.join(faults)}"


@gate
def certify(x: ArrayLike | MapLike, f: ArrayLike | Mesh | None = None) -> Certificate:
    """Certify a map of a closed genus-0 mesh to the unit sphere, or of a disk to the plane, made by any program.

    The map sends each face to the spherical triangle of its image corners, or to the plane one. It is a homeomorphism
    if (and, apart from degenerate faces, only if) every face is positively oriented and the degree is 1; in the plane,
    if every face is positively oriented and the boundary of the image crosses itself nowhere. All is decided in exact
    arithmetic on the given numbers.

    Parameters
    ----------
    x : (n, 3) or (n, 2) array_like or SphereMap
        Images of the vertices on the unit sphere, or in the plane; or a map, which needs no `f`.
    f : (m, 3) array_like or Mesh, optional
        Faces as 0-based vertex indices: a closed, oriented, connected genus-0 mesh, or, for the plane, a mesh with one
        boundary loop and no handle. By default those of `x`, a map.

    Returns
    -------
    Certificate
        The foldings, the degree and the verdict ``folding_free``.

    Raises
    ------
    MeshError
        If `f` is not such a mesh on the rows of `x`, or `x` is not an (n, 3) or (n, 2) array of real numbers, or one of
        them (longdouble, a large integer) would be rounded.
    TypeError
        If `f` is missing, and `x` is not a map.

    See Also
    --------
    sphere_map : a map of another program as a result with measures.
    repair_foldings : a map without the foldings.

    References
    ----------
    Orientation by the adaptive exact predicates of Shewchuk 1997. docs/guarantee.md proves that local orientation and
    degree 1 suffice.

    Examples
    --------
    >>> import numpy as np
    >>> import igl_spheremap as ism
    >>> x = np.vstack((np.eye(3), -np.eye(3)))
    >>> f = [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
    >>> ism.certify(x, f).folding_free
    True
    >>> ism.certify(-x, f).degree
    -1
    >>> ism.certify([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2], [0, 2, 3]])
    Certificate(folding_free=True, 0 foldings, degree 1)
    """
    x, f = rows_and_faces(x, f)
    given = plain_array(x, "positions")
    if isinstance(f, Mesh) or given.shape[1:] != (2,):
        x = check_rows(x)
        return Certificate.of(x, check_faces(f, len(x)))
    p, faces = check_rows(x, columns=2), check_triangles(f)
    # messages name places; the certificate names NaN
    places = np.column_stack((np.where(np.isfinite(p), p, 0.0), np.zeros(len(p))))
    return Certificate.of_plane(p, faces, disk_rim(faces, places))


@phase("certificate")
def after_change(
    certificate: Certificate, x: FloatArray, y: FloatArray, f: IntArray, changed: IntArray
) -> Certificate:
    """The certificate of `y`, given that of `x`, a map that differs at some faces only, ascending; it measures these.

    Over any direction the signs of all other faces have the same sum for both maps.
    """
    corners, part = np.unique(f[changed], return_inverse=True)
    part, before, now = part.reshape(-1, 3), x[corners], y[corners]
    signs, new = orientation_signs(before, part), orientation_signs(now, part)
    degrees = _degrees(part, (before, before, signs), (now, now, new))
    faulty = len(certificate.off_sphere) + len(certificate.not_finite) > 0
    if degrees is None or faulty or not (np.abs(row_lengths(now) - 1) <= UNIT_TOLERANCE).all():
        return Certificate.of(y, f)
    return replace(
        certificate,
        flipped=np.union1d(np.setdiff1d(certificate.flipped, changed), changed[new < 0]),
        degenerate=np.union1d(np.setdiff1d(certificate.degenerate, changed), changed[new == 0]),
        degree=certificate.degree + degrees[1] - degrees[0],
    )


#: A map's rows, the same rows scaled, and the orientations of its faces.
_Oriented = tuple[FloatArray, FloatArray, IntArray]


def _degrees(f: IntArray, *maps: _Oriented) -> list[int] | None:
    """For each map the sum of the signs of its faces over one direction, in general position for all, exactly."""
    for q in _directions(maps[0][1], f, maps[0][2]):
        found = [_signs_over(q, f, *each) for each in maps]
        if None not in found:
            return cast(list[int], found)
    return None


def _signs_over(
    q: FloatArray, f: IntArray, x: FloatArray, y: FloatArray, signs: IntArray
) -> int | None:
    """Sum of the signs of the faces over a direction; None if it is on an edge. `y` has the rows of x, scaled."""
    over = _faces_near(y, f, q)
    corners = [x[f[over, k]] for k in range(3)]
    side = determinant_signs(
        np.tile(q, (3 * len(over), 1)),
        np.concatenate(corners),
        np.concatenate([corners[k - 2] for k in range(3)]),
    ).reshape(3, -1)
    sign = signs[over]
    inside = (side * sign).min(axis=0, initial=1)
    on_edge = np.where(sign != 0, inside == 0, (side == 0).all(axis=0))
    if on_edge.any():  # the sum is not defined here
        return None
    return int(sign[inside > 0].sum())


def _directions(x: FloatArray, f: IntArray, signs: IntArray) -> Iterator[FloatArray]:
    """Directions to count at: inside eight faces of the image, then 24 fixed ones; a second is hardly ever needed.

    If corners of a face nearly cancel, its direction may lie outside it and have any length: it serves as well.
    """
    proper = np.flatnonzero(signs)
    if len(proper):
        proper = proper[np.linspace(0, len(proper) - 1, num=min(8, len(proper))).astype(int)]
    middles = np.einsum("k,ikj->ij", [0.5, 0.3, 0.2], x[f[proper]])
    yield from middles[middles.any(axis=1)]
    # Points spaced by the golden angle: they lie on an edge of a mesh only if the mesh was made from them.
    height = (np.arange(24) + 0.5) / 12 - 1
    turn = np.arange(24) * 2.399963229728653 + 0.1
    rim = np.sqrt(1 - height**2)
    yield from np.column_stack((rim * np.cos(turn), rim * np.sin(turn), height))


def _faces_near(x: FloatArray, f: IntArray, q: FloatArray) -> IntArray:
    """Faces of rows no longer than 2 that may hold direction `q`: a necessary test in floating point.

    Seen along q, a cone that holds q has the origin in the bounding box of its corners.
    """
    q = unit_rows(q[None])[0]
    axes = np.concatenate((np.linalg.svd(q[None, :])[2][1:], q[None, :]))
    a, b, c = np.einsum("ij,jk->ik", axes, np.ascontiguousarray(x.T))
    # One bit for each half-plane, and for the half-space, that holds a vertex: a face is kept if its corners have all
    # five.
    bits = np.zeros(len(x), dtype=np.uint8)
    for k, side in enumerate((a <= _ROOM, a >= -_ROOM, b <= _ROOM, b >= -_ROOM, c > -_ROOM)):
        bits |= side.view(np.uint8) << np.uint8(k)
    corners = bits.take(f)
    return np.flatnonzero((corners[:, 0] | corners[:, 1] | corners[:, 2]) == 0b11111)
