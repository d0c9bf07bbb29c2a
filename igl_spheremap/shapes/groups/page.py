"""A page about a group: the mean and its modes to be turned, a film, and the members, worst first."""

from __future__ import annotations

import os
import shlex
from collections.abc import Sequence
from datetime import datetime, timezone
from html import escape
from pathlib import Path
from urllib.parse import quote

import numpy as np

from ...draw.cards import Card, card_sheet, histogram
from ...draw.markup import View, legend, made_by, page, scene, table
from ...draw.palette import Ramp, round_up, sizes
from ...draw.plot import both_sides, pose
from ...io.replacing import make_folder, replacing
from ...io.textured import write_picture
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.timings import counted
from .files import FIGURES, file_names
from .film import REACH, movement, over_time
from .group import Group
from .series import Series
from .series_files import frame_rows

_SHOWN = 3  # modes with pictures
_SIZE = 200  # pixels of each of the two views of a member: both fill a card on a screen of high resolution
_FAR = 3.0  # colours end at this many root mean square distances of the members: few points of one lie farther


def write_group_page(path: str | os.PathLike[str], group: Group, command: str = "") -> None:
    """Write a page, and the members' pictures into the folder `pictures` beside it; needs Pillow."""
    turn = pose(group.vertices)
    spread = sizes("standard deviation of position", round_up(float(np.percentile(group.spread, 95))))
    model = group.figures()
    rows = [(str(k + 1), *(f"{value:.4g}" for value in values)) for k, values in enumerate(zip(*model, strict=True))]
    body = [f"<h1>{len(group.members)} surfaces and their mean</h1>", made_by(command, datetime.now(timezone.utc)),
            f"<p>{escape(repr(group))}</p>",
            *(f"<p><strong>Doubtful: {escape(note)}.</strong></p>" for note in group.notes), "<h2>Mean and modes</h2>"]
    for k in range(min(_SHOWN, len(group.modes))):
        scores = [np.append(np.zeros(k), side * np.sqrt(group.variances[k])) for side in (-REACH, 0.0, REACH)]
        bodies = _together([group.shape(each) for each in scores], turn)
        moved = movement(group, k)
        away = sizes(f"mode {k + 1}: movement in a standard deviation", round_up(float(moved.max())))
        shown = ((f"Mode {k + 1}: -2 standard deviations", away, moved),
                 ("Mean: standard deviation of position", spread, group.spread),
                 ("+2 standard deviations", away, moved))
        views = [View(caption, x, _by_face(ramp, values, group.faces), np.empty(0, dtype=np.int64), ramp)
                 for x, (caption, ramp, values) in zip(bodies, shown, strict=True)]
        body.append(scene(group.faces, views))
    usual = float(np.sqrt(np.mean([member.distance**2 for member in group.members])))
    ramp = sizes("distance from the mean", round_up(_FAR * usual))
    figures = {name: name for name in (*FIGURES, *(f"mode_{k + 1}" for k in range(len(group.modes))))}
    body += ["<p>Drag to turn, double-click to reset.</p>", "<h2>How good a model the modes are</h2>",
             table(rows, ("modes", "compactness", "generalisation", "specificity")), "<h2>Members</h2>",
             '<div class="plots">',
             *(histogram(name, name, np.array([getattr(member, name) for member in group.members]),
                         np.inf, "", "members") for name in FIGURES), "</div>",
             "<p>What was left out, then members that may lie wrong, which are marked, then the farthest from the mean "
             "first. Click a bar to see its members, a picture to see all of one. <code>template "
             "--ratings</code> reads the ratings that are saved.</p>",
             card_sheet(_cards(Path(path), group, ramp, turn), figures, [ramp])]
    with replacing(path, force=True) as partial:
        partial.write_text(page("A group of surfaces", "\n".join(body)), encoding="utf-8", errors="backslashreplace")


def _cards(path: Path, group: Group, ramp: Ramp, turn: FloatArray) -> list[Card]:
    """A card for each surface, and the pictures of the members, each in colours of its distance from the mean."""
    folder = make_folder(path.parent / "pictures")
    blank: dict[str, object] = dict.fromkeys((*FIGURES, *(f"mode_{k + 1}" for k in range(len(group.modes)))))
    cards = [Card(f"out{k}", {"source": name, "status": "left out", "notes": reason, **blank}, name,
                  f"left out: {reason}", "", shlex.join(("igl-spheremap", "view", name)), good=False)
             for k, (name, reason) in enumerate(group.left_out.items())]
    shorts = file_names([member.name for member in group.members])
    order = sorted(range(len(shorts)), key=lambda k: (not group.members[k].doubts, -group.members[k].distance))
    for k in counted("pictures", order):
        member, shape = group.members[k], group.shapes[k]
        off = np.linalg.norm(shape - group.vertices, axis=1)
        picture = both_sides([shape], group.faces, _by_face(ramp, off, group.faces), turn.T, _SIZE)
        write_picture(folder / f"{shorts[k]}.png", picture, force=True)
        row = {"source": member.name, "status": "member", **{name: getattr(member, name) for name in FIGURES},
               **{f"mode_{j + 1}": score for j, score in enumerate(group.scores[k].tolist())}}
        cards.append(Card(f"m{k}", row, member.name, f"{member.distance:.3g} from the mean, size {member.size:.3f}, "
                          f"correlation {member.correlation:.3f}", "Laid on the mean, from the front and from behind.",
                          shlex.join(("igl-spheremap", "view", f"{path.parent}/members/{shorts[k]}.npz")),
                          f"pictures/{quote(shorts[k], errors='surrogateescape')}.png", list(member.doubts)))
    return cards


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
            *(f"<p><strong>Doubtful: {escape(note)}.</strong></p>" for note in found.notes),
            scene(found.faces, views), "<p>Drag to turn, double-click to reset.</p>",
            f'<h2>Film</h2><figure><img src="{film}" alt="all frames"><figcaption>The frames, and the same colours on '
            "their mean.</figcaption></figure>", legend(ramp), "<h2>Frames</h2>",
            table(cells, [str(cell) for cell in header])]
    with replacing(path, force=True) as partial:
        partial.write_text(page("A series of surfaces", "\n".join(body)), encoding="utf-8", errors="backslashreplace")


def _by_face(ramp: Ramp, values: FloatArray, f: IntArray) -> FloatArray:
    return ramp.colours(values[f].mean(axis=1))


def _together(bodies: list[FloatArray], turn: FloatArray) -> list[FloatArray]:
    """Bodies turned, and brought into the unit ball by one scale."""
    middle = np.mean(bodies, axis=(0, 1))
    radius = max(np.linalg.norm(body - middle, axis=1).max() for body in bodies)
    return [(body - middle) @ turn.T / radius for body in bodies]
