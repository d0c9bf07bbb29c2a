"""A page about a population: distributions, and a sheet of pictures to sort, filter and rate, the worst first."""

from __future__ import annotations

import hashlib
import json
import math
import os
import shlex
from collections.abc import Mapping, Sequence
from datetime import datetime
from html import escape
from importlib.resources import files
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from ..draw.markup import data_address, legend, made_by, page, page_file, small_png, wrapping
from ..draw.palette import FOLDED, Ramp, areas
from ..draw.plot import pose, raster, shading
from ..errors import FileError, import_optional
from ..io.files import read_sphere
from ..io.gifti import structure_of
from ..io.replacing import replacing
from ..io.textured import write_picture
from ..mesh.arrays import FloatArray
from ..mesh.check import check_mesh
from ..verify.distortion import area_distortion
from ..verify.signs import folded_faces
from .child import ProcessPool, own_child
from .job import Options
from .table import FIGURES, MAPPED, OUTLIER, Row, fences, outlying, plain, worst_first

SIZE = 180  # pixels of each of the four views
_AMBIENT = 0.6  # brightness of faces that the light grazes: colours must stay readable there
_BEHIND = np.array([-1.0, 1.0, -1.0])  # half a turn about the vertical
#: Right, up and towards the viewer, where hemispheres are seen from outside: FreeSurfer's x is right, y front, z up.
_LATERAL = {"CortexLeft": np.array([[0.0, -1, 0], [0, 0, 1], [-1, 0, 0]]),
            "CortexRight": np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])}
MOST = 2000  # pictures of one sheet: a page of 1,000 opens in 3 s
_BINS = 30
_SORTS = {"rank": "worst first", "source": "name", **FIGURES, "seconds": "seconds"}
#: What the axes of figures measure, by the ends of their names.
_AXES = {"angle": "degrees", "area": "|ln(image area / source area)|", "edge": "|ln(image / source length)|",
         "stretch": "times shorter"}
_BADGES = 3  # reasons on a card; the page of a map has all
#: Width and height of a histogram, and the room below, beside and above its bars, in units of its drawing.
_WIDTH, _HEIGHT, _AXIS, _SIDE, _TOP = 240, 120, 26, 12, 14

_OURS = "<!-- igl_spheremap batch -->"


def check_page(place: str | os.PathLike[str]) -> Path:
    """The file of a page: `place` if it ends in .html, else `index.html` in that folder.

    Raise a FileError without Pillow, or if there is a file that `write_page` did not write; a ValueError if the place
    is neither.
    """
    import_optional("PIL", "a report", "io")
    path = page_file(place, "index.html")
    if path.exists() and not (path.is_file() and _OURS in path.read_text(encoding="utf-8", errors="replace")):
        raise FileError(f"{path} is no page of an earlier report, and is kept; give another place for the report")
    return path


def write_page(
    place: str | os.PathLike[str], rows: Sequence[Row], options: Options, processes: int | None = None, *,
    began: str, command: str = "",
) -> Path:  # fmt: skip
    """Write a page with the worst rows and a picture of each, and return its path.

    It is one file if `place` ends in .html, else `index.html` in that folder with the pictures beside it, which are
    kept for the next page. They are drawn by processes. `began` is when the run did, by ISO 8601.
    """
    path = check_page(place)
    path.parent.mkdir(parents=True, exist_ok=True)
    shown = [rows[k] for k in worst_first(rows)[:MOST]]
    ramp, limits = scale(rows), fences(rows)
    names = [hashlib.sha256(os.path.realpath(row.target).encode("utf-8", "surrogateescape")).hexdigest()[:16]
             for row in shown]
    with TemporaryDirectory() as temporary:
        apart = Path(place) != path
        folder = path.parent / "subjects" if apart else Path(temporary)
        folder.mkdir(exist_ok=True)
        files_of = [folder / f"{name}-{ramp.high:g}.png" for name in names]
        drawn = _draw(shown, [str(file) for file in files_of], ramp, options, processes)
        addresses = [(f"subjects/{file.name}" if apart else data_address(small_png(file))) if there else ""
                     for file, there in zip(files_of, drawn, strict=True)]
    folder_of_all, ending, short = _short([row.source for row in rows])
    cards = [_card(rank, row, name, address, short[row.source], limits)
             for rank, (row, name, address) in enumerate(zip(shown, names, addresses, strict=True))]
    certified = sum(row.status == "certified" for row in rows)
    left_out = f" The sheet shows the worst {MOST:,}." if len(rows) > MOST else ""
    where = " ".join(filter(None, (folder_of_all and f"in {folder_of_all}", ending and f"that end in {ending}")))
    code = files("igl_spheremap.draw").joinpath("population.js").read_text(encoding="utf-8")
    body = [_OURS, f"<h1>{certified:,} of {len(rows):,} maps are certified free of foldings</h1>",
            made_by(command, datetime.fromisoformat(began)),
            f"<p>Files {escape(where)}</p>" if where else "",
            f'<div class="plots">{"".join(_histograms(rows, limits))}</div>',
            "<h2>Maps</h2><p>Worst first: files without a map, then by foldings, then by the figure farthest above "
            f"those of the others. Outliers lie more than {OUTLIER:g} interquartile ranges above the third quartile. "
            f"Click a bar to see its maps, a map to see all of it.{left_out}</p>",
            f'<div class="legends">{legend(ramp)}{legend(("folded face", FOLDED))}</div>', _toolbar(rows),
            f'<div class="sheet">{"".join(cards)}</div><dialog></dialog><script>{code}</script>']
    with replacing(path, force=True) as partial:
        partial.write_text(page("Spherical maps", "\n".join(filter(None, body))), encoding="utf-8",
                           errors="backslashreplace")
    return path


def scale(rows: Sequence[Row]) -> Ramp:
    """Colours of areas, the same for all maps: the mean logarithms of three fifths of them lie within."""
    return areas(np.array([row.mean_area for row in rows]))


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
    short = {name: (Path(name).relative_to(common) if common != Path() else Path(name)).as_posix() for name in names}
    folder = "" if common == Path() else f"{common.as_posix().rstrip('/')}/"
    return folder, ending, {name: text.removesuffix(ending) for name, text in short.items()}


def _toolbar(rows: Sequence[Row]) -> str:
    """What sorts, filters and exports; population.js makes it work."""
    sorts = "".join(f'<option value="{key}">{escape(label)}</option>' for key, label in _SORTS.items())
    shown = ["all", *sorted({row.status for row in rows}), "outliers", "passed", "failed by you", "not rated"]
    statuses = "".join(f"<option>{escape(one)}</option>" for one in shown)
    return (f'<form class="toolbar"><label>sort by <select name="sort">{sorts}</select></label> '
            f'<label>show <select name="status">{statuses}</select></label> '
            '<label>name has <input name="text" type="search"></label> '
            '<button type="button" name="bars" hidden></button> '
            '<button type="button" name="export">Save ratings as TSV</button> <output></output></form>')


def _draw(
    rows: Sequence[Row], paths: Sequence[str], ramp: Ramp, options: Options, processes: int | None
) -> list[bool]:
    """Which rows have a picture."""
    pool = ProcessPool(processes or os.cpu_count() or 1)
    try:
        futures = [pool.submit(lambda *call: own_child().call(draw_row, *call), row, path, ramp, options)
                   for row, path in zip(rows, paths, strict=True)]
        return [future.exception() is None and future.result() for future in futures]
    finally:
        pool.end()


def draw_row(row: Row, path: str, ramp: Ramp, options: Options) -> bool:
    """Draw surface and sphere from the front, then both from behind, unless the picture is newer than the map.

    Hemispheres are seen from the side, then from the middle. False where the files hold no map.
    """
    source, target = options.place(row.source), options.place(row.target)
    if row.status not in MAPPED:
        return False
    if Path(path).exists() and os.stat(path).st_mtime_ns > os.stat(target).st_mtime_ns:
        return True
    v, f, _ = options.repaired(options.read(source))
    x, _ = read_sphere(target)
    mesh, side = check_mesh(v, f), _LATERAL.get(structure_of(source).get("structure", ""))
    view = (pose(v) if side is None else side).T
    colours = ramp.colours(area_distortion(mesh.v, mesh.f, x))
    folded = np.flatnonzero(folded_faces(x, mesh.f))
    tiles = [raster(y @ turn, mesh.f, colours * shading(y, mesh.f, turn, _AMBIENT)[:, None], SIZE, folded)
             for turn in (view, view * _BEHIND) for y in (v, x)]
    write_picture(path, np.concatenate(tiles, axis=1), force=True)
    return True


def _card(rank: int, row: Row, name: str, address: str, short: str, limits: Mapping[str, float]) -> str:
    """A map in the sheet; population.js makes its page of what is in the attribute."""
    text = row.notes if row.status not in MAPPED else (
        f"{row.foldings_before:,} → {row.foldings:,} foldings, angles {row.mean_angle:.3g}°, areas {row.mean_area:.3g}")
    reasons = [f"{FIGURES[key]} {getattr(row, key):.3g} > {limits[key]:.3g}" for key in outlying(row, limits)]
    more = [f"and {len(reasons) - _BADGES} more"] if len(reasons) > _BADGES else []
    badges = "".join(f'<span class="badge">{escape(reason)}</span> ' for reason in (*reasons[:_BADGES], *more))
    sides = "from the side and from the middle" if structure_of(row.source) else "from the front and from behind"
    data = {"rank": rank, "row": plain(row), "reasons": reasons, "sides": sides,
            "command": shlex.join(("igl-spheremap", "view", row.source, row.target))}
    image = f'<img loading="lazy" alt="" src="{address}">' if address else ""
    return (f'<div class="card{"" if row.status == "certified" else " bad"}" id="{name}" '
            f'data-map="{escape(json.dumps(data))}"><a href="#{name}">{image}<div>{wrapping(short)}</div>'
            f"<small>{escape(row.status)}: {escape(text)}</small></a><div>{badges}</div></div>\n")


def _histograms(rows: Sequence[Row], limits: Mapping[str, float]) -> list[str]:
    plots = []
    for name, label in FIGURES.items():
        values = np.array([getattr(row, name) for row in rows], dtype=np.float64)
        if len(values := values[np.isfinite(values)]):
            plots.append(_histogram(name, label, values, limits[name]))
    return plots


def _histogram(name: str, label: str, values: FloatArray, limit: float) -> str:
    """Bars of maps by a figure, outliers in one of their own; a sentence where all are equal."""
    if np.ptp(values) == 0:
        return f"<figure><figcaption>{label}: {values[0]:.3g} in all</figcaption></figure>"
    ends = float(values.min()), min(limit, float(values.max()))
    if ends[0] == ends[1]:
        ends = ends[0] - 0.5, ends[1] + 0.5
    counts, edges = np.histogram(values, bins=_BINS, range=ends)
    edges[-1] = np.nextafter(edges[-1], math.inf)  # the last bar has its upper end
    bars = [(k, int(count), *edges[k : k + 2].tolist()) for k, count in enumerate(counts)]
    bars.append((_BINS + 1, int((values > limit).sum()), limit, math.inf))
    step, most = (_WIDTH - _SIDE) / (_BINS + 2.5), max(count for _, count, _, _ in bars)
    room = _HEIGHT - _AXIS - _TOP
    drawn = []
    for k, count, low, high in bars:
        x, height = _SIDE + k * step, max(room * count / most, 1.5)
        outliers = high == math.inf
        said = f"{count} above {low:.3g}" if outliers else f"{count} from {low:.3g} to {high:.3g}"
        if count:
            drawn.append(
                f'<g class="bar{" outliers" if outliers else ""}" data-figure="{name}" data-low="{low!r}" '
                f'data-high="{"" if outliers else repr(high)}" data-said="{label} {said}"><title>{said}: click</title>'
                f'<rect class="hit" x="{x:.1f}" y="{_TOP}" width="{step:.1f}" height="{room}"/><rect x="{x:.1f}" '
                f'y="{_TOP + room - height:.1f}" width="{0.9 * step:.1f}" height="{height:.1f}"/></g>')
    base, end = _HEIGHT - _AXIS, _SIDE + _BINS * step
    last = (_WIDTH, "> ") if bars[-1][1] else (end, "")
    texts = [(0, 9, "start", f"{most} maps"), (_SIDE - 3, base, "end", "0"),
             (_SIDE, base + 11, "start", f"{edges[0]:.3g}"), (last[0], base + 11, "end", f"{last[1]}{edges[-1]:.3g}"),
             ((_SIDE + end) / 2, base + 23, "middle", _AXES[name.rpartition("_")[2]])]
    words = "".join(f'<text x="{x:.1f}" y="{y}" text-anchor="{anchor}">{escape(text)}</text>'
                    for x, y, anchor, text in texts)
    caption = f"{label}: median {np.median(values):.3g}, largest {values.max():.3g}"
    return (f'<figure><svg viewBox="0 0 {_WIDTH} {_HEIGHT}" role="img" aria-label="{caption}">'
            f'<path d="M{_SIDE} {_TOP}V{base}H{_WIDTH}"/>{"".join(drawn)}{words}</svg>'
            f"<figcaption>{caption}</figcaption></figure>")
