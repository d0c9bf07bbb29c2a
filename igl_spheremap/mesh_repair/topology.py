"""The components of any triangles, their boundary loops and handles, and their faults as a surface."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..mesh.arrays import BoolArray, IntArray
from ..mesh.edges import (
    components,
    direction_components,
    fans,
    marked,
    next_corners,
    shared_edges,
    sides,
)


@dataclass(frozen=True)
class Component:
    """A connected part of a mesh, cut where more than two faces meet in an edge, or sheets touch at a vertex.

    Attributes
    ----------
    vertices, faces : int
        Their numbers.
    boundary_loops : tuple of int
        The edges of each, the longest first; none if it is closed.
    handles : int or None
        0 for a sphere and a disk; None if it is not orientable.
    part : int or None
        The number K by which FILE:K names its closed part; None if that is open.
    """

    vertices: int
    faces: int
    boundary_loops: tuple[int, ...]
    handles: int | None
    part: int | None


@dataclass(frozen=True)
class Topology:
    """The components and the faults of any triangles.

    Attributes
    ----------
    edges : int
        Of faces with three different vertices.
    components : tuple of Component
        The one with the most faces first.
    nonmanifold_edges : int
        Edges of more than two faces.
    nonmanifold_vertices : int
        Vertices around which faces form several fans.
    reversed_edges : int
        Edges along which both faces run in the same direction.
    out_of_range : int
        Faces that name a vertex which is not there.
    repeated_indices : int
        Faces that name a vertex twice.
    copies : int
        Faces with the corners of an earlier one.
    unreferenced : int
        Vertices in no face.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.sphere(42)
    >>> found = ism.info(v, f[[0, 0, 1]]).topology
    >>> found.copies, found.nonmanifold_edges, found.unreferenced
    (1, 0, 37)
    """

    edges: int
    components: tuple[Component, ...]
    nonmanifold_edges: int
    nonmanifold_vertices: int
    reversed_edges: int
    out_of_range: int
    repeated_indices: int
    copies: int
    unreferenced: int


def closed_parts(f: IntArray, n: int) -> list[IntArray]:
    """The faces of each component of a mesh of n vertices that has no boundary, in the order of their first faces.

    Faces with a repeated index belong to their components, but close nothing.

    >>> [part.tolist() for part in closed_parts(np.array([[4, 5, 6], [0, 1, 2], [0, 2, 1], [4, 4, 5]]), 7)]
    [[1, 2]]
    """
    inside, usable = usable_faces(f, n)
    corners = f[inside]
    number, label = components(corners.ravel(), np.roll(corners, -1, axis=1).ravel(), n)
    keys, edge, _, _ = shared_edges(f[usable], n)
    closed = marked(label[keys // n], number)
    closed[label[keys[np.bincount(edge) == 1] // n]] = False
    of_face = label[np.where(inside, f[:, 0], 0)]
    order = np.flatnonzero(inside & closed[of_face])
    order = order[np.argsort(of_face[order], kind="stable")]
    if not len(order):
        return []
    parts = np.split(order, np.flatnonzero(np.diff(of_face[order])) + 1)
    return sorted(parts, key=lambda part: int(part[0]))


def usable_faces(f: IntArray, n: int) -> tuple[BoolArray, BoolArray]:
    """Of each face whether its indices are in range of n vertices, and whether it has three different ones, too."""
    inside = np.asarray(((f >= 0) & (f < n)).all(axis=1))
    a, b, c = f.T
    usable: BoolArray = inside & (a != b) & (b != c) & (c != a)
    return inside, usable


def topology_of(f: IntArray, n: int) -> Topology:
    """Look at any faces over n vertices.

    >>> topology_of(np.array([[0, 1, 2], [0, 2, 3]]), 4).components
    (Component(vertices=4, faces=2, boundary_loops=(4,), handles=0, part=None),)
    """
    inside, usable = usable_faces(f, n)
    part = np.full(len(f), -1)  # the number of the closed part of each face
    for k, faces in enumerate(closed_parts(f, n)):
        part[faces] = k
    part, f = part[usable], f[usable]
    keys, edge, first, second = shared_edges(f, n)
    start = f.ravel()
    number, label = components(first // 3, second // 3, len(f))
    clash = sides(f)[0][first] == sides(f)[0][second]
    forward, backward = direction_components(first // 3, second // 3, clash, len(f))
    orientable = ~marked(label[forward == backward], number)
    count, fan = fans(f, first, second)
    one = np.unique(fan, return_index=True)[1]  # a corner of each fan
    half = np.flatnonzero(~marked(np.r_[first, second], f.size))
    corner = fan.astype(np.int64)
    begin, end = (corner[each] for each in next_corners(half))
    loop = components(begin, end, count)[1][begin]
    _, where, length = np.unique(loop, return_index=True, return_counts=True)
    owner = label[half[where] // 3]
    vertices, faces, inner, outer, around = (
        np.bincount(each, minlength=number)
        for each in (label[one // 3], label, label[first // 3], label[half // 3], owner)
    )
    edges = inner + outer
    handles = (2 - (vertices - edges + faces) - around) // 2
    lengths: list[list[int]] = [[] for _ in range(number)]
    for k in np.argsort(-length, kind="stable").tolist():
        lengths[owner[k]].append(int(length[k]))
    a_face = np.unique(label, return_index=True)[1]
    found = []
    for k in np.argsort(-faces, kind="stable").tolist():
        genus, closed_part = None, None
        if orientable[k]:
            genus = int(handles[k])
        if part[a_face[k]] >= 0:
            closed_part = int(part[a_face[k]])
        sizes = int(vertices[k]), int(faces[k])
        found.append(Component(*sizes, tuple(lengths[k]), genus, closed_part))
    return Topology(
        edges=len(keys),
        components=tuple(found),
        nonmanifold_edges=int((np.bincount(edge) > 2).sum()),
        nonmanifold_vertices=int((np.bincount(start[one]) > 1).sum()),
        reversed_edges=int(clash.sum()),
        out_of_range=int((~inside).sum()),
        repeated_indices=int((inside & ~usable).sum()),
        copies=len(f) - len(np.unique(np.sort(f, axis=1), axis=0)),
        unreferenced=n - len(np.unique(start)),
    )
