"""The figures of a mesh that decide how good its map can be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..mesh.arrays import EPS, FloatArray, IntArray, weld
from ..mesh.edges import shared_edges, sides
from ..mesh.measure import corner_angles, enclosed_volume, face_areas
from . import SIX_DIGITS
from .welding import gaps

#: Share of the mean area up to which a face has none: sides that are off by eps leave about as much.
_NO_AREA = 4 * EPS


@dataclass(frozen=True)
class MeshQuality:
    """Figures of a triangle mesh, in the units of its file unless said otherwise.

    Attributes
    ----------
    extent : tuple of 3 floats
        Size of the bounding box.
    area : float
        Of the surface.
    volume : float
        Enclosed; negative if the mesh is oriented inwards, NaN if it is not closed and oriented.
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
    near_vertices : int
        Places of vertices that are closer to another one than a millionth of the diagonal of the bounding box.
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
    near_vertices: int
    largest_valence: int


def mesh_quality(v: FloatArray, f: IntArray) -> MeshQuality:
    """Measure any triangles whose positions are finite.

    >>> v = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], dtype=float)
    >>> quality = mesh_quality(v, np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]))
    >>> round(quality.volume, 9), round(quality.smallest_angle, 6), quality.non_delaunay_edges
    (2.666666667, 60.0, 0)
    """
    n, low, high = len(v), v.min(axis=0), v.max(axis=0)
    size = scale = 1.0
    if v.any():
        size = float(np.abs(v).max())
    if (high > low).any():
        scale = min(float((high / size - low / size).max()) * size, float(np.finfo(float).max))
    p = v / scale - (low / scale + high / scale) / 2
    keys, _, first, second = shared_edges(f, n)
    start, ends = sides(f)[0], np.concatenate((keys // n, keys % n))
    length = np.linalg.norm(p[keys // n] - p[keys % n], axis=1)
    angles, areas = corner_angles(p, f), face_areas(p, f)
    opposite = angles.ravel()[first] + angles.ravel()[second]
    closed = 2 * len(first) == f.size and not (start[first] == start[second]).any()
    volume, places = np.nan, weld(p)[0]
    if closed:
        volume = enclosed_volume(p, f) * scale * scale * scale
    x, y, z = (high / scale - low / scale).tolist()
    return MeshQuality(
        extent=(x * scale, y * scale, z * scale),
        area=float(areas.sum()) * scale * scale,
        volume=volume,
        shortest_edge=float(length.min()) * scale,
        mean_edge=float(length.mean()) * scale,
        longest_edge=float(length.max()) * scale,
        smallest_angle=float(np.degrees(angles.min())),
        largest_angle=float(np.degrees(angles.max())),
        slivers=int((angles.min(axis=1) < np.radians(1)).sum()),
        zero_area_faces=int((areas <= _NO_AREA * areas.mean()).sum()),
        # the sum is pi in rectangles, to rounding
        non_delaunay_edges=int((opposite > np.pi + 1e-9).sum()),
        coincident_vertices=n - len(places),
        near_vertices=int((gaps(places) < SIX_DIGITS * np.linalg.norm(np.ptp(p, axis=0))).sum()),
        largest_valence=int(np.bincount(ends).max()),
    )
