"""Pages and films of a group and of a series: bodies to be turned, members worst first; films need Pillow."""

from __future__ import annotations

import os
import shlex
from collections.abc import Sequence
from dataclasses import replace
from html import escape
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np

from ...draw.cards import Card, card_sheet, histogram
from ...draw.markup import View, legend, made_by, page, scene, table
from ...draw.palette import Ramp, areas, round_up, sequential, sizes
from ...draw.plot import both_sides, frame, pose, raster, shading
from ...errors import import_optional
from ...io.pictures import write_picture
from ...io.replacing import make_folder, replacing
from ...mesh.arrays import BoolArray, FloatArray, IntArray
from ...timings import counted
from .files import file_names, member_rows
from .group import Group
from .permutation import LEVEL, PointTest
from .series import Series
from .series_files import frame_rows

#: The figures by which the page sorts members, each with its words.
_FIGURES = {
    "correlation": "correlation of depth with the mean's",
    "size": "size over that of all",
    "distance": "distance from the mean (rms)",
}
_REACH = 2.0  # standard deviations that pictures of a mode go to either side
_SHOWN = 3  # modes with pictures
# pixels of each of the two views of a member: both fill a card on a screen of high resolution
_SIZE = 200
# colours end at this many root mean square distances of the members: few points of one lie farther
_FAR = 3.0
# share of colour that is left where chance explains an effect: enough to see the surface's shape
_PALE = 0.25
#: Where a group's page has its tests, which are made later.
_TESTS, _END = '<section id="tests">', "</section>"
_FILM = 320  # pixels of a side of a film, which shows two bodies side by side
_MOST = 200  # frames of a film, evenly chosen
_PAUSE, _LENGTH = 80, 1920  # milliseconds of a frame and of a film at least


def write_group_page(path: str | os.PathLike[str], group: Group, command: str = "") -> None:
    """Write a page, and the members' pictures into the folder `pictures` beside it; needs Pillow."""
    turn = pose(group.vertices)
    spread = sizes(
        "standard deviation of position", round_up(float(np.percentile(group.spread, 95)))
    )
    rows = [
        (str(k + 1), *(f"{value:.4g}" for value in values))
        for k, values in enumerate(zip(*group.figures(), strict=True))
    ]
    body = [
        f"<h1>{len(group.members)} surfaces and their mean</h1>",
        f"<p>{escape(repr(group))}</p>",
        *map(_doubtful, group.notes),
        "<h2>Mean and modes</h2>",
    ]
    for k in range(min(_SHOWN, len(group.modes))):
        scores = [
            np.append(np.zeros(k), side * np.sqrt(group.variances[k]))
            for side in (-_REACH, 0.0, _REACH)
        ]
        moved = _movement(group, k)
        away = sizes(
            f"mode {k + 1}: movement in a standard deviation", round_up(float(moved.max()))
        )
        body.append(
            _scene(
                [group.shape(each) for each in scores],
                group.faces,
                turn,
                [
                    (f"Mode {k + 1}: -2 standard deviations", away, moved),
                    ("Mean: standard deviation of position", spread, group.spread),
                    ("+2 standard deviations", away, moved),
                ],
            )
        )
    usual = float(np.sqrt(np.mean([member.distance**2 for member in group.members])))
    ramp = sizes("distance from the mean", round_up(_FAR * usual))
    figures = _FIGURES | {
        f"mode_{k + 1}": f"score of mode {k + 1}" for k in range(len(group.modes))
    }
    body += [
        "<p>Drag to turn, double-click to reset.</p>",
        _TESTS + _END,
        "<h2>How good a model the modes are</h2>",
        table(rows, ("modes", "compactness", "generalisation", "specificity")),
        "<h2>Members</h2>",
        '<div class="plots">',
        *(
            histogram(
                name,
                label,
                np.array([getattr(member, name) for member in group.members]),
                np.inf,
                "",
                "members",
            )
            for name, label in _FIGURES.items()
        ),
        "</div>",
        "<p>What was left out, then members that may lie wrong, which are marked, then the farthest from the mean "
        "first. Click a bar to see its members, a picture to see all of one. <code>template "
        "--ratings</code> reads the ratings that are saved.</p>",
        card_sheet(_cards(Path(path), group, ramp, turn), figures, [ramp]),
    ]
    _write(path, "A group of surfaces", body, command)


def _cards(path: Path, group: Group, ramp: Ramp, turn: FloatArray) -> list[Card]:
    """A card for each surface, and the pictures of the members, each in colours of its distance from the mean."""
    folder = make_folder(path.parent / "pictures", follow=False)
    header, *rows = member_rows(group)
    known: list[dict[str, Any]] = [
        {
            str(name): None if cell == "" else cell
            for name, cell in zip(("source", *header[1:]), row, strict=True)
        }
        for row in rows
    ]
    cards = [
        Card(
            f"out{k}",
            row,
            row["source"],
            f"left out: {row['reason']}",
            "",
            shlex.join(("igl-spheremap", "view", row["source"])),
            good=False,
        )
        for k, row in enumerate(known[len(group.members) :])
    ]
    shorts = file_names([member.name for member in group.members])
    order = sorted(
        range(len(shorts)), key=lambda k: (not group.members[k].doubts, -group.members[k].distance)
    )
    for k in counted("pictures", order):
        member, shape = group.members[k], group.shapes[k]
        off = np.linalg.norm(shape - group.vertices, axis=1)
        picture = both_sides([shape], group.faces, _by_face(ramp, off, group.faces), turn.T, _SIZE)
        write_picture(folder / f"{shorts[k]}.png", picture, force=True)
        text = f"{member.distance:.3g} from the mean, size {member.size:.3f}, correlation {member.correlation:.3f}"
        cards.append(
            Card(
                f"m{k}",
                known[k],
                member.name,
                text,
                "Laid on the mean, from the front and from behind.",
                shlex.join(("igl-spheremap", "view", f"{path.parent}/members/{shorts[k]}.npz")),
                f"pictures/{quote(shorts[k], errors='surrogateescape')}.png",
                list(member.doubts),
            )
        )
    return cards


def write_tests(
    path: Path, group: Group, tests: Sequence[tuple[str, str, PointTest]], command: str = ""
) -> None:
    """Write tests into a group's page, or into one of their own: of each the variable, what was found, and the test."""
    text = path.read_text(encoding="utf-8") if path.exists() else ""
    before, _, after = (
        text if _TESTS in text else page("Tests of a group", _TESTS + _END)
    ).partition(_TESTS)
    body = [_TESTS, "<h2>Tests</h2>", made_by(command)]
    for name, words, found in tests:
        body += [
            f"<h3>{escape(name)}</h3>",
            f"<p>{escape(words)}.</p>",
            *map(_doubtful, found.notes),
        ]
        if len(found.p) != len(group.vertices):
            continue
        lengths = np.linalg.norm(found.effect, axis=2)
        ramp = sizes(f"effect of {name}; pale where p > {LEVEL}", round_up(float(lengths.max())))
        captions = [f"From {found.levels[0]} to {level}" for level in found.levels[1:]] or [
            f"A unit of {name} more"
        ]
        body.append(
            _scene(
                [group.vertices] * len(lengths),
                group.faces,
                pose(group.vertices),
                [(caption, ramp, size) for caption, size in zip(captions, lengths, strict=True)],
                found.p[group.faces].max(axis=1) > LEVEL,
            )
        )
    with replacing(path, force=True) as partial:
        partial.write_text(
            before + "\n".join(body) + _END + after.partition(_END)[2],
            encoding="utf-8",
            errors="backslashreplace",
        )


def write_series_page(
    path: str | os.PathLike[str],
    found: Series,
    mean: FloatArray,
    film: str,
    names: Sequence[str],
    feature_names: Sequence[str],
    command: str = "",
) -> None:
    """Write a page about a series, which needs no other file but its film."""
    values, ramp = _over_time(found, *feature_names[:1])
    radius = np.sqrt(found.areas.sum(axis=1).mean() / (4 * np.pi))
    drift = sizes("drift of the last frame", round_up(float(np.percentile(found.drift, 99))))
    bodies = [found.aligned[0], mean, found.aligned[-1]]
    header, *rows = frame_rows(found, names, feature_names)
    cells = [[cell if isinstance(cell, str) else f"{cell:.5g}" for cell in row] for row in rows]
    off = float(np.sqrt((found.drift**2).mean()))
    body = [
        f"<h1>{len(names)} frames of one body</h1>",
        "<p>Each frame is registered to the one before. Points of the last frame lie "
        f"{off:.3g} (root mean square), {off / radius:.1%} of the radius of a ball of its area, from where its map "
        "puts them that is registered to the first frame directly: that is the drift.</p>",
        *map(_doubtful, found.notes),
        _scene(
            bodies,
            found.faces,
            pose(mean),
            [
                (f"First frame: {names[0]}", ramp, values[0]),
                ("Mean of the frames", drift, found.drift),
                (f"Last frame: {names[-1]}", ramp, values[-1]),
            ],
        ),
        "<p>Drag to turn, double-click to reset.</p>",
        f'<h2>Film</h2><figure><img src="{film}" alt="all frames"><figcaption>The frames, and the same colours on '
        "their mean.</figcaption></figure>",
        legend(ramp),
        "<h2>Frames</h2>",
        table(cells, [str(cell) for cell in header]),
    ]
    _write(path, "A series of surfaces", body, command)


def _doubtful(note: str) -> str:
    return f"<p><strong>Doubtful: {escape(note)}.</strong></p>"


def _write(path: str | os.PathLike[str], title: str, body: list[str], command: str) -> None:
    """Write a page whose first part is its heading."""
    body.insert(1, made_by(command))
    with replacing(path, force=True) as partial:
        partial.write_text(
            page(title, "\n".join(body)), encoding="utf-8", errors="backslashreplace"
        )


def _scene(
    bodies: Sequence[FloatArray],
    f: IntArray,
    turn: FloatArray,
    shown: Sequence[tuple[str, Ramp, FloatArray]],
    faint: BoolArray | None = None,
) -> str:
    """Bodies to be turned, in one scale, each with its caption, a colour scale, and values over its vertices.

    Faces that are `faint` are pale.
    """
    middle = np.mean(bodies, axis=(0, 1))
    radius = max(np.linalg.norm(body - middle, axis=1).max() for body in bodies)
    left = np.ones((len(f), 1)) if faint is None else np.where(faint, _PALE, 1.0)[:, None]
    return scene(
        f,
        [
            View(
                caption,
                (body - middle) @ turn.T / radius,
                1 - left + left * _by_face(ramp, values, f),
                np.empty(0, dtype=np.int64),
                ramp,
            )
            for body, (caption, ramp, values) in zip(bodies, shown, strict=True)
        ],
    )


def _by_face(ramp: Ramp, values: FloatArray, f: IntArray) -> FloatArray:
    return ramp.colours(values[f].mean(axis=1))


def _movement(group: Group, mode: int) -> FloatArray:
    """How far a standard deviation of a mode moves each vertex."""
    return np.asarray(np.linalg.norm(group.modes[mode], axis=1) * np.sqrt(group.variances[mode]))


def _over_time(found: Series, feature: str = "") -> tuple[FloatArray, Ramp]:
    """The first feature (frames, n), whose name is given, and its colours.

    Without features these are the logarithms of the areas around the points over their mean in time.
    """
    if found.features.shape[2]:
        values = found.features[:, :, 0]
        return values, sequential(feature, *np.percentile(values, [1, 99]).tolist())
    values = np.log(found.areas / found.areas.mean(axis=0))
    most = round_up(float(np.expm1(np.percentile(np.abs(values), 99))))
    return values, replace(areas(1 + most), label="area / its mean in time")


def write_series_film(path: str | os.PathLike[str], found: Series, mean: FloatArray) -> None:
    """Write the frames, and beside them the mean surface, in the colours of the page, as an animated .gif."""
    images, turn = import_optional("PIL.Image", "a film", "io"), pose(mean).T
    values, ramp = _over_time(found)
    chosen = np.unique(np.linspace(0, len(values) - 1, min(_MOST, len(values))).round().astype(int))
    moving, still = found.aligned[chosen] @ turn, mean @ turn
    seen = frame(moving.reshape(-1, 3)), frame(still)
    pictures = []
    for k, body in zip(chosen, moving, strict=True):
        colours = _by_face(ramp, values[k], found.faces)
        pictures.append(
            np.concatenate(
                [
                    raster(
                        v,
                        found.faces,
                        colours * shading(v, found.faces, np.eye(3))[:, None],
                        _FILM,
                        shown=shown,
                    )
                    for v, shown in zip((body, still), seen, strict=True)
                ],
                axis=1,
            )
        )
    first, *others = map(images.fromarray, pictures)
    with replacing(path, force=True) as partial:
        first.save(
            partial,
            "GIF",
            save_all=True,
            append_images=others,
            loop=0,
            duration=max(_PAUSE, _LENGTH // len(pictures)),
        )
