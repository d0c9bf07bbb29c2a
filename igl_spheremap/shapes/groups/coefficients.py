"""Coefficients of many surfaces as one table, in frames that agree, and their principal modes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ...gate import PathLike
from ...io import npz
from ...io.tables import write_cells
from ...mesh.arrays import FloatArray
from ..harmonics.harmonics import SphericalHarmonics
from .modes import Modes, principal_modes


class CoefficientTable(NamedTuple):
    """Coefficients of surfaces, rows in their order.

    Attributes
    ----------
    names : tuple of str
        Of the surfaces.
    coefficients : (surfaces, (L + 1)^2, 3) float64 array
        As those of `SphericalHarmonics`.
    modes : Modes or None
        Principal components: fields of coefficients whose displacement has mean square 1 over the sphere.
    """

    names: tuple[str, ...]
    coefficients: FloatArray
    modes: Modes | None

    @property
    def compactness(self) -> FloatArray:
        """Share of the variance that the first 1, 2, ... modes hold; empty without modes."""
        if self.modes is None:
            return np.empty(0)
        away = self.coefficients - self.coefficients.mean(axis=0)
        return np.cumsum(self.modes.variances) * (4 * math.pi * (len(away) - 1)) / (away**2).sum()


def in_common_frame(
    shapes: Sequence[SphericalHarmonics], rounds: int = 10
) -> list[SphericalHarmonics]:
    """Surfaces in the frames of their first-order ellipsoids, with axes directed nearest to the mean.

    None of them decides for the others: each begins with the directions of its own skewness. All choose anew until they
    keep theirs, mostly after two or three rounds.
    """
    aligned = [shape.align().harmonics for shape in shapes]
    before = np.stack([each.coefficients for each in aligned])
    for _ in range(rounds):
        mean = SphericalHarmonics(before.mean(axis=0))
        aligned = [shape.align(mean).harmonics for shape in shapes]
        after = np.stack([each.coefficients for each in aligned])
        if np.allclose(after, before):
            break
        before = after
    return aligned


def coefficient_table(
    names: Sequence[str], shapes: Sequence[SphericalHarmonics], modes: int = 0
) -> CoefficientTable:
    """The table of surfaces, with this number of its principal modes."""
    rows = np.stack([shape.coefficients for shape in shapes])
    if not modes:
        return CoefficientTable(tuple(names), rows, None)
    # the basis is orthonormal: squares of coefficients add up to the integral over the sphere, of area 4 pi
    unit = math.sqrt(rows.shape[1] / (4 * math.pi))
    found = principal_modes(unit * (rows - rows.mean(axis=0)), np.ones(rows.shape[1]), modes)
    return CoefficientTable(tuple(names), rows, found._replace(modes=found.modes / unit))


def write_coefficient_table(
    path: PathLike, table: CoefficientTable, *, force: bool = False
) -> None:
    """Write a .tsv or .csv file with a row for each surface: its scores, then x_l0m0 and so on; or an .npz file."""
    if not str(path).lower().endswith(".npz"):
        write_cells(path, _rows(table), force=force)
        return
    arrays = {"names": np.array(table.names, dtype=str), "coefficients": table.coefficients}
    if table.modes is not None:
        arrays |= table.modes._asdict()
    npz.save_arrays(path, arrays, force)


def _rows(table: CoefficientTable) -> Iterator[Sequence[object]]:
    scores = np.empty((len(table.names), 0))
    if table.modes is not None:
        scores = table.modes.scores
    degree = math.isqrt(table.coefficients.shape[1]) - 1
    names = [
        f"{axis}_l{ell}m{m}"
        for ell in range(degree + 1)
        for m in range(-ell, ell + 1)
        for axis in "xyz"
    ]
    yield "surface", *(f"mode_{k + 1}" for k in range(scores.shape[1])), *names
    for name, own, rows in zip(table.names, scores.tolist(), table.coefficients, strict=True):
        yield name, *own, *rows.ravel().tolist()
