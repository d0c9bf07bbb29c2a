"""A grid of surfaces that turn together, with captions, legends and insets: the layout of all pictures."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import lru_cache
from textwrap import wrap
from typing import Any

import numpy as np

from ...draw import palette
from ...draw.lens import Lens
from ...errors import legible
from ...mesh.arrays import FloatArray, IntArray
from .body import Body, Dots
from .colouring import Colouring, Legend
from .window import UNITS_PER_PIXEL, aim, imgui, pressed, ps, to_world

Place = tuple[int, int]

#: Actions of the mouse on every grid.
MOUSE = (
    "Drag to turn all, drag with the right button to shift, scroll to zoom, double-click or press R to reset. "
    "Click a vertex to mark it on all bodies; click beside it or press Escape to forget it. "
    "Numbers choose colours, L the whole sphere or the lens that fits, S writes a picture."
)

#: Pixels: width of the panel, what is left around a body, a line of text, and between an inset, or a text, and what is
#: next to it.
PANEL = 290
_MARGIN = 26
_LINE = 20
_GAP = 6
#: Radius of an inset, as a share of its cell's width.
_INSET = 0.13
#: Pixels: radius of the rings around a vertex that is marked and around the place of the lens, and of the marks of
#: folded faces that are not seen.
_RING = 9.0
_MARK = 4.0


@dataclass(frozen=True, eq=False)
class Part:
    """A surface inside the unit ball, with its appearance.

    Attributes
    ----------
    caption : str
        The text above it.
    x, f : arrays
        Positions (n, 3), and faces (m, 3).
    colours : Colouring
        Its colours; grey by default.
    image : bool
        Whether it is a map, whose folded faces are drawn in front.
    lens : Lens, optional
        Through which a sphere is seen. If it magnifies, the whole sphere is small in the corner, its place circled.
    legends : sequence
        The colours' meanings, below it.
    edges : float
        Width of the edges of faces; 0 without edges.
    dots : mapping
        Points on it by their names.
    visible : bool
        Whether it is drawn; its place stays.
    """

    caption: str
    x: FloatArray
    f: IntArray
    colours: Colouring | None = None
    image: bool = False
    lens: Lens | None = None
    legends: Sequence[Legend] = ()
    edges: float = 0.0
    dots: Mapping[str, Dots] = field(default_factory=dict)
    visible: bool = True


Rows = Sequence[Sequence[Part]]


class Grid:
    """Parts in rows; all turn together under the mouse.

    Dragging turns, dragging with the right button shifts, the wheel zooms, a double click resets. No body leaves its
    cell. A `panel` of this many pixels is kept free at the left edge, a strip of `foot` pixels at the lower edge.
    """

    def __init__(self, panel: int = PANEL, foot: int = 0) -> None:
        self.panel, self._foot = panel, foot
        self.rows = self.columns = 1
        self.parts: dict[Place, Part] = {}
        self.bodies: dict[Place, Body] = {}
        self.insets: dict[Place, Body] = {}
        self.turn = np.eye(3)
        self.zoom = 1.0
        self.shift = np.zeros(2)
        #: The vertex that was picked, marked on all bodies.
        self.picked: int | None = None
        self._laid_out: object = None
        self._pressed = np.zeros(2)

    @property
    def foot(self) -> float:
        """Pixels that are kept free at the lower edge; in small windows less: bodies have most of the height."""
        return min(self._foot, 0.28 * ps.get_window_size()[1])

    def show(self, rows: Rows) -> None:
        """Show parts in place of the earlier ones; polyscope is told of changes."""
        self.rows, self.columns = len(rows), max(map(len, rows))
        self.parts = {(i, k): part for i, row in enumerate(rows) for k, part in enumerate(row)}
        for bodies in (self.bodies, self.insets):
            for place, body in tuple(bodies.items()):
                part = self.parts.get(place)
                if part is None or part.f is not body.f or part.image != body.image:
                    bodies.pop(place).remove()
        for place, part in self.parts.items():
            colours, seen = part.colours, part.x
            if colours is None:
                colours = Colouring(np.tile(palette.SURFACE, (len(part.f), 1)))
            magnified = part.lens is not None and part.lens.power > 1
            if part.lens is not None:
                small = self._body(self.insets, "inset", place, part)
                small.visible = part.visible and magnified
                if magnified:
                    seen = part.lens(part.x)
                    small.show(part.x, colours, 0.0, {})
            body = self._body(self.bodies, "part", place, part)
            body.magnified, body.visible = magnified, part.visible
            body.show(seen, colours, part.edges, part.dots)

    def _body(self, bodies: dict[Place, Body], kind: str, place: Place, part: Part) -> Body:
        if place not in bodies:
            bodies[place] = Body(f"{kind} {place}", part.x, part.f, part.image)
        return bodies[place]

    @contextmanager
    def bare(self) -> Iterator[None]:
        """Leave no room for the panel, which then is not drawn: for pictures that a window writes."""
        room, self.panel = self.panel, 0
        self._laid_out = None
        try:
            yield
        finally:  # a picture that can't be written leaves the window as it was
            self.panel = room
            self._laid_out = None

    def cell(self, row: int, column: int) -> tuple[float, float, float, float]:
        """Left, top, width and height of a cell in pixels, captions and legends included."""
        width, height = ps.get_window_size()
        w, h = (width - self.panel) / self.columns, (height - self.foot) / self.rows
        return self.panel + column * w, row * h, w, h

    def draw(self) -> None:
        """Lay out changed parts, write captions and legends; to be called every frame."""
        everything = [*self.bodies.values(), *self.insets.values()]
        state = (
            tuple(ps.get_window_size()),
            self.turn.tobytes(),
            self.zoom,
            self.shift.tobytes(),
            tuple(body.version for body in everything),
        )
        if state != self._laid_out:
            self._laid_out = state
            aim(ps.get_window_size()[1])
            for place, body in self.bodies.items():
                body.move(*self.frame(place), self.turn, self.zoom)
            for place, body in self.insets.items():
                body.move(*self.inset_frame(place), self.turn, 1.0)
            self._clip()
        for place, body in self.bodies.items():
            self._annotate(place, self.parts[place])
            self._mark(place, body, self.frame(place))
            if self.picked is not None:
                self.ring(self.frame(place), body.x[self.picked], _RING, palette.PICKED)
        for place, body in self.insets.items():
            if body.visible:
                self._mark(place, body, self.inset_frame(place))
                self._circle(place, self.parts[place].lens or Lens())

    def _mark(self, place: Place, body: Body, frame: tuple[FloatArray, float]) -> None:
        """Dots over folded faces that are too small to be seen, rings around those that lie behind."""
        places, front = body.marks(self.turn, frame[1] / UNITS_PER_PIXEL)
        if not len(places):
            return
        left, top, w, h = self.cell(*place)
        at = self.pixels(frame, places)
        inside = ((at > [left, top]) & (at < [left + w, top + h])).all(axis=1)
        # If marks would cover each other, only one of them is drawn.
        _, chosen = np.unique(
            np.column_stack((np.rint(at / _MARK), front))[inside], axis=0, return_index=True
        )
        canvas = imgui.GetBackgroundDrawList()
        colour, white = packed(palette.FOLDED), packed(palette.BACKGROUND)
        for (x, y), near in zip(
            at[inside][chosen].tolist(), front[inside][chosen].tolist(), strict=True
        ):
            if near:
                canvas.AddCircleFilled((x, y), _MARK, white)
                canvas.AddCircleFilled((x, y), _MARK - 1, colour)
            else:
                canvas.AddCircle((x, y), _MARK, colour, 0, 1.5)

    def _clip(self) -> None:
        """While bodies are magnified or shifted, cut each off at the borders to its neighbours; planes cost time."""
        ps.remove_all_slice_planes()
        if self.zoom <= 1 and not self.shift.any():
            return
        for row, column in self.bodies:
            left, top, w, h = self.cell(row, column)
            sides = (
                (column > 0, (left, 0), (1.0, 0.0, 0.0)),
                (column < self.columns - 1, (left + w, 0), (-1.0, 0.0, 0.0)),
                (row > 0, (0, top), (0.0, -1.0, 0.0)),
                (row < self.rows - 1, (0, top + h), (0.0, 1.0, 0.0)),
            )
            for inner, (x, y), normal in sides:
                if not inner:
                    continue
                plane = ps.add_scene_slice_plane()
                plane.set_draw_plane(False)
                plane.set_pose(to_world(x, y), normal)
                for body in (*self.bodies.values(), *self.insets.values()):
                    for structure in body.structures():
                        structure.set_ignore_slice_plane(
                            plane, body is not self.bodies[row, column]
                        )

    def frame(self, place: Place) -> tuple[FloatArray, float]:
        """Centre and radius of the body of a cell, in the world."""
        left, top, w, h = self.cell(*place)
        # The spheres of a row are of one size.
        row = [one for (r, _), one in self.parts.items() if r == place[0]]
        above = 8 + _LINE * max(len(wrapped(one.caption, w - 2 * _GAP)) for one in row)
        below = max(sum(legend_height(legend, w) for legend in one.legends) for one in row)
        if any(one.lens is not None for one in row):
            below = max(below, self._strip(w))
        room = h - above - below
        x, y = left + w / 2, top + above + room / 2
        across, along = self.bodies[place].extent(self.turn)
        radius = (
            max(10.0, min((w - _MARGIN) / across, (room - _MARGIN) / along) / 2)
            * UNITS_PER_PIXEL
            * self.zoom
        )
        return to_world(x, y) + radius * np.append(self.shift, 0.0), radius

    def _strip(self, w: float) -> float:
        """Height below a ball that is as wide as its cell, so that it stays clear of the inset in the cell's corner."""
        ball, size = (w - _MARGIN) / 2, _INSET * w + _GAP
        return size + math.sqrt(max((ball + size) ** 2 - (w / 2 - size) ** 2, 0.0)) - ball

    def inset_frame(self, place: Place) -> tuple[FloatArray, float]:
        """Centre and radius of the inset of a cell, in the world: before the body, in the lower right corner."""
        left, top, w, h = self.cell(*place)
        size = _INSET * w
        # the camera is 1.5 heights away, plain bodies end at half a height
        depth = 0.5 * ps.get_window_size()[1]
        return to_world(
            left + w - size - _GAP, top + h - size - _GAP, depth
        ), size * UNITS_PER_PIXEL

    def pixels(self, frame: tuple[FloatArray, float], point: FloatArray) -> FloatArray:
        """Pixels from the upper left to a point of the unit ball of a frame."""
        width, height = ps.get_window_size()
        centre, radius = frame
        x, y, _ = ((centre + radius * point @ self.turn.T) / UNITS_PER_PIXEL).T
        return np.stack((width / 2 + x, height / 2 - y), axis=-1)

    def mouse(self) -> None:
        """Turn, shift and zoom by the mouse; to be called every frame of a window."""
        io = imgui.GetIO()
        if pressed("R") or (imgui.IsMouseDoubleClicked(0) and not io.WantCaptureMouse):
            self.turn, self.zoom, self.shift = np.eye(3), 1.0, np.zeros(2)
        if io.WantCaptureMouse:
            return
        dx, dy = io.MouseDelta
        if imgui.IsMouseDragging(0):
            self.rotate(0.008 * dx, 0.008 * dy)  # 400 pixels are half a turn
        elif imgui.IsMouseDragging(1):
            self.shift = self.shift + np.array([dx, -dy]) / (150 * self.zoom)  # pixels a radius
        if io.MouseWheel:
            self.zoom = float(np.clip(self.zoom * 1.15**io.MouseWheel, 0.3, 200))

    def clicked(self) -> FloatArray | None:
        """The pixel of a click that has just ended on the grid, and was no drag; to be called every frame."""
        if imgui.GetIO().WantCaptureMouse:
            return None
        mouse = np.array(imgui.GetMousePos())
        if imgui.IsMouseClicked(0):
            self._pressed = mouse
        if imgui.IsMouseReleased(0) and np.linalg.norm(mouse - self._pressed) < _RING / 2:
            return mouse
        return None

    def vertex_at(self, pixel: FloatArray) -> int | None:
        """The vertex that is seen at a pixel, on any body, or None."""
        hit = ps.pick(screen_coords=tuple(pixel))
        if hit.is_hit and hit.structure_name in {body.name for body in self.bodies.values()}:
            return int(hit.structure_data["index"])
        return None

    def rotate(self, right: float, down: float) -> None:
        """Turn all bodies by radians of the near side."""
        a, b = np.cos([right, down]), np.sin([right, down])
        about_y = np.array([[a[0], 0, b[0]], [0, 1, 0], [-b[0], 0, a[0]]])
        about_x = np.array([[1, 0, 0], [0, a[1], -b[1]], [0, b[1], a[1]]])
        self.turn = about_x @ about_y @ self.turn

    def _annotate(self, place: Place, part: Part) -> None:
        left, top, w, h = self.cell(*place)
        canvas = imgui.GetBackgroundDrawList()
        for k, line in enumerate(wrapped(part.caption, w - 2 * _GAP)):
            text(canvas, left + w / 2, top + 8 + _LINE * k, line)
        y = top + h + 4
        for legend in part.legends:
            y -= legend_height(legend, w)
            draw_legend(canvas, left + w / 2, y, w, legend)

    def _circle(self, place: Place, lens: Lens) -> None:
        """Mark the place of a lens on the small sphere, and say its power."""
        self.ring(self.inset_frame(place), lens.place, _RING, palette.INK)
        left, top, w, h = self.cell(*place)
        corner = w - 2 * _INSET * w - _GAP
        lines = wrapped(f"circled: {magnification(lens.power)}", corner - 12)
        for k, line in enumerate(reversed(lines)):
            text(
                imgui.GetBackgroundDrawList(),
                left + corner - 6 - text_width(line) / 2,
                top + h - _GAP - _LINE * (k + 1),
                line,
            )

    def ring(
        self,
        frame: tuple[FloatArray, float],
        point: FloatArray,
        radius: float,
        colour: palette.Colour,
    ) -> None:
        """Draw a ring around a point of the unit ball of a frame, which is seen on the far side, too."""
        for shade, width in ((palette.BACKGROUND, 4.0), (colour, 2.0)):
            imgui.GetBackgroundDrawList().AddCircle(
                tuple(self.pixels(frame, point)), radius, packed(shade), 0, width
            )


def packed(colour: palette.Colour) -> int:
    """A colour for ImGui: red in the lowest byte, opaque.

    >>> hex(packed((1.0, 0.0, 0.0)))
    '0xff0000ff'
    """
    r, g, b = (round(255 * c) for c in colour)
    return 0xFF000000 | b << 16 | g << 8 | r


def text(canvas: Any, x: float, y: float, line: str) -> None:
    """Write a line on a light ground; x is its middle and y its upper edge, in pixels."""
    left = x - text_width(line) / 2
    ground = packed(palette.BACKGROUND) & 0xD0FFFFFF  # lets a little through
    canvas.AddRectFilled((left - 3, y), (2 * x - left + 3, y + _LINE), ground)
    canvas.AddText((left, y), packed(palette.INK), line)


def _label(legend: Legend, width: float) -> tuple[str, ...]:
    """The lines of a label; a colour stands beside its own."""
    if isinstance(legend, palette.Ramp):
        return wrapped(legend.label, width - 2 * _GAP)
    return wrapped(legend[0], width - 24)


def legend_height(legend: Legend, width: float) -> float:
    """Pixels that a legend takes: lines of text, and those of a colour map."""
    return 4.0 + _LINE * max(2, len(_label(legend, width)) + isinstance(legend, palette.Ramp))


def draw_legend(canvas: Any, x: float, y: float, width: float, legend: Legend) -> None:
    """Draw a colour map with its label and the values at its ends, or one colour with its meaning, within a width."""
    lines = _label(legend, width)
    if not isinstance(legend, palette.Ramp):
        first = max(12 - _LINE * (len(lines) - 1) / 2, 0.0)
        for k, line in enumerate(lines):
            text(canvas, x + 10, y + first + _LINE * k, line)
        left = x - 10 - max(map(text_width, lines)) / 2
        canvas.AddRectFilled((left, y + 14), (left + 14, y + 28), packed(legend[1]))
        return
    for k, line in enumerate(lines):
        text(canvas, x, y + _LINE * k, line)
    y += _LINE * (len(lines) - 1)
    beside = 2 * (_GAP + max(map(text_width, legend.ends)))
    width = max(min(200.0, width - beside - _GAP), 1.0)
    left = x - width / 2
    step = width / (len(legend.stops) - 1)
    for k in range(len(legend.stops) - 1):
        a, b = (packed(tuple(legend.stops[k + j].tolist())) for j in (0, 1))
        canvas.AddRectFilledMultiColor(
            (left + k * step, y + 20), (left + (k + 1) * step, y + 30), a, b, b, a
        )
    for edge, side, name in zip((left, left + width), (-1, 1), legend.ends, strict=True):
        text(canvas, edge + side * (6 + text_width(name) / 2), y + 16, name)


@lru_cache(maxsize=256)  # the font stays
def wrapped(paragraphs: str, width: float) -> tuple[str, ...]:
    """Lines of text that are no wider than `width` pixels; words that are wider are broken."""
    lines: list[str] = []
    for paragraph in filter(None, legible(paragraphs).splitlines()):
        letters = len(paragraph)
        while letters > 1 and any(text_width(line) > width for line in wrap(paragraph, letters)):
            letters -= 1
        lines += wrap(paragraph, letters)
    return tuple(lines)


def text_width(line: str) -> float:
    """Width of a line in pixels, in the current font."""
    return float(imgui.CalcTextSize(line)[0])


def magnification(power: float) -> str:
    """The power of a lens in words, with two digits.

    >>> magnification(1.0), magnification(2.34), magnification(38765.0)
    ('the whole sphere', 'magnified 2.3x', 'magnified 39,000x')
    """
    power = float(f"{power:.2g}")
    if power <= 1:
        return "the whole sphere"
    if power < 10:
        return f"magnified {power:.1f}x"
    return f"magnified {power:,.0f}x"
