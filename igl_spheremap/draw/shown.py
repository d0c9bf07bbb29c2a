"""Results in notebooks: a picture by numpy alone, its caption, and a table of figures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..gate import gate
from ..mesh.arrays import FloatArray, IntArray, own_unit
from ..mesh.check import Mesh
from ..mesh.disk import Disk
from ..verify.certificate import Certificate
from .markup import picture, png
from .palette import AREAS, fitting, pale
from .plot import pose, raster, shading

_SIZE = 288  # pixels along a side of a body's picture: three of them fit beside one another
#: Notebooks set all cells to the right, as numbers are.
_STYLE = "<style>.shown figure { margin: 0 } .shown [scope=row] + td { text-align: left }</style>"


@dataclass(frozen=True, eq=False)
class Drawing:
    """Bodies (n, 3) with the same faces (m, 3) in face colours (m, 3), side by side, and a caption.

    `turns` are the views of the bodies, rows being right, up and towards the viewer; `folded` are indices of faces.
    """

    caption: str
    bodies: Sequence[FloatArray]
    turns: Sequence[FloatArray]
    f: IntArray
    colours: FloatArray
    folded: IntArray

    def image(self) -> NDArray[np.uint8]:
        """The pixels, (height, width, 3)."""
        # of the mark of a folded face, a side, before pictures are made half as large
        mark = 8
        # of each colour above 0: the file takes a third less than with all, and it is not seen
        levels = 31
        drawn, folded = [], None
        if len(self.folded):
            folded = self.folded
        for body, turn in zip(self.bodies, self.turns, strict=True):
            # given maps hold anything
            y = own_unit(np.nan_to_num(body, posinf=0.0, neginf=0.0))[0] @ turn.T
            shaded = self.colours * shading(y, self.f, np.eye(3))[:, None]
            drawn.append(raster(y, self.f, shaded, 2 * _SIZE, folded, least=mark))
        fine = np.concatenate(drawn, axis=1).astype(np.uint16)
        # so that borders are smooth
        sums = fine[::2, ::2] + fine[1::2, ::2] + fine[::2, 1::2] + fine[1::2, 1::2]
        return np.rint(np.rint(sums * (levels / 1020)) * (255 / levels)).astype(np.uint8)


class Shown:
    """Objects that show themselves in notebooks: by a drawing, and a table as HTML."""

    def _drawing(self) -> Drawing:
        raise NotImplementedError

    def _figures(self) -> str:
        raise NotImplementedError

    @gate
    def _repr_html_(self) -> str:
        """HTML for notebooks."""
        return notebook_html(self._drawing(), self._figures())


def notebook_html(drawing: Drawing, figures: str) -> str:
    """A drawing with its caption above a table."""
    return f'<div class="shown">{_STYLE}{picture(png(drawing.image()), drawing.caption)}{figures}</div>'


def area_drawing(
    mesh: Mesh | Disk, image: FloatArray, ratios: FloatArray, certificate: Certificate, target: str
) -> Drawing:
    """A surface and its image (n, 3) by logarithms of area ratios, both without caps; an image in the plane z = 0 is
    seen from above.
    """
    ramp = fitting(AREAS, ratios)
    folded = np.zeros(len(mesh.f), dtype=bool)
    folded[certificate.flipped] = folded[certificate.degenerate] = True
    kept = np.flatnonzero(folded[mesh.surface])
    below, above = ramp.ends
    caption = (
        f"Left: the surface; right: its image {target}. The same colour is the same face: purple where the map "
        f"shrinks areas ({below} at the darkest), green where it magnifies them ({above})"
    )
    if len(kept):
        caption += f"; {len(kept):,} folded faces are red"
    turns = [pose(mesh.unit)] * 2
    if not image[:, 2].any():
        turns[1] = np.eye(3)
    return Drawing(
        f"{caption}.", (mesh.unit, image), turns, mesh.f[mesh.surface], ramp.colours(ratios), kept
    )


def place_drawing(
    bodies: Sequence[FloatArray],
    f: IntArray,
    caption: str,
    turns: Sequence[FloatArray] | None = None,
) -> Drawing:
    """Bodies in colours by place along the longest side of the first, seen as it stands unless `turns` are given."""
    along = bodies[0][:, int(np.argmax(np.ptp(bodies[0], axis=0)))][f].mean(axis=1)
    colours = pale("", float(along.min()), float(along.max())).colours(along)
    if turns is None:
        turns = [pose(bodies[0])] * len(bodies)
    return Drawing(caption, bodies, turns, f, colours, np.empty(0, dtype=np.int64))
