"""One surface on the stage, and the lens through which a sphere is seen."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from ...draw import palette
from ...mesh.arrays import FloatArray, IntArray
from ...samples import sphere
from ...sphere.rows import from_chart, row_crosses, row_dets, row_dots, to_chart
from .window import MATERIAL, linear, ps

Legend = palette.Ramp | tuple[str, palette.Colour]

_NONE = np.empty(0, dtype=np.int64)
_TINIEST = np.finfo(float).tiny

#: Planes of folded faces are drawn at this distance from the centre at least, so that no face of the sphere hides them.
_LIFT = 1.012
#: A folded face may be pushed out by this factor at the most.
_FARTHEST = 1.05
#: Folded faces whose image is smaller than this square get a dot to be seen at all.
_TINY = 0.008
_DOT = 0.014
#: Edges of up to so many folded faces are drawn; those of more would be all that is seen.
_EDGES = 10_000
_EDGE_WIDTH = 0.5
#: Distance from a surface at which its folded faces are drawn over a checkerboard.
_ABOVE = 0.004
#: Folded faces keep their colour in every light, to be found by it alone; polyscope applies no gamma to it.
_UNLIT = "flat"
#: Angle that most of a large cluster takes to each side of the place: the rest of the view shows what is around it.
_SPREAD = 0.6
#: Angle for one face; a cluster of k faces takes sqrt(k) as much, so that faces of all clusters look equally large.
_FACE = 0.1
#: Percentage of the corners of a cluster within that angle; the rest may be the ends of long faces.
_WITHIN = 95
#: Power of the strongest lens: beyond it the rounding of float64 shows.
_STRONGEST = 1e9
#: Directions in which the farthest vertices are looked for that must stay within the cell.
_DIRECTIONS = 162


@dataclass(frozen=True, eq=False)
class Lens:
    """Moebius map that magnifies angles at a unit vector `place` by `power`, with the place towards +z."""

    place: FloatArray = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    power: float = 1.0

    def __call__(self, x: FloatArray) -> FloatArray:
        """Apply to unit rows: scale the stereographic chart that is centred at the place.

        >>> import numpy as np
        >>> Lens(power=3.0)(np.array([[0.0, 0.6, 0.8], [0.0, 0.0, -1.0]])).round(12)
        array([[ 0.,  1.,  0.],
               [ 0.,  0., -1.]])
        """
        pole = self.place[None]
        return from_chart(self.power * to_chart(x, pole), pole) @ self.axes().T

    def axes(self) -> FloatArray:
        """Rows to the right, up and to the place: the shortest turn of the place to +z."""
        p, z = self.place, np.array([0.0, 0.0, 1.0])
        if p[2] < -1 + 1e-12:
            return np.diag([-1.0, 1.0, -1.0])
        return np.eye(3) - np.outer(p + z, p + z) / (1 + p[2]) + 2 * np.outer(z, p)


def follow(x: FloatArray, f: IntArray, folded: IntArray) -> Lens:
    """Lens on the largest cluster of folded faces; the plain view where there is none."""
    return look_at(x, f[folded[clusters(f[folded])[0]]]) if len(folded) else Lens()


def look_at(x: FloatArray, faces: IntArray) -> Lens:
    """Lens on faces of a map, given as rows of vertex indices."""
    corners = x[np.unique(faces)]
    place = corners[int(np.argmax(corners @ corners.mean(axis=0)))]
    radius = float(np.percentile(np.abs(to_chart(corners, place[None])), _WITHIN))  # 2 tan of half the angle
    spread = min(_SPREAD, _FACE * float(np.sqrt(len(faces))))
    return Lens(place, float(np.clip(2 * np.tan(spread / 2) / max(radius, _TINIEST), 1.0, _STRONGEST)))


def clusters(faces: IntArray) -> list[IntArray]:
    """Indices of faces, given as rows of vertex indices, that are connected by shared vertices; the largest set first.

    >>> [one.tolist() for one in clusters(np.array([[5, 6, 7], [0, 1, 2], [2, 3, 4]]))]
    [[1, 2], [0]]
    """
    names, local = np.unique(faces, return_inverse=True)
    local = local.reshape(-1, 3)
    tail, head = local[:, [0, 1]].ravel(), local[:, [1, 2]].ravel()
    links = coo_matrix((np.ones(len(tail), dtype=bool), (tail, head)), shape=(len(names), len(names)))
    label = connected_components(links, directed=False)[1][local[:, 0]]
    return sorted((np.flatnonzero(label == one) for one in np.unique(label)), key=len, reverse=True)


class Body:
    """A surface that fits into the unit ball: x to the right, y up, z towards the viewer.

    With `lift`, folded faces are drawn apart from the others, and to the front of them while they are `raised`; for
    images, where they lie under others.
    """

    def __init__(self, name: str, x: FloatArray, f: IntArray, *, lift: bool = False) -> None:
        self.name, self.f, self.lift = name, f, lift
        self.raised = True
        self.x = x
        self._farthest = x[[int(np.argmax(x @ way)) for way in sphere(_DIRECTIONS)[0]]]
        self.caption = ""
        self.legend: Legend | None = None
        self.visible = True
        self.version = 0
        self._outside = 1 if row_dets(*(x[f[:, k]] for k in range(3))).sum() >= 0 else -1
        self.mesh = _register(name, x, f[:, :: self._outside], MATERIAL)
        self.mesh.set_back_face_policy("cull")  # the back costs as much time as the front and is not seen
        self.points: dict[str, Any] = {}
        self._folded: Any = None
        self._colours: FloatArray | None = None
        self.paint(np.tile(palette.SURFACE, (len(f), 1)))

    def extent(self, turn: FloatArray) -> tuple[float, float]:
        """How far it reaches to a side, and up or down, when it is turned."""
        if self.lift:
            return 1.0, 1.0
        across, along = np.abs(self._farthest @ turn[:2].T).max(axis=0)
        return float(across), float(along)

    def set_positions(self, x: FloatArray) -> None:
        """Move the vertices; `paint` then moves the folded faces."""
        self.x = x
        self.mesh.update_vertex_positions(x)
        self.version += 1

    def paint(
        self, colours: FloatArray, folded: IntArray | None = None, checks: FloatArray | None = None
    ) -> None:
        """Colour the faces, (m, 3), those whose indices are in `folded` in their own colour.

        In place of the colours, `checks` shows a checkerboard of unit squares: coordinates (3 m, 2) of the corners.
        """
        folded = _NONE if folded is None else folded
        if checks is not None:
            both = (tuple(linear(np.array(colour))) for colour in palette.CHECKS)
            self.mesh.add_parameterization_quantity(
                "checks", checks, defined_on="corners", viz_style="checker", checker_size=1.0,
                checker_colors=tuple(both), enabled=True,
            )  # fmt: skip
        else:
            if colours is not self._colours:
                self._colours, self._linear = colours, linear(colours)
            shown = self._linear.copy()
            shown[folded] = linear(np.array(palette.FOLDED))
            self.mesh.add_color_quantity("colour", shown, defined_on="faces", enabled=True)
        self._bring_to_front(folded if self.lift or checks is not None else _NONE)
        self.version += 1

    def dots(self, label: str, positions: FloatArray, colour: palette.Colour, radius: float = 0.03) -> None:
        """Show (k, 3) points on the surface in place of those of that label; k = 0 takes them away."""
        name = f"{self.name} {label}"
        old = self.points.pop(label, None)
        if old is not None:
            ps.remove_point_cloud(name)
        if len(positions):
            cloud = ps.register_point_cloud(name, positions, color=colour, material=_UNLIT)
            self.points[label] = cloud, radius
        self.version += 1

    def move(self, centre: FloatArray, radius: float, turn: FloatArray, zoom: float) -> None:
        """Put the unit ball somewhere; dots don't grow with `zoom`, by which the radius was magnified."""
        _put(self.mesh, centre, radius, turn)
        if self._folded is not None:
            _put(self._folded, centre, radius, turn)
        for structure in self.structures():
            structure.set_enabled(self.visible)
        for cloud, size in self.points.values():
            cloud.set_radius(size * radius / zoom, relative=False)
            _put(cloud, centre, radius * _LIFT, turn)

    def structures(self) -> list[Any]:
        """All that polyscope draws of it."""
        folded = [] if self._folded is None else [self._folded]
        return [self.mesh, *folded, *(cloud for cloud, _ in self.points.values())]

    def show_edges(self, width: float) -> None:
        """Draw the edges of faces that are not folded; a width of 0 hides them."""
        self.mesh.set_edge_width(width)

    def remove(self) -> None:
        """Take the body off the stage."""
        for label in tuple(self.points):
            self.dots(label, np.empty((0, 3)), palette.FOLDED)
        self._bring_to_front(_NONE)
        ps.remove_surface_mesh(self.name)

    def _bring_to_front(self, folded: IntArray) -> None:
        if self._folded is not None:
            ps.remove_surface_mesh(f"{self.name} folded")
            self._folded = None
        tiny = np.empty((0, 3))
        if len(folded):
            a, b, c = (self.x[self.f[folded, k]] for k in range(3))
            normal = row_crosses(b - a, c - a)
            size = np.sqrt(row_dots(normal, normal))
            middle = (a + b + c) / 3
            depth = np.abs(row_dots(normal, a)) / np.maximum(size, _TINIEST)
            factor = np.clip(_LIFT / np.maximum(depth, _TINIEST), 1.0, _FARTHEST if self.raised else 1.0)
            corners = np.stack((a, b, c), axis=1) * factor[:, None, None]
            if not self.lift:
                corners += _ABOVE * self._outside * (normal / np.maximum(size, _TINIEST)[:, None])[:, None]
            own = np.arange(3 * len(folded)).reshape(-1, 3)
            self._folded = _register(f"{self.name} folded", corners.reshape(-1, 3), own, _UNLIT)
            self._folded.set_back_face_policy("identical")
            self._folded.set_color(palette.FOLDED)
            self._folded.set_edge_color(palette.FOLDED_EDGES)
            self._folded.set_edge_width(_EDGE_WIDTH if len(folded) <= _EDGES else 0.0)
            tiny = (middle * factor[:, None])[size < 2 * _TINY**2]
        self.dots("foldings", tiny, palette.FOLDED, _DOT)


def _register(name: str, x: FloatArray, f: IntArray, material: str) -> Any:
    mesh = ps.register_surface_mesh(name, x, f, material=material)
    mesh.set_edge_color(tuple(linear(np.array(palette.EDGES))))
    return mesh


def _put(structure: Any, centre: FloatArray, radius: float, turn: FloatArray) -> None:
    matrix = np.eye(4)
    matrix[:3, :3] = radius * turn
    matrix[:3, 3] = centre
    structure.set_transform(matrix)
