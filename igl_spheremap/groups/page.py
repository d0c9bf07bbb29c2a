"""A page about a group: the mean and its modes to be turned, a film, and the members, worst first."""

from __future__ import annotations

import io
import os
from collections.abc import Sequence
from datetime import datetime, timezone
from html import escape

import numpy as np
from numpy.typing import NDArray

from ..draw.markup import MOST_PICTURES, View, data_address, legend, made_by, page, scene, table, wrapping
from ..draw.palette import Ramp, round_up, sizes
from ..draw.plot import pose, raster, shading
from ..errors import import_optional
from ..io.replacing import replacing
from ..mesh.arrays import FloatArray, IntArray
from .film import REACH, movement, over_time
from .group import Group
from .series import Series
from .series_files import frame_rows

_SHOWN = 3  # modes with pictures
_SIZE = 160  # pixels of a member's picture


def write_group_page(path: str | os.PathLike[str], group: Group, command: str = "") -> None:
    """Write a page, which needs no other file; needs Pillow."""
    turn = pose(group.vertices)
    spread = sizes("standard deviation of position", round_up(float(np.percentile(group.spread, 95))))
    order = np.argsort([-member.distance for member in group.members], kind="stable")
    model = group.figures()
    rows = [(str(k + 1), *(f"{value:.4g}" for value in values)) for k, values in enumerate(zip(*model, strict=True))]
    body = [f"<h1>{len(group.members)} surfaces and their mean</h1>", made_by(command, datetime.now(timezone.utc)),
            f"<p>{escape(repr(group))}</p>", "<h2>Mean and modes</h2>"]
    for k in range(min(_SHOWN, len(group.modes))):
        scores = [np.append(np.zeros(k), side * np.sqrt(group.variances[k])) for side in (-REACH, 0.0, REACH)]
        bodies = _together([group.shape(each) for each in scores], turn)
        away = sizes(f"mode {k + 1}: movement in a standard deviation", round_up(float(movement(group, k).max())))
        captions = (f"Mode {k + 1}: -2 standard deviations", "Mean: standard deviation of position",
                    "+2 standard deviations")
        views = [View(caption, x, _by_face(spread if x is bodies[1] else away, group.spread if x is bodies[1]
                 else movement(group, k), group.faces), np.empty(0, dtype=np.int64), spread if x is bodies[1] else away)
                 for caption, x in zip(captions, bodies, strict=True)]
        body.append(scene(group.faces, views))
    body += ["<p>Drag to turn, double-click to reset.</p>", "<h2>How good a model the modes are</h2>",
             table(rows, ("modes", "compactness", "generalisation", "specificity")), "<h2>Members</h2>",
             "<p>The farthest from the mean first; colours are the distance from it.</p>"]
    if group.left_out:
        body.append(table([(name, reason) for name, reason in group.left_out.items()], ("left out", "why")))
    off = np.linalg.norm(group.shapes - group.vertices, axis=2)
    ramp = sizes("distance from the mean", round_up(float(np.percentile(off, 99))))
    cards = []
    for k in order[:MOST_PICTURES]:
        member = group.members[k]
        image = raster(group.shapes[k] @ turn.T, group.faces, _lit(group.shapes[k], ramp, off[k], group, turn), _SIZE)
        cards.append(f'<div class="card"><img loading="lazy" alt="" src="{data_address(_png(image))}"><div>'
                     f"{wrapping(member.name)}</div><small>{member.distance:.3g} from the mean, size "
                     f"{member.size:.3f}, correlation {member.correlation:.3f}</small></div>")
    body.append(f'<div class="sheet">{"".join(cards)}</div>')
    with replacing(path, force=True) as partial:
        partial.write_text(page("A group of surfaces", "\n".join(body)), encoding="utf-8", errors="backslashreplace")


def write_series_page(path: str | os.PathLike[str], found: Series, mean: FloatArray, film: str, names: Sequence[str],
                      feature_names: Sequence[str], command: str = "") -> None:
    """Write a page about a series, which needs no other file but its film."""
    (values, ramp), radius = over_time(found, *feature_names[:1]), np.sqrt(found.areas.sum(axis=1).mean() / (4 * np.pi))
    drift = sizes("drift of the last frame", round_up(float(np.percentile(found.drift, 99))))
    bodies = _together([found.aligned[0], mean, found.aligned[-1]], pose(mean))
    captions = f"First frame: {names[0]}", "Mean of the frames", f"Last frame: {names[-1]}"
    views = [View(caption, x, _by_face(scale, colours, found.faces), np.empty(0, dtype=np.int64), scale)
             for caption, x, scale, colours in zip(captions, bodies, (ramp, drift, ramp),
                                                   (values[0], found.drift, values[-1]), strict=True)]
    header, *rows = frame_rows(found, names, feature_names)
    cells = [[cell if isinstance(cell, str) else f"{cell:.5g}" for cell in row] for row in rows]
    off = float(np.sqrt((found.drift**2).mean()))
    body = [f"<h1>{len(names)} frames of one body</h1>", made_by(command, datetime.now(timezone.utc)),
            "<p>Each frame is registered to the one before. Points of the last frame lie "
            f"{off:.3g} (root mean square), {off / radius:.1%} of the radius of a ball of its area, from where its map "
            "puts them that is registered to the first frame directly: that is the drift.</p>",
            scene(found.faces, views), "<p>Drag to turn, double-click to reset.</p>",
            f'<h2>Film</h2><figure><img src="{film}" alt="all frames"><figcaption>The frames, and the same colours on '
            "their mean.</figcaption></figure>", legend(ramp), "<h2>Frames</h2>",
            table(cells, [str(cell) for cell in header])]
    with replacing(path, force=True) as partial:
        partial.write_text(page("A series of surfaces", "\n".join(body)), encoding="utf-8", errors="backslashreplace")


def _by_face(ramp: Ramp, values: FloatArray, f: IntArray) -> FloatArray:
    return ramp.colours(values[f].mean(axis=1))


def _lit(v: FloatArray, ramp: Ramp, values: FloatArray, group: Group, turn: FloatArray) -> FloatArray:
    """Face colours in the light of the pictures."""
    return _by_face(ramp, values, group.faces) * shading(v, group.faces, turn.T)[:, None]


def _together(bodies: list[FloatArray], turn: FloatArray) -> list[FloatArray]:
    """Bodies turned, and brought into the unit ball by one scale."""
    middle = np.mean(bodies, axis=(0, 1))
    radius = max(np.linalg.norm(body - middle, axis=1).max() for body in bodies)
    return [(body - middle) @ turn.T / radius for body in bodies]


def _png(image: NDArray[np.uint8]) -> bytes:
    """A picture in 64 colours."""
    images = import_optional("PIL.Image", "a page", "io")
    stream = io.BytesIO()
    images.fromarray(image).quantize(64).save(stream, "PNG", optimize=True)
    return stream.getvalue()
