"""Why a mesh is refused: what is wrong, where, and which call repairs it. Nothing here runs for sound meshes."""

from __future__ import annotations

from functools import cached_property
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from ..errors import MeshError, Remedy
from ..mesh.arrays import FloatArray, IntArray, count, examples, listed, own_unit, place
from ..mesh.edges import direction_components, pinched_vertices, shared_edges, sides
from .handles import short_loop
from .seam import TIPS
from .surface import Surface, holes_text
from .welding import weld_tolerance

#: Share of the faces that the largest component must have for the others to be dropped. If even it is smaller, the mesh
#: is a heap of pieces, none of which is the surface. A tenth is a choice.
_LEAST_PART = 0.1


#: Options of repairs, in the order in which these are made.
_REPAIRS = ("weld", "keep_largest", "holes", "handles", "cut")


def repair_by(function: str, **options: Any) -> Remedy:
    """A repair with those of its options that are set."""
    return Remedy(function, {name: options[name] for name in _REPAIRS if options.get(name)})


class Refusal:
    """The errors of a refused mesh: faces with indices in range, and its positions where they are known.

    `asked` is the repair that the mesh comes from; the call that an error suggests includes its options. A disk, which
    `repair_disk` makes, may have a boundary.
    """

    def __init__(self, f: IntArray, n: int, v: FloatArray | None, asked: Remedy) -> None:
        self.f, self.n, self.v, self.asked = f, n, v, asked
        self._closed = asked.function == "repair_mesh"

    def half_edges(self) -> NoReturn:
        """Refuse faces with a repeated index, or edges that are not shared by two opposite faces."""
        f, n = self.f, self.n
        a, b, c = f.T
        repeated = np.flatnonzero((a == b) | (b == c) | (c == a))
        if len(repeated):
            self.refuse(
                f"degenerate: {count(repeated, 'face')} with a repeated vertex index, {examples(repeated)}",
                "remove them",
            )
        start, stop = sides(f)
        keys, edge, first, second = shared_edges(f, n)
        ends, faces_at = np.column_stack((keys // n, keys % n)), np.bincount(edge)
        if (faces_at > 2).any():
            bad = ends[faces_at > 2]
            _, one, copies = np.unique(
                np.sort(f, axis=1), axis=0, return_index=True, return_counts=True
            )
            twice = one[copies > 1]
            hint = (
                f"{count(twice, 'face')} given twice, {examples(twice)}: remove the copies"
                if len(twice)
                else "split the surface there, or remove the surplus faces"
            )
            self.refuse(
                f"non-manifold edge: {count(bad, 'edge')} in more than two faces, {_edges(bad)}",
                hint,
            )
        if (faces_at < 2).any() and self._closed:
            self._open(np.column_stack((start, stop))[faces_at[edge] < 2])
        clash = start[first] == start[second]
        bad = ends[edge[first[clash]]]
        faces = np.column_stack((first // 3, second // 3))[clash]
        forward, backward = direction_components(first // 3, second // 3, clash, len(f))
        if (forward == backward).any():
            self.refuse(
                "not orientable: no choice of face directions agrees across all edges (a Klein bottle or "
                f"projective plane), it fails {_edges(bad[:1])}",
                "give an orientable surface",
            )
        self.refuse(
            f"inconsistent orientation: {count(bad, 'edge')} run in the same direction by both faces, e.g. "
            f"faces {listed(faces[0])} at edge {bad[0, 0]}-{bad[0, 1]}",
            "reverse faces until they agree",
        )

    def unreferenced(self, bad: IntArray) -> NoReturn:
        """Refuse vertices in no face."""
        self.refuse(
            f"unreferenced: {count(bad, 'vertex', 'vertices')} in no face, {examples(bad)}",
            "remove them",
        )

    def components(self, label: NDArray[np.int32]) -> NoReturn:
        """Refuse several components, given the component of each face."""
        sizes = np.sort(np.bincount(label))[::-1]
        self.refuse(
            f"{len(sizes)} components of {listed(sizes)} faces, face {int(np.argmax(label > 0))} is in the "
            "second one",
            "give one closed surface" if self._closed else "give one of them",
        )

    def characteristic(self, twin: NDArray[np.int32]) -> NoReturn:
        """Refuse pinched vertices, or else handles."""
        m = len(self.f)
        pinched = pinched_vertices(sides(self.f)[0], np.arange(3 * m), twin)
        if len(pinched):
            self.pinched(pinched)
        genus = (2 - (self.n - 3 * m // 2 + m)) // 2
        where = f"Euler characteristic {2 - 2 * genus}"
        if self.v is not None:
            loop = short_loop(own_unit(self.v)[0], self.f)
            where = (
                f"the shortest loop found has {len(loop)} edges, near {place(self.v[loop], self.v)}"
            )
        self.refuse(
            f"genus {genus}: {genus} handle{'s' * (genus > 1)} ({where}), and only genus 0 maps to a sphere",
            "cut and fill the handles",
        )

    def pinched(self, bad: IntArray) -> NoReturn:
        """Refuse vertices with several fans of faces."""
        self.refuse(
            f"non-manifold vertex: {count(bad, 'vertex', 'vertices')} where two sheets touch, "
            f"{examples(bad)}",
            "give each sheet a vertex of its own",
        )

    def _open(self, edges: IntArray) -> NoReturn:
        """Refuse edges with one face: holes, or seams whose two sides have vertices at the same places."""
        work, _, near = self._cleaned
        if near:
            self.refuse(
                f"open surface: {count(edges, 'boundary edge')}, {_edges(edges)}, whose vertices nearly "
                f"coincide: within {near:g} of the diagonal of the bounding box",
                "weld them",
            )
        if not work.sound or len(work.f) < _LEAST_PART * len(self.f):
            self.refuse(
                f"open surface: {count(edges, 'boundary edge')}, {_edges(edges)}", "close the holes"
            )
        if not work.rims:
            self.refuse(
                f"open surface: {count(edges, 'boundary edge')}, {_edges(edges)}",
                "weld the coincident vertices along them",
            )
        self.refuse(
            f"open surface: {holes_text(work.v, work.rims, places=self.v is not None)}, {_edges(edges)}",
            "close the holes",
        )

    @cached_property
    def _cleaned(self) -> tuple[Surface, int, float]:
        """The mesh, as far as it is repaired without new geometry, how many components it had, and how it was welded.

        Vertices that nearly coincide are welded where that leaves fewer components and holes.
        """
        work, parts = self._clean(0.0)
        near = weld_tolerance(self.v, self.f) if self.v is not None else None
        if near is not None:
            joined, fewer = self._clean(near)
            if joined.sound and fewer + len(joined.rims) < parts + len(work.rims):
                return joined, fewer, near
        return work, parts, 0.0

    def _clean(self, near: float) -> tuple[Surface, int]:
        apart = np.arange(self.n)[:, None] * np.ones(3)
        work = Surface(apart if self.v is None else self.v, self.f)
        return work, work.clean(keep_largest=True, weld=near)

    def refuse(self, what: str, hint: str) -> NoReturn:
        """Raise the error with the hint, and the repair that follows it, if there is one."""
        remedy = None
        if self._cleaned[0].sound:
            work, parts, near = self._cleaned
            if len(work.f) < _LEAST_PART * len(self.f):
                raise MeshError(
                    f"{what}; join the {parts} components, the largest has {count(work.f, 'face')}"
                )
            loops = len(work.rims)
            work.fill_holes()
            cut = TIPS if not self._closed and (work.genus or not loops) else 0
            stays = not self._closed and not cut
            needed = {
                "weld": near,
                "keep_largest": parts > 1,
                "holes": loops > stays and "fill",
                "handles": work.genus > 0 and "cut",
                "cut": cut,
            }
            remedy = repair_by(
                self.asked.function,
                **{**self.asked.options, **{k: x for k, x in needed.items() if x}},
            )
        raise MeshError(f"{what}; {hint}", remedy)


def _edges(edges: NDArray[Any]) -> str:
    return "e.g. edge " + ", ".join(f"{int(i)}-{int(j)}" for i, j in edges[:3])
