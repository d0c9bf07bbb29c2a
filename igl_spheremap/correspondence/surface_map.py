"""A map from one surface to another: two certified maps to one sphere, composed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import igl
import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from ..errors import MeshError, own_errstate
from ..mesh.arrays import FloatArray, IntArray, check_rows, own_unit
from ..result.sphere_map import SphereMap
from ..shapes.locate import Location, locator_of
from ..shapes.rotation import RotationCandidate
from ..shapes.transfer import interpolate
from ..sphere.rows import row_lengths, unit_rows
from .overlay import Overlay, overlay
from .stretch import Distortion

#: Places in a face of this share of the size have some four digits.
_SPECK = 1e-12
#: Points may be so many sizes of a surface away from it that libigl's squares of distances don't overflow.
_FAR = 1e100


@dataclass(frozen=True, eq=False)
class SurfaceMap:
    """A bijection from a surface A to a surface B: from A to the sphere by one map, from there to B by another.

    Attributes
    ----------
    map : SphereMap
        A's map to the sphere in the frame of B's, certified. Its mesh is A; where A was mirrored, or its faces were
        divided at landmarks, it is that surface.
    target : SphereMap
        B's map to the sphere.
    landmarks : (k,) int64 array
        Vertices of A that were to meet given points of B, those of curves last.
    goals : Location
        These points of B.
    candidates : tuple of RotationCandidate
        Rotations that were considered, the one that was taken first.
    notes : tuple of str
        What was done beside what was asked for, and reasons to doubt the result.
    """

    map: SphereMap
    target: SphereMap
    landmarks: IntArray
    goals: Location
    candidates: tuple[RotationCandidate, ...] = ()
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return (f"SurfaceMap({len(self.map.sphere)} vertices onto {len(self.target.sphere)}, "
                f"{len(self.landmarks)} landmarks)")

    @cached_property
    def location(self) -> Location:
        """Where A's vertices lie on B."""
        return locator_of(self.target).locate(self.map.sphere)

    @property
    def positions(self) -> FloatArray:
        """Where A's vertices lie on B, (n_A, 3), in the units of B.

        With A's faces that is B on the connectivity of A.
        """
        return interpolate(self.target.vertices, self.target.faces, self.location)

    @property
    def landmark_errors(self) -> FloatArray:
        """Distances (k,) of the landmarks' images from the points that they were to meet, in the units of B."""
        goals = interpolate(self.target.vertices, self.target.faces, self.goals)
        return row_lengths(self.positions[self.landmarks] - goals)

    @property
    def unresolved(self) -> tuple[int, int]:
        """How many faces of A are on B, and of B on A, so small that float64 can't tell what lies where in them."""
        back = interpolate(self.map.vertices, self.map.faces, locator_of(self.map).locate(self.target.sphere))
        return _specks(self.positions, self.map.faces), _specks(back, self.target.faces)

    @own_errstate
    def forward(self, points: Location | ArrayLike) -> Location:
        """Where points of A lie on B.

        Parameters
        ----------
        points : Location or (k, 3) array_like
            Points of A by face and barycentric weights, or positions in A's units, of which the nearest points of A
            are taken.

        Returns
        -------
        Location
            Faces of B and barycentric weights; unpacks to both.

        Raises
        ------
        MeshError
            If a face or a weight is out of range, or positions are not finite.

        Examples
        --------
        >>> import numpy as np
        >>> import igl_spheremap as ism
        >>> v, f = ism.samples.make("pear", n_vertices=500)
        >>> a = ism.balanced_spherical_map(v, f, 1)
        >>> onto = ism.match(a, a)
        >>> face, weights = onto.forward(v[:5])
        >>> size = np.abs(v).max()
        >>> bool(np.allclose(np.einsum("ij,ijk->ik", weights, v[f[face]]), v[:5], atol=0.02 * size))
        True
        """
        return locator_of(self.target).locate(_directions(self.map, points, "A"))

    @own_errstate
    def inverse(self, points: Location | ArrayLike) -> Location:
        """Where points of B come from on A; the inverse of `forward`.

        Parameters
        ----------
        points : Location or (k, 3) array_like
            Points of B by face and barycentric weights, or positions in B's units, of which the nearest points of B
            are taken.

        Returns
        -------
        Location
            Faces of A and barycentric weights; unpacks to both.

        Raises
        ------
        MeshError
            If a face or a weight is out of range, or positions are not finite.
        """
        return locator_of(self.map).locate(_directions(self.target, points, "B"))

    def matrix(self) -> sp.csr_matrix:
        """The matrix (n_A, n_B) that takes values at B's vertices to A's: each row has the weights of one face of B.

        Returns
        -------
        scipy.sparse.csr_matrix
            Rows sum 1. ``matrix() @ b.vertices`` are the `positions`.
        """
        face, weights = self.location
        n = len(face)
        rows = np.arange(0, 3 * n + 1, 3)
        return sp.csr_matrix((weights.ravel(), self.target.faces[face].ravel(), rows),
                             shape=(n, len(self.target.sphere)))

    def overlay(self) -> Overlay:
        """The common refinement of A and B: a mesh with positions on both, whose faces are mapped linearly.

        Returns
        -------
        Overlay
            Of the triangulations of both surfaces on the sphere, by exact signs; it is made once.

        Examples
        --------
        >>> import igl_spheremap as ism
        >>> a, b = (ism.samples.make(name, n_vertices=300) for name in ("pear", "spheroid"))
        >>> common = ism.match(a, b).overlay()
        >>> common.on_a.shape == common.on_b.shape, len(common.faces) == 2 * len(common.on_a) - 4
        (True, True)
        """
        return self._overlay

    @own_errstate
    def distortion(self) -> Distortion:
        """How far the map is from an isometry up to scale, measured on the faces of the overlay.

        Returns
        -------
        Distortion
            Symmetric Dirichlet energy, change of areas and change of angles of each face, and their figures over the
            area of A and of B without caps.

        Examples
        --------
        >>> import igl_spheremap as ism
        >>> a, b = (ism.samples.make(name, n_vertices=300) for name in ("pear", "spheroid"))
        >>> figures = ism.match(a, b).distortion().figures
        >>> figures["over_a"]["symmetric_dirichlet"]["median"] >= 4, figures["over_b"]["angle"]["above_100"]
        (True, 0.0)
        """
        common = self._overlay
        caps = np.zeros(len(common.faces), dtype=bool)
        for result, face in ((self.map, common.face_a), (self.target, common.face_b)):
            if result.mesh.caps is not None:
                caps |= result.mesh.caps[face]
        return Distortion.of(common.on_a, common.on_b, common.faces, caps)

    @cached_property
    def _overlay(self) -> Overlay:
        return overlay(self.map, self.target)


def _specks(p: FloatArray, f: IntArray) -> int:
    """How many faces are specks beside the whole."""
    sides = np.max([row_lengths(p[f[:, k]] - p[f[:, k - 1]]) for k in range(3)], axis=0)
    return int(np.count_nonzero(sides < _SPECK * np.ptp(p, axis=0).max()))


def _directions(result: SphereMap, points: Location | ArrayLike, name: str) -> FloatArray:
    """Images on the sphere of points of a mapped surface."""
    location = checked_location(points, result.faces, name) if isinstance(points, Location) else nearest(
        result, check_rows(points, name=f"points of {name}"), name)
    return unit_rows(interpolate(result.sphere, result.faces, location))


def nearest(result: SphereMap, points: FloatArray, name: str) -> Location:
    """The points of a surface that are nearest to given positions."""
    if not np.isfinite(points).all():
        bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
        raise MeshError(f"points of {name} are not finite, e.g. row {bad[0]}; give positions")
    v, unit = own_unit(result.vertices)
    points = np.clip(np.ldexp(points, -unit), -_FAR, _FAR)
    _, face, on = igl.point_mesh_squared_distance(points, v, result.faces)[:3]
    face = np.asarray(face, dtype=np.int64).reshape(-1)
    corners = (np.ascontiguousarray(v[result.faces[face, k]]) for k in range(3))
    weights = np.nan_to_num(np.asarray(igl.barycentric_coordinates(np.asarray(on).reshape(-1, 3), *corners)))
    weights = np.maximum(weights, 0.0)
    total = weights.sum(axis=1, keepdims=True)
    return Location(face, np.where(total > 0, weights / np.where(total > 0, total, 1.0), 1 / 3))


def checked_location(points: Location, f: IntArray, name: str) -> Location:
    """Faces in range, and weights that are not negative and sum 1; else a MeshError that names the first bad one."""
    face, weights = np.asarray(points.face), np.asarray(points.weights, dtype=np.float64)
    if face.dtype.kind not in "iu" or face.ndim != 1 or weights.shape != (len(face), 3):
        raise MeshError(f"points of {name} have faces of shape {face.shape} and weights of shape {weights.shape}; give "
                        "(k,) whole numbers and (k, 3) weights")
    bad = np.flatnonzero((face < 0) | (face >= len(f)))
    if len(bad):
        raise MeshError(f"point {bad[0]} of {name} is in face {face[bad[0]]}, but there are faces 0 to {len(f) - 1}")
    total = weights.sum(axis=1)
    bad = np.flatnonzero(~((weights >= 0).all(axis=1) & (np.abs(total - 1) < 1e-6)))
    if len(bad):
        raise MeshError(f"the weights of point {bad[0]} of {name} are {weights[bad[0]].tolist()}; give three that are "
                        "not negative and sum 1")
    return Location(face.astype(np.int64), weights / total[:, None])
