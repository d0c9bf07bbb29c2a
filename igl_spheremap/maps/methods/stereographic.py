"""The punctured-plane baselines: a conformal map to the plane, then inverse stereographic projection."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from ...descent.energies.harmonic import HarmonicEnergy
from ...descent.iterate import Iterate, Listener, Status
from ...errors import MapError
from ...mesh.check import Mesh
from ...operators.operators import Operators, build_operators
from ...sphere.moebius import center
from ...start.dipole import dipole_map
from ...start.flat_metric import ComplexArray, FlatMetric, flat_metric, lay_out
from ...start.punctured import candidate_faces, to_sphere
from ...untangle.candidate import Candidate
from .method import Method

FloatArray = NDArray[np.float64]
Plane = Literal["laplace-beltrami", "conformal-equivalence"]


@dataclass(frozen=True)
class Stereographic(Method):
    """The method "stereographic": a conformal map to the plane, then inverse stereographic projection.

    Parameters
    ----------
    plane : {"laplace-beltrami", "conformal-equivalence"}
        How the punctured surface is flattened: by one linear solve (reference [11] of Lai et al.), or by a
        flow of the conformal factor to a flat metric (reference [12]), here the convex Newton iteration of
        Springborn, Schroeder and Pinkall.
    puncture : int, optional
        Face that holds the pole. The flat metric has the pole at its first corner: next to a punctured face
        of equal sides triangles would have angles of 180 degrees. By default a well-shaped face of middling
        size; for the flat metric the best of four such.
    tolerance : float
        Of the flat metric only: largest angle defect in radians.
    max_iterations : int
        Of the flat metric only: Newton steps at the most, counted for each puncture that is tried.
    backend : str
        Factorisation, see `igl_spheremap.operators.factor.factorize`; "auto" takes the best that is installed.

    Raises
    ------
    ValueError
        If `plane` is unknown; at the run, if there is no such face or backend.
    MapError
        At the run, if the plane map is not finite.
    NotConverged
        At the run, if the Newton iteration for the flat metric did not end.

    References
    ----------
    Angenent, Haker, Tannenbaum, Kikinis 1999; Springborn, Schroeder, Pinkall 2008, *Conformal Equivalence of
    Triangle Meshes*.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("spheroid", n_vertices=500)
    >>> ism.spherical_conformal_map(v, f, ism.Stereographic(puncture=0)).notes
    ('face 0 is punctured',)
    """

    name: ClassVar[str] = "stereographic"
    plane: Plane = "laplace-beltrami"
    puncture: int | None = None
    tolerance: float = 1e-8
    max_iterations: int = 100
    backend: str = "auto"

    def __post_init__(self) -> None:
        """Refuse unknown choices before anything is computed."""
        if self.plane not in get_args(Plane):
            raise ValueError(f"unknown plane map {self.plane!r}: choose one of {', '.join(get_args(Plane))}")

    def run(self, mesh: Mesh, listener: Listener | None = None) -> Candidate:
        """Map a mesh; the notes name the face, and the Newton steps."""
        faces = candidate_faces(mesh) if self.puncture is None else iter([_checked_face(mesh, self.puncture)])
        operators = build_operators(mesh, self.backend)
        if self.plane == "laplace-beltrami":
            face = next(faces)
            z, notes = dipole_map(mesh, operators, face), [f"face {face} is punctured"]
        else:
            z, notes = self._flattened(mesh, operators, faces)
        x = _lifted(z, operators.A)
        energy = HarmonicEnergy(operators.L).evaluate(x)[0]
        status = Status.CONVERGED
        try:
            if listener is not None:
                listener(Iterate("stereographic", 0, 1, x, energy))
        except StopIteration:
            status = Status.STOPPED
        return Candidate(x, energy, status, backend=operators.factor.backend, notes=(*operators.notes, *notes))

    def _flattened(
        self, mesh: Mesh, operators: Operators, faces: Iterator[int]
    ) -> tuple[ComplexArray, list[str]]:
        """The conformally equivalent plane map that breaks the fewest faces, and notes on it."""
        best: tuple[int, FlatMetric] | None = None
        for face in faces:
            first = to_sphere(dipole_map(mesh, operators, face), operators.A)
            flat = flat_metric(mesh, int(mesh.f[face, 0]), first, tolerance=self.tolerance,
                               max_iterations=self.max_iterations)
            if best is None or len(flat.broken) < len(best[1].broken):
                best = face, flat
            if not len(flat.broken):
                break
        assert best is not None
        face, flat = best
        notes = [f"face {face} is punctured, {flat.iterations} Newton steps to a flat metric"]
        if len(flat.broken):
            notes.append(
                f"no flat metric at {len(flat.broken)} faces, whose sides break the triangle inequality, e.g. "
                f"{', '.join(map(str, flat.broken[:3].tolist()))}"
            )
        return lay_out(flat), notes


def _checked_face(mesh: Mesh, face: int) -> int:
    """The face, if there is one of that number."""
    if not 0 <= face < len(mesh.f):
        raise ValueError(f"there is no face {face} to puncture: the mesh has faces 0 to {len(mesh.f) - 1}")
    return int(face)


def _lifted(z: ComplexArray, A: FloatArray) -> FloatArray:
    """The sphere map of a plane map of which one vertex may lie at infinity, centred."""
    near = np.isfinite(z)
    if near.sum() < len(z) - 1:
        raise MapError("the plane map is not finite; puncture another face")
    x = np.tile([0.0, 0.0, -1.0], (len(z), 1))
    x[near] = to_sphere(z[near], A[near])
    return center(x, A)
