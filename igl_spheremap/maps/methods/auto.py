"""The fast, certified pipeline: one factorisation, a start for free, two or three steps, repair where it folds."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ...descent.fast import TOLERANCE, fast_map
from ...descent.iterate import Listener, Status
from ...descent.problem import HarmonicEnergy
from ...mesh.check import Mesh
from ...operators.operators import Operators, build_operators
from ...sphere.gauge import fix_gauge
from ...untangle.ladder import untangle
from ...untangle.mend import is_off_centre, restore_gauge
from ...untangle.polish import polish_map
from ...untangle.relax import Polish
from ...verify.certificate import certify_checked
from .draft import Draft

FloatArray = NDArray[np.float64]
Gauge = Literal["centred", "poles"]


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
    gauge : {"centred", "poles"}
        "poles" puts the two deepest tips of a body that is beyond float64 at the poles, where coordinates are finer, if
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
    return map_in_metric(mesh, build_operators(mesh, backend), None, listener, tolerance=tolerance,
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
    if gauge not in ("centred", "poles"):
        raise ValueError(f"unknown gauge {gauge!r}: choose 'centred' or 'poles'")
    if polish not in (None, "angles", "mips"):
        raise ValueError(f"unknown polish {polish!r}: choose 'angles' or 'mips'")


def map_in_metric(mesh: Mesh, operators: Operators, start: FloatArray | None, listener: Listener | None, *,
                  tolerance: float, max_iterations: int, gauge: Gauge, polish: Polish | None) -> Draft:
    """What `auto` does once the Laplacian is factorised.

    Parameters
    ----------
    mesh : Mesh
        The checked source.
    operators : Operators
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
    minimum = fast_map(mesh, operators, start, tolerance=tolerance, max_iterations=max_iterations, listener=listener)
    x, energy, status = fix_gauge(mesh, minimum.last.x, operators.A), minimum.last.energy, minimum.status
    try:
        mended = None if status is Status.STOPPED else untangle(mesh, operators, x, listener, poles=gauge == "poles")
    except StopIteration:
        mended = None
    if mended is None:
        return Draft(x, energy, Status.STOPPED, backend=operators.factor.backend, notes=operators.notes,
                     certificate=certify_checked(x, mesh.f))
    y, certificate = mended.x, mended.certificate
    if polish is not None:
        y = polish_map(mesh, y, polish)
        y = y if mended.at_poles else restore_gauge(mesh, y, operators.A)
        certificate = certify_checked(y, mesh.f)
    notes = operators.notes
    if not mended.at_poles and is_off_centre(y, operators.A):
        notes = (*notes, "not Moebius-centred, which would fold huge faces or spoil their angles")
    if y is not x:
        energy = HarmonicEnergy(operators.L).evaluate(y)[0]
    return Draft(y, energy, status, mended.rounds, operators.factor.backend, notes, certificate,
                 "poles" if mended.at_poles else "centred", mended.stretch)
