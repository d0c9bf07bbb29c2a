"""Landmarks and curves of two surfaces: vertices of the first, and the corresponding places of the second."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from ...errors import MeshError
from ...maps.given_sphere import certified
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import HALF_DIGITS, FloatArray, IntArray, check_values, plain_array
from ...mesh.check import check_mesh
from ...mesh.edges import marked, touching
from ...resampling.locate import Location, at_vertices, joined, take_points
from ...resampling.transfer import interpolate
from ...sphere.rows import row_crosses, row_dots, row_lengths, unit_rows
from ...untangle.local_repair import unfolded
from .surface_map import checked_location, nearest

#: Vertices, or points by face and weights.
Points = ArrayLike | Location
_ENDS = "the source", "the target"


@dataclass(frozen=True, eq=False)
class LandmarkPairs:
    """Points of the source and of the target that belong together.

    Attributes
    ----------
    surface : SphereMap
        The source, with a vertex at each of its points; its own come first.
    added : Location
        The added vertices on the source's own faces.
    vertices : (k,) int64 array
        Points of the source.
    goals : Location
        Points of the target.
    names : list of str
        The points as given.
    """

    surface: SphereMap
    added: Location
    vertices: IntArray
    goals: Location
    names: list[str]

    @classmethod
    def of(
        cls,
        landmarks: tuple[Points, Points] | None,
        curves: Iterable[tuple[Points, Points]],
        source: SphereMap,
        target: SphereMap,
    ) -> LandmarkPairs:
        """Check the points; a MeshError names a wrong one."""
        pairs, names = [(Location(np.empty(0, dtype=np.int64), np.empty((0, 3))),) * 2], list[str]()
        if landmarks is not None:
            points, goals = _pair(landmarks, source, target, "landmark")
            if len(points.face) != len(goals.face):
                raise MeshError(
                    f"{len(points.face)} landmarks of the source have {len(goals.face)} points of the "
                    "target; give one for each"
                )
            pairs.append((points, goals))
            names += [f"landmark {k}" for k in range(len(points.face))]
        for number, each in enumerate(curves):
            curve = f"curve {number}"
            points, goals = _pair(each, source, target, "point", curve)
            pairs.append((points, _at_the_same_length(points, goals, source, target, curve)))
            names += [f"point {k} of {curve}" for k in range(len(points.face))]
        points, goals = (joined(*each) for each in zip(*pairs, strict=True))
        surface, added, vertices = with_vertices(source, points)
        there = interpolate(target.sphere, target.faces, goals)
        on_target = np.unique(there, axis=0, return_inverse=True)[1].reshape(-1)
        kept = np.sort(
            np.unique(np.column_stack((vertices, on_target)), axis=0, return_index=True)[1]
        )
        for numbers, name in ((vertices[kept], _ENDS[0]), (on_target[kept], _ENDS[1])):
            order = np.argsort(numbers, kind="stable")
            equal = np.flatnonzero(np.diff(numbers[order]) == 0)
            if len(equal):
                i, j = (names[k] for k in kept[order[equal[0] : equal[0] + 2]])
                raise MeshError(
                    f"{i} and {j} are one point of {name}; give each its own, and divide curves where they "
                    "meet"
                )
        return cls(
            surface, added, vertices[kept], take_points(goals, kept), [names[k] for k in kept]
        )

    def carried(self, values: ArrayLike, source: SphereMap) -> FloatArray:
        """Interpolate features over the source's own vertices at the vertices of `surface`."""
        values = check_values(values, len(source.sphere), "features of the source")
        return np.concatenate((values, interpolate(values, source.faces, self.added)))


def _pair(
    pair: tuple[Points, Points], source: SphereMap, target: SphereMap, one: str, curve: str = ""
) -> tuple[Location, Location]:
    """Check two lists of points, landmarks or those of a curve."""
    ends, what = _ENDS, "landmarks"
    if curve:
        what, ends = curve, (f"{curve} of {_ENDS[0]}", f"{curve} of {_ENDS[1]}")
    if not isinstance(pair, Sequence) or len(pair) != 2:
        raise MeshError(f"no pair for {what}; give (points of the source, points of the target)")
    return _points(pair[0], source, one, ends[0]), _points(pair[1], target, one, ends[1])


def _points(values: Points, result: SphereMap, one: str, name: str) -> Location:
    """Check vertices, or faces and weights, and return them as points of faces."""
    if isinstance(values, Location):
        return checked_location(values, result.faces, name)
    index, n = plain_array(values, f"{one}s of {name}"), len(result.sphere)
    if index.ndim != 1 or not len(index) or index.dtype.kind not in "iu":
        raise MeshError(
            f"{one}s of {name} are not a list of vertex indices; give one whole number each, at least "
            "one, or a Location"
        )
    bad = np.flatnonzero((index < 0) | (index >= n))
    if len(bad):
        raise MeshError(
            f"{one} {bad[0]} of {name} is vertex {index[bad[0]]}; give a vertex from 0 to {n - 1}"
        )
    return take_points(at_vertices(result.faces), index.astype(np.int64))


def _at_the_same_length(
    first: Location, second: Location, source: SphereMap, target: SphereMap, curve: str
) -> Location:
    """Find the point of the target's curve at the same share of its length for each point of the source's."""
    shares, ends = [], []
    for points, result, name in ((first, source, _ENDS[0]), (second, target, _ENDS[1])):
        p = interpolate(result.vertices, result.faces, points)
        length = np.append(0.0, np.cumsum(row_lengths(np.diff(p, axis=0))))
        if length[-1] == 0:
            raise MeshError(f"{curve} of {name} has no length; give two points or more")
        shares.append(length / length[-1])
        ends.append(p)
    places = np.column_stack([np.interp(shares[0], shares[1], column) for column in ends[1].T])
    goals = nearest(target, places, _ENDS[1])
    tips = [0, -1]
    goals.face[tips], goals.weights[tips] = second.face[tips], second.weights[tips]
    return goals


def with_vertices(result: SphereMap, points: Location) -> tuple[SphereMap, Location, IntArray]:
    """Divide faces so that a map has vertices at given points; return it, the places of new vertices, and the vertices.

    Faces are divided at points within them, and two of them at points of their common side. If a point is nearer to a
    side or a corner than 1e-8 of the face, it lies there.
    """
    f, n = result.faces, len(result.sphere)
    near = np.flatnonzero(touching(f, marked(f[points.face], n)))
    # parts of faces, the face of each, and its corners' weights there
    parts, owner, corners = f[near], near, np.tile(np.eye(3), (len(near), 1, 1))
    vertices, added = np.empty(len(points.face), dtype=np.int64), list[FloatArray]()
    for k, (face, w) in enumerate(zip(*points, strict=True)):
        w = np.where(w < HALF_DIGITS, 0.0, w)
        w, here = w / w.sum(), np.flatnonzero(owner == face)
        height = _heights(w, corners[here])
        best = height.min(axis=1).argmax()
        ends, beside = parts[here[best]], np.flatnonzero(height[best] < HALF_DIGITS)
        if len(beside) > 1:
            vertices[k] = ends[height[best].argmax()]
            continue
        vertices[k] = new = n + len(added)
        added.append(w)
        divided = here[[best]]
        if len(beside):
            ends = np.delete(ends, beside[0])
            divided = np.flatnonzero(np.isin(parts, ends).sum(axis=1) == 2)
        # each part once for each of the ends, which the vertex replaces
        taken = parts[divided] == ends[:, None, None]
        own = ((f[owner[divided]][:, :, None] == f[face]) * w).sum(axis=2)
        parts[divided], *others = np.where(taken, new, parts[divided])
        parts = np.concatenate((parts, *others))
        corners[divided], *others = np.where(taken[..., None], own[:, None], corners[divided])
        corners = np.concatenate((corners, *others))
        owner = np.concatenate((owner, *[owner[divided]] * len(others)))
    if not added:
        return result, take_points(points, slice(0, 0)), vertices
    first = np.array([np.flatnonzero(vertices == n + k)[0] for k in range(len(added))])
    inserted = Location(points.face[first], np.array(added))
    v, x = (
        np.concatenate((p, interpolate(p, f, inserted))) for p in (result.vertices, result.sphere)
    )
    faces = np.concatenate((f, parts[len(near) :]))
    faces[near] = parts[: len(near)]
    caps = result.mesh.caps
    if caps is not None:
        caps = np.append(caps, caps[owner[len(near) :]])
    mesh = check_mesh(v, faces, caps=caps)
    found = certified(mesh, unfolded(mesh, unit_rows(x)))
    return replace(found, run=result.run), inserted, vertices


def _heights(w: FloatArray, parts: FloatArray) -> FloatArray:
    """Measure the distance of a point inside the sides (k, 3) of triangles; all are given by barycentric weights."""
    starts = np.roll(parts, -1, axis=1).reshape(-1, 3)
    sides = np.roll(parts, 1, axis=1).reshape(-1, 3) - starts
    twice = row_crosses(starts - w, sides).sum(axis=1)  # of triangles in the plane of sum 1
    return np.asarray(twice / np.sqrt(row_dots(sides, sides))).reshape(-1, 3)
