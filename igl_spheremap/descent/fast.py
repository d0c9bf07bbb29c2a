"""The fast map: a start that the factorisation gives, then preconditioned Cayley steps."""

from __future__ import annotations

from dataclasses import replace
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from ..mesh.check import Mesh
from ..operators.operators import Operators
from ..start.punctured import is_coarse, punctured_start
from ..verify.certificate import certify_checked
from ..verify.distortion import mean_angle_difference
from .iterate import Listener, Status
from .minimize import Minimum, minimize
from .sobolev import SobolevCayley

FloatArray = NDArray[np.float64]

#: Share of the mesh's own discretisation error, energy minus image area, that may be left above the minimum.
TOLERANCE = 1e-3
#: Share of the end's angle differences that makes up for a few foldings of the start.
_FAR_LESS = 0.5


def fast_map(
    mesh: Mesh,
    operators: Operators,
    x: FloatArray | None = None,
    *,
    tolerance: float = TOLERANCE,
    max_iterations: int = 30,
    listener: Listener | None = None,
) -> Minimum:
    """Harmonic map of a mesh whose Laplacian is factorised.

    Parameters
    ----------
    mesh : Mesh
        The checked source.
    operators : Operators
        Its factorised Laplacian.
    x : (n, 3) float64 array, optional
        Start; the punctured harmonic map by default.
    tolerance : float
        Energy above the minimum that may be left, in units of the gap between energy and image area.
    max_iterations : int
        Steps at the most.
    listener : callable, optional
        Called with every iterate.

    Returns
    -------
    Minimum
        Usually after two or three steps. On a mesh so coarse that its faces cut deep through the sphere the chord
        energy has no useful minimiser: there the last iterate is the start, if that keeps angles better.
    """
    if x is None:
        x = punctured_start(mesh, operators)
    iterates = SobolevCayley(operators.L, operators.P, operators.factor, operators.A, mesh.f).iterates(x)
    first = next(iterates)
    minimum = minimize(chain([first], iterates), tolerance=tolerance, max_iterations=max_iterations, listener=listener)
    last, stopped = minimum.last, minimum.status is Status.STOPPED
    if not stopped and is_coarse(mesh, last.x) and _misled(mesh, first.x, last.x):
        return replace(minimum, last=first)
    return minimum


def _misled(mesh: Mesh, start: FloatArray, end: FloatArray) -> bool:
    """Whether the start is the better map: of less angle differences without more foldings, or of far less."""
    before, after = (mean_angle_difference(mesh, x) for x in (start, end))
    fewer = certify_checked(start, mesh.f).foldings <= certify_checked(end, mesh.f).foldings
    return before < (after if fewer else _FAR_LESS * after)
