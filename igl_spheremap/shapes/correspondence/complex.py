"""A part of a closed triangulation whose sides collapse."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

#: Corners of faces, counter-clockwise, by the faces' numbers.
Faces = Mapping[int, tuple[int, ...]]


class Complex:
    """Triangles by their numbers, and the triangles around each vertex.

    Each side at a vertex whose triangles are all here has two of them, which run it in opposite directions. Collapses
    keep that. `collapsed` returns its new faces by the numbers of those that they replace; `put` makes them.

    Attributes
    ----------
    faces : dict of int to tuple of int
        The corners of each face.
    around : dict of int to set of int
        The faces at each vertex.
    """

    def __init__(self, faces: Faces) -> None:
        self.faces: dict[int, tuple[int, ...]] = {}
        self.around: dict[int, set[int]] = {}
        self.put(faces)

    def put(self, faces: Faces, gone: Iterable[int] = ()) -> None:
        """Put faces in the place of the faces of the same numbers, and take out those in `gone`."""
        for i in (*faces, *gone):
            for v in self.faces.pop(i, ()):
                self.around[v].discard(i)
        for i, corners in faces.items():
            self.faces[i] = corners
            for v in corners:
                self.around.setdefault(v, set()).add(i)

    def neighbours(self, v: int) -> set[int]:
        """Return the other ends of the sides at a vertex."""
        return {w for i in self.around[v] for w in self.faces[i]} - {v}

    def collapsed(self, out: int, into: int) -> tuple[Faces, set[int]] | None:
        """Return the faces around a side once `out` lies at `into`, and the two faces at the side, which go.

        If both have other common neighbours than the two beside the side, None: the surface would touch itself.
        """
        if len(self.neighbours(out) & self.neighbours(into)) != 2:
            return None
        gone = self.around[out] & self.around[into]
        kept = (self.around[out] | self.around[into]) - gone
        moved = {out: into}
        return {i: tuple(moved.get(v, v) for v in self.faces[i]) for i in kept}, gone
