"""A grid of surfaces that turn together, with captions and legends: the layout of all pictures."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import style
from .body import Body, Legend
from .window import UNITS_PER_PIXEL, aim

FloatArray = NDArray[np.float64]

PANEL = 290
_MARGIN = 26
_LINE = 20
_LEGEND = 44


class Stage:
    """Cells in rows and columns, each with one body; all turn together under the mouse.

    Dragging turns, dragging with the right button shifts, the wheel zooms, a double click resets; nothing
    does while ``locked``.

    Parameters
    ----------
    rows, columns : int
        Of the grid.
    panel : int
        Width in pixels of a panel at the right edge that is kept free.
    head, foot : int
        Heights in pixels of strips at the upper and lower edge that are kept free.
    """

    def __init__(self, rows: int, columns: int, panel: int = PANEL, head: int = 0, foot: int = 0) -> None:
        self.rows, self.columns, self.panel, self.head, self.foot = rows, columns, panel, head, foot
        self.bodies: dict[tuple[int, int], Body] = {}
        self.turn = np.eye(3)
        self.zoom = 1.0
        self.shift = np.zeros(2)
        self.locked = False
        self._laid_out: object = None

    def place(self, row: int, column: int, body: Body) -> Body:
        """Put a body into a cell, in place of what was there.

        Parameters
        ----------
        row, column : int
            From 0, the upper left.
        body : Body
            What to show.

        Returns
        -------
        Body
            The same.
        """
        old = self.bodies.get((row, column))
        if old is not None and old.name != body.name:
            old.remove()
        self.bodies[row, column] = body
        self._laid_out = None
        return body

    def clear(self) -> None:
        """Remove all bodies."""
        for body in self.bodies.values():
            body.remove()
        self.bodies.clear()
        self._laid_out = None

    def cell(self, row: int, column: int) -> tuple[float, float, float, float]:
        """Left, top, width and height of a cell in pixels.

        Parameters
        ----------
        row, column : int
            Of the cell.

        Returns
        -------
        tuple of float
            Captions and legends included.
        """
        import polyscope as ps

        width, height = ps.get_window_size()
        w, h = (width - self.panel) / self.columns, (height - self.head - self.foot) / self.rows
        return column * w, self.head + row * h, w, h

    def draw(self) -> None:
        """Lay out what has changed, write captions and legends; to be called every frame."""
        import polyscope as ps

        state = (
            tuple(ps.get_window_size()),
            self.turn.tobytes(),
            self.zoom,
            self.shift.tobytes(),
            tuple(body.version for body in self.bodies.values()),
        )
        if state != self._laid_out:
            self._laid_out = state
            aim(ps.get_window_size()[1])
            for place, body in self.bodies.items():
                body.move(*self.frame(place), self.turn, self.zoom)
        for place, body in self.bodies.items():
            self._annotate(place, body)

    def frame(self, place: tuple[int, int]) -> tuple[FloatArray, float]:
        """Where the body of a cell is in the world: centre and radius.

        Parameters
        ----------
        place : (int, int)
            Row and column.

        Returns
        -------
        centre : (3,) float64 array
        radius : float
        """
        import polyscope as ps

        width, height = ps.get_window_size()
        left, top, w, h = self.cell(*place)
        body = self.bodies[place]
        above = 8 + _LINE * len(body.caption.splitlines())
        room = h - above - (_LEGEND if body.legend is not None else 0)
        x, y = left + w / 2, top + above + room / 2
        radius = max(10.0, min(w, room) / 2 - _MARGIN / 2) * UNITS_PER_PIXEL * self.zoom
        centre = np.array([(x - width / 2) * UNITS_PER_PIXEL, (height / 2 - y) * UNITS_PER_PIXEL, 0.0])
        centre[:2] += self.shift * radius
        return centre, radius

    def to_pixels(self, row: int, column: int, point: FloatArray) -> FloatArray:
        """Where a point of a body is seen.

        Parameters
        ----------
        row, column : int
            Of the body's cell.
        point : (3,) float64 array
            In the body's unit ball.

        Returns
        -------
        (2,) float64 array
            Pixels from the upper left.
        """
        import polyscope as ps

        width, height = ps.get_window_size()
        centre, radius = self.frame((row, column))
        x, y, _ = (centre + radius * self.turn @ point) / UNITS_PER_PIXEL
        return np.array([width / 2 + x, height / 2 - y])

    def from_pixels(self, row: int, column: int, pixel: FloatArray, like: FloatArray) -> FloatArray:
        """The point of a body that is seen at a pixel, as far from the viewer as another one.

        Parameters
        ----------
        row, column : int
            Of the body's cell.
        pixel : (2,) float64 array
            From the upper left.
        like : (3,) float64 array
            A point of the body's unit ball.

        Returns
        -------
        (3,) float64 array
            In the coordinates of the body's unit ball.
        """
        _, radius = self.frame((row, column))
        moved = (pixel - self.to_pixels(row, column, like)) * UNITS_PER_PIXEL / radius
        return np.asarray(like + self.turn.T @ [moved[0], -moved[1], 0.0])

    def mouse(self) -> None:
        """Turn, shift and zoom as the mouse says; to be called every frame of a window."""
        from polyscope import imgui

        io = imgui.GetIO()
        if io.WantCaptureMouse or self.locked:
            return
        dx, dy = io.MouseDelta
        if imgui.IsMouseDragging(0):
            self.rotate(0.008 * dx, 0.008 * dy)
        elif imgui.IsMouseDragging(1):
            self.shift = self.shift + np.array([dx, -dy]) / (150 * self.zoom)
        if io.MouseWheel:
            self.zoom = float(np.clip(self.zoom * 1.15**io.MouseWheel, 0.3, 200))
        if imgui.IsMouseDoubleClicked(0):
            self.turn, self.zoom, self.shift = np.eye(3), 1.0, np.zeros(2)

    def rotate(self, right: float, down: float) -> None:
        """Turn all bodies.

        Parameters
        ----------
        right, down : float
            Radians that the near side moves to the right and down.

        Returns
        -------
        None
        """
        a, b = np.cos([right, down]), np.sin([right, down])
        about_y = np.array([[a[0], 0, b[0]], [0, 1, 0], [-b[0], 0, a[0]]])
        about_x = np.array([[1, 0, 0], [0, a[1], -b[1]], [0, b[1], a[1]]])
        self.turn = about_x @ about_y @ self.turn

    def _annotate(self, place: tuple[int, int], body: Body) -> None:
        from polyscope import imgui

        left, top, w, h = self.cell(*place)
        canvas = imgui.GetBackgroundDrawList()
        for k, line in enumerate(body.caption.splitlines()):
            text(canvas, left + w / 2, top + 8 + _LINE * k, line)
        if body.legend is not None:
            draw_legend(canvas, left + w / 2, top + h - _LEGEND + 4, min(200.0, w - 60), body.legend)


def packed(colour: style.Colour) -> int:
    """A colour as ImGui wants it.

    Parameters
    ----------
    colour : (float, float, float)
        Between 0 and 1.

    Returns
    -------
    int
        Red in the lowest byte, opaque.

    Examples
    --------
    >>> hex(packed((1.0, 0.0, 0.0)))
    '0xff0000ff'
    """
    r, g, b = (round(255 * c) for c in colour)
    return 0xFF000000 | b << 16 | g << 8 | r


def text(canvas: Any, x: float, y: float, line: str) -> None:
    """Write a line that is centred at x.

    Parameters
    ----------
    canvas : ImDrawList
        To write on.
    x, y : float
        Middle and upper edge, in pixels.
    line : str
        One line.

    Returns
    -------
    None
    """
    canvas.AddText((x - text_width(line) / 2, y), packed(style.INK), line)


def draw_legend(canvas: Any, x: float, y: float, width: float, legend: Legend) -> None:
    """Draw a colour map with its label and the values at its ends, or one colour with its meaning.

    Parameters
    ----------
    canvas : ImDrawList
        To draw on.
    x, y : float
        Middle and upper edge, in pixels.
    width : float
        Of the coloured bar.
    legend : Ramp or (str, colour)
        What to explain.

    Returns
    -------
    None
    """
    if legend is None:
        return
    if not isinstance(legend, style.Ramp):
        label, colour = legend
        text(canvas, x + 10, y + 12, label)
        left = x - 10 - text_width(label) / 2
        canvas.AddRectFilled((left, y + 14), (left + 14, y + 28), packed(colour))
        return
    left = x - width / 2
    step = width / (len(legend.stops) - 1)
    for k in range(len(legend.stops) - 1):
        a, b = (packed(tuple(legend.stops[k + j].tolist())) for j in (0, 1))
        canvas.AddRectFilledMultiColor((left + k * step, y + 20), (left + (k + 1) * step, y + 30), a, b, b, a)
    text(canvas, x, y, legend.label)
    for edge, side, value in ((left, -1, legend.low), (left + width, 1, legend.high)):
        text(canvas, edge + side * (6 + text_width(f"{value:g}") / 2), y + 16, f"{value:g}")


def text_width(line: str) -> float:
    """Width of a line in pixels.

    Parameters
    ----------
    line : str
        One line.

    Returns
    -------
    float
        In the current font.
    """
    from polyscope import imgui

    return float(imgui.CalcTextSize(line)[0])
