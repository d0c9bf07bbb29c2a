"""The whole sphere in the corner of a cell, with the place of the lens circled."""

from __future__ import annotations

from ...draw.palette import INK
from ...mesh.arrays import FloatArray, IntArray
from .body import Body
from .colouring import Colouring
from .lazy import imgui
from .lens import Lens
from .stage import Stage, packed, text, text_width, wrapped

_CIRCLE = 7
_LINE = 18


class Inset:
    """Shown while a lens magnifies."""

    def __init__(self, stage: Stage, row: int, column: int, f: IntArray, x: FloatArray) -> None:
        self._stage, self._cell = stage, (row, column)
        self._body = stage.inset(row, column, Body(f"inset {row} {column}", x, f, lift=True))
        self._lens = Lens()

    def show(self, x: FloatArray, lens: Lens, colours: Colouring) -> None:
        """Show a map without the lens through which its cell shows it."""
        self._lens = lens
        self._body.visible = lens.power > 1
        self._body.set_positions(x)
        self._body.paint(colours.colours, colours.folded)

    def annotate(self) -> None:
        """Draw the circle and the text; to be called every frame."""
        if not self._body.visible:
            return
        canvas = imgui.GetForegroundDrawList()
        x, y = self._stage.inset_pixels(*self._cell, self._lens.place)
        canvas.AddCircle((x, y), _CIRCLE, packed((1.0, 1.0, 1.0)), 0, 4.0)
        canvas.AddCircle((x, y), _CIRCLE, packed(INK), 0, 2.0)
        left, bottom = self._stage.inset_corner(*self._cell)
        power = float(f"{self._lens.power:.2g}")
        sentence = f"circled: magnified {power:,.{int(power < 10)}f}x"
        lines = wrapped(sentence, left - 12 - self._stage.cell(*self._cell)[0])
        for k, line in enumerate(reversed(lines)):
            text(canvas, left - 6 - text_width(line) / 2, bottom - _LINE * (k + 1), line)
