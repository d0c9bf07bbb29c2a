"""Coefficients of spherical harmonics: SPHARM-PDM's `.coef` files, and NPZ."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np

from ...errors import FileError, MeshError, Remedy
from ...gate import PathLike, gate
from ...io import npz
from ...io.reading import reading
from ...io.replacing import replacing
from ...mesh.arrays import FloatArray, check_values
from .bases import in_basis, pdm_rows
from .harmonics import Expanded, SphericalHarmonics

_NUMBER = re.compile(r"[^\s{},]+")


@gate
def write_coefficients(
    path: PathLike, harmonics: SphericalHarmonics, *, force: bool = False
) -> None:
    """Write coefficients of spherical harmonics.

    Parameters
    ----------
    path : str or path-like
        A new `.coef` file, as SPHARM-PDM and ktch read them (positions only, with the rounding of a factor), or an
        `.npz` file, which keeps the source's data, too.
    harmonics : SphericalHarmonics
        The coefficients.
    force : bool
        Replace an existing file.

    Raises
    ------
    FileError
        If the suffix is another one, the file exists and `force` is not set, or it can't be written.
    MeshError
        If the coefficients have not three columns and the file is a `.coef` file.

    Examples
    --------
    >>> import tempfile
    >>> import igl_spheremap as ism
    >>> x, f = ism.samples.sphere(162)
    >>> shape = ism.shapes.spherical_harmonics(ism.sphere_map(x, f, x), degree=3)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     ism.shapes.write_coefficients(f"{folder}/ball.coef", shape)
    ...     again = ism.shapes.read_coefficients(f"{folder}/ball.coef")
    >>> bool(abs(again.coefficients - shape.coefficients).max() < 1e-15)
    True
    """
    kind = check_name(path)
    c = harmonics.coefficients
    if kind == ".coef" and c.shape[1] != 3:
        raise MeshError(
            f"a .coef file holds the three columns of positions, not {c.shape[1]}; write .npz"
        )
    with replacing(path, force) as partial:
        if kind == ".coef":
            rows = ",\n".join(
                "{{{!r}, {!r}, {!r}}}".format(*row) for row in in_basis(c, "spharm-pdm").tolist()
            )
            partial.write_text(f"{{ {len(c)},{rows}}}")
        else:
            source = {}
            if harmonics.source is not None:
                source = vars(harmonics.source)
            npz.write_arrays(partial, {"coefficients": c, **source})


@gate
def read_coefficients(path: PathLike) -> SphericalHarmonics:
    """Read coefficients of spherical harmonics.

    Parameters
    ----------
    path : str or path-like
        A `.coef` file of SPHARM-PDM, ktch or this package, or an `.npz` file of this package.

    Returns
    -------
    SphericalHarmonics
        In this package's basis; of `.coef` files without a source.

    Raises
    ------
    FileError
        If the file can't be read, or its suffix is not one of these.
    MeshError
        If it is damaged; see `write_coefficients` for an example.
    """
    path = Path(path)
    with reading(path):
        if check_name(path) == ".coef":
            return SphericalHarmonics(_parse(path.read_text(encoding="ascii")))
        arrays = npz.read_arrays(path)
        if "coefficients" not in arrays:
            raise MeshError(
                "the archive holds no coefficients; give a file that was written by "
                f"{Remedy('write_coefficients', given='path, harmonics')}"
            )
        c = check_values(arrays["coefficients"], len(arrays["coefficients"]), "coefficients")
        source = None
        if "x" in arrays:
            source = Expanded(arrays["x"], arrays["values"], arrays["areas"])
        return SphericalHarmonics(c, source)


def check_name(path: PathLike) -> str:
    """The suffix of a file of coefficients; a FileError for another one."""
    suffix = Path(path).suffix.lower()
    if suffix not in (".coef", ".npz"):
        raise FileError(f"{path}: coefficients are kept in .coef and .npz files")
    return suffix


def _parse(text: str) -> FloatArray:
    """The coefficients of `{ N,{x, y, z},{x, y, z}...}`."""
    count, *numbers = _NUMBER.findall(text)
    n = int(count)
    rows = np.array(numbers, dtype=np.float64)
    if len(rows) != 3 * n or math.isqrt(n) ** 2 != n:
        raise MeshError(
            f"{len(rows)} numbers, but {n} rows of three are expected, a square number of rows"
        )
    order, factors = pdm_rows(math.isqrt(n) - 1)
    c = np.empty((n, 3))
    c[order] = rows.reshape(n, 3) / factors[:, None]
    return check_values(c, n, "coefficients")
