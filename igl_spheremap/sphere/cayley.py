"""The Cayley update: a step that stays on the sphere."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..gate import gate
from ..mesh.arrays import FloatArray, check_rows
from .rows import row_dots


@gate
def cayley_update(x: ArrayLike, h: ArrayLike, tau: float) -> FloatArray:
    r"""Move along the Cayley path of Theorem 1, which keeps the length of each row for every `tau`.

    Solves :math:`Y = F - \tfrac{\tau}{2} A (F + Y)` with :math:`A = H F^* - F H^*`, eqs. (10) and (11), in closed
    form :math:`Y = \alpha F + \beta H`.

    Parameters
    ----------
    x : (n, 3) array_like
        The map F; rows of any nonzero length.
    h : (n, 3) array_like
        The descent covector H (its negative is followed), one row per row of `x`.
    tau : float
        Step size; 0 gives `x` back, negative values go backwards.

    Returns
    -------
    (n, 3) float64 array
        Y[tau], each row as long as that of `x` up to rounding.

    Raises
    ------
    MeshError
        If an array is not real or not of that shape.

    References
    ----------
    Lai et al., Theorem 1. With T the part of H orthogonal to F and s = ``tau |F| |T| / 2`` its coefficients are those
    of the rational parametrisation of a rotation: written so, nothing cancels when H is almost parallel to F.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> ism.cayley_update([[0.0, 0.0, 1.0]], [[-1.0, 0.0, 5.0]], 2.0)
    array([[1., 0., 0.]])
    """
    f = check_rows(x)
    return cayley_step(f, check_rows(h, len(f), "directions"), tau)


def cayley_step(f: FloatArray, h: FloatArray, tau: float) -> FloatArray:
    """`cayley_update` for float64 rows."""
    ff = row_dots(f, f)
    t = (row_dots(f, h) / ff)[:, None] * f
    np.subtract(h, t, out=t)
    s = 0.5 * tau * np.sqrt(ff * row_dots(t, t))
    # of the cosine of half the angle; if s overflows it is 0, as is right
    square = 1 / (1 + s * s)
    t *= (tau * square * ff)[:, None]
    y = (2 * square - 1)[:, None] * f  # Theorem 1
    y -= t
    # A long step magnifies rounding's rest of F in T: give each row its length back.
    y *= np.sqrt(ff / row_dots(y, y))[:, None]
    return y
