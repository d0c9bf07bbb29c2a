"""Figures by matplotlib, and shaded surfaces as pixels by numpy alone: no display, no OpenGL."""

from __future__ import annotations

import io
import math
from collections.abc import Iterator, Sequence
from typing import Any

import igl
import numpy as np
from numpy.typing import NDArray

from ..errors import import_optional, legible
from ..mesh.arrays import TINY, FloatArray, IntArray
from ..mesh.measure import face_areas
from .folds import MANY, SEEN
from .palette import AREAS, FOLDED, LINES, Ramp, fitting

#: Formats of saved figures.
FORMATS = (".png", ".svg", ".pdf")
SMALL = 8  # points, of small text


def new_figure(
    rows: int, columns: int, title: str, size: tuple[float, float] = (3.2, 3.4)
) -> tuple[Any, Any]:
    """A matplotlib figure without pyplot, which opens no window, and its axes (rows, columns) of `size` in inches."""
    base = import_optional("matplotlib.figure", "a figure", "plot").Figure
    # Notebooks show a bare figure only after pyplot was imported there, but anything with this method at once.
    shown = type("Figure", (base,), {"_repr_png_": _png})
    figure = shown(figsize=(size[0] * columns, size[1] * rows), layout="constrained", dpi=150)
    # names of files may hold what matplotlib takes for formulas
    figure.suptitle(legible(title), fontsize=11, parse_math=False)
    axes = figure.subplots(rows, columns, squeeze=False)
    for ax in axes.ravel():
        ax.spines[["top", "right"]].set_visible(False)
    return figure, axes


def _png(figure: Any) -> bytes:
    """The figure as a PNG file."""
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=100)
    return stream.getvalue()


def plot_angles(ax: Any, differences: FloatArray) -> None:
    """Histogram of angle differences; the outermost half percent are in the bars at the ends."""
    ax.set_xlabel("image minus source, degrees", fontsize=SMALL)
    _histogram(ax, differences.ravel(), "of the corners", "angle differences: mean size", "°")


def plot_areas(ax: Any, ratios: FloatArray) -> None:
    """Histogram of logarithms of area ratios; the outermost half percent are in the bars at the ends."""
    ax.set_xlabel("ln(image area / source area)", fontsize=SMALL)
    _histogram(
        ax, ratios[~np.isnan(ratios)], "of the faces", "areas: mean size of the logarithm", ""
    )


def _histogram(
    ax: Any,
    values: FloatArray,
    of: str,
    name: str,
    unit: str,
    bins: int = 81,
    beyond: float = 0.5,
) -> None:
    """Shares of values on an axis without that percentage of them; the bars at its ends hold these.

    The number of bins is odd: the middle one is about 0.
    """
    size = np.abs(values[np.isfinite(values)])
    ax.set_title(f"{name} {size.mean():.3g}{unit},\n99% below {np.percentile(size, 99):.3g}{unit}, "
                 f"largest {size.max():.3g}{unit}", fontsize=SMALL)  # fmt: skip
    low, high = np.percentile(values[np.isfinite(values)], (beyond / 2, 100 - beyond / 2))
    if low == high:
        low, high = low - 1, high + 1
    counts, edges = np.histogram(np.clip(values, low, high), bins=bins, range=(low, high))
    ax.stairs(counts * 100 / values.size, edges, fill=True, color=LINES[0])
    ax.set_ylabel(f"percent {of}\n(bars at the ends: all beyond)", fontsize=SMALL)
    ax.tick_params(labelsize=SMALL)


def extremes(values: FloatArray, bins: int = 1000) -> IntArray:
    """Places of the least and the largest value in each bin of a row of values: a curve that drops no peak.

    >>> peaks = np.zeros(1000)
    >>> peaks[[333, 335]] = 1.0, -1.0
    >>> {333, 335} <= set(extremes(peaks, 10).tolist()), len(extremes(peaks, 10)) <= 20
    (True, True)
    """
    part = np.arange(len(values)) * bins // max(len(values), 1)
    order = np.lexsort((values, part))
    return np.union1d(order[np.diff(part, prepend=-1) != 0], order[np.diff(part, append=bins) != 0])


def colour_bar(ax: Any, ramp: Ramp) -> None:
    """A horizontal colour bar below axes, with its label and the names of its ends."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LinearSegmentedColormap, Normalize

    scale = ScalarMappable(
        Normalize(ramp.low, ramp.high), LinearSegmentedColormap.from_list("", ramp.stops)
    )
    bar = ax.figure.colorbar(
        scale, ax=ax, orientation="horizontal", shrink=0.6, aspect=30, pad=0.02
    )
    bar.set_ticks([ramp.low, ramp.high], labels=ramp.ends)
    bar.ax.tick_params(labelsize=SMALL, length=0)
    bar.set_label(ramp.label, fontsize=SMALL)
    bar.outline.set_visible(False)


def plot_plane(
    p: FloatArray,
    f: IntArray,
    differences: FloatArray,
    ratios: FloatArray,
    title: str,
    pixels: int = 840,
) -> Any:
    """A figure of a map: its image, coloured by area ratios, folded faces in their own colour, and two histograms.

    It takes images (n, 2), faces, angle differences in degrees, and logarithms of area ratios. `pixels` are those of a
    side of the image.
    """
    figure, ((left, middle, right),) = new_figure(1, 3, title, size=(3.6, 3.4))
    ramp, corners = fitting(AREAS, ratios), p[f]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    folded = np.flatnonzero(a[:, 0] * b[:, 1] <= a[:, 1] * b[:, 0])
    left.imshow(
        raster(np.column_stack((p, np.zeros(len(p)))), f, ramp.colours(ratios), pixels, folded)
    )
    left.set_axis_off()
    colour_bar(left, ramp)
    plot_angles(middle, differences)
    plot_areas(right, ratios)
    return figure


#: Direction of the light, in the frame of the view.
LIGHT = np.array([-0.35, 0.45, 0.82]) / np.linalg.norm([-0.35, 0.45, 0.82])
#: Factors of the axes of a view that turn it half around the vertical.
BEHIND = np.array([-1.0, 1.0, -1.0])
#: Angles by which a pose is turned away from the broad side of a surface, and seen from above.
_AZIMUTH, _ELEVATION = np.radians(28), np.radians(16)
#: Directions that may be up, by the names that users give.
UPS = {
    "x": (1, 0, 0),
    "-x": (-1, 0, 0),
    "y": (0, 1, 0),
    "-y": (0, -1, 0),
    "z": (0, 0, 1),
    "-z": (0, 0, -1),
}
#: Views from a side, where z is up, y ahead and x to the right, as in neuroimaging: right, up and towards the viewer.
SIDES = {"left": ((0, -1, 0), (0, 0, 1), (-1, 0, 0)), "right": ((0, 1, 0), (0, 0, 1), (1, 0, 0))}


def upright(v: FloatArray) -> str:
    """The direction, "y" or "z", along which a surface stands more safely on its lowest part; if in neither, "z".

    >>> upright(np.array([[0.0, 0, 0], [1, 0, 0], [0, 0, 1], [1, 0, 1], [0.6, 9, 0.5]]))
    'y'
    """
    safe = {up: _stability(v, axis) for up, axis in (("z", 2), ("y", 1))}
    best = max(safe, key=lambda up: safe[up])
    if safe[best] <= 0:
        return "z"
    return best


def _stability(v: FloatArray, axis: int, part: float = 0.04) -> float:
    """Distance from the middle to the border of the lowest part's hull, both seen from above; negative outside.

    The part is this share of the height.
    """
    from scipy.spatial import ConvexHull, QhullError  # takes long to import

    level = [k for k in range(3) if k != axis]
    height = v[:, axis] - v[:, axis].min()
    try:
        hull = ConvexHull(v[height <= part * height.max()][:, level])
    except (QhullError, ValueError):  # a line or a point
        return -math.inf
    return float(-(hull.equations[:, :2] @ v[:, level].mean(axis=0) + hull.equations[:, 2]).max())


def vertical(v: FloatArray, up: str = "auto") -> FloatArray:
    """The direction that is up: one of `UPS`, by "auto" that of `upright`, of `SIDES` z.

    >>> vertical(np.eye(3), "left").tolist(), vertical(np.eye(3), "-x").tolist()
    ([0.0, 0.0, 1.0], [-1.0, 0.0, 0.0])
    """
    named = up
    if up == "auto":
        named = upright(v)
    elif up in SIDES:
        named = "z"
    if named not in UPS:
        raise ValueError(
            f"unknown direction {up!r}: choose one of auto, {', '.join((*UPS, *SIDES))}"
        )
    return np.array(UPS[named], dtype=np.float64)


def pose(v: FloatArray, up: str = "auto") -> FloatArray:
    """Rotation whose rows are right, up and towards the viewer: the broad side in front, seen from above and aside.

    `up` is as of `vertical`; from one of `SIDES` the surface is seen.

    >>> box = np.array([[0.0, 0, 0], [9, 0, 0], [9, 2, 0], [9, 2, 5]])
    >>> rotation = pose(box, "z")
    >>> bool(rotation[0] @ [1, 0, 0] > 0.8), bool(rotation[1] @ [0, 0, 1] > 0.9)
    (True, True)
    """
    if up in SIDES:
        return np.array(SIDES[up], dtype=np.float64)
    standing = vertical(v, up)
    level = np.flatnonzero(standing == 0)
    extent = np.ptp(v, axis=0)
    right = np.zeros(3)
    right[level[int(np.argmax(extent[level] * [1.0001, 1.0]))]] = 1.0  # of equal extents the first
    axes = np.vstack((right, standing, np.cross(right, standing)))
    a, e = _AZIMUTH, _ELEVATION
    aside = np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]])
    above = np.array([[1, 0, 0], [0, np.cos(e), -np.sin(e)], [0, np.sin(e), np.cos(e)]])
    return above @ aside @ axes


def fit(v: FloatArray, rotation: FloatArray) -> FloatArray:
    """Rotate a surface, and scale it about the middle of its bounding box to the unit ball."""
    w = v @ rotation.T
    w = w - (w.max(axis=0) + w.min(axis=0)) / 2
    return np.asarray(w / max(float(np.linalg.norm(w, axis=1).max()), TINY))


def shading(v: FloatArray, f: IntArray, view: FloatArray, ambient: float = 0.6) -> FloatArray:
    """Brightness (m,) of the faces between `ambient`, where the light grazes and colours must be read, and 1."""
    normals = igl.per_face_normals(v @ view, f, np.zeros(3))
    return np.asarray(ambient + (1 - ambient) * np.abs(normals @ LIGHT))


def raster(
    y: FloatArray,
    f: IntArray,
    colours: FloatArray,
    size: int,
    folded: IntArray | None = None,
    shown: tuple[FloatArray, float] | None = None,
    least: int = SEEN,
) -> NDArray[np.uint8]:
    """A picture (size, size, 3) of a surface in face colours (m, 3), seen along -z and fitted into the square.

    If pictures of several surfaces share what is `shown`, the `frame` of all of them, they have one scale.

    Folded faces, given by their indices, have their own colour. Unless they cover much of the surface, they hide all
    before them in the nearer half, and have at least `least` pixels along a side.

    >>> triangle = np.array([[-1.0, -1, 0], [1, -1, 0], [0, 1, 0]])
    >>> raster(triangle, np.array([[0, 1, 2]]), np.array([[1.0, 0, 0]]), 9)[4, 4].tolist()
    [255, 0, 0]
    """
    if shown is None:
        shown = frame(y)
    middle, radius = shown
    pixels = (y - middle) * (size / (2 * radius)) * [1, -1, 1] + [size / 2, size / 2, 0]
    seen = np.full(size * size, len(f))  # white, where there is no face
    nearest = np.full(size * size, -np.inf)
    for place, depth, owner in _samples(pixels, f, size):
        np.maximum.at(nearest, place, depth)
        front = depth == nearest[place]
        seen[place[front]] = owner[front]
    if folded is not None:
        seen[np.isin(seen, folded)] = len(f) + 1
        sizes = face_areas(y, f)
        near = f[folded][pixels[f[folded], 2].mean(axis=1) >= 0]
        if len(near) and sizes[folded].sum() < MANY * sizes.sum():
            for place, _, _ in _samples(pixels, near, size):
                seen[place] = len(f) + 1
            seen[_blocks(pixels, near, size, least)] = len(f) + 1
    palette = np.rint(255 * np.clip(np.vstack((colours, np.ones(3), FOLDED)), 0, 1)).astype(
        np.uint8
    )
    return palette[seen].reshape(size, size, 3)


def both_sides(
    bodies: Sequence[FloatArray],
    f: IntArray,
    colours: FloatArray,
    view: FloatArray,
    size: int,
    folded: IntArray | None = None,
) -> NDArray[np.uint8]:
    """A picture of bodies with the same faces in shaded colours, side by side: from the front, then from behind."""
    return np.concatenate(
        [
            raster(v @ turn, f, colours * shading(v, f, turn)[:, None], size, folded)
            for turn in (view, view * BEHIND)
            for v in bodies
        ],
        axis=1,
    )


def _blocks(pixels: FloatArray, f: IntArray, size: int, least: int) -> IntArray:
    """Places in the picture of the blocks that are drawn for faces that are smaller."""
    corners = pixels[f][:, :, :2]
    small = corners[np.ptp(corners, axis=1).max(axis=1) < least].mean(axis=1)
    around = np.arange(least) - least // 2
    column, row = (
        np.clip(small[:, k, None] + around, 0, size - 1).astype(np.int32) for k in (0, 1)
    )
    return np.asarray((row[:, :, None] * size + column[:, None, :]).ravel())


def frame(y: FloatArray, margin: float = 1.06) -> tuple[FloatArray, float]:
    """Middle (3,) of positions, and half the side of the square around it that their picture shows.

    It is the larger extent times the margin. At one point it is not 0: the scale to pixels stays finite.
    """
    low, high = y.min(axis=0), y.max(axis=0)
    return (low + high) / 2, max(float((high - low)[:2].max()) / 2, 1e-300) * margin


def _samples(
    pixels: FloatArray, f: IntArray, size: int, at_once: int = 2**19
) -> Iterator[tuple[IntArray, FloatArray, IntArray]]:
    """Places in the picture, depths and faces of points that lie less than a pixel apart on every face, in parts.

    A part has about `at_once` points, some 20 MB.
    """
    corners = pixels[f]
    longest = np.abs(corners - corners[:, [1, 2, 0]])[:, :, :2].max(axis=(1, 2))
    level = np.ceil(np.log2(np.maximum(longest, 0.5))).astype(int)
    for k in np.unique(level):
        grid, faces = _grid(int(2.0**k)), np.flatnonzero(level == k)
        for part in np.array_split(faces, math.ceil(len(faces) * len(grid) / at_once)):
            x, y, depth = (corners[part, :, axis] @ grid.T for axis in range(3))
            column, row = (np.clip(pixel, 0, size - 1).astype(np.int32) for pixel in (x, y))
            yield (row * size + column).ravel(), depth.ravel(), np.repeat(part, len(grid))


def _grid(k: int) -> FloatArray:
    """Barycentric coordinates of the points that divide a triangle's edges into `k` parts; of its middle for 0.

    >>> _grid(0), len(_grid(1)), len(_grid(2))
    (array([[0.33333333, 0.33333333, 0.33333333]]), 3, 6)
    """
    if k == 0:
        return np.full((1, 3), 1 / 3)
    i, j = (index.ravel() for index in np.mgrid[: k + 1, : k + 1])
    inside = i + j <= k
    i, j = i[inside], j[inside]
    return np.column_stack((i, j, k - i - j)) / k
