"""Differences of groups of shapes, or their dependence on a covariate: permutations, with the maximum statistic."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.stats import t

from ...errors import MeshError, Remedy, check_whole
from ...gate import gate
from ...mesh.arrays import (
    EPS,
    ROUNDING,
    TINY,
    FloatArray,
    IntArray,
    own_unit,
    plain_array,
    real_array,
)
from .group import Group

#: Chance of a false finding anywhere on the surface.
LEVEL = 0.05
# length of a column of unit length that is left beside others, from which on it is not in their span; statistics that
# differ by a smaller share are equal
_RANK = 1e-9
_AUGMENT = Remedy(options={"augment": True})
#: Cells of tables that say that there is no value, in lower case.
_MISSING = {"", "na", "n/a", "nan"}
#: With fewer permutations the smallest p is above `LEVEL`.
_FEWEST = round(1 / LEVEL) - 1


@dataclass(frozen=True, eq=False)
class PointTest:
    """Dependence on a variable at each point, beside that by chance.

    Attributes
    ----------
    statistic : (n,) float64 array
        F at each point, a ratio: the squares of all coordinates together; 0 if the data do not vary.
    p : (n,) float64 array
        Probability, from 0 to 1, that the largest F anywhere is as large if nothing depends on the variable.
    effect : (q, n, d) float64 array
        Movement of the points from the first level of the variable to each other one, or with a unit of a number, at
        equal covariates; in the units of the data, by default the members' own.
    error, margin : (q, n) float64 arrays
        Standard error of one coordinate of the effect, and half of its interval of 95 percent confidence, at each
        point by itself, in the effect's units.
    explained : (n,) float64 array
        Share of the variance that covariates do not explain (partial R squared).
    threshold : float
        F that chance passes anywhere in 5 of 100 experiments; NaN if the test was augmented: then it differs by
        permutation.
    levels : tuple of str
        Of the variable; empty for a number.
    notes : tuple of str
        Reasons to doubt p.
    """

    statistic: FloatArray
    p: FloatArray
    effect: FloatArray
    error: FloatArray
    margin: FloatArray
    explained: FloatArray
    threshold: float
    levels: tuple[str, ...]
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return (
            f"PointTest({(self.p <= LEVEL).mean():.0%} of {len(self.p)} points, smallest p {self.p.min():.2g}, at "
            f"most {self.explained.max():.0%} explained)"
        )


@gate
def permutation_test(
    group: Group,
    variable: ArrayLike,
    *,
    covariates: ArrayLike | None = None,
    data: ArrayLike | None = None,
    permutations: int = 1000,
    augment: bool = False,
    seed: int = 0,
) -> PointTest:
    """Test at each point whether the members' shapes depend on a variable: a group, or a number.

    The statistic at each point is compared with the largest one over all points in each permutation. Without covariates
    the test is exact: if there is no effect, the chance of a finding anywhere is at most `LEVEL`, whatever the
    distribution of the data. With covariates their residuals are permuted (Freedman, Lane), and that chance is near
    `LEVEL`; for few members, with skewed or heavy-tailed data and covariates, it is above.

    Parameters
    ----------
    group : Group
        The group.
    variable : (members,) array_like
        Numbers, or names of groups: two or more.
    covariates : (members,) or (members, k) array_like, optional
        Other numbers that may explain differences, such as age; a covariate that follows from the others changes
        nothing.
    data : (members, n) or (members, n, d) array_like, optional
        The tested data; the members' shapes by default.
    permutations : int, default 1000
        Number of permutations; the smallest p is 1 / (permutations + 1).
    augment : bool, default False
        Compare each permutation with the data in a model that has the covariates both as they are and permuted (Guan).
        The chance of a finding is then at most twice `LEVEL` for any covariates and distributions, and was below
        `LEVEL` in all experiments; it takes more than 2 k + 2 members, and finds less in few.
    seed : int, default 0
        Seed of the random permutations.

    Returns
    -------
    PointTest
        Statistic, p, effects and their errors at each point.

    Raises
    ------
    MeshError
        If there is not one finite value for each member, the variable is constant or follows from the covariates, or
        members are too few.
    ValueError
        If `permutations` is below 19, which can't reach .05.

    References
    ----------
    Nichols, Holmes 2002, *Nonparametric permutation tests for functional neuroimaging*; Winkler et al. 2014,
    *Permutation inference for the general linear model*; Guan 2024, *A conformal test of linear models via
    permutation-augmented regressions*.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("pear", n_vertices=100)
    >>> group = ism.shapes.template([(v * [1.3 + 0.1 * k, 1, 1], f) for k in range(3)], target="ico:1")
    >>> ism.shapes.permutation_test(group, [30, 40, 50], permutations=19).effect.shape  # for instance ages
    (1, 42, 3)
    """
    check_whole(permutations, "permutations", _FEWEST)
    count = len(group.members)
    tested, levels = _columns(variable, count)
    tested, unit_x = own_unit(tested)
    Z = np.empty((count, 0))
    if covariates is not None:
        Z = _spanned(_numbers(covariates, count, "covariates"))
    Qz = np.column_stack((np.full((count, 1), count**-0.5), Z))
    if data is None:
        data = group.shapes
    values, unit = own_unit(_finite(data, count))
    Qx, R = _varying(tested, Qz)
    (k, z), also = (Qx.shape[1], Z.shape[1]), ""
    freedom = left = count - z - 1 - k
    if augment:
        left, also = freedom - z, f" with {_AUGMENT}"
    if left < 1:
        raise MeshError(
            f"{count} members are too few for {k} columns of the variable and {z} of covariates{also}; give fewer "
            "covariates"
        )
    residuals = _Residuals.of(values.reshape(count, values.shape[1], -1), Qz, freedom / k)
    rng = np.random.default_rng(check_whole(seed, "seed"))
    orders = np.stack([rng.permutation(count) for _ in range(permutations)])
    F = residuals.statistics(Qx[None], Qz[None])[0]
    maxima, beyond, same = _permuted(residuals, F, Qx, Qz, orders, augment)
    explained = F / (F + residuals.ratio)
    noise = np.sqrt((1 - explained) * residuals.squares / (freedom * residuals.shape[1]))
    effect = np.linalg.solve(R, Qx.T @ residuals.rest)
    error = np.sqrt(np.diag(np.linalg.inv(R.T @ R)))[:, None] * noise
    effect, error = (np.ldexp(each, unit - unit_x) for each in (effect, error))
    threshold = np.nan
    if not augment:
        rank = int(np.ceil((1 - LEVEL) * (permutations + 1))) - 1
        threshold = float(np.sort(maxima)[rank])
    return PointTest(
        F,
        (1 + beyond) / (1 + permutations),
        effect.reshape(k, *residuals.shape),
        error,
        error * t.ppf(1 - LEVEL / 2, freedom),
        explained,
        threshold,
        levels,
        tuple(_notes(residuals, same, permutations, z, augment)),
    )


class _Residuals(NamedTuple):
    """Residuals of data after covariates: `rest` (members, n d), its squares (n,), and members to spare for each
    column."""

    rest: FloatArray
    shape: tuple[int, int]
    squares: FloatArray
    ratio: float

    @classmethod
    def of(cls, values: FloatArray, Qz: FloatArray, ratio: float) -> _Residuals:
        flat = values.reshape(len(values), -1)
        rest = flat - Qz @ (Qz.T @ flat)
        rest[:, np.abs(rest).max(axis=0) <= ROUNDING * np.abs(flat).max()] = 0.0
        squares = (rest**2).sum(axis=0).reshape(values.shape[1:]).sum(axis=1)
        return cls(rest, (values.shape[1], values.shape[2]), squares, ratio)

    def statistics(self, x: FloatArray, z: FloatArray) -> FloatArray:
        """F (k, n) of orthonormal columns (k, members, q) beside others (k, members, z)."""
        parts = (
            np.einsum("kmc,mi->kci", np.concatenate((x, z), axis=2), self.rest, optimize=True) ** 2
        )
        parts = parts.reshape(*parts.shape[:2], *self.shape).sum(axis=3)
        model = parts[:, : x.shape[2]].sum(axis=1)
        left = self.squares - parts.sum(axis=1)
        least = EPS * self.squares.max() + TINY
        return self.ratio * model / np.maximum(left, least)


def _permuted(
    residuals: _Residuals,
    F: FloatArray,
    Qx: FloatArray,
    Qz: FloatArray,
    orders: IntArray,
    augment: bool,
    block: int = 64,
) -> tuple[FloatArray, IntArray, int]:
    """The largest F of each order, the number of orders in which it is at least F of each point, and of those that
    change no F.

    A product of matrices takes a `block` of orders.
    """
    maxima, beyond, same = np.empty(len(orders)), np.zeros(len(F), dtype=int), 0
    for start in range(0, len(orders), block):
        part = orders[start : start + block]
        if augment:
            # the covariates original and permuted, both with a constant, and the variation beside them
            as_they_are = np.broadcast_to(Qz, (len(part), *Qz.shape))
            z = _spanning(np.concatenate((as_they_are, Qz[part][:, :, 1:]), axis=2))
            here, there = (
                residuals.statistics(_spanning(x - z @ (np.swapaxes(z, 1, 2) @ x)), z)
                for x in (Qx[None], Qx[part])
            )
        else:
            here, there = F, residuals.statistics(Qx[part], Qz[part])
        largest = maxima[start : start + len(part)] = there.max(axis=1)
        beyond += (largest[:, None] >= here * (1 - _RANK)).sum(axis=0)
        same += int((np.abs(there - here) <= _RANK * here).all(axis=1).sum())
    return maxima, beyond, same


def _finite(data: ArrayLike, count: int) -> FloatArray:
    """Finite numbers (count, n) or (count, n, d)."""
    values = np.asarray(real_array(data, "data"), dtype=np.float64)
    whole = values.ndim in (2, 3) and len(values) == count and values.size > 0
    if not whole or not np.isfinite(values).all():
        raise MeshError(
            f"data of shape {values.shape} for {count} members; give finite numbers, (members, n) or "
            "(members, n, d)"
        )
    return values


def _varying(tested: FloatArray, Qz: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Orthonormal columns of the variation beside others, and its coordinates in them; without any, a MeshError."""
    free = tested - Qz @ (Qz.T @ tested)
    if _spanned(tested).shape[1] < tested.shape[1] or (
        np.linalg.svd(free, compute_uv=False).min()
        <= _RANK * np.linalg.norm(tested - tested.mean(axis=0))
    ):
        raise MeshError(
            "the variable is constant, or follows from the covariates; give one that varies beside them"
        )
    Qx, R = np.linalg.qr(free)
    return Qx, R


def _spanning(columns: FloatArray) -> FloatArray:
    """Orthonormal columns that span given ones (k, members, j); surplus ones are zero."""
    U, sizes, _ = np.linalg.svd(columns, full_matrices=False)
    return U * (sizes > _RANK)[:, None]


def _notes(
    residuals: _Residuals,
    same: int,
    permutations: int,
    covariates: int,
    augment: bool,
    enough: int = 20,
) -> Iterator[str]:
    """Reasons to doubt p: `same` permutations leave F as it is, and covariates are independent.

    Of 100 experiments, however skewed, at most 7 had a false finding with `enough` members for each covariate, up to 16
    with fewer (docs/shapes.md).
    """
    count, least = len(residuals.rest), (1 + same) / (1 + permutations)
    if not residuals.squares.any():
        yield (
            "the data are the same for all members, or follow from the covariates: nothing can depend on the variable"
        )
    elif least > LEVEL:
        yield (
            f"{count} members are too few to find anything at {LEVEL}: {same} of {permutations} permutations change "
            f"nothing, so no p is below {least:.2g}, however large the difference; give more members"
        )
    if count < enough * covariates and not augment:
        yield (
            f"{count} members are few for {covariates} independent covariates: where data and covariates are "
            "skewed, chance finds something more often than in 5 of 100 experiments, "
            f"{_AUGMENT} keeps to them"
        )


def _spanned(columns: FloatArray) -> FloatArray:
    """Orthonormal columns that span the given ones, each less its mean; dependent ones are dropped."""
    peaks = np.abs(columns).max(axis=0)
    scaled = columns / np.where(peaks > 0, peaks, 1.0)
    centred = np.where(np.ptp(scaled, axis=0) > ROUNDING, scaled - scaled.mean(axis=0), 0.0)
    lengths = np.linalg.norm(centred, axis=0)
    U, sizes, _ = np.linalg.svd(centred / np.where(lengths > 0, lengths, 1.0), full_matrices=False)
    return U[:, sizes > _RANK]


def level(cell: str) -> str:
    """A word as the name of a level: words that look the same are the same.

    >>> level(" no  treatment\u00a0"), level("a\u0308") == "\u00e4"
    ('no treatment', True)
    """
    return " ".join(unicodedata.normalize("NFC", cell).split())


def is_missing(cell: str) -> bool:
    """Whether a cell says that there is no value.

    >>> [is_missing(cell) for cell in ("NA", " ", "none")]
    [True, True, False]
    """
    return cell.strip().lower() in _MISSING


def _columns(variable: ArrayLike, count: int) -> tuple[FloatArray, tuple[str, ...]]:
    """Columns of a variable: itself, or one for each level but the first."""
    given = plain_array(variable, "the variable's values")
    if given.dtype.kind in "iuf":
        return _numbers(given, count, "the variable"), ()
    names = np.array([level(name) for name in given.astype(str).ravel()], dtype=str)
    if len(names) != count:
        raise MeshError(
            f"the variable has {len(names)} values for {count} members; give one for each"
        )
    none = [value is None for value in given.reshape(-1).tolist()]
    missing = np.flatnonzero([is_missing(name) for name in names.tolist()] | np.array(none))
    if len(missing):
        raise MeshError(
            f"the variable has no value for {len(missing)} of the members, the first is number "
            f"{missing[0]}; leave them out of the group"
        )
    levels = tuple(np.unique(names).tolist())
    if len(levels) < 2:
        raise MeshError(
            f"the variable is {levels[0]!r} for all members; give one that differs between them"
        )
    return indicators(names), levels


def indicators(names: NDArray[np.generic]) -> FloatArray:
    """A column of zeros and ones for each level but the first, in the order of sorting."""
    return (names[:, None] == np.unique(names)[1:]).astype(np.float64)


def _numbers(values: ArrayLike, count: int, name: str) -> FloatArray:
    """Rows (count, k) of finite numbers."""
    rows = plain_array(values, name)
    if rows.dtype.kind not in "iufb":
        raise MeshError(
            f"{name} have dtype {rows.dtype}; give numbers, of names a column of zeros and ones for each "
            "but the first"
        )
    rows = rows.astype(np.float64)
    rows = np.atleast_1d(rows)
    rows = rows.reshape(len(rows), -1)
    if len(rows) != count or not np.isfinite(rows).all():
        raise MeshError(
            f"{name} have {len(rows)} rows for {count} members; give a finite number for each"
        )
    return rows
