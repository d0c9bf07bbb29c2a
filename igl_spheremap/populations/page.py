"""A page about a population: distributions, and a sheet of pictures of surfaces and spheres, the worst first."""

from __future__ import annotations

import hashlib
import os
import shlex
from collections.abc import Sequence
from dataclasses import fields
from html import escape
from pathlib import Path

import numpy as np

from ..draw.markup import page, table
from ..draw.palette import FOLDED, diverging
from ..draw.plot import pose, raster, shading
from ..errors import FileError
from ..io.files import read_sphere
from ..io.replacing import replacing
from ..io.textured import write_picture
from ..mesh.arrays import FloatArray
from ..mesh.check import check_mesh
from ..verify.distortion import mesh_area_distortion
from ..verify.signs import folded_faces
from .child import ProcessPool, own_child
from .job import Options
from .table import FIGURES, MAPPED, Row, worst_first

SIZE = 180  # pixels of each of the four views
REACH = 2.0  # logarithm of an area ratio at the ends of the colours
_AMBIENT = 0.6
_BEHIND = np.array([-1.0, 1.0, -1.0])  # half a turn about the vertical
MOST = 2000  # pictures of one sheet: a page of 1,000 opens in 3 s
_BINS = 40
_COLOURS = (f"Colours: the logarithm of image area over source area, purple at {-REACH:g}, white at 0, green at "
            f"{REACH:g}. Folded faces are vermilion.")

_OURS = "<!-- igl_spheremap batch -->"


def check_page(folder: str | os.PathLike[str]) -> None:
    """Raise a FileError if `index.html` in a folder is not one that `write_page` wrote."""
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
    names = [hashlib.sha256(os.path.realpath(row.target).encode("utf-8", "surrogateescape")).hexdigest()[:16]
             for row in shown]
    drawn = _draw(shown, [str(base / "subjects" / f"{name}.png") for name in names], options, processes)
    for row, name, has_picture in zip(shown, names, drawn, strict=True):
        _write(base / "subjects" / f"{name}.html", row.source, _subject(row, name, has_picture))
    cards = [_card(*entry) for entry in zip(shown, names, drawn, strict=True)]
    certified = sum(row.status == "certified" for row in rows)
    left_out = f" The sheet shows the worst {MOST:,}." if len(rows) > MOST else ""
    body = [_OURS, f"<h1>{certified:,} of {len(rows):,} maps are certified free of foldings</h1>",
            f'<div class="plots">{"".join(_histograms(rows))}</div>',
            f"<h2>Worst first</h2><p>Files without a map, then by foldings, then by the figure that is farthest above "
            f"those of the others. {_COLOURS}{left_out}</p>", f'<div class="sheet">{"".join(cards)}</div>']
    return _write(base / "index.html", "Spherical maps", "\n".join(body))


def _draw(rows: Sequence[Row], paths: Sequence[str], options: Options, processes: int | None) -> list[bool]:
    """Which rows have a picture."""
    pool = ProcessPool(processes or os.cpu_count() or 1)
    try:
        futures = [pool.submit(lambda *call: own_child().call(draw_row, *call), row, path, options)
                   for row, path in zip(rows, paths, strict=True)]
        return [future.exception() is None and future.result() for future in futures]
    finally:
        pool.end()


def draw_row(row: Row, path: str, options: Options) -> bool:
    """Draw surface and sphere from the front, then both from behind, unless the picture is newer than the map.

    Purple shrinks, green grows, folded faces are vermilion. False where the files hold no map.
    """
    source, target = options.place(row.source), options.place(row.target)
    if row.status not in MAPPED:
        return False
    if Path(path).exists() and os.stat(path).st_mtime_ns > os.stat(target).st_mtime_ns:
        return True
    v, f = options.repaired(options.read(source))
    x, _ = read_sphere(target)
    mesh, view = check_mesh(v, f), pose(v).T
    colours = diverging("", REACH).colours(mesh_area_distortion(mesh, x))
    folded = folded_faces(x, mesh.f)
    tiles = []
    for turn in (view, view * _BEHIND):
        for y in (v, x):
            shaded = colours * shading(y, mesh.f, turn, _AMBIENT)[:, None]
            shaded[folded] = FOLDED
            tiles.append(raster(y @ turn, mesh.f, shaded, SIZE))
    write_picture(path, np.concatenate(tiles, axis=1), force=True)
    return True


def _card(row: Row, name: str, has_picture: bool) -> str:
    picture = f'<img loading="lazy" alt="" src="subjects/{name}.png">' if has_picture else ""
    text = row.notes if row.status not in MAPPED else (
        f"{row.foldings_before:,} → {row.foldings:,} foldings, angles {row.mean_angle:.3g}°, areas {row.mean_area:.3g}")
    bad = "" if row.status == "certified" else " bad"
    return (f'<a class="card{bad}" href="subjects/{name}.html">{picture}<div>{escape(row.source)}</div>'
            f"<small>{escape(row.status)}: {escape(text)}</small></a>\n")


def _subject(row: Row, name: str, has_picture: bool) -> str:
    """The page of one map."""
    picture = f'<p><img alt="" src="{name}.png" width="{4 * SIZE}"></p><p>{_COLOURS}</p>' if has_picture else ""
    figures = table((field.name.replace("_", " "), str(getattr(row, field.name))) for field in fields(Row))
    command = shlex.join(("igl-spheremap", "view", row.source, row.target))
    return (f"<h1>{escape(row.source)}</h1>{picture}{figures}<pre>{escape(command)}</pre>"
            '<p><a href="../index.html">all maps</a></p>')


def _histograms(rows: Sequence[Row]) -> list[str]:
    plots = []
    for name, label in FIGURES.items():
        values = np.array([getattr(row, name) for row in rows], dtype=np.float64)
        if len(values := values[np.isfinite(values)]):
            plots.append(_histogram(label, values))
    return plots


def _histogram(label: str, values: FloatArray) -> str:
    """Bars from the least value to the largest, with the median."""
    counts, edges = np.histogram(values, bins=_BINS)
    bars = "".join(f'<rect x="{k}" y="{20 - 20 * count / counts.max():.2f}" width=".9" '
                   f'height="{20 * count / counts.max():.2f}"/>' for k, count in enumerate(counts) if count)
    return (f'<figure><svg viewBox="0 0 {_BINS} 20" role="img" aria-label="{label}">{bars}</svg><figcaption>{label}: '
            f"{edges[0]:.3g} to {edges[-1]:.3g}, median {np.median(values):.3g}</figcaption></figure>")


def _write(path: Path, title: str, body: str) -> Path:
    with replacing(path, force=True) as partial:
        partial.write_text(page(title, body), encoding="utf-8", errors="backslashreplace")
    return path
