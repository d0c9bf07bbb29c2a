"""Repair of input meshes, on request only, as far as no new geometry has to be invented."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..errors import MeshError, own_errstate
from .arrays import BoolArray, FloatArray, IntArray, check_rows, check_triangles, weld
from .check import check_mesh
from .edges import components, direction_components, edge_keys
from .measure import enclosed_volume


@dataclass(frozen=True, eq=False)
class RepairedMesh:
    """A closed, outward oriented genus-0 mesh, and what its rows were in the input. Unpacks to ``v, f``.

    Attributes
    ----------
    v : (n, 3) float64 array
        Vertices, rows of the input.
    f : (m, 3) int64 array
        Faces.
    vertex_source : (n,) int64 array
        Row of the input that each vertex comes from.
    face_source : (m,) int64 array
        Row of the input that each face comes from.
    vertex_image : (n_input,) int64 array
        Vertex that each row of the input became, -1 for those that were dropped.
    actions : tuple of str
        What was done, a phrase each; empty for a mesh that was sound.
    """

    v: FloatArray
    f: IntArray
    vertex_source: IntArray
    face_source: IntArray
    vertex_image: IntArray
    actions: tuple[str, ...]

    def __iter__(self) -> Iterator[Any]:
        return iter((self.v, self.f))

    def __repr__(self) -> str:
        return f"RepairedMesh({len(self.v)} vertices, {len(self.f)} faces; {'; '.join(self.actions) or 'nothing done'})"


@own_errstate
def repair_mesh(v: ArrayLike, f: ArrayLike, keep_largest: bool = False) -> RepairedMesh:
    """Repair what keeps a surface from being a closed, oriented genus-0 mesh, where that needs no new geometry.

    Welds coincident vertices along open edges, drops faces with a repeated index, surplus copies of faces and
    unreferenced vertices, makes the orientation consistent and outward, and gives each of the sheets that
    touch at a vertex one of its own. Coincident vertices elsewhere are left alone: thin sheets have them.

    Parameters
    ----------
    v : (n, 3) array_like
        Vertex positions.
    f : (m, 3) array_like
        Faces as 0-based vertex indices.
    keep_largest : bool
        Keep the component with the most faces and drop the others; by default several are refused.

    Returns
    -------
    RepairedMesh
        The mesh, index maps to the input and what was done.

    Raises
    ------
    MeshError
        If that is not enough: holes, handles, surplus sheets, several components, NaN.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1], [9, 9, 9]]
    >>> ism.repair_mesh(v, [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 2, 3]]).actions
    ('dropped 1 unreferenced vertex', 'reversed 1 face to agree with neighbours')
    """
    vertices, faces = check_rows(v, name="vertices"), check_triangles(f)
    low, high = int(faces.min()), int(faces.max())
    if low < 0 or high >= len(vertices):
        check_mesh(vertices, faces)  # raises
    work = _Work(vertices, faces)
    work.weld_open_edges()
    work.drop_repeated_indices()
    work.drop_copies()
    work.drop_components(keep_largest)
    work.drop_unreferenced()
    work.orient()
    work.split_pinched()
    work.turn_outward()
    try:
        check_mesh(work.v, work.f)
    except MeshError as error:
        done = "; ".join(work.actions) or "nothing"
        raise MeshError(f"repair (done: {done}) is not enough: {error}") from None
    return RepairedMesh(work.v, work.f, work.vertex_source, work.face_source, work.image, tuple(work.actions))


class _Work:
    """A mesh under repair, with its index maps; each method repairs one kind of fault and lists it in `actions`."""

    def __init__(self, v: FloatArray, f: IntArray) -> None:
        self.v, self.f = v, f
        self.vertex_source, self.face_source = np.arange(len(v)), np.arange(len(f))
        self.image = np.arange(len(v))
        self.actions: list[str] = []

    def weld_open_edges(self) -> None:
        start, stop = self.f.ravel(), self.f[:, [1, 2, 0]].ravel()
        _, index, count = np.unique(edge_keys(start, stop, len(self.v)), return_inverse=True, return_counts=True)
        open_edges = count[index] == 1
        rim = np.unique(np.concatenate([start[open_edges], stop[open_edges]]))
        v, index = weld(self.v[rim])
        if len(v) == len(rim):
            return
        target = np.arange(len(self.v))
        target[rim] = rim[np.unique(index, return_index=True)[1]][index]
        self.f, self.image = target[self.f], target[self.image]
        self._note("welded", len(rim) - len(v), "coincident vertex", "coincident vertices", "along open edges")

    def drop_repeated_indices(self) -> None:
        a, b, c = self.f.T
        bad = (a == b) | (b == c) | (c == a)
        self._keep_faces(~bad)
        self._note("dropped", int(bad.sum()), "face", "faces", "with a repeated index")

    def drop_copies(self) -> None:
        """Where an edge has more than two faces, keep the first of those with the same corners."""
        keys = edge_keys(self.f.ravel(), self.f[:, [1, 2, 0]].ravel(), len(self.v))
        _, index, count = np.unique(keys, return_inverse=True, return_counts=True)
        crowded = (count[index] > 2).reshape(-1, 3).any(axis=1)
        if not crowded.any():
            return
        copy = np.ones(len(self.f), dtype=bool)
        copy[np.unique(np.sort(self.f, axis=1), axis=0, return_index=True)[1]] = False
        self._keep_faces(~(copy & crowded))
        self._note("dropped", int((copy & crowded).sum()), "surplus copy of a face", "surplus copies of faces")

    def drop_components(self, keep_largest: bool) -> None:
        if not keep_largest or len(self.f) == 0:
            return
        first, second = self._twins()
        number, label = components(first // 3, second // 3, len(self.f))
        self._keep_faces(label == np.argmax(np.bincount(label)))
        self._note("dropped", number - 1, "smaller component", "smaller components")

    def drop_unreferenced(self) -> None:
        used = np.zeros(len(self.v), dtype=bool)
        used[self.f] = True
        lost = ~used & (self.image == np.arange(len(self.v)))  # those that were welded are not lost
        number = np.where(used, np.cumsum(used) - 1, -1)
        self.f, self.image = number[self.f], number[self.image]
        self.v, self.vertex_source = self.v[used], self.vertex_source[used]
        self._note("dropped", int(lost.sum()), "unreferenced vertex", "unreferenced vertices")

    def orient(self) -> None:
        """Reverse the fewest faces of each component that make neighbours agree."""
        first, second = self._twins()
        i, j, m = first // 3, second // 3, len(self.f)
        start = self.f.ravel()
        clash = start[first] == start[second]
        if not clash.any():
            return
        forward, backward = direction_components(i, j, clash, m)
        if (forward == backward).any():
            return  # not orientable: `check_mesh` refuses it
        _, label = components(i, j, m)
        seed = np.unique(label, return_index=True)[1]
        reverse = forward != forward[seed][label]
        reverse ^= (np.bincount(label, weights=reverse) * 2 > np.bincount(label))[label]
        self.f = np.where(reverse[:, None], self.f[:, ::-1], self.f)
        self._note("reversed", int(reverse.sum()), "face", "faces", "to agree with neighbours")

    def split_pinched(self) -> None:
        """Give each fan of faces around a vertex a vertex of its own."""
        first, second = self._twins()
        start = self.f.ravel()
        if 2 * len(first) != len(start) or (start[first] == start[second]).any():
            return  # open or not orientable: `check_mesh` refuses it
        onward = [3 * (h // 3) + (h + 1) % 3 for h in (first, second)]
        fans, fan = components(np.r_[first, second], np.r_[onward[1], onward[0]], len(start))
        vertex = start[np.unique(fan, return_index=True)[1]]  # of each fan
        extra = np.ones(fans, dtype=bool)
        extra[np.unique(vertex, return_index=True)[1]] = False
        if not extra.any():
            return
        number = np.where(extra, len(self.v) + np.cumsum(extra) - 1, vertex)
        self.f = number[fan].reshape(-1, 3)
        self.v = np.concatenate([self.v, self.v[vertex[extra]]])
        self.vertex_source = np.concatenate([self.vertex_source, self.vertex_source[vertex[extra]]])
        self._note("split", len(np.unique(vertex[extra])), "vertex", "vertices", "where sheets touch")

    def turn_outward(self) -> None:
        if not np.isfinite(self.v).all() or len(self.f) == 0:
            return
        if enclosed_volume(self.v, self.f) < 0:
            self.f = np.ascontiguousarray(self.f[:, ::-1])
            self.actions.append("turned the surface outward")

    def _keep_faces(self, keep: BoolArray) -> None:
        self.f, self.face_source = np.ascontiguousarray(self.f[keep]), self.face_source[keep]

    def _twins(self) -> tuple[IntArray, IntArray]:
        """Half-edges (3 * face + corner) in pairs, of the edges that have exactly two faces."""
        keys = edge_keys(self.f.ravel(), self.f[:, [1, 2, 0]].ravel(), len(self.v))
        order = np.argsort(keys, kind="stable")
        _, first, count = np.unique(keys[order], return_index=True, return_counts=True)
        pairs = first[count == 2]
        return order[pairs], order[pairs + 1]

    def _note(self, verb: str, count: int, singular: str, plural: str, where: str = "") -> None:
        if count:
            self.actions.append(f"{verb} {count} {singular if count == 1 else plural} {where}".rstrip())
