"""Types of arrays, the checks of arrays that callers give, and the phrases of their errors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import MeshError

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
ComplexArray = NDArray[np.complex128]
PixelArray = NDArray[np.uint8]
AnyArray = NDArray[Any]

#: float64's relative precision, and its smallest number with all digits.
EPS, TINY = float(np.finfo(float).eps), float(np.finfo(float).tiny)
#: Root of that precision, 1.5e-8: half of the digits. The square of a relative error below it is rounding.
HALF_DIGITS = float(np.sqrt(EPS))

#: Rounding of sums and small matrices, relative to their largest value: 4,500 times float64's epsilon.
ROUNDING = 1e-12


def plain_array(values: ArrayLike, name: str) -> NDArray[Any]:
    """`values` as an array, or MeshError for a map, ragged rows or masked entries."""
    if hasattr(values, "sphere"):
        raise MeshError(
            f"{name} are a {type(values).__name__}; give its vertices, its faces or its sphere"
        )
    if isinstance(values, np.ma.MaskedArray):
        raise MeshError(f"{name} are a masked array; give plain numbers and fill what is masked")
    try:
        return np.asarray(values)
    except ValueError as error:
        raise MeshError(
            f"{name} are ragged: rows differ in length; triangulate polygons first"
        ) from error


def real_array(values: ArrayLike, name: str) -> NDArray[Any]:
    """Real numbers of any shape and type; a MeshError for texts, objects and complex numbers."""
    array = plain_array(values, name)
    if array.dtype.kind not in "fiub":
        raise MeshError(f"{name} have dtype {array.dtype}; give real numbers")
    return array


def check_values(values: ArrayLike, n_vertices: int, name: str = "values") -> FloatArray:
    """Data at the vertices as (n, k) float64 rows, one for each; MeshError for missing or non-finite rows."""
    array = real_array(values, name)
    if array.ndim not in (1, 2) or len(array) != n_vertices or array.shape[1:] == (0,):
        raise MeshError(
            f"{name} have shape {array.shape} but the mesh has {n_vertices} vertices; give one row each, "
            "of one number or more"
        )
    array = array.reshape(n_vertices, -1).astype(np.float64)
    bad = np.flatnonzero(~np.isfinite(array).all(axis=1))
    if len(bad):
        raise MeshError(
            f"{name} are not finite at {count(bad, 'vertex', 'vertices')}, {examples(bad)}; fill them in"
        )
    return array


def check_rows(
    x: ArrayLike, n_vertices: int | None = None, name: str = "positions", columns: int = 3
) -> FloatArray:
    """Real numbers of any dtype, byte order and layout as C-contiguous (n, columns) float64 rows, finite or not.

    Raises MeshError for anything else, and for another number of rows than a given `n_vertices`. It also refuses
    numbers that float64 would round, so that every verdict is of the given numbers.
    """
    array = real_array(x, name)
    if array.ndim != 2 or array.shape[1] != columns:
        raise MeshError(
            f"{name} have shape {array.shape}; give one row of {('two', 'three')[columns - 2]} coordinates "
            f"per vertex{_transposed(array)}"
        )
    if n_vertices is not None and len(array) != n_vertices:
        raise MeshError(
            f"{name} have {len(array)} rows but the mesh has {n_vertices} vertices; give one row each"
        )
    rows = np.ascontiguousarray(array, dtype=np.float64)
    rounded = np.flatnonzero(_rounded(x, array, rows).any(axis=1))
    if len(rounded):
        raise MeshError(
            f"{name} of dtype {array.dtype} are not float64 numbers in {count(rounded, 'row')}, "
            f"{examples(rounded)}; round them yourself, so that the verdict is of the numbers you keep"
        )
    return rows


def _rounded(given: ArrayLike, array: NDArray[Any], rows: FloatArray) -> BoolArray:
    """Whether each given number differs from its float64 in `rows`; `array` is numpy's version of them."""
    if array.dtype.kind == "f" and array.dtype.itemsize > rows.itemsize:
        return np.asarray((rows.astype(array.dtype) != array) & ~np.isnan(array))
    large = np.abs(rows) >= 2.0**53  # from there on float64 does not hold every whole number
    # numpy rounds whole numbers in a list with floats: compare the list itself
    if large.any():
        each = np.array(given, dtype=object)
        large[large] = [
            isinstance(a, (int, np.integer)) and int(a) != int(b)
            for a, b in zip(each[large], rows[large].tolist(), strict=True)
        ]
    return large


def check_directions(
    x: ArrayLike, n_vertices: int | None = None, name: str = "positions"
) -> FloatArray:
    """`check_rows`, and MeshError for rows that are zero or not finite."""
    rows = check_rows(x, n_vertices, name)
    bad = np.flatnonzero(~np.isfinite(rows).all(axis=1) | ~rows.any(axis=1))
    if len(bad):
        raise MeshError(
            f"{name} are zero or not finite in {count(bad, 'row')}, {examples(bad)}; give each a direction"
        )
    return rows


def check_triangles(f: ArrayLike) -> IntArray:
    """Whole numbers of any dtype, byte order and layout as a new (m, 3) int64 array, in range or not.

    Raises MeshError for anything else, and for no faces.
    """
    array = plain_array(f, "faces")
    if is_padded(array):
        array = array.reshape(-1, 4)[:, 1:]
    if array.size == 0:
        raise MeshError("no faces: the mesh is empty or a point cloud; give a closed triangle mesh")
    if array.ndim != 2 or array.shape[1] != 3:
        raise MeshError(
            f"faces have shape {array.shape}; give triangles, one row of three indices "
            f"each{_transposed(array)}; triangulate polygons first"
        )
    if array.dtype.kind == "f":
        if not (np.abs(array) < 2.0**63).all() or (array != np.floor(array)).any():
            raise MeshError("faces are not whole numbers of 64 bits; give 0-based vertex indices")
    elif array.dtype.kind not in "iu":
        raise MeshError(f"faces have dtype {array.dtype}; give 0-based vertex indices")
    return np.array(array, dtype=np.int64, order="C")


def is_padded(f: NDArray[Any]) -> bool:
    """Whether an array has the number 3 before the corners of each face, as VTK and PyVista keep triangles."""
    if f.shape[1:] not in ((), (4,)) or f.size == 0 or f.size % 4:
        return False
    return bool((f.reshape(-1, 4)[:, 0] == 3).all())


def _transposed(array: NDArray[Any]) -> str:
    """A hint for errors, if rows and columns seem to be swapped."""
    if array.ndim == 2 and array.shape[0] == 3:
        return " (it looks transposed)"
    return ""


def plural(number: int, singular: str, several: str | None = None) -> str:
    """A number of things.

    >>> plural(1, "face"), plural(0, "face"), plural(2, "vertex", "vertices")
    ('1 face', 'no faces', '2 vertices')
    """
    if number == 1:
        return f"1 {singular}"
    if several is None:
        several = f"{singular}s"
    if number == 0:
        return f"no {several}"
    return f"{number} {several}"


def count(items: NDArray[Any], singular: str, several: str | None = None) -> str:
    """The number of items: `3 faces`, or `1 face`."""
    return plural(len(items), singular, several)


def listed(items: NDArray[Any], most: int = 5) -> str:
    """`0, 1, 2, 3, 4, ...`: the first whole numbers."""
    shown = [str(int(item)) for item in items[:most]]
    if len(items) > most:
        shown.append("...")
    return ", ".join(shown)


def listed_words(items: Sequence[object], most: int = 5) -> str:
    """The first items as a phrase.

    >>> listed_words([40, 12, 7]), listed_words([7]), listed_words(range(9))
    ('40, 12 and 7', '7', '0, 1, 2, 3, 4 and 4 more')
    """
    words = [str(item) for item in items[:most]]
    if len(items) > most:
        words.append(f"{len(items) - most} more")
    return " and ".join(filter(None, (", ".join(words[:-1]), words[-1])))


def own_unit(v: FloatArray) -> tuple[FloatArray, int]:
    """Positions in the mesh's own unit, largest coordinate .5 to 1, and that power of 2: nothing is rounded.

    No product of lengths over- or underflows there, and libraries may take the positions for float32.

    >>> own_unit(np.array([[3e300, 0, 0]]))[0].round(3), own_unit(np.array([[3.0, 0, 0]]))[1]
    (array([[0.56, 0.  , 0.  ]]), 2)
    """
    power = int(np.frexp(np.abs(v).max(initial=0.0, where=np.isfinite(v)))[1])
    return np.ldexp(v, -power), power


def mean_position(points: FloatArray, v: FloatArray) -> str:
    """The mean of points, to a thousandth of the size of the mesh of vertices `v`.

    >>> mean_position(np.array([[2, 4, 1], [2, 4.001, 3]]), 100 * np.eye(3))
    '(2, 4, 2)'
    """
    own, power = own_unit(v)
    size = float(np.ldexp(np.ptp(own, axis=0).max(), power))
    digits = 3
    if 0 < size < math.inf:
        digits -= math.floor(math.log10(size))
    mean = np.ldexp(np.ldexp(points, -power).mean(axis=0), power)
    # no negative zeros
    return "(" + ", ".join(f"{round(x, digits) + 0.0:.12g}" for x in mean.tolist()) + ")"


def examples(indices: NDArray[Any]) -> str:
    """`e.g. 7, 8, 9`: three of some indices."""
    return "e.g. " + listed(indices, 3).removesuffix(", ...")


def weld(points: FloatArray) -> tuple[FloatArray, IntArray]:
    """Each distinct row once, in the order of first appearance, and for each row of `points` its equal.

    >>> weld(np.array([[1.0, 0, 0], [0, 0, 0], [1, 0, 0]]))[1]
    array([0, 1, 0])
    """
    order = np.lexsort(points.T[::-1])  # stable: the first of equals comes first
    fresh = np.ones(len(points), dtype=bool)
    fresh[1:] = (points[order[1:]] != points[order[:-1]]).any(axis=1)
    first = order[fresh]
    group = np.empty(len(points), dtype=np.int64)
    group[order] = np.cumsum(fresh) - 1
    kept = np.sort(first)
    return points[kept], np.searchsorted(kept, first[group])
