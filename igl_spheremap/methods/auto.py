"""The fast, certified pipeline: one factorisation, a start for free, two or three steps, repair where it folds."""

from __future__ import annotations

from ..fast import TOLERANCE, fast_map
from ..iterate import Listener
from ..mesh import Mesh
from ..metric import build_metric
from .draft import Draft


def auto(
    mesh: Mesh,
    listener: Listener | None = None,
    *,
    tolerance: float = TOLERANCE,
    max_iterations: int = 30,
    backend: str = "auto",
) -> Draft:
    """Map a mesh by preconditioned Cayley steps.

    Parameters
    ----------
    mesh : Mesh
        The checked source.
    listener : callable, optional
        Called with every iterate.
    tolerance : float
        Energy above the minimum that may be left, in units of the gap between energy and flat image area, which is the
        mesh's own discretisation error.
    max_iterations : int
        Steps at the most.
    backend : str
        Factorisation, see `igl_spheremap.factor.factorize`.

    Returns
    -------
    Draft
        The map.
    """
    metric = build_metric(mesh, backend)
    minimum = fast_map(mesh, metric, tolerance=tolerance, max_iterations=max_iterations, listener=listener)
    return Draft(minimum.last.x, minimum.last.energy, minimum.status, backend=metric.factor.backend, notes=metric.notes)
