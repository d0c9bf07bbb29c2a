"""A page about a population: distributions, and a sheet of pictures to sort, filter and rate, the worst first."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from ..draw.cards import Card, card_section, histogram
from ..draw.markup import data_address, small_png, top
from ..draw.palette import AREAS, FOLDED, Colour, Ramp, fitting
from ..draw.plot import both_sides, pose
from ..errors import import_optional
from ..gate import PathLike
from ..io.files import read_sphere
from ..io.hemispheres import LEFT, RIGHT, structure_of
from ..io.pages import check_own_page, page_file, write_page
from ..io.pictures import write_picture
from ..io.replacing import make_folder
from ..mesh.check import check_mesh
from ..verify.distortion import log_area_ratios
from ..verify.signs import folded_faces
from .child import ProcessPool, own_child
from .mapping import SphereMapping
from .table import MAPPED, OUTLIER, JobRow, Row, fences, figures_of, outlying, plain, worst_first

#: Right, up and towards the viewer, for hemispheres seen from outside: FreeSurfer's x is right, y front, z up.
LATERAL = {
    LEFT: np.array([[0.0, -1, 0], [0, 0, 1], [-1, 0, 0]]),
    RIGHT: np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]]),
}
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
    """Texts and pictures of a page for the rows of a task.

    Attributes
    ----------
    title, heading : str
        Of the window and of the page.
    nouns : str
        Subjects of the pictures, such as "maps".
    draw : function of a row
        Draws its picture to a path, in a process, unless it is there; without anything to draw it returns False.
    look : str
        Causes of changes of pictures besides their files, as a part of their names.
    legends : sequence of (str, colour) or Ramp
        Of the pictures.
    text, caption : functions of a row
        The line of its card; the caption of its picture.
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


def check_page(place: PathLike) -> Path:
    """The file of a page: `place` if it ends in .html, else `index.html` in that folder.

    Without Pillow, or if there is a file that `write_population_page` did not write, raise a FileError; if the place is
    neither, a ValueError.
    """
    import_optional("PIL", "a report", "io")
    path = page_file(place, "index.html")
    check_own_page(path)
    return path


def write_population_page(
    place: PathLike, rows: Sequence[JobRow], sheet: Sheet, processes: int | None = None, *,
    command: str = "", most: int = 2000,
) -> Path:  # fmt: skip
    """Write a page with all rows and a picture of each, the worst first, and return its path.

    If `place` ends in .html, it is one file with pictures of the `most` worst, of some 15 kB each. Else it is
    `index.html` in that folder with the pictures beside it, which are kept for the next page. They are drawn by
    processes.
    """
    path = check_page(place)
    make_folder(path.parent)
    apart = Path(place) != path
    shown, left_out, folder = [rows[k] for k in worst_first(rows)], "", None
    pictured = shown
    if apart:
        folder = make_folder(path.parent / "subjects", follow=False)
    elif len(rows) > most:
        pictured, left_out = shown[:most], f" The worst {most:,} have pictures."
    addresses = _pictures(pictured, folder, sheet, processes)
    limits, (where, short) = fences(rows), _short([row.source for row in rows])
    cards = [
        _card(row, short[row.source], limits, sheet, addresses.get(_key(row), "")) for row in shown
    ]
    figures = figures_of(rows)
    section = card_section(
        cards,
        sheet.nouns,
        f"Sorted worst first: failed files, folded maps, then outliers, more than {OUTLIER:g} interquartile ranges "
        f"above the third quartile. Click a picture to see all of it, a bar, where there are some, to see its "
        f"{sheet.nouns}.{left_out}",
        [
            histogram(
                name,
                label,
                np.array([getattr(row, name) for row in rows], dtype=np.float64),
                sheet.nouns,
                limits[name],
                _AXES[name.rpartition("_")[2]],
            )
            for name, label in figures.items()
        ],
        {**figures, "seconds": "seconds", "memory": "MB of memory"},
        sheet.legends,
    )
    write_page(path, sheet.title, top(sheet.heading, command), where, section)
    return path


def _key(row: JobRow) -> str:
    """The address of a row, on a page and among pictures."""
    path = os.path.realpath(row.target).encode("utf-8", "surrogateescape")
    return hashlib.sha256(path).hexdigest()[:16]


def _pictures(
    rows: Sequence[JobRow], folder: Path | None, sheet: Sheet, processes: int | None
) -> dict[str, str]:
    """The addresses of pictures by those of rows: of files in a folder, or of content of the page."""
    with TemporaryDirectory() as temporary:
        paths = {_key(row): f"{folder or temporary}/{_key(row)}-{sheet.look}.png" for row in rows}
        drawn = _draw(rows, [*paths.values()], sheet, processes)
        found = {
            key: path for (key, path), there in zip(paths.items(), drawn, strict=True) if there
        }
        if folder is None:
            return {key: data_address(small_png(Path(path))) for key, path in found.items()}
    return {key: f"subjects/{Path(path).name}" for key, path in found.items()}


def map_sheet(rows: Sequence[Row], task: SphereMapping) -> Sheet:
    """The pictures of maps: surfaces and spheres in the colours of areas."""
    ramp = area_ramp(rows)

    def caption(row: Row) -> str:
        views = "the front and from behind"
        if structure_of(row.source):
            views = "the side and from the middle"
        return f"Surface and sphere from {views}."

    return Sheet(
        title="Spherical maps",
        heading=f"{share_certified(rows)} maps are certified free of foldings",
        nouns="maps",
        draw=lambda row: partial(draw_row, row, ramp=ramp, task=task),
        look=f"{ramp.high:g}",
        legends=(ramp, ("folded face", FOLDED)),
        text=lambda row: (
            f"{row.foldings_before:,} → {row.foldings:,} foldings, angles {row.mean_angle:.3g}°, areas "
            f"{row.mean_area:.3g}"
        ),
        caption=caption,
        command=view_words,
    )


def view_words(row: JobRow) -> Sequence[str]:
    """The command that shows a row's surface with its result."""
    return "view", row.source, row.target


def share_certified(rows: Sequence[JobRow]) -> str:
    """The number of certified rows, as "3 of 4"."""
    return f"{sum(row.status == 'certified' for row in rows):,} of {len(rows):,}"


def area_ramp(rows: Sequence[Row]) -> Ramp:
    """Colours of areas, the same for all maps: the mean logarithms of three fifths of them lie within."""
    return fitting(AREAS, np.array([row.mean_area for row in rows]))


def _short(names: Sequence[str]) -> tuple[str, dict[str, str]]:
    """A line with the common folder and ending of all names, and the rest of each.

    >>> _short(["a/b/c.ply", "a/d.ply"])
    ('<p>Files in a/ that end in .ply</p>', {'a/b/c.ply': 'b/c', 'a/d.ply': 'd'})
    >>> _short(["/a/b.ply", "c.obj"])
    ('', {'/a/b.ply': '/a/b.ply', 'c.obj': 'c.obj'})
    """
    endings = {Path(name).suffix for name in names}
    short, said = {name: Path(name).as_posix() for name in names}, ""
    try:
        common = Path(os.path.commonpath([Path(name).parent for name in names]))
    except ValueError:  # there are no names, or absolute and relative ones
        common = Path()
    if common != Path():
        short = {name: Path(name).relative_to(common).as_posix() for name in names}
        said = f" in {common.as_posix().rstrip('/')}/"
    if len(endings) == 1 and (ending := endings.pop()):
        short = {name: text.removesuffix(ending) for name, text in short.items()}
        said += f" that end in {ending}"
    if said:
        said = f"<p>Files{escape(said)}</p>"
    return said, short


def _draw(
    rows: Sequence[JobRow], paths: Sequence[str], sheet: Sheet, processes: int | None
) -> list[bool]:
    """Whether each row has a picture."""
    pool = ProcessPool(processes)
    try:
        futures = [
            pool.submit(lambda *call: own_child().call(*call), sheet.draw(row), path)
            for row, path in zip(rows, paths, strict=True)
        ]
        return [future.exception() is None and future.result() for future in futures]
    finally:
        pool.end()


def draw_row(row: Row, path: str, ramp: Ramp, task: SphereMapping, size: int = 180) -> bool:
    """Draw surface and sphere from the front, then both from behind, unless the picture is newer than the map.

    Each of the four views has `size` pixels a side. Hemispheres are seen from the side, then from the middle. If the
    files hold no map, False.
    """
    source, target = task.place(row.source), task.place(row.target)
    if row.status not in MAPPED:
        return False
    if is_newer(path, target):
        return True
    v, f, _ = task.repaired(task.read(source))
    x, _ = read_sphere(target)
    mesh, side = check_mesh(v, f), LATERAL.get(structure_of(source).get("structure", ""))
    if side is None:
        side = pose(v)
    colours = ramp.colours(log_area_ratios(mesh.unit, mesh.f, x))
    folded = np.flatnonzero(folded_faces(x, mesh.f))
    write_picture(path, both_sides([v, x], mesh.f, colours, side.T, size, folded), force=True)
    return True


def is_newer(path: str, other: str) -> bool:
    """Whether a file exists, is no link, and is newer than another one."""
    here = Path(path).exists() and not os.path.islink(path)
    return here and os.stat(path).st_mtime_ns > os.stat(other).st_mtime_ns


def _card(row: JobRow, name: str, limits: Mapping[str, float], sheet: Sheet, picture: str) -> Card:
    """A row in the sheet."""
    text = row.notes
    if row.status in MAPPED:
        text = sheet.text(row)
    reasons = [
        f"{row.FIGURES[key]} {getattr(row, key):.3g} > {limits[key]:.3g}"
        for key in outlying(row, limits)
    ]
    return Card(
        _key(row),
        plain(row),
        name,
        f"{row.status}: {text}",
        sheet.caption(row),
        sheet.command(row),
        picture,
        reasons,
        row.status == "certified",
    )
