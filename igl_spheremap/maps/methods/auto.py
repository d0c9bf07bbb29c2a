"""The fast, certified pipeline: one factorisation, a start for free, two or three steps, repair where it folds."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ...descent.fast import TOLERANCE, fast_map
from ...descent.iterate import Listener, Status
from ...descent.problem import HarmonicEnergy
from ...mesh.check import Mesh
from ...operators.operators import Metric, build_metric
from ...sphere.gauge import fix_gauge
from ...untangle.ladder import climb
from ...untangle.mend import is_astray, restore_gauge
from ...untangle.polish import polish_map
from ...untangle.relax import Polish
from ...verify.certificate import certify_checked
from .draft import Draft

FloatArray = NDArray[np.float64]
Gauge = Literal["centred", "axis"]


def auto(
    mesh: Mesh,
    listener: Listener | None = None,
    *,
    tolerance: float = TOLERANCE,
    max_iterations: int = 30,
    backend: str = "auto",
    gauge: Gauge = "centred",
    polish: Polish | None = None,
) -> Draft:
    """Map a mesh by preconditioned Cayley steps, and mend what folds.

    Parameters
    ----------
    mesh : Mesh
        The checked source.
    listener : callable, optional
        Called with every iterate, and with the map of every rung of the repair ladder.
    tolerance : float
        Energy above the minimum that may be left, in units of the gap between energy and flat image area, which is the
        mesh's own discretisation error.
    max_iterations : int
        Steps at the most.
    backend : str
        Factorisation, see `igl_spheremap.operators.factor.factorize`.
    gauge : {"centred", "axis"}
        "axis" puts the two deepest tips of a body that is beyond float64 at the poles, where coordinates are finer, if
        the map is better for it; the result's ``gauge`` tells.
    polish : {"angles", "mips"}, optional
        Lower the angle differences themselves (the mean falls by 10 percent or more on many meshes), or the MIPS
        energy (the largest differences fall), when the map is done. Nothing by default.

    Returns
    -------
    Draft
        Certified folding-free, unless a listener stopped it.

    Raises
    ------
    ValueError
        If `backend`, `gauge` or `polish` is unknown.
    """
    check_choices(gauge, polish)
    return map_in_metric(mesh, build_metric(mesh, backend), None, listener, tolerance=tolerance,
                         max_iterations=max_iterations, gauge=gauge, polish=polish)


def check_choices(gauge: str, polish: str | None) -> None:
    """Raise unless both are known, before anything is computed.

    Parameters
    ----------
    gauge, polish : str
        As of `auto`.

    Raises
    ------
    ValueError
        If one is unknown.
    """
    if gauge not in ("centred", "axis"):
        raise ValueError(f"unknown gauge {gauge!r}: choose 'centred' or 'axis'")
    if polish not in (None, "angles", "mips"):
        raise ValueError(f"unknown polish {polish!r}: choose 'angles' or 'mips'")


def map_in_metric(mesh: Mesh, metric: Metric, start: FloatArray | None, listener: Listener | None, *,
                  tolerance: float, max_iterations: int, gauge: Gauge, polish: Polish | None) -> Draft:
    """What `auto` does once the Laplacian is factorised.

    Parameters
    ----------
    mesh : Mesh
        The checked source.
    metric : Metric
        Its factorised Laplacian; its areas `A` are what the gauge balances.
    start : (n, 3) float64 array, optional
        Unit rows; the punctured harmonic map by default.
    listener, tolerance, max_iterations, gauge, polish
        As of `auto`.

    Returns
    -------
    Draft
        Certified folding-free, unless a listener stopped it.
    """
    minimum = fast_map(mesh, metric, start, tolerance=tolerance, max_iterations=max_iterations, listener=listener)
    x, energy, status = fix_gauge(mesh, minimum.last.x, metric.A), minimum.last.energy, minimum.status
    try:
        mended = None if status is Status.STOPPED else climb(mesh, metric, x, listener, axis=gauge == "axis")
    except StopIteration:
        mended = None
    if mended is None:
        return Draft(x, energy, Status.STOPPED, backend=metric.factor.backend, notes=metric.notes,
                     certificate=certify_checked(x, mesh.f))
    y, certificate = mended.x, mended.certificate
    if polish is not None:
        y = polish_map(mesh, y, polish)
        y = y if mended.on_axis else restore_gauge(mesh, y, metric.A)
        certificate = certify_checked(y, mesh.f)
    notes = metric.notes
    if not mended.on_axis and is_astray(y, metric.A):
        notes = (*notes, "not Moebius-centred, which would fold huge faces or spoil their angles")
    if y is not x:
        energy = HarmonicEnergy(metric.L).evaluate(y)[0]
    return Draft(y, energy, status, mended.rounds, metric.factor.backend, notes, certificate,
                 "axis" if mended.on_axis else "centred", mended.stretch)
