"""A map from one surface to another: two certified maps to one sphere, composed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import igl
import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array

from ...draw.markup import table
from ...draw.plot import pose
from ...draw.shown import Drawing, place_drawing
from ...errors import MeshError
from ...gate import gate
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray, IntArray, check_rows, own_unit
from ...resampling.locate import Location, locator_of
from ...resampling.transfer import interpolate
from ...resampling.weights import linear_matrix
from ...result.findings import verdict
from ...sphere.rows import row_lengths, unit_rows
from .overlay import Overlay, overlay
from .result import OfMap
from .stretch import Distortion


@dataclass(frozen=True, eq=False)
class SurfaceMap(OfMap):
    """A bijection from one surface to another: to the sphere by the source's map, from there to the target by its own.

    Attributes
    ----------
    map : SphereMap
        The source's map to the sphere in the frame of the target's, certified. Its mesh is the source, perhaps
        mirrored, or with faces divided at landmarks.
    target : SphereMap
        The target's map to the sphere.
    landmarks : (k,) int64 array
        Vertices of the source that were to meet given points of the target, those of curves last.
    goals : Location
        These points of the target.
    notes : tuple of str
        Further actions, and reasons to doubt the result.

    Examples
    --------
    >>> import numpy as np
    >>> import igl_spheremap as ism
    >>> a, b = (ism.samples.make(name, n_vertices=300) for name in ("pear", "spheroid"))
    >>> onto = ism.shapes.match(a, b)
    >>> face, weights = onto.inverse(onto.forward(a[0][:5]))
    >>> bool(np.allclose(np.einsum("ij,ijk->ik", weights, a[0][a[1][face]]), a[0][:5]))
    True
    >>> common = onto.overlay()
    >>> common.on_source.shape == common.on_target.shape, len(common.faces) == 2 * len(common.on_source) - 4
    (True, True)
    >>> figures = onto.distortion().figures["over_source"]
    >>> figures["symmetric_dirichlet"]["median"] >= 4, figures["angle_ratio"]["above_100"]
    (True, 0.0)
    """

    _in_words = "a SurfaceMap, as shapes.match makes one"

    map: SphereMap
    target: SphereMap
    landmarks: IntArray
    goals: Location
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return (
            f"SurfaceMap({len(self.map.sphere)} vertices onto {len(self.target.sphere)}, "
            f"{len(self.landmarks)} landmarks)"
        )

    def _drawing(self) -> Drawing:
        image = interpolate(self.target.mesh.unit, self.target.faces, self.location)
        return place_drawing(
            (self.map.mesh.unit, image),
            self.map.faces,
            "Left: the source; right: its faces on the target. The same colour is the same place.",
            (pose(self.map.mesh.unit), pose(image)),
        )

    def _figures(self) -> str:
        rows = [
            ("certificate", verdict(self.certificate, self.map.mesh.caps).text),
            ("source", f"{len(self.map.sphere):,} vertices, {len(self.map.faces):,} faces"),
            ("target", f"{len(self.target.sphere):,} vertices, {len(self.target.faces):,} faces"),
        ]
        if len(self.landmarks):
            rows.append(
                (
                    "landmarks",
                    f"{len(self.landmarks)}, off by {self.landmark_errors.max():.3g} at most",
                )
            )
        return table([*rows, *(("note", note) for note in self.notes)])

    @property
    def _images(self) -> FloatArray:
        return self.positions

    @cached_property
    def location(self) -> Location:
        """The source's vertices on the target."""
        return locator_of(self.target).locate(self.map.sphere)

    @property
    def positions(self) -> FloatArray:
        """Images of the source's vertices on the target, (n, 3), in the target's units.

        With the source's faces that is the target on the connectivity of the source.
        """
        return interpolate(self.target.vertices, self.target.faces, self.location)

    @property
    def landmark_errors(self) -> FloatArray:
        """Distances (k,) of the landmarks' images from the points that they were to meet, in the target's units."""
        goals = interpolate(self.target.vertices, self.target.faces, self.goals)
        return row_lengths(self.positions[self.landmarks] - goals)

    @gate
    def forward(self, points: Location | ArrayLike) -> Location:
        """Images of points of the source on the target.

        Parameters
        ----------
        points : Location or (k, 3) array_like
            Points of the source by face and barycentric weights, or positions in its units, which are moved to the
            nearest points of the source.

        Returns
        -------
        Location
            Faces of the target and barycentric weights; unpacks to both.

        Raises
        ------
        MeshError
            If a face or a weight is out of range, or positions are not finite.
        """
        return locator_of(self.target).locate(_directions(self.map, points, "the source"))

    @gate
    def inverse(self, points: Location | ArrayLike) -> Location:
        """Origins of points of the target on the source; the inverse of `forward`.

        Parameters
        ----------
        points : Location or (k, 3) array_like
            Points of the target, as those of the source for `forward`.

        Returns
        -------
        Location
            Points of the source.
        """
        return locator_of(self.map).locate(_directions(self.target, points, "the target"))

    def matrix(self) -> csr_array:
        """The matrix (n, n_target) that takes values at the target's vertices to the source's.

        Each row has the weights of one face of the target.

        Returns
        -------
        scipy.sparse.csr_array
            Rows sum to 1. ``matrix() @ target.vertices`` are the `positions`.
        """
        return linear_matrix(self.target.faces, self.location, len(self.target.sphere))

    def overlay(self) -> Overlay:
        """The common refinement of both: a mesh with positions on each, whose faces are mapped linearly.

        Returns
        -------
        Overlay
            The overlay of both triangulations on the sphere, made by exact signs, at the first call only.
        """
        return self._overlay

    @gate
    def distortion(self) -> Distortion:
        """Distance of the map from an isometry up to scale, on the faces of the overlay.

        Returns
        -------
        Distortion
            Symmetric Dirichlet energy, change of areas and change of angles of each face, and their figures over the
            area of the source and of the target without caps.
        """
        common = self._overlay
        caps = np.zeros(len(common.faces), dtype=bool)
        for result, face in ((self.map, common.source_face), (self.target, common.target_face)):
            if result.mesh.caps is not None:
                caps |= result.mesh.caps[face]
        return Distortion.of(common.on_source, common.on_target, common.faces, caps)

    @cached_property
    def _overlay(self) -> Overlay:
        return overlay(self.map, self.target)


def _directions(result: SphereMap, points: Location | ArrayLike, name: str) -> FloatArray:
    """Map points of a surface to the sphere."""
    if isinstance(points, Location):
        location = checked_location(points, result.faces, name)
    else:
        location = nearest(result, check_rows(points, name=f"points of {name}"), name)
    return unit_rows(interpolate(result.sphere, result.faces, location))


def nearest(result: SphereMap, points: FloatArray, name: str) -> Location:
    """Find the points of a surface that are nearest to given positions."""
    if not np.isfinite(points).all():
        bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
        raise MeshError(f"points of {name} are not finite, e.g. row {bad[0]}; give positions")
    v, unit = own_unit(result.vertices)
    points = np.clip(np.ldexp(points, -unit), -1e100, 1e100)  # libigl squares distances
    _, face, on = igl.point_mesh_squared_distance(points, v, result.faces)[:3]
    face = np.asarray(face, dtype=np.int64).reshape(-1)
    corners = (np.ascontiguousarray(v[result.faces[face, k]]) for k in range(3))
    weights = np.nan_to_num(
        np.asarray(igl.barycentric_coordinates(np.asarray(on).reshape(-1, 3), *corners))
    )
    weights = np.maximum(weights, 0.0)
    total = weights.sum(axis=1, keepdims=True)
    return Location(face, np.where(total > 0, weights / np.where(total > 0, total, 1.0), 1 / 3))


def checked_location(points: Location, f: IntArray, name: str) -> Location:
    """Check that faces are in range, and weights not negative and of sum 1; a MeshError names the first bad one."""
    face, weights = np.asarray(points.face), np.asarray(points.weights, dtype=np.float64)
    if face.dtype.kind not in "iu" or face.ndim != 1 or weights.shape != (len(face), 3):
        raise MeshError(
            f"points of {name} have faces of shape {face.shape} and weights of shape {weights.shape}; give "
            "(k,) whole numbers and (k, 3) weights"
        )
    bad = np.flatnonzero((face < 0) | (face >= len(f)))
    if len(bad):
        raise MeshError(
            f"point {bad[0]} of {name} is in face {face[bad[0]]}; give a face from 0 to {len(f) - 1}"
        )
    total = weights.sum(axis=1)
    # float32 holds seven digits
    bad = np.flatnonzero(~((weights >= 0).all(axis=1) & (np.abs(total - 1) < 1e-6)))
    if len(bad):
        raise MeshError(
            f"the weights of point {bad[0]} of {name} are {weights[bad[0]].tolist()}; give three that are "
            "not negative and sum to 1"
        )
    return Location(face.astype(np.int64), weights / total[:, None])
