"""The sphere as the plane with a point at infinity: stereographic projection, and Moebius maps that users ask for."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..errors import MeshError
from ..gate import gate
from ..mesh.arrays import (
    HALF_DIGITS,
    ComplexArray,
    FloatArray,
    check_directions,
    check_rows,
    check_values,
    count,
    examples,
    plain_array,
)
from .moebius import center, moebius
from .rows import row_dots, unit_rows


@gate
def stereographic(x: ArrayLike) -> ComplexArray:
    """Project the unit sphere from the north pole (0, 0, 1) to the complex plane.

    Parameters
    ----------
    x : (n, 3) array_like
        Points of the sphere; rows are divided by their lengths.

    Returns
    -------
    (n,) complex128 array
        ``(x + i y) / (1 - z)``: the equator is the unit circle, the south pole 0, the north pole infinite.

    Raises
    ------
    MeshError
        If a row is zero or not finite.

    See Also
    --------
    inverse_stereographic : the way back.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> ism.stereographic([[1, 0, 0], [0, 0.6, -0.8], [0, 0, -1]]).round(12).tolist()
    [(1+0j), 0.333333333333j, 0j]
    """
    u, v = _homogeneous(_unit(x))
    with np.errstate(divide="ignore", invalid="ignore"):
        z = u / v
    z[v == 0] = np.inf
    return z


@gate
def inverse_stereographic(z: ArrayLike) -> FloatArray:
    """Lift points of the complex plane to the unit sphere, infinity to the north pole.

    Parameters
    ----------
    z : (n,) array_like of complex numbers
        Points of the plane; any infinite number is the north pole.

    Returns
    -------
    (n, 3) float64 array
        Unit rows, ``(2 Re z, 2 Im z, |z|^2 - 1) / (|z|^2 + 1)``.

    Raises
    ------
    MeshError
        If `z` is no list of numbers, or one is NaN.

    See Also
    --------
    stereographic : the way back.

    Examples
    --------
    >>> import numpy as np
    >>> import igl_spheremap as ism
    >>> ism.inverse_stereographic([0, 1j, np.inf]).tolist()
    [[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    """
    given = plain_array(z, "points of the plane")
    if given.ndim != 1 or given.dtype.kind not in "iufc":
        raise MeshError(
            f"points of the plane have shape {given.shape} and type {given.dtype}; give one complex "
            "number each"
        )
    points = given.astype(np.complex128)
    bad = np.flatnonzero(np.isnan(points) & ~np.isinf(points))
    if len(bad):
        raise MeshError(
            f"{count(bad, 'point')} of the plane are NaN, {examples(bad)}; fill them in"
        )
    far = np.abs(points) > 1
    inverse = np.zeros_like(points)
    np.divide(1, points, out=inverse, where=far & np.isfinite(points))
    return _lifted(np.where(far, 1, points), np.where(far, inverse, 1))


@gate
def moebius_map(x: ArrayLike, c: ArrayLike) -> FloatArray:
    """Apply the Moebius map of the ball that takes a point inside it to the centre.

    Parameters
    ----------
    x : (n, 3) array_like
        Points of the sphere; rows are divided by their lengths.
    c : (3,) array_like
        The point. Images near ``c / |c|`` are spread out, those opposite are crowded; ``-c`` undoes it.

    Returns
    -------
    (n, 3) float64 array
        Unit rows. The map is conformal, so that angles of small faces stay.

    Raises
    ------
    MeshError
        If a row is zero or not finite, or `c` is not inside the unit ball.

    See Also
    --------
    recentre : the Moebius map that balances weights.
    moebius_through : the map that takes three points to three others.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> ism.moebius_map([[0, 0, 1], [1, 0, 0]], [0, 0, 0.5]).round(12).tolist()
    [[0.0, 0.0, 1.0], [0.6, 0.0, -0.8]]
    """
    centre = plain_array(c, "the Moebius centre")
    if centre.shape != (3,):
        raise MeshError(f"the Moebius centre has shape {centre.shape}; give three coordinates")
    return moebius(_unit(x), centre)


@gate
def recentre(x: ArrayLike, weights: ArrayLike) -> FloatArray:
    """Apply the Moebius map after which weights of the points balance: their barycentre is the origin.

    Maps that differ by a Moebius map differ by a rotation afterwards.

    Parameters
    ----------
    x : (n, 3) array_like
        Points of the sphere; rows are divided by their lengths.
    weights : (n,) array_like
        Weights from 0, such as `result.mesh.A`, the vertex areas of the surface. Less than half of them may lie at
        one point.

    Returns
    -------
    (n, 3) float64 array
        Unit rows; their weighted mean is shorter than 1e-12.

    Raises
    ------
    MeshError
        If a row is zero or not finite, a weight is negative or not finite, or no Moebius map balances them.

    References
    ----------
    Baden, Crane, Kazhdan 2018, *Moebius Registration*: the conformal barycentre, by Newton's method.

    Examples
    --------
    >>> import numpy as np
    >>> import igl_spheremap as ism
    >>> x = np.vstack((np.eye(3), -np.eye(3)))
    >>> moved = ism.moebius_map(x, [0.1, 0.2, 0.3])
    >>> bool(np.abs(ism.recentre(moved, np.ones(6)).mean(axis=0)).max() < 1e-12)
    True
    """
    rows = _unit(x)
    w = check_values(weights, len(rows), "weights")[:, 0]
    if (w < 0).any() or not w.any():
        raise MeshError("weights are negative or all zero; give numbers from 0")
    moved = center(rows, w)
    if np.abs(w @ moved).max() > 1e-9 * w.sum():
        raise MeshError(
            "no Moebius map balances the weights: half of them or more lie at one point; spread them"
        )
    return moved


@gate
def moebius_through(x: ArrayLike, points: ArrayLike, targets: ArrayLike) -> FloatArray:
    """Apply the Moebius map that takes three points of the sphere to three others.

    Parameters
    ----------
    x : (n, 3) array_like
        Points of the sphere; rows are divided by their lengths.
    points, targets : (3, 3) array_like
        Three different points, one a row, and their three different images.

    Returns
    -------
    (n, 3) float64 array
        Unit rows. Exactly one Moebius map that keeps orientation does this.

    Raises
    ------
    MeshError
        If a row is zero or not finite, or two of the three points are nearer to each other than 1.5e-8.

    Examples
    --------
    >>> import numpy as np
    >>> import igl_spheremap as ism
    >>> ism.moebius_through([[0, 0, 1], [0, 0, -1]], np.eye(3), np.roll(np.eye(3), 1, axis=0)).round(12).tolist()
    [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]
    """
    rows = np.stack(_homogeneous(_unit(x)))
    start, end = (_basis(each, name) for each, name in ((points, "points"), (targets, "targets")))
    u, v = end @ np.linalg.solve(start, rows)
    return _lifted(u, v)


def _basis(corners: ArrayLike, name: str) -> ComplexArray:
    """`projective_frame` of three points of the sphere, which must differ."""
    rows = _unit(check_rows(corners, 3, name))
    p = np.stack(_homogeneous(rows))
    for i, j in ((0, 1), (0, 2), (1, 2)):
        if np.abs(rows[i] - rows[j]).max() < HALF_DIGITS:
            raise MeshError(f"{name} {i} and {j} coincide; give three different ones")
    return projective_frame(p)


def projective_frame(p: ComplexArray) -> ComplexArray:
    """The first two columns (2, 2) of three points in homogeneous coordinates, scaled so that their sum is the third.

    As a Moebius map it takes infinity, 0 and 1 to the three points.
    """
    return np.asarray(p[:, :2] * np.linalg.solve(p[:, :2], p[:, 2]), dtype=np.complex128)


def _unit(x: ArrayLike) -> FloatArray:
    """Rows of unit length; MeshError for rows that have no direction."""
    return unit_rows(check_directions(x, name="points of the sphere"))


def _homogeneous(x: FloatArray) -> tuple[ComplexArray, ComplexArray]:
    """Complex numbers u, v, not both small, of which u / v is the stereographic projection of unit rows."""
    xy, z = x[:, 0] + 1j * x[:, 1], x[:, 2]
    south = z < 0
    return np.where(south, xy, 1 + z), np.where(south, 1 - z, xy.conj())


def _lifted(u: ComplexArray, v: ComplexArray) -> FloatArray:
    """The unit rows of homogeneous coordinates of any common scale."""
    size = np.maximum(np.abs(u), np.abs(v))
    u, v = u / size, v / size
    xy, uu, vv = 2 * u * v.conj(), np.abs(u) ** 2, np.abs(v) ** 2
    y = np.column_stack((xy.real, xy.imag, uu - vv))
    return np.asarray(y / np.sqrt(row_dots(y, y))[:, None])
