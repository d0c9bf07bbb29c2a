"""One surface on the grid."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...draw import palette
from ...draw.folds import ABOVE, NEARER, Marks
from ...mesh.arrays import BoolArray, FloatArray, IntArray
from ...samples import sphere
from ...sphere.rows import row_dets
from .colouring import Colouring
from .window import MATERIAL, linear, ps

#: Points (k, 3) on a surface, their colour, and their radius.
Dots = tuple[FloatArray, palette.Colour, float]

EDGE_WIDTH = 0.5
#: Folded faces keep their colour in every light, to be found by it alone; polyscope applies no gamma to it.
_UNLIT = "flat"


class Body:
    """A surface that fits into the unit ball: x to the right, y up, z towards the viewer.

    On an `image`, folded faces, which lie under others, are drawn in front. Those that would not be seen have `marks`;
    if the image is `magnified`, only those in front, since the others are no longer apart.
    """

    def __init__(self, name: str, x: FloatArray, f: IntArray, image: bool) -> None:
        self.name, self.f, self.image, self.x = name, f, image, x
        self.magnified, self.visible, self.version = False, True, 0
        # directions whose farthest vertices must stay within the cell
        self._farthest = x[[int(np.argmax(x @ way)) for way in sphere(162)[0]]]
        self._outside = 1
        if row_dets(*(x[f[:, k]] for k in range(3))).sum() < 0:
            self._outside = -1
        self.mesh = _register(name, x, f[:, :: self._outside], MATERIAL)
        # the back costs as much time as the front and is not seen
        self.mesh.set_back_face_policy("cull")
        self.mesh.set_selection_mode("vertices_only")
        self.points: dict[str, tuple[Any, float]] = {}
        self._folded: Any = None
        self._folds = np.empty(0, dtype=np.int64)
        self._look: tuple[float, bool] | None = None
        self._quantity = ""
        self._nearer = 0.0
        self._shown: Colouring | None = None
        self._colours: FloatArray | None = None

    def extent(self, turn: FloatArray) -> tuple[float, float]:
        """Its extent to a side, and up or down, when it is turned."""
        if self.image:
            return 1.0, 1.0
        across, along = np.abs(self._farthest @ turn[:2].T).max(axis=0)
        return float(across), float(along)

    def show(
        self, x: FloatArray, colours: Colouring, edges: float, dots: Mapping[str, Dots]
    ) -> None:
        """Move the vertices to (n, 3) positions, colour the faces, and draw their edges and dots."""
        moved = x is not self.x
        if moved:
            self.x = x
            self.mesh.update_vertex_positions(x)
        if moved or colours is not self._shown:
            self._shown = colours
            self._paint(colours)
        # On a sphere only the checkerboard is to be seen: thin faces would look like scratches.
        look = edges, self.image and colours.checks is not None
        if look != self._look:  # each call has polyscope compile its shaders anew
            self._look = look
            self.mesh.set_edge_width(look[0])
            self.mesh.set_smooth_shade(look[1])
        for label in {*self.points, *dots}:
            self._dot(label, *dots.get(label, (np.empty((0, 3)), palette.FOLDED, 0.0)))
        self.version += 1

    def _paint(self, colours: Colouring) -> None:
        folded, checks = colours.folded, colours.checks
        shown, self._quantity = self._quantity, "colour"
        if checks is not None:
            self._quantity = "checks"
        if checks is not None and shown == "checks":
            self.mesh.get_quantity_buffer("checks", "coords").update_data(checks)
        elif checks is not None:
            both = (tuple(linear(np.array(colour))) for colour in palette.CHECKS)
            self.mesh.add_parameterization_quantity(
                "checks", checks, defined_on="corners", viz_style="checker", checker_size=1.0,
                checker_colors=tuple(both), enabled=True,
            )  # fmt: skip
        else:
            if colours.colours is not self._colours:
                self._colours, self._linear = colours.colours, linear(colours.colours)
            painted = self._linear.copy()
            painted[folded] = linear(np.array(palette.FOLDED))
            if shown == "colour":
                self.mesh.get_quantity_buffer("colour", "colors").update_data(painted)
            else:
                self.mesh.add_color_quantity("colour", painted, defined_on="faces", enabled=True)
        self._marks = Marks.of(self.x, self.f[:, :: self._outside], folded, self.image)
        self._nearer = 0.0
        if len(self._marks.clusters) and self.image:
            self._nearer = NEARER
        elif checks is not None:
            self._nearer = ABOVE
        if not self.image and checks is None:
            folded = folded[:0]
        self._bring_to_front(folded)

    def marks(self, turn: FloatArray, pixels: float) -> tuple[FloatArray, BoolArray]:
        """Places (c, 3) of folds that are not seen if a unit takes `pixels`, and whether each faces the viewer."""
        places, front = self._marks.unseen(turn[2], pixels)
        shown = front & self.visible if self.magnified else np.full(len(front), self.visible)
        return places[shown], front[shown]

    def _dot(
        self, label: str, positions: FloatArray, colour: palette.Colour, radius: float
    ) -> None:
        """Show (k, 3) points under a label, in place of its earlier ones; with k = 0 remove them."""
        name = f"{self.name} {label}"
        if self.points.pop(label, None) is not None:
            ps.remove_point_cloud(name)
        if len(positions):
            cloud = ps.register_point_cloud(name, positions, color=colour, material=_UNLIT)
            self.points[label] = cloud, radius

    def move(
        self,
        centre: FloatArray,
        radius: float,
        turn: FloatArray,
        zoom: float,
        out: float = 1.012,
    ) -> None:
        """Put the unit ball somewhere; dots don't grow with `zoom`, by which the radius was magnified.

        They lie farther out than the surface by the factor `out`.
        """
        _put(self.mesh, centre, radius, turn)
        if self._folded is not None:
            _put(self._folded, centre + np.array([0.0, 0.0, self._nearer * radius]), radius, turn)
        for structure in self.structures():
            structure.set_enabled(self.visible)
        for cloud, size in self.points.values():
            cloud.set_radius(size * radius / zoom, relative=False)
            _put(cloud, centre, radius * out, turn)

    def structures(self) -> list[Any]:
        """Its structures in polyscope."""
        folded = [each for each in (self._folded,) if each is not None]
        return [self.mesh, *folded, *(cloud for cloud, _ in self.points.values())]

    def remove(self) -> None:
        """Take the body off the grid."""
        for structure in self.structures():
            structure.remove()

    def _bring_to_front(self, folded: IntArray, most: int = 10_000) -> None:
        """Draw folded faces before the others; if they are few, with edges: edges of many would hide all else."""
        corners = self.x[self.f[folded].ravel()]
        if len(folded) and np.array_equal(folded, self._folds):
            self._folded.update_vertex_positions(corners)
            return
        if self._folded is not None:
            self._folded.remove()
            self._folded = None
        self._folds = folded
        if len(folded):
            own = np.arange(3 * len(folded)).reshape(-1, 3)
            self._folded = _register(f"{self.name} folded", corners, own, _UNLIT)
            self._folded.set_back_face_policy("identical")
            self._folded.set_color(palette.FOLDED)
            self._folded.set_edge_color(palette.FOLDED_EDGES)
            width = 0.0
            if len(folded) <= most:
                width = EDGE_WIDTH
            self._folded.set_edge_width(width)


def _register(name: str, x: FloatArray, f: IntArray, material: str) -> Any:
    mesh = ps.register_surface_mesh(name, x, f, material=material)
    mesh.set_edge_color(tuple(linear(np.array(palette.EDGES))))
    return mesh


def _put(structure: Any, centre: FloatArray, radius: float, turn: FloatArray) -> None:
    matrix = np.eye(4)
    matrix[:3, :3] = radius * turn
    matrix[:3, 3] = centre
    structure.set_transform(matrix)
