"""The fast, certified pipeline: one factorisation, a start for free, two or three steps, repair where it folds."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from ...descent.energies.harmonic import HarmonicEnergy
from ...descent.iterate import Listener, Status
from ...descent.preconditioned import MAX_ITERATIONS, TOLERANCE, harmonic_map
from ...mesh.check import Mesh
from ...operators.operators import Operators, build_operators
from ...sphere.gauge import fix_gauge
from ...untangle.candidate import Candidate
from ...untangle.ladder import untangle
from ...untangle.mend import is_off_centre, restore_gauge
from ...untangle.polish import polish_map
from ...untangle.relax import Polish
from ...verify.certificate import certify_checked
from .method import Method

FloatArray = NDArray[np.float64]
Gauge = Literal["centred", "poles"]


@dataclass(frozen=True)
class Auto(Method):
    """The default method: preconditioned Cayley steps, then the repair of what folds.

    Parameters
    ----------
    tolerance : float
        Harmonic energy above the minimum that may be left, in units of the gap between energy and flat image area,
        which is the mesh's own discretisation error.
    max_iterations : int
        Steps at the most, for each harmonic map: the repair may solve for another one.
    backend : str
        Factorisation, see `igl_spheremap.operators.factor.factorize`; "auto" takes the best that is installed.
    gauge : {"centred", "poles"}
        "poles" puts the two deepest tips of a body that is beyond float64 at the poles, where coordinates are finer, if
        the map is better for it; the result's ``gauge`` says which it is.
    polish : {"angles", "mips"}, optional
        Lower the angle differences themselves (the mean falls by 10 percent or more on many meshes), or the MIPS
        energy (the largest differences fall), when the map is done. Nothing by default.

    Raises
    ------
    ValueError
        If `gauge` or `polish` is unknown; at the run, if `backend` is.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("spheroid", n_vertices=500)
    >>> ism.spherical_conformal_map(v, f, ism.Auto(polish="angles")).settings
    {'polish': 'angles'}
    """

    name: ClassVar[str] = "auto"
    tolerance: float = TOLERANCE
    max_iterations: int = MAX_ITERATIONS
    backend: str = "auto"
    gauge: Gauge = "centred"
    polish: Polish | None = None

    def __post_init__(self) -> None:
        """Refuse unknown choices before anything is computed."""
        if self.gauge not in get_args(Gauge):
            raise ValueError(f"unknown gauge {self.gauge!r}: choose 'centred' or 'poles'")
        if self.polish not in (None, *get_args(Polish)):
            raise ValueError(f"unknown polish {self.polish!r}: choose 'angles' or 'mips'")

    def run(self, mesh: Mesh, listener: Listener | None = None) -> Candidate:
        """Map a mesh; certified free of foldings, unless a listener stopped it."""
        return self.map(mesh, build_operators(mesh, self.backend), None, listener)

    def map(
        self, mesh: Mesh, operators: Operators, start: FloatArray | None, listener: Listener | None = None
    ) -> Candidate:
        """Map a mesh whose Laplacian is factorised; the areas of its operators are what the gauge balances."""
        minimum = harmonic_map(mesh, operators, start, tolerance=self.tolerance, max_iterations=self.max_iterations,
                               listener=listener)
        x = fix_gauge(mesh, minimum.last.x, operators.A)
        found = Candidate(x, minimum.last.energy, minimum.status, certificate=certify_checked(x, mesh.f),
                          backend=operators.factor.backend, notes=operators.notes)
        if found.status is Status.STOPPED:
            return found
        try:
            found = untangle(mesh, operators, found, listener, poles=self.gauge == "poles")
        except StopIteration:
            return replace(found, status=Status.STOPPED)
        if self.polish is not None:
            y = polish_map(mesh, found.x, self.polish)
            y = y if found.gauge == "poles" else restore_gauge(mesh, y, operators.A)
            energy = HarmonicEnergy(operators.L).evaluate(y)[0]
            found = replace(found, x=y, energy=energy, certificate=certify_checked(y, mesh.f))
        if found.gauge == "centred" and is_off_centre(found.x, operators.A):
            note = "not Moebius-centred, which would fold huge faces or spoil their angles"
            found = replace(found, notes=(*found.notes, note))
        return found
