"""Where groups of shapes differ, or depend on a covariate: permutations, with the maximum statistic."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...errors import MeshError, check_whole, own_errstate
from ...mesh.arrays import FloatArray
from .group import Group

#: Chance to find a difference anywhere on the surface where there is none.
LEVEL = 0.05
_BLOCK = 64  # permutations of one product of matrices
_RANK = 1e-9  # share of a column that must not lie in the covariates
_TIE = 1e-9  # statistics that differ by a smaller share are equal up to rounding
#: With fewer permutations the smallest p is above `LEVEL`.
_FEWEST = round(1 / LEVEL) - 1


@dataclass(frozen=True, eq=False)
class PointTest:
    """What depends on a variable at each point, and what chance reaches.

    Attributes
    ----------
    statistic : (n,) float64 array
        F at each point, a ratio: the squares of all coordinates together.
    p : (n,) float64 array
        Probability, from 0 to 1, that the largest F anywhere is as large if nothing depends on the variable.
    effect : (q, n, d) float64 array
        How far the points move from the first level of the variable to each other one, or with a unit of a number;
        covariates being equal; in the units of the data, by default the members' own.
    error : (q, n) float64 array
        Standard error of one coordinate of the effect, in the effect's units.
    explained : (n,) float64 array
        Share of the variance, beside what covariates explain (partial R squared).
    threshold : float
        F that chance passes anywhere in 5 of 100 experiments.
    levels : tuple of str
        Of the variable; empty for a number.
    """

    statistic: FloatArray
    p: FloatArray
    effect: FloatArray
    error: FloatArray
    explained: FloatArray
    threshold: float
    levels: tuple[str, ...]

    def __repr__(self) -> str:
        return (f"PointTest({(self.p <= LEVEL).mean():.0%} of {len(self.p)} points, smallest p {self.p.min():.2g}, at "
                f"most {self.explained.max():.0%} explained)")


@own_errstate
def permutation_test(
    group: Group,
    variable: ArrayLike,
    *,
    covariates: ArrayLike | None = None,
    data: ArrayLike | None = None,
    permutations: int = 1000,
    seed: int = 0,
) -> PointTest:
    """Test at each point whether the members' shapes depend on a variable: a group, or a number.

    Residuals of the covariates are permuted (Freedman, Lane), and each point is compared with the largest statistic of
    all points, so that the chance of finding anything at all where nothing is there is at most `LEVEL`.

    Parameters
    ----------
    group : Group
        The group.
    variable : (members,) array_like
        Numbers, or names of groups: two or more.
    covariates : (members,) or (members, k) array_like, optional
        Numbers that may explain differences, too, such as age.
    data : (members, n) or (members, n, d) array_like, optional
        What is tested; the members' shapes by default.
    permutations : int, default 1000
        How many; the smallest p is 1 / (permutations + 1).
    seed : int, default 0
        Of the permutations.

    Returns
    -------
    PointTest
        Statistic, p, effects and their errors at each point.

    Raises
    ------
    MeshError
        If there is not one finite value for each member, or the variable is constant or follows from the covariates.
    ValueError
        If `permutations` is below 19, which can't reach .05.

    References
    ----------
    Nichols, Holmes 2002, *Nonparametric permutation tests for functional neuroimaging*; Winkler et al. 2014,
    *Permutation inference for the general linear model*.

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
    nuisance = np.ones((count, 1)) if covariates is None else np.column_stack(
        (np.ones(count), _numbers(covariates, count, "covariates")))
    values = np.asarray(group.shapes if data is None else data, dtype=np.float64)
    if values.ndim not in (2, 3) or len(values) != count or not np.isfinite(values).all():
        raise MeshError(f"data of shape {values.shape} for {count} members; give finite numbers, (members, n) or "
                        "(members, n, d)")
    values = values.reshape(count, values.shape[1], -1)
    Qz = np.linalg.qr(nuisance)[0]
    free = tested - Qz @ (Qz.T @ tested)
    if np.linalg.svd(free, compute_uv=False).min() <= _RANK * np.linalg.norm(tested):
        raise MeshError("the variable is constant, or follows from the covariates; give one that varies beside them")
    Qx, R = np.linalg.qr(free)
    freedom = count - Qz.shape[1] - Qx.shape[1]
    if freedom < 1:
        raise MeshError(f"{count} members are too few for {Qz.shape[1] + Qx.shape[1]} columns; give fewer covariates")
    flat = values.reshape(count, -1)
    rest = flat - Qz @ (Qz.T @ flat)
    squares = (rest**2).sum(axis=0).reshape(values.shape[1:]).sum(axis=1)
    basis = np.concatenate((Qx, Qz), axis=1)
    ratio = freedom / Qx.shape[1]

    def statistics(rows: FloatArray) -> FloatArray:
        """F (k, n) of bases (k, members, q + z) whose rows are permuted instead of the residuals."""
        parts = np.einsum("kmc,mi->kci", rows, rest, optimize=True) ** 2
        parts = parts.reshape(*parts.shape[:2], *values.shape[1:]).sum(axis=3)
        model = parts[:, : Qx.shape[1]].sum(axis=1)
        left = squares - parts.sum(axis=1)
        return np.asarray(ratio * model / np.maximum(left, np.finfo(float).eps * squares.max()))

    F = statistics(basis[None])[0]
    rng = np.random.default_rng(seed)
    maxima = np.empty(permutations)
    for start in range(0, permutations, _BLOCK):
        block = np.stack([basis[rng.permutation(count)] for _ in range(min(_BLOCK, permutations - start))])
        maxima[start : start + len(block)] = statistics(block).max(axis=1)
    maxima.sort()
    beyond = permutations - np.searchsorted(maxima, F * (1 - _TIE))
    effect = np.linalg.solve(R, Qx.T @ flat).reshape(-1, *values.shape[1:])
    explained = F / (F + ratio)
    noise = np.sqrt((1 - explained) * squares / (freedom * values.shape[2]))
    error = np.sqrt(np.diag(np.linalg.inv(R.T @ R)))[:, None] * noise
    threshold = float(maxima[int(np.ceil((1 - LEVEL) * (permutations + 1))) - 1])
    return PointTest(F, (1 + beyond) / (1 + permutations), effect, error, explained, threshold, levels)


def _columns(variable: ArrayLike, count: int) -> tuple[FloatArray, tuple[str, ...]]:
    """Columns of a variable: itself, or one for each level but the first."""
    given = np.asarray(variable)
    if given.dtype.kind in "iuf":
        return _numbers(variable, count, "the variable"), ()
    names = given.astype(str).reshape(-1)
    if len(names) != count:
        raise MeshError(f"the variable has {len(names)} values for {count} members; give one for each")
    return indicators(names), tuple(np.unique(names).tolist())


def indicators(names: NDArray[np.generic]) -> FloatArray:
    """A column of zeros and ones for each level but the first, in the order of sorting."""
    return (names[:, None] == np.unique(names)[1:]).astype(np.float64)


def _numbers(values: ArrayLike, count: int, name: str) -> FloatArray:
    """Rows (count, k) of finite numbers."""
    rows = np.asarray(values, dtype=np.float64)
    rows = rows.reshape(len(rows), -1) if rows.ndim else rows.reshape(1, 1)
    if len(rows) != count or not np.isfinite(rows).all():
        raise MeshError(f"{name} have {len(rows)} rows for {count} members; give a finite number for each")
    return rows
