"""Why a mesh is refused: the fault, its place, and the call that repairs it. Nothing here runs for sound meshes."""

from __future__ import annotations

from functools import cached_property
from typing import Any, NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import MeshError, Remedy
from ..mesh.arrays import (
    FloatArray,
    IntArray,
    count,
    examples,
    listed,
    listed_words,
    mean_position,
    own_unit,
    plural,
)
from ..mesh.check import check_indices
from ..mesh.edges import direction_components, pinched_vertices, shared_edges, sides
from . import REPAIRS
from .handles import short_loop
from .polygons import polygons_in, triangulated
from .surface import Surface, holes_text, percent
from .topology import usable_faces
from .welding import weld_tolerance

#: The way to read one part of a file.
_ONE_PART = Remedy("read_mesh", given="'FILE:K'")


def repair_by(function: str, options: dict[str, Any]) -> Remedy:
    """A repair with those of its options that differ from the defaults."""
    known = {name: options.get(name, default) for name, default in REPAIRS.items()}
    return Remedy(function, {key: value for key, value in known.items() if value != REPAIRS[key]})


class Refusal:
    """The errors of a refused mesh: faces with indices in range, and its positions if known.

    `asked` is the repair that the mesh comes from, with all options given so far, and `work` the surface under that
    repair. Sentences have the input's numbers, and the suggested call was tried on the input. A disk, which
    `repair_disk` makes, may have a boundary.
    """

    def __init__(
        self, f: IntArray, n: int, v: FloatArray | None, asked: Remedy, work: Surface | None = None
    ) -> None:
        self.f, self.n, self.v, self.asked = f, n, v, asked
        self._closed = asked.function == "repair_mesh"
        if work is None:
            if v is None:  # random positions coincide nowhere
                v = np.random.default_rng(0).random((n, 3))
            work = Surface(v, f)
        self._work = work

    def half_edges(self) -> NoReturn:
        """Refuse faces with a repeated index, or edges that are not shared by two opposite faces."""
        f, n = self.f, self.n
        repeated = np.flatnonzero(~usable_faces(f, n)[1])
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
            hint = "part the sheets that meet there, and drop the faces that are left over"
            if len(twice):
                hint = f"{count(twice, 'face')} given twice, {examples(twice)}: remove the copies"
            self.refuse(
                f"non-manifold edge: {count(bad, 'edge')} in more than two faces, {self._edges(bad)}",
                hint,
            )
        if (faces_at < 2).any() and self._closed:
            self._open(np.column_stack((start, stop))[faces_at[edge] < 2])
        clash = start[first] == start[second]
        bad = ends[edge[first[clash]]]
        faces = self._work.face_source[np.column_stack((first // 3, second // 3))[clash][0]]
        forward, backward = direction_components(first // 3, second // 3, clash, len(f))
        if (forward == backward).any():
            self.refuse(
                "not orientable: no choice of face directions agrees across all edges (a Klein bottle or "
                f"projective plane), it fails {self._edges(bad[:1])}",
                "give an orientable surface",
            )
        self.refuse(
            f"inconsistent orientation: {count(bad, 'edge')} run in the same direction by both faces, "
            f"{self._edges(bad[:1])}, faces {listed(faces)}",
            "reverse faces until they agree",
        )

    def several_loops(self, loops: list[IntArray]) -> NoReturn:
        """Refuse several boundary loops of a disk."""
        assert self.v is not None
        sizes = listed_words(list(map(len, loops)))
        near = [mean_position(self.v[each], self.v) for each in loops[:2]]
        joined = repair_by("repair_disk", {**self.asked.options, "cut": max(2, len(loops))})
        self.refuse(
            f"{len(loops)} boundary loops, of {sizes} edges, near {near[0]} and {near[1]}",
            f"a disk has one: join them by a cut ({joined} does), or fill the others",
        )

    def not_finite(self, bad: IntArray) -> NoReturn:
        """Refuse vertices with coordinates that are not finite."""
        self.refuse(
            f"not finite: {count(bad, 'vertex', 'vertices')} with NaN or infinite coordinates, "
            f"{examples(bad)}",
            "correct them, or remove them with their faces",
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
        second = self._work.face_source[int(np.argmax(label > 0))]
        self.refuse(
            f"{len(sizes)} components of {listed(sizes)} faces, face {second} is in the second one",
            f"give one of them, by {_ONE_PART}, or keep the largest",
        )

    def characteristic(self, twin: NDArray[np.int32]) -> NoReturn:
        """Refuse pinched vertices, or else handles."""
        m = len(self.f)
        pinched = pinched_vertices(self.f, np.arange(3 * m), twin)
        if len(pinched):
            self.pinched(pinched)
        genus = (2 - (self.n - 3 * m // 2 + m)) // 2
        where = f"Euler characteristic {2 - 2 * genus}"
        if self.v is not None:
            loop = short_loop(own_unit(self.v)[0], self.f)
            where = f"the shortest loop found has {len(loop)} edges, near {mean_position(self.v[loop], self.v)}"
        self.refuse(
            f"genus {genus}: {plural(genus, 'handle')} ({where}), and only genus 0 maps to a sphere",
            "cut and fill the handles",
        )

    def pinched(self, bad: IntArray) -> NoReturn:
        """Refuse vertices with several fans of faces."""
        self.refuse(
            f"non-manifold vertex: {count(bad, 'vertex', 'vertices')} where two sheets touch, "
            f"{examples(self._work.vertex_source[bad])}",
            "give each sheet a vertex of its own",
        )

    def _open(self, edges: IntArray) -> NoReturn:
        """Refuse edges with one face: holes, or seams whose two sides don't share their vertices."""
        work, near = self._cleaned
        what, hints, rims = count(edges, "boundary edge"), list[str](), work.rims
        if work.sound and rims:
            what = holes_text(work.v, rims, places=self.v is not None)
        seam = ""
        if near:
            seam = f", whose vertices nearly coincide: within {near:g} of the diagonal of the bounding box"
        if work.welded:
            hints.append("weld the coincident vertices along them")
        if work.stitched:
            hints.append("split the faces on whose edges other vertices lie")
        if work.parts > 1 and self._remedy is None:
            hints.append(f"join the {work.parts} components")
        elif work.parts > 1:
            hints.append(
                f"of {work.parts} components give one, by {_ONE_PART}, or keep the largest"
            )
        if rims or not hints:
            hints.append("close the holes")
        self.refuse(f"open surface: {what}, {self._edges(edges)}{seam}", listed_words(hints))

    def _edges(self, edges: IntArray) -> str:
        """Three edges of (k, 2), by the input's numbers; if a repair has renumbered them, also the place of the
        first."""
        rows = self._work.vertex_source[edges]
        known = rows[(rows >= 0).all(axis=1)][:3].tolist()
        text = "e.g. edge " + ", ".join(f"{i}-{j}" for i, j in known)
        if not known:
            text = "on new faces"
        if self._work.actions:
            text += f" near {mean_position(self._work.v[edges[0]], self._work.v)}"
        return text

    @cached_property
    def _cleaned(self) -> tuple[Surface, float]:
        """The input, as far as it is repaired without new geometry, and the tolerance by which it was welded.

        If that leaves fewer components and holes, nearly coincident vertices are welded.
        """
        given = self.asked.options.get("weld", 0.0)
        work = self._clean(given)
        near = weld_tolerance(*self._work.given)
        if near is not None and near != given:
            joined = self._clean(near)
            if joined.sound and joined.parts + len(joined.rims) < work.parts + len(work.rims):
                return joined, near
        return work, given

    def _clean(self, near: float) -> Surface:
        work = Surface(*self._work.given, closed=self._closed)
        work.clean(keep_largest=True, weld=near)
        return work

    def refuse(self, what: str, hint: str) -> NoReturn:
        """Raise the error with the hint, and the repair that mends it, if there is one, with the area that it keeps."""
        remedy = self._remedy
        kept = self._cleaned[0].kept
        if remedy is not None and self.v is not None and round(kept, 6) < 1:
            hint = f"{hint}, which keeps {percent(kept)} of the area"
        raise MeshError(f"{what}; {hint}", remedy)

    @cached_property
    def _remedy(self) -> Remedy | None:
        """The repair by which the input passes the check; None if none does, or only the one that failed."""
        work, near = self._cleaned
        if not work.sound or not len(work.f):
            return None
        loops, parts = len(work.rims), work.parts
        work.fill_holes()
        if self._closed and len(work.v) < 4:
            return None
        options = dict(self.asked.options)
        options["weld"] = near
        options["keep_largest"] = parts > 1
        kept = 0
        if not self._closed and "cut" not in options:
            kept = 1
            if work.genus or not loops:
                options["cut"], kept = 4, 0  # tips
        if loops > kept and (self._closed or work.genus or "cut" not in self.asked.options):
            options["holes"] = "fill"
        if work.genus:
            options["handles"] = "cut"
        remedy = repair_by(self.asked.function, options)
        if remedy.options == self.asked.options and self._work.cleaned:
            return None
        return remedy


def refuse_polygons(v: FloatArray, f: ArrayLike) -> None:
    """Refuse faces that are an array of polygons."""
    if polygons_in(f) is None:
        return
    faces, rows, _ = triangulated(v, f)
    check_indices(faces, len(v))
    work = Surface(v, faces, rows)
    refusal = Refusal(faces, len(v), v, Remedy("repair_mesh"), work)
    refusal.refuse(
        f"faces are not triangles: {int(rows[-1]) + 1} faces, of {np.bincount(rows).max() + 2} corners",
        "triangulate them",
    )
