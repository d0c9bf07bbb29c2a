"""A page about a group: the mean and its modes to be turned, a film, and the members, worst first."""

from __future__ import annotations

import io
import os
from datetime import datetime, timezone
from html import escape
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..draw.markup import View, data_address, made_by, page, scene, table, wrapping
from ..draw.palette import Ramp, round_up, sizes
from ..draw.plot import pose, raster, shading
from ..errors import import_optional
from ..io.replacing import replacing
from ..mesh.arrays import FloatArray
from .group import Group

_SHOWN = 3  # modes with pictures
_REACH = 2.0  # standard deviations to either side
_SIZE = 160  # pixels of a member's picture
_FRAMES, _FILM = 24, 320  # of a film, and its pixels
_MOST = 2000  # members with pictures; the table of the group has all
_AMBIENT = 0.6  # brightness of faces that the light grazes


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
        scores = [np.append(np.zeros(k), side * np.sqrt(group.variances[k])) for side in (-_REACH, 0.0, _REACH)]
        bodies = _together([group.shape(each) for each in scores], turn)
        away = sizes(f"mode {k + 1}: movement in a standard deviation", round_up(float(_length(group, k).max())))
        captions = (f"Mode {k + 1}: -2 standard deviations", "Mean: standard deviation of position",
                    "+2 standard deviations")
        views = [View(caption, x, _by_face(spread if x is bodies[1] else away, group.spread if x is bodies[1]
                 else _length(group, k), group), np.empty(0, dtype=np.int64), spread if x is bodies[1] else away)
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
    for k in order[:_MOST]:
        member = group.members[k]
        image = raster(group.shapes[k] @ turn.T, group.faces, _lit(group.shapes[k], ramp, off[k], group, turn), _SIZE)
        cards.append(f'<div class="card"><img loading="lazy" alt="" src="{data_address(_png(image))}"><div>'
                     f"{wrapping(member.name)}</div><small>{member.distance:.3g} from the mean, size "
                     f"{member.size:.3f}, correlation {member.correlation:.3f}</small></div>")
    body.append(f'<div class="sheet">{"".join(cards)}</div>')
    with replacing(path, force=True) as partial:
        partial.write_text(page("A group of surfaces", "\n".join(body)), encoding="utf-8", errors="backslashreplace")


def write_film(path: str | os.PathLike[str], group: Group, mode: int = 0) -> None:
    """Write a mode from -2 to +2 standard deviations and back as an animated .gif; needs Pillow."""
    images = import_optional("PIL.Image", "a film", "io")
    turn, away = pose(group.vertices), _length(group, mode)
    ramp = sizes("movement", round_up(float(away.max())))
    frames = []
    for angle in np.linspace(0, 2 * np.pi, _FRAMES, endpoint=False):
        score = np.append(np.zeros(mode), _REACH * np.sin(angle) * np.sqrt(group.variances[mode]))
        v = group.shape(score)
        frames.append(images.fromarray(raster(v @ turn.T, group.faces, _lit(v, ramp, away, group, turn), _FILM)))
    with replacing(path, force=True) as partial:
        frames[0].save(Path(partial), "GIF", save_all=True, append_images=frames[1:], duration=80, loop=0)


def _length(group: Group, mode: int) -> FloatArray:
    """How far a standard deviation of a mode moves each vertex."""
    return np.asarray(np.linalg.norm(group.modes[mode], axis=1) * np.sqrt(group.variances[mode]))


def _by_face(ramp: Ramp, values: FloatArray, group: Group) -> FloatArray:
    return ramp.colours(values[group.faces].mean(axis=1))


def _lit(v: FloatArray, ramp: Ramp, values: FloatArray, group: Group, turn: FloatArray) -> FloatArray:
    """Face colours in the light of the pictures."""
    return _by_face(ramp, values, group) * shading(v, group.faces, turn.T, _AMBIENT)[:, None]


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
