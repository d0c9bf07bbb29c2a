"""A surface of any topology under repair: each step repairs one kind of fault, and reports it."""

from __future__ import annotations

import igl
import numpy as np
from numpy.typing import NDArray

from ..mesh.arrays import (
    BoolArray,
    FloatArray,
    IntArray,
    listed_words,
    mean_position,
    own_unit,
    plural,
)
from ..mesh.edges import (
    components,
    direction_components,
    edge_keys,
    fans,
    marked,
    next_corners,
    rims,
    shared_edges,
    sides,
)
from ..mesh.measure import enclosed_volume, face_areas
from .handles import cutting_loops
from .holes import cap, conormals, simple_rims
from .junctions import stitched
from .seam import seam
from .sheets import numbered, part_sheets
from .topology import usable_faces
from .welding import welded


class Surface:
    """Vertices and faces, the rows of the input that they come from (-1: new), and the actions.

    `rows` are those of the input that faces come from, their numbers by default, and `done` the actions before. The
    surface is to be `closed`, or else a disk.

    `clean` repairs all that needs no new geometry, and gives each fan of faces a vertex of its own. If `sound`, only
    holes (`rims`), handles (`genus`) and components (`parts`) remain; else there is no orientation.
    """

    def __init__(
        self,
        v: FloatArray,
        f: IntArray,
        rows: IntArray | None = None,
        done: tuple[str, ...] = (),
        closed: bool = True,
    ) -> None:
        self.given = self.v, self.f = v, f
        if rows is None:
            rows = np.arange(len(f))
        self.vertex_source, self.image, self.face_source = (
            np.arange(len(v)),
            np.arange(len(v)),
            rows,
        )
        self.actions, self._closed = list(done), closed
        self.welded, self.stitched, self.parts = 0, 0, 0
        self.cleaned = self.sound = False
        self.rims: list[IntArray] = []
        self._power = own_unit(v)[1]
        self._area = float(self._areas(f).sum())

    def clean(self, keep_largest: bool, weld: float = 0.0) -> None:
        """Repair all that needs no new geometry."""
        self.cleaned = True
        self._drop_not_finite()
        self._weld_open_edges(weld)
        self._drop_repeated_indices()
        self._stitch_junctions(weld)
        self._drop_copies()
        self._orient()
        self._part_sheets()
        self._orient()
        self._drop_components(keep_largest)
        self._drop_unreferenced()
        self.split_fans(np.empty(0, dtype=np.int64))

    @property
    def kept(self) -> float:
        """Share of the input's area that is left."""
        return self._share(self.f[self.face_source >= 0])

    @property
    def genus(self) -> int:
        """Number of handles, once the holes are filled."""
        return (2 - len(self.v) + len(self.f) // 2) // 2

    def _drop_not_finite(self) -> None:
        bad = np.asarray(~np.isfinite(self.v).all(axis=1))
        lost = int((bad & marked(self.f, len(self.v))).sum())
        if lost:
            self.image[bad] = -1
            at_them = np.asarray(bad[self.f].any(axis=1))
            self._keep_faces(~at_them)
            self.actions.append(
                f"dropped {plural(lost, 'vertex', 'vertices')} with NaN or infinite coordinates and "
                f"{plural(int(at_them.sum()), 'face')} at them"
            )

    def _weld_open_edges(self, tolerance: float) -> None:
        rim, first = welded(self.v, self.f, tolerance)
        target = np.append(np.arange(len(self.v)), -1)  # -1 stays
        target[rim] = first
        self.f, self.image = target[self.f], target[self.image]
        where = "along open edges"
        if tolerance:
            where = f"{where}, within {tolerance:g} of the diagonal"
        self.welded = int((rim != first).sum())
        self._note("welded", self.welded, "coincident vertex", where, "coincident vertices")

    def _drop_repeated_indices(self) -> None:
        _, usable = usable_faces(self.f, len(self.v))
        self._note("dropped", ~usable, "face", "with a repeated index")
        self._keep_faces(usable)

    def _stitch_junctions(self, tolerance: float) -> None:
        self.f, source = stitched(self.v, self.f, tolerance)
        self.face_source = self.face_source[source]
        self.stitched = int((np.bincount(source) > 1).sum())
        self._note("split", self.stitched, "face", "at vertices on their open edges")

    def _drop_copies(self) -> None:
        """If an edge has more than two faces, keep the first of those with the same corners."""
        edge = shared_edges(self.f, len(self.v))[1]
        surplus = np.any((np.bincount(edge)[edge] > 2).reshape(-1, 3), axis=1)
        surplus[np.unique(np.sort(self.f, axis=1), axis=0, return_index=True)[1]] = False
        self._keep_faces(~surplus)
        self._note("dropped", surplus, "surplus copy of a face", "", "surplus copies of faces")

    def _part_sheets(self) -> None:
        edges = int((np.bincount(shared_edges(self.f, len(self.v))[1]) > 2).sum())
        if not edges:
            return
        parted, owner, faces = part_sheets(own_unit(self.v)[0], self.f)
        surplus = ~marked(faces, len(self.f))
        if surplus.any():
            lost = plural(int(surplus.sum()), "face")
            self._drop_faces(surplus, f"{lost} left over at edges of more than two faces")
        self.f, self.v, self.vertex_source = parted, self.v[owner], self.vertex_source[owner]
        self._note("parted", edges, "edge", "where sheets meet")

    def _drop_components(self, keep_largest: bool) -> None:
        """Of several components keep the largest: by area, or, if a surface to be closed has a closed one, by
        volume."""
        first, second = self._twins()
        self.parts, label = components(first // 3, second // 3, len(self.f))
        if not keep_largest or self.parts < 2:
            return
        size = np.bincount(label, self._areas(self.f)).astype(np.float64)
        closed = 2 * np.bincount(label[first // 3], minlength=self.parts) == 3 * np.bincount(label)
        if self._closed and closed.any():
            size = _volumes(own_unit(self.v)[0], self.f, label)
        if size.any():
            size /= size.max()
        largest = np.argmax(np.round(size, 9))
        self._drop_faces(label != largest, plural(self.parts - 1, "smaller component"))

    def _drop_unreferenced(self) -> None:
        used = marked(self.f, len(self.v))
        lost = ~used & marked(self.image[self.image >= 0], len(self.v))  # not what was welded
        number = np.append(np.where(used, np.cumsum(used) - 1, -1), -1)  # -1 stays
        self.f, self.image = number[self.f], number[self.image]
        self.v, self.vertex_source = self.v[used], self.vertex_source[used]
        self._note("dropped", lost, "unreferenced vertex", "", "unreferenced vertices")

    def _orient(self) -> None:
        """Reverse the fewest faces of each component that make neighbours agree."""
        first, second = self._twins()
        i, j, m = first // 3, second // 3, len(self.f)
        start = sides(self.f)[0]
        clash = start[first] == start[second]
        if not clash.any():
            return
        forward, backward = direction_components(i, j, clash, m)
        if (forward == backward).any():
            return  # not orientable
        _, label = components(i, j, m)
        seed = np.unique(label, return_index=True)[1]
        reverse = forward != forward[seed][label]
        reverse ^= (np.bincount(label, weights=reverse) * 2 > np.bincount(label))[label]
        self.f = np.where(reverse[:, None], self.f[:, ::-1], self.f)
        self._note("reversed", reverse, "face", "to agree with neighbours")

    def split_fans(self, cut: IntArray, capped: bool = True) -> None:
        """Give each fan of faces around a vertex a vertex of its own, and find the rims; open the edges of keys `cut`.

        If a rim passes a vertex twice and caps of both holes will lie between its fans, these stay together.
        """
        start, corners, n = sides(self.f)[0], self.f.ravel(), len(self.v)
        keys, edge, first, second = shared_edges(self.f, n)
        if (np.bincount(edge) > 2).any() or (start[first] == start[second]).any():
            return
        self.sound = True
        shut = ~np.isin(keys[edge[first]], cut)
        first, second = first[shut], second[shut]
        number, fan = fans(self.f, first, second)
        vertex = corners[np.unique(fan, return_index=True)[1]]  # of each fan
        inner = next_corners(np.r_[first, second])[0]
        tail = np.flatnonzero(~marked(inner, len(corners)))  # from which an open edge runs
        parts: list[list[int]] = []
        joined = np.arange(number)
        for rim in rims(fan[next_corners(tail)[0]], fan[tail]):
            found = [(rim, rim[0])]
            if capped:
                found = list(simple_rims(rim, vertex[rim].tolist()))
            for part, closing in found:
                joined[closing] = joined[part[0]]
                parts.append(part)
        kept = np.unique(joined)
        owner = vertex[kept]
        row = np.empty(number, dtype=np.int64)
        row[kept], extra = numbered(owner, n)
        row = row[joined]
        self.rims = [row[part] for part in parts]
        self.f = row[fan].reshape(-1, 3)
        self.v = np.concatenate([self.v, self.v[owner[extra]]])
        self.vertex_source = np.concatenate([self.vertex_source, self.vertex_source[owner[extra]]])
        if not len(cut):
            touching = len(np.unique(owner[extra]))
            self._note("split", touching, "vertex", "where sheets touch", "vertices")

    def fill_holes(self, kept: int | None = None) -> None:
        """Close every rim by a cap, except one to keep."""
        left = []
        if kept is not None:
            left.append(self.rims.pop(kept))
        if self.rims:
            text = holes_text(self.v, self.rims)
            self._close_rims()
            self.actions.append(f"filled {text}")
        self.rims = left

    def cut_open(self, points: IntArray | int, keep_largest: bool) -> None:
        """Cut along edges (k, 2), or a tree that joins the boundary loops and vertices, or loops and tips by number."""
        if not isinstance(points, int) and points.ndim == 2:
            self._cut(points)
            self._drop_components(keep_largest)
            self._drop_unreferenced()
            return
        loops, joined = len(self.rims), []
        if loops:
            joined.append(plural(loops, "boundary loop"))
        if not isinstance(points, int):
            joined.append(plural(len(points), "vertex", "vertices"))
        elif points > loops:
            joined.append(plural(points - loops, "tip"))
        edges = seam(self.v, self.f, points, self.rims)
        self._cut(edges, f" between {listed_words(joined)}")

    def _cut(self, edges: IntArray, between: str = "") -> None:
        self.split_fans(edge_keys(edges[:, 0], edges[:, 1], len(self.v)), capped=False)
        self.actions.append(f"cut along {plural(len(edges), 'edge')}{between}")

    def cut_handles(self) -> None:
        """Cut the handles of a closed surface along short loops, and close the cuts by caps.

        The middle of a loop around a handle is in the body, that of a loop around a tunnel is not.
        """
        cuts: list[tuple[float, str]] = []
        while self.genus > 0:
            own, power = own_unit(self.v)
            v, further = own_unit(own - own.mean(axis=0))  # libigl makes float32 of positions
            loops = cutting_loops(v, self.f)
            middles = np.array([v[loop].mean(axis=0) for loop in loops])
            inside = np.abs(igl.fast_winding_number(v, self.f, middles)) > 0.5
            for loop, kind in zip(loops, np.where(inside, "handle", "tunnel"), strict=True):
                length = np.ldexp(
                    np.linalg.norm(v[loop] - v[np.roll(loop, 1)], axis=1).sum(), power + further
                )
                text = (
                    f"a {kind} loop of {len(loop)} edges and length {length:.3g} near "
                    f"{mean_position(self.v[loop], self.v)}"
                )
                cuts.append((length, text))
            n = len(self.v)
            self.split_fans(
                np.concatenate([edge_keys(loop, np.roll(loop, -1), n) for loop in loops])
            )
            self._close_rims()
        if cuts:
            texts = [text for _, text in sorted(cuts)]
            self.actions.append(f"cut {plural(len(cuts), 'handle')}, {listed_words(texts)}")

    def _close_rims(self) -> None:
        own, power = own_unit(self.v)
        v, f, n = [self.v], [self.f], len(self.v)
        after = np.concatenate([np.roll(rim, -1) for rim in self.rims])
        onward = conormals(own, self.f, np.concatenate(self.rims), after)
        ends = np.cumsum([len(rim) for rim in self.rims])
        for rim, out in zip(self.rims, np.split(onward, ends[:-1]), strict=True):
            points, faces = cap(own[rim], out)
            v.append(np.ldexp(points, power))
            f.append(np.append(rim, np.arange(n, n + len(points)))[faces])
            n += len(points)
        self.rims = []
        self.vertex_source = np.append(self.vertex_source, np.full(n - len(self.v), -1))
        self.v, self.f = np.concatenate(v), np.concatenate(f)
        self.face_source = np.append(
            self.face_source, np.full(len(self.f) - len(self.face_source), -1)
        )

    def turn_outward(self) -> None:
        """Reverse all faces of a closed surface that is inside out."""
        if enclosed_volume(own_unit(self.v)[0], self.f) < 0:
            self.f = np.ascontiguousarray(self.f[:, ::-1])
            self.actions.append("turned the surface outward")

    def _keep_faces(self, keep: BoolArray) -> None:
        self.f, self.face_source = np.ascontiguousarray(self.f[keep]), self.face_source[keep]

    def _drop_faces(self, drop: BoolArray, words: str) -> None:
        """Drop faces, and say their share of the input's area."""
        self.actions.append(f"dropped {words}, {percent(self._share(self.f[drop]))} of the area")
        self._keep_faces(~drop)

    def _areas(self, f: IntArray) -> FloatArray:
        """Areas of faces in the input's own unit, 0 if not finite."""
        areas = face_areas(np.ldexp(self.v, -self._power), f)
        return np.nan_to_num(areas, nan=0.0, posinf=0.0)

    def _share(self, f: IntArray) -> float:
        """The share of the input's area that faces have; 0 if it has none."""
        area = float(self._areas(f).sum())
        if not self._area:
            return area
        return area / self._area

    def _twins(self) -> tuple[IntArray, IntArray]:
        """Half-edges in pairs, of the edges that have exactly two faces."""
        return shared_edges(self.f, len(self.v))[2:]

    def _note(
        self,
        verb: str,
        things: BoolArray | int,
        one: str,
        where: str = "",
        several: str | None = None,
    ) -> None:
        """If there were any things, marked ones or a number, note the action on them."""
        number = int(np.sum(things))
        if number:
            self.actions.append(f"{verb} {plural(number, one, several)} {where}".rstrip())


def _volumes(v: FloatArray, f: IntArray, label: NDArray[np.int32]) -> FloatArray:
    """Volumes that components enclose, boundary loops being closed by cones from the middle."""
    corners = v[f]
    faces = np.bincount(label)[:, None]
    middle = np.column_stack(
        [np.bincount(label, corners[:, :, axis].mean(axis=1)) for axis in range(3)]
    )
    a, b, c = (corners - (middle / faces)[label][:, None]).transpose(1, 0, 2)
    return np.abs(np.bincount(label, np.einsum("ij,ij->i", a, np.cross(b, c))))


def percent(share: float) -> str:
    """A share in percent.

    >>> percent(0.5), percent(0.99999), percent(0.00001)
    ('50 percent', 'more than 99.9 percent', 'less than 0.1 percent')
    """
    if 0.999 < share < 1:
        return "more than 99.9 percent"
    if 0 < share < 0.001:
        return "less than 0.1 percent"
    return f"{100 * share:.3g} percent"


def holes_text(v: FloatArray, rims: list[IntArray], places: bool = True) -> str:
    """The holes' number and lengths, and the place of the longest.

    >>> holes_text(np.eye(4, 3), [np.array([0, 1, 2, 3]), np.array([0, 1, 2])])
    '2 holes (4 and 3 edges), the longest near (0.25, 0.25, 0.25)'
    """
    sizes = sorted(map(len, rims), reverse=True)
    text = f"{plural(len(rims), 'hole')} ({listed_words(sizes)} edges)"
    if not places:
        return text
    if len(rims) > 1:
        text = f"{text}, the longest"
    return f"{text} near {mean_position(v[max(rims, key=len)], v)}"
