"""The fast map: a start that the factorisation gives, then preconditioned Cayley steps."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .iterate import Listener
from .mesh import Mesh
from .metric import Metric
from .minimize import Minimum, minimize
from .puncture import punctured_start
from .solvers.sobolev import SobolevCayley

FloatArray = NDArray[np.float64]

#: Share of the mesh's own discretisation error, energy minus image area, that may be left above the minimum.
TOLERANCE = 1e-3


def fast_map(
    mesh: Mesh,
    metric: Metric,
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
    metric : Metric
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
        Usually after two or three steps.
    """
    if x is None:
        x = punctured_start(mesh, metric)
    solver = SobolevCayley(metric.L, metric.P, metric.factor, metric.A, mesh.f)
    return minimize(solver.iterates(x), tolerance=tolerance, max_iterations=max_iterations, listener=listener)
