"""A page about a population: distributions, and a sheet of pictures to sort, filter and rate, the worst first."""

from __future__ import annotations

import hashlib
import os
import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from ..draw.cards import Card, card_sheet, histogram
from ..draw.markup import check_own_page, data_address, made_by, page, page_file, small_png
from ..draw.palette import AREAS, FOLDED, Colour, Ramp, fitting
from ..draw.plot import both_sides, pose
from ..errors import import_optional
from ..io.files import read_sphere
from ..io.hemispheres import LEFT, RIGHT, structure_of
from ..io.pictures import write_picture
from ..io.replacing import make_folder, replacing
from ..mesh.check import check_mesh
from ..verify.distortion import log_area_ratios
from ..verify.signs import folded_faces
from .child import ProcessPool, own_child
from .mapping import SphereMapping
from .table import MAPPED, OUTLIER, JobRow, Row, fences, figures_of, outlying, plain, worst_first

SIZE = 180  # pixels of each of the four views
#: Right, up and towards the viewer, where hemispheres are seen from outside: FreeSurfer's x is right, y front, z up.
LATERAL = {
    LEFT: np.array([[0.0, -1, 0], [0, 0, 1], [-1, 0, 0]]),
    RIGHT: np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]]),
}
# pictures within a page that is one file, of some 15 kB each; in a folder they are files of their own
MOST = 2000
#: What the axes of figures measure, by the ends of their names.
_AXES = {
    "angle": "degrees",
    "area": "|ln(image area / source area)|",
    "edge": "|ln(image / source length)|",
    "stretch": "times shorter",
    "unlike": "1 - correlation of depth",
    "unsure": "share of the vertices",
}


@dataclass(frozen=True)
class Sheet:
    """What a page says and draws of the rows of a task.

    Attributes
    ----------
    title, heading : str
        Of the window and of the page.
    nouns : str
        What the pictures show, such as "maps".
    draw : function of a row
        What draws its picture to a path, in a process, unless it is there; it returns False where there is nothing to
        draw.
    look : str
        What changes pictures besides their files, as a part of their names.
    legends : sequence of (str, colour) or Ramp
        Of the pictures.
    text, caption : functions of a row
        The line of its card; what its picture shows.
    command : function of a row
        The words by which a person looks closer.
    """

    title: str
    heading: str
    nouns: str
    draw: Callable[[Any], Callable[[str], bool]]
    look: str
    legends: Sequence[Ramp | tuple[str, Colour]]
    text: Callable[[Any], str]
    caption: Callable[[Any], str]
    command: Callable[[Any], Sequence[str]]


def check_page(place: str | os.PathLike[str]) -> Path:
    """The file of a page: `place` if it ends in .html, else `index.html` in that folder.

    Raise a FileError without Pillow, or if there is a file that `write_page` did not write; a ValueError if the place
    is neither.
    """
    import_optional("PIL", "a report", "io")
    path = page_file(place, "index.html")
    check_own_page(path)
    return path


def write_page(
    place: str | os.PathLike[str], rows: Sequence[JobRow], sheet: Sheet, processes: int | None = None, *,
    command: str = "",
) -> Path:  # fmt: skip
    """Write a page with all rows and a picture of each, the worst first, and return its path.

    It is one file if `place` ends in .html, with pictures of the worst, else `index.html` in that folder with the
    pictures beside it, which are kept for the next page. They are drawn by processes.
    """
    path = check_page(place)
    make_folder(path.parent)
    apart = Path(place) != path
    shown = [rows[k] for k in worst_first(rows)]
    pictured = shown if apart else shown[:MOST]
    limits = fences(rows)
    names = [
        hashlib.sha256(os.path.realpath(row.target).encode("utf-8", "surrogateescape")).hexdigest()[
            :16
        ]
        for row in shown
    ]
    with TemporaryDirectory() as temporary:
        folder = path.parent / "subjects" if apart else Path(temporary)
        make_folder(folder, follow=False)
        files_of = [folder / f"{name}-{sheet.look}.png" for name in names[: len(pictured)]]
        drawn = _draw(pictured, [str(file) for file in files_of], sheet, processes)
        addresses = [
            (f"subjects/{file.name}" if apart else data_address(small_png(file))) if there else ""
            for file, there in zip(files_of, drawn, strict=True)
        ] + [""] * (len(shown) - len(pictured))
    folder_of_all, ending, short = _short([row.source for row in rows])
    cards = [
        _card(row, name, address, short[row.source], limits, sheet)
        for row, name, address in zip(shown, names, addresses, strict=True)
    ]
    left_out = f" The worst {MOST:,} have pictures." if len(rows) > len(pictured) else ""
    where = " ".join(
        filter(None, (folder_of_all and f"in {folder_of_all}", ending and f"that end in {ending}"))
    )
    plots = [
        histogram(
            name,
            label,
            np.array([getattr(row, name) for row in rows], dtype=np.float64),
            limits[name],
            _AXES[name.rpartition("_")[2]],
            sheet.nouns,
        )
        for name, label in figures_of(rows).items()
    ]
    body = [
        f"<h1>{escape(sheet.heading)}</h1>",
        made_by(command),
        f"<p>Files {escape(where)}</p>" if where else "",
        f'<div class="plots">{"".join(plots)}</div>',
        f"<h2>{sheet.nouns.capitalize()}</h2><p>Worst first: files without a map, then by foldings, then by the "
        f"figure farthest above those of the others. Outliers lie more than {OUTLIER:g} interquartile ranges above "
        f"the third quartile. Click a bar to see its {sheet.nouns}, a picture to see all of it.{left_out}</p>",
        card_sheet(
            cards,
            {**figures_of(rows), "seconds": "seconds", "memory": "MB of memory"},
            sheet.legends,
        ),
    ]
    with replacing(path, force=True) as partial:
        partial.write_text(
            page(sheet.title, "\n".join(filter(None, body))),
            encoding="utf-8",
            errors="backslashreplace",
        )
    return path


def map_sheet(rows: Sequence[Row], task: SphereMapping) -> Sheet:
    """The pictures of maps: surfaces and spheres in the colours of areas."""
    ramp = scale(rows)
    return Sheet(
        "Spherical maps", f"{share_certified(rows)} maps are certified free of foldings", "maps",
        lambda row: partial(draw_row, row, ramp=ramp, task=task), f"{ramp.high:g}",
        (ramp, ("folded face", FOLDED)),
        lambda row: f"{row.foldings_before:,} → {row.foldings:,} foldings, angles {row.mean_angle:.3g}°, areas "
                    f"{row.mean_area:.3g}",
        lambda row: "Surface and sphere from "
                    f"{'the side and from the middle' if structure_of(row.source) else 'the front and from behind'}.",
        lambda row: ("view", row.source, row.target),
    )  # fmt: skip


def share_certified(rows: Sequence[JobRow]) -> str:
    """How many of the rows are certified, as "3 of 4"."""
    return f"{sum(row.status == 'certified' for row in rows):,} of {len(rows):,}"


def scale(rows: Sequence[Row]) -> Ramp:
    """Colours of areas, the same for all maps: the mean logarithms of three fifths of them lie within."""
    return fitting(AREAS, np.array([row.mean_area for row in rows]))


def _short(names: Sequence[str]) -> tuple[str, str, dict[str, str]]:
    """The folder and the ending that all names have, and what is left of each.

    >>> _short(["a/b/c.ply", "a/d.ply"])
    ('a/', '.ply', {'a/b/c.ply': 'b/c', 'a/d.ply': 'd'})
    >>> _short(["/a/b.ply", "c.obj"])
    ('', '', {'/a/b.ply': '/a/b.ply', 'c.obj': 'c.obj'})
    """
    endings = {Path(name).suffix for name in names}
    ending = endings.pop() if len(endings) == 1 else ""
    try:
        common = Path(os.path.commonpath([Path(name).parent for name in names]))
    except ValueError:  # there are no names, or absolute and relative ones
        common = Path()
    short = {
        name: (Path(name).relative_to(common) if common != Path() else Path(name)).as_posix()
        for name in names
    }
    folder = "" if common == Path() else f"{common.as_posix().rstrip('/')}/"
    return folder, ending, {name: text.removesuffix(ending) for name, text in short.items()}


def _draw(
    rows: Sequence[JobRow], paths: Sequence[str], sheet: Sheet, processes: int | None
) -> list[bool]:
    """Which rows have a picture."""
    pool = ProcessPool(processes)
    try:
        futures = [
            pool.submit(lambda *call: own_child().call(*call), sheet.draw(row), path)
            for row, path in zip(rows, paths, strict=True)
        ]
        return [future.exception() is None and future.result() for future in futures]
    finally:
        pool.end()


def draw_row(row: Row, path: str, ramp: Ramp, task: SphereMapping) -> bool:
    """Draw surface and sphere from the front, then both from behind, unless the picture is newer than the map.

    Hemispheres are seen from the side, then from the middle. False where the files hold no map.
    """
    source, target = task.place(row.source), task.place(row.target)
    if row.status not in MAPPED:
        return False
    if is_newer(path, target):
        return True
    v, f, _ = task.repaired(task.read(source))
    x, _ = read_sphere(target)
    mesh, side = check_mesh(v, f), LATERAL.get(structure_of(source).get("structure", ""))
    view = (pose(v) if side is None else side).T
    colours = ramp.colours(log_area_ratios(mesh.unit, mesh.f, x))
    folded = np.flatnonzero(folded_faces(x, mesh.f))
    write_picture(path, both_sides([v, x], mesh.f, colours, view, SIZE, folded), force=True)
    return True


def is_newer(path: str, other: str) -> bool:
    """Whether a file is there, no link to one, and was made after another one."""
    here = Path(path).exists() and not os.path.islink(path)
    return here and os.stat(path).st_mtime_ns > os.stat(other).st_mtime_ns


def _card(
    row: JobRow, name: str, address: str, short: str, limits: Mapping[str, float], sheet: Sheet
) -> Card:
    """A row in the sheet."""
    text = row.notes if row.status not in MAPPED else sheet.text(row)
    reasons = [
        f"{row.FIGURES[key]} {getattr(row, key):.3g} > {limits[key]:.3g}"
        for key in outlying(row, limits)
    ]
    return Card(
        name,
        plain(row),
        short,
        f"{row.status}: {text}",
        sheet.caption(row),
        shlex.join(("igl-spheremap", *sheet.command(row))),
        address,
        reasons,
        row.status == "certified",
    )
