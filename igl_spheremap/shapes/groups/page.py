"""Pages and films of a group and of a series: bodies to be turned, members worst first; films need Pillow."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from html import escape
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np

from ...draw.cards import Card, card_section, histogram
from ...draw.markup import View, legend, made_by, page, scene, table, top
from ...draw.palette import Ramp, areas, round_up, sequential, sizes
from ...draw.plot import both_sides, frame, pose, raster, shading
from ...errors import import_optional
from ...gate import PathLike
from ...io.pages import write_html, write_page
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
#: Where a group's page has its tests, which are made later.
_TESTS, _END = '<section id="tests">', "</section>"
_TURN = "<p>Drag to turn, double-click to reset.</p>"


def write_group_page(path: PathLike, group: Group, command: str = "") -> None:
    """Write a page, and the members' pictures into the folder `pictures` beside it; needs Pillow."""
    turn = pose(group.vertices)
    rows = [
        (str(k + 1), *(f"{value:.4g}" for value in values))
        for k, values in enumerate(zip(*group.figures(), strict=True))
    ]
    ramp, cards = _cards(Path(path), group, turn)
    figures = _FIGURES | {
        f"mode_{k + 1}": f"score of mode {k + 1}" for k in range(len(group.modes))
    }
    write_page(
        Path(path),
        "A group of surfaces",
        top(f"{len(group.members)} surfaces and their mean", command),
        f"<p>{escape(repr(group))}</p>",
        *map(_doubtful, group.notes),
        "<h2>Mean and modes</h2>",
        *_modes(group, turn),
        _TURN,
        _TESTS + _END,
        "<h2>How good a model the modes are</h2>",
        table(rows, ("modes", "compactness", "generalisation", "specificity")),
        card_section(
            cards,
            "members",
            "What was left out, then members that may lie wrong, which are marked, then the farthest from the mean "
            "first. Click a bar to see its members, a picture to see all of one. <code>template "
            "--ratings</code> reads the ratings that are saved.",
            [
                histogram(
                    name, label, np.array([getattr(one, name) for one in group.members]), "members"
                )
                for name, label in _FIGURES.items()
            ],
            figures,
            [ramp],
        ),
    )


def _modes(group: Group, turn: FloatArray, most: int = 3, reach: float = 2.0) -> Iterator[str]:
    """Scenes of the first modes, each some standard deviations to either side of the mean."""
    spread = sizes(
        "standard deviation of position", round_up(float(np.percentile(group.spread, 95)))
    )
    for k, variance in enumerate(group.variances[: min(most, len(group.modes))]):
        moved = np.linalg.norm(group.modes[k], axis=1) * np.sqrt(variance)
        away = sizes(
            f"mode {k + 1}: movement in a standard deviation", round_up(float(moved.max()))
        )
        bodies = [
            group.shape(np.append(np.zeros(k), side * np.sqrt(variance)))
            for side in (-reach, 0.0, reach)
        ]
        yield _scene(
            bodies,
            group.faces,
            turn,
            [
                (f"Mode {k + 1}: -{reach:g} standard deviations", away, moved),
                ("Mean: standard deviation of position", spread, group.spread),
                (f"+{reach:g} standard deviations", away, moved),
            ],
        )


def _cards(
    path: Path, group: Group, turn: FloatArray, pixels: int = 200, far: float = 3.0
) -> tuple[Ramp, list[Card]]:
    """Colours of distances from the mean, and a card for each surface.

    Members have pictures in these colours, two views that fill a card on a screen of high resolution. Few points lie
    farther than `far` root mean square distances of the members, where the colours end.
    """
    usual = float(np.sqrt(np.mean([member.distance**2 for member in group.members])))
    ramp = sizes("distance from the mean", round_up(far * usual))
    folder = make_folder(path.parent / "pictures", follow=False)
    header, *rows = member_rows(group)
    known: list[dict[str, Any]] = []
    for cells in rows:
        entry = dict(zip(("source", *map(str, header[1:])), cells, strict=True))
        known.append(entry | {name: None for name, cell in entry.items() if cell == ""})
    cards = []
    for k, row in enumerate(known[len(group.members) :]):
        text = f"left out: {row['reason']}"
        words = ("view", row["source"])
        cards.append(Card(f"out{k}", row, row["source"], text, "", words, good=False))
    shorts = file_names([member.name for member in group.members])
    order = sorted(
        range(len(shorts)), key=lambda k: (not group.members[k].doubts, -group.members[k].distance)
    )
    for k in counted("pictures", order):
        member, shape = group.members[k], group.shapes[k]
        off = np.linalg.norm(shape - group.vertices, axis=1)
        picture = both_sides([shape], group.faces, _by_face(ramp, off, group.faces), turn.T, pixels)
        write_picture(folder / f"{shorts[k]}.png", picture, force=True)
        text = f"{member.distance:.3g} from the mean, size {member.size:.3f}, correlation {member.correlation:.3f}"
        cards.append(
            Card(
                f"m{k}",
                known[k],
                member.name,
                text,
                "Registered to the mean, from the front and from behind.",
                ("view", f"{path.parent}/members/{shorts[k]}.npz"),
                f"pictures/{quote(shorts[k], errors='surrogateescape')}.png",
                list(member.doubts),
            )
        )
    return ramp, cards


def write_tests(
    path: Path, group: Group, tests: Sequence[tuple[str, str, PointTest]], command: str = ""
) -> None:
    """Write tests into a group's page, or into one of their own: of each the variable, the findings, and the test."""
    text = ""
    if path.exists():
        text = path.read_text(encoding="utf-8")
    if _TESTS not in text:
        text = page("Tests of a group", _TESTS + _END)
    before, _, after = text.partition(_TESTS)
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
        captions = [f"From {found.levels[0]} to {level}" for level in found.levels[1:]]
        if not captions:
            captions = [f"A unit of {name} more"]
        body.append(
            _scene(
                [group.vertices] * len(lengths),
                group.faces,
                pose(group.vertices),
                [(caption, ramp, size) for caption, size in zip(captions, lengths, strict=True)],
                found.p[group.faces].max(axis=1) > LEVEL,
            )
        )
    write_html(path, before + "\n".join(body) + _END + after.partition(_END)[2])


def write_series_page(
    path: PathLike,
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
    cells = [list(map(_cell, row)) for row in rows]
    off = float(np.sqrt((found.drift**2).mean()))
    write_page(
        Path(path),
        "A series of surfaces",
        top(f"{len(names)} frames of one body", command),
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
        _TURN,
        f'<h2>Film</h2><figure><img src="{film}" alt="all frames"><figcaption>The frames, and the same colours on '
        "their mean.</figcaption></figure>",
        legend(ramp),
        "<h2>Frames</h2>",
        table(cells, [str(cell) for cell in header]),
    )


def _cell(value: object) -> str:
    """A text, or a number in five digits."""
    if isinstance(value, str):
        return value
    return f"{value:.5g}"


def _doubtful(note: str) -> str:
    return f"<p><strong>Doubtful: {escape(note)}.</strong></p>"


def _scene(
    bodies: Sequence[FloatArray],
    f: IntArray,
    turn: FloatArray,
    shown: Sequence[tuple[str, Ramp, FloatArray]],
    faint: BoolArray | None = None,
    left: float = 0.25,
) -> str:
    """Bodies to be turned, in one scale, each with its caption, a colour scale, and values over its vertices.

    Faces that are `faint` keep the share `left` of their colour, enough to see the surface's shape.
    """
    middle = np.mean(bodies, axis=(0, 1))
    radius = max(np.linalg.norm(body - middle, axis=1).max() for body in bodies)
    colour, none = np.ones((len(f), 1)), np.empty(0, dtype=np.int64)
    if faint is not None:
        colour[faint] = left
    views = []
    for body, (caption, ramp, values) in zip(bodies, shown, strict=True):
        painted = 1 - colour + colour * _by_face(ramp, values, f)
        views.append(View(caption, (body - middle) @ turn.T / radius, painted, none, ramp))
    return scene(f, views)


def _by_face(ramp: Ramp, values: FloatArray, f: IntArray) -> FloatArray:
    return ramp.colours(values[f].mean(axis=1))


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


def write_series_film(
    path: PathLike,
    found: Series,
    mean: FloatArray,
    pixels: int = 320,
    most: int = 200,
    least: tuple[int, int] = (80, 1920),
) -> None:
    """Write the frames, and beside them the mean surface, in the colours of the page, as an animated .gif.

    Pixels are those of a body's side; if there are too many frames, some are chosen, evenly. `least` are the shortest
    times of a frame and of the film, in milliseconds.
    """
    images, turn = import_optional("PIL.Image", "a film", "io"), pose(mean).T
    values, ramp = _over_time(found)
    chosen = np.unique(np.linspace(0, len(values) - 1, min(most, len(values))).round().astype(int))
    moving, still = found.aligned[chosen] @ turn, mean @ turn
    seen = frame(moving.reshape(-1, 3)), frame(still)
    pictures = []
    for k, body in zip(chosen, moving, strict=True):
        colours, drawn = _by_face(ramp, values[k], found.faces), []
        for v, shown in zip((body, still), seen, strict=True):
            shaded = colours * shading(v, found.faces, np.eye(3))[:, None]
            drawn.append(raster(v, found.faces, shaded, pixels, shown=shown))
        pictures.append(images.fromarray(np.concatenate(drawn, axis=1)))
    with replacing(path, force=True) as partial:
        pictures[0].save(
            partial,
            "GIF",
            save_all=True,
            append_images=pictures[1:],
            loop=0,
            duration=max(least[0], least[1] // len(pictures)),
        )
