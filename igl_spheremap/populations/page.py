"""A page about a population: distributions, and a sheet of pictures to sort, filter and rate, the worst first."""

from __future__ import annotations

import hashlib
import json
import os
import shlex
from collections.abc import Sequence
from dataclasses import fields
from html import escape
from importlib.resources import files
from pathlib import Path

import numpy as np

from ..draw.markup import page, table
from ..draw.palette import FOLDED, Ramp, diverging, round_up
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
from .table import FIGURES, MAPPED, Row, worst_first

SIZE = 180  # pixels of each of the four views
_AMBIENT = 0.6  # brightness of faces that the light grazes: colours must stay readable there
_BEHIND = np.array([-1.0, 1.0, -1.0])  # half a turn about the vertical
#: Right, up and towards the viewer, where hemispheres are seen from outside: FreeSurfer's x is right, y front, z up.
_LATERAL = {"CortexLeft": np.array([[0.0, -1, 0], [0, 0, 1], [-1, 0, 0]]),
            "CortexRight": np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])}
MOST = 2000  # pictures of one sheet: a page of 1,000 opens in 3 s
_BINS = 40
_SORTS = {"rank": "worst first", "source": "name", **FIGURES, "seconds": "seconds"}

_OURS = "<!-- igl_spheremap batch -->"


def check_page(folder: str | os.PathLike[str]) -> None:
    """Raise a FileError without Pillow, or if `index.html` in a folder is not one that `write_page` wrote."""
    import_optional("PIL", "a report", "io")
    path = Path(folder, "index.html")
    if path.exists() and not (path.is_file() and _OURS in path.read_text(encoding="utf-8", errors="replace")):
        raise FileError(f"{path} is no page of an earlier report, and is kept; give another folder for the report")


def write_page(
    folder: str | os.PathLike[str], rows: Sequence[Row], options: Options, processes: int | None = None
) -> Path:
    """Write `index.html` into a folder, with a page and a picture for each of the worst rows, and return its path.

    Pictures are drawn by processes, those that are there already are kept.
    """
    check_page(folder)
    base = Path(folder)
    (base / "subjects").mkdir(parents=True, exist_ok=True)
    shown = [rows[k] for k in worst_first(rows)[:MOST]]
    ramp = scale(rows)
    names = [hashlib.sha256(os.path.realpath(row.target).encode("utf-8", "surrogateescape")).hexdigest()[:16]
             for row in shown]
    pictures = [f"{name}-{ramp.high:g}.png" for name in names]
    drawn = _draw(shown, [str(base / "subjects" / picture) for picture in pictures], ramp, options, processes)
    pictures = [picture if there else "" for picture, there in zip(pictures, drawn, strict=True)]
    for row, name, picture in zip(shown, names, pictures, strict=True):
        _write(base / "subjects" / f"{name}.html", row.source, _subject(row, picture, ramp))
    cards = [_card(rank, *entry) for rank, entry in enumerate(zip(shown, names, pictures, strict=True))]
    certified = sum(row.status == "certified" for row in rows)
    left_out = f" The sheet shows the worst {MOST:,}." if len(rows) > MOST else ""
    code = files("igl_spheremap.draw").joinpath("population.js").read_text(encoding="utf-8")
    body = [_OURS, f"<h1>{certified:,} of {len(rows):,} maps are certified free of foldings</h1>",
            f'<div class="plots">{"".join(_histograms(rows))}</div>',
            "<h2>Maps</h2><p>Worst first: files without a map, then by foldings, then by the figure farthest above "
            f"those of the others.{left_out}</p>{_legend(ramp)}{_toolbar(rows)}",
            f'<div class="sheet">{"".join(cards)}</div><script>{code}</script>']
    return _write(base / "index.html", "Spherical maps", "\n".join(body))


def scale(rows: Sequence[Row]) -> Ramp:
    """Colours of logarithms of area ratios: half of the maps have 99 percent of their faces within."""
    finite = [row.p99_area for row in rows if np.isfinite(row.p99_area)]
    return diverging("", round_up(float(np.median(finite))) if finite else 1.0)


def _legend(ramp: Ramp) -> str:
    """The scale as a bar, with its ends as factors."""
    stops = ", ".join("rgb({:.0f} {:.0f} {:.0f})".format(*(255 * colour)) for colour in ramp.stops)
    factor = f"{np.exp(ramp.high):.3g}"
    return (f'<p class="legend">image area: 1/{factor} of its share <span style="background: linear-gradient(to right, '
            f'{stops})"></span> {factor} times its share; folded faces are vermilion</p>')


def _toolbar(rows: Sequence[Row]) -> str:
    """What sorts, filters and exports; population.js makes it work."""
    sorts = "".join(f'<option value="{key}">{escape(label)}</option>' for key, label in _SORTS.items())
    shown = ["all", *sorted({row.status for row in rows}), "passed", "failed by you", "not rated"]
    statuses = "".join(f"<option>{escape(one)}</option>" for one in shown)
    return (f'<form class="toolbar"><label>sort by <select name="sort">{sorts}</select></label> '
            f'<label>show <select name="status">{statuses}</select></label> '
            '<label>name has <input name="text" type="search"></label> '
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
    folded = folded_faces(x, mesh.f)
    tiles = []
    for turn in (view, view * _BEHIND):
        for y in (v, x):
            shaded = colours * shading(y, mesh.f, turn, _AMBIENT)[:, None]
            shaded[folded] = FOLDED
            tiles.append(raster(y @ turn, mesh.f, shaded, SIZE))
    write_picture(path, np.concatenate(tiles, axis=1), force=True)
    return True


def _card(rank: int, row: Row, name: str, picture: str) -> str:
    image = f'<img loading="lazy" alt="" src="subjects/{picture}">' if picture else ""
    text = row.notes if row.status not in MAPPED else (
        f"{row.foldings_before:,} → {row.foldings:,} foldings, angles {row.mean_angle:.3g}°, areas {row.mean_area:.3g}")
    bad = "" if row.status == "certified" else " bad"
    figures = {"rank": rank, "status": row.status, **{key: getattr(row, key) for key in _SORTS if key != "rank"}}
    data = escape(json.dumps({key: value if value == value else None for key, value in figures.items()}))
    return (f'<div class="card{bad}" data-row="{data}"><a href="subjects/{name}.html">{image}'
            f"<div>{escape(row.source)}</div><small>{escape(row.status)}: {escape(text)}</small></a></div>\n")


def _subject(row: Row, picture: str, ramp: Ramp) -> str:
    """The page of one map."""
    sides = "from the side and from the middle" if structure_of(row.source) else "from the front and from behind"
    image = (f'<p><img alt="" src="{picture}" width="{4 * SIZE}"></p><p>Surface and sphere {sides}.</p>{_legend(ramp)}'
             if picture else "")
    values = [(field.name, getattr(row, field.name)) for field in fields(Row)]
    figures = table((name.replace("_", " "), f"{value:.3g}" if isinstance(value, float) else str(value))
                    for name, value in values)
    command = shlex.join(("igl-spheremap", "view", row.source, row.target))
    return (f"<h1>{escape(row.source)}</h1>{image}{figures}<pre>{escape(command)}</pre>"
            '<p><a href="../index.html">all maps</a></p>')


def _histograms(rows: Sequence[Row]) -> list[str]:
    plots = []
    for name, label in FIGURES.items():
        values = np.array([getattr(row, name) for row in rows], dtype=np.float64)
        if len(values := values[np.isfinite(values)]):
            plots.append(_histogram(label, values))
    return plots


def _histogram(label: str, values: FloatArray) -> str:
    """Bars from the least value to the largest, with the median; a sentence where all are equal."""
    if np.ptp(values) == 0:
        return f"<figure><figcaption>{label}: {values[0]:.3g} in all</figcaption></figure>"
    counts, edges = np.histogram(values, bins=_BINS)
    bars = "".join(f'<rect x="{k}" y="{20 - 20 * count / counts.max():.2f}" width=".9" '
                   f'height="{20 * count / counts.max():.2f}"/>' for k, count in enumerate(counts) if count)
    return (f'<figure><svg viewBox="0 0 {_BINS} 20" role="img" aria-label="{label}">{bars}</svg><figcaption>{label}: '
            f"{edges[0]:.3g} to {edges[-1]:.3g}, median {np.median(values):.3g}</figcaption></figure>")


def _write(path: Path, title: str, body: str) -> Path:
    with replacing(path, force=True) as partial:
        partial.write_text(page(title, body), encoding="utf-8", errors="backslashreplace")
    return path
