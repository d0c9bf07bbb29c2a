"""The figures of a mesh that decide how good its map can be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .arrays import FloatArray, IntArray, weld
from .check import Mesh
from .edges import edge_keys
from .measure import corner_angles, enclosed_volume, face_areas


@dataclass(frozen=True)
class MeshQuality:
    """Figures of a closed genus-0 mesh, in the units of its file where not said otherwise.

    Attributes
    ----------
    extent : tuple of 3 floats
        Size of the bounding box.
    area : float
        Of the surface.
    volume : float
        Enclosed; negative where the mesh is oriented inwards.
    shortest_edge, mean_edge, longest_edge : float
        Edge lengths.
    smallest_angle, largest_angle : float
        Degrees, over all corners.
    slivers : int
        Faces with an angle below 1 degree.
    zero_area_faces : int
        Faces without area, up to rounding.
    non_delaunay_edges : int
        Edges whose opposite angles exceed 180 degrees together: their cotangent weights are negative.
    coincident_vertices : int
        Vertices at the place of another one.
    largest_valence : int
        Most edges at one vertex.
    """

    extent: tuple[float, float, float]
    area: float
    volume: float
    shortest_edge: float
    mean_edge: float
    longest_edge: float
    smallest_angle: float
    largest_angle: float
    slivers: int
    zero_area_faces: int
    non_delaunay_edges: int
    coincident_vertices: int
    largest_valence: int


def mesh_quality(mesh: Mesh) -> MeshQuality:
    """Measure a checked mesh.

    >>> from igl_spheremap import check_mesh
    >>> v = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]
    >>> quality = mesh_quality(check_mesh(v, [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]))
    >>> round(quality.volume, 9), round(quality.smallest_angle, 6), quality.non_delaunay_edges
    (2.666666667, 60.0, 0)
    """
    p, f = mesh.vertices, mesh.f
    i, j = f.ravel(), f[:, [1, 2, 0]].ravel()
    length = np.linalg.norm(p[i] - p[j], axis=1)[i < j]
    angles = corner_angles(mesh.v, f)
    areas = face_areas(mesh.v, f)
    # `check_mesh` scales lengths by one factor: undo it in the volume.
    scale = float(np.ptp(p, axis=0).max() / np.ptp(mesh.v, axis=0).max())
    extent = np.ptp(p, axis=0).tolist()
    smallest, largest = float(angles.min()), float(angles.max())
    return MeshQuality(
        extent=(extent[0], extent[1], extent[2]),
        area=float(areas.sum()) * scale**2,
        volume=enclosed_volume(mesh.v, f) * scale**3,
        shortest_edge=float(length.min()),
        mean_edge=float(length.mean()),
        longest_edge=float(length.max()),
        smallest_angle=float(np.degrees(smallest)),
        largest_angle=float(np.degrees(largest)),
        slivers=int((angles.min(axis=1) < np.radians(1)).sum()),
        zero_area_faces=int((areas <= 4 * np.finfo(float).eps * areas.mean()).sum()),
        non_delaunay_edges=_non_delaunay(f, angles, len(p)),
        coincident_vertices=len(p) - len(weld(p)[0]),
        largest_valence=int(np.bincount(i).max()),
    )


def _non_delaunay(f: IntArray, angles: FloatArray, n: int) -> int:
    """Edges whose opposite angles sum to more than pi."""
    start, stop = f[:, [1, 2, 0]].ravel(), f[:, [2, 0, 1]].ravel()  # the edge opposite each corner
    order = np.argsort(edge_keys(start, stop, n), kind="stable")
    opposite = angles.ravel()[order]
    return int((opposite[0::2] + opposite[1::2] > np.pi + 1e-9).sum())  # the sum is pi in rectangles, to rounding
