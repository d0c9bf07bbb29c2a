"""The punctured-plane baselines: a conformal map to the plane, then inverse stereographic projection."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np

from ...descent.iterate import Iterate, Listener, Status
from ...errors import MapError
from ...mesh.check import Mesh
from ...operators.operators import Operators, build_operators
from ...sphere.moebius import center
from ...start.dipole import dipole_map
from ...start.flat_metric import ComplexArray, FlatMetric, flat_metric, lay_out
from ...start.punctured import candidate_faces, to_sphere
from .draft import Draft

_PLANES = ("laplace-beltrami", "conformal-equivalence")


def stereographic(
    mesh: Mesh,
    listener: Listener | None = None,
    *,
    plane: Literal["laplace-beltrami", "conformal-equivalence"] = "laplace-beltrami",
    puncture: int | None = None,
    tolerance: float = 1e-8,
    max_iterations: int = 100,
    backend: str = "auto",
) -> Draft:
    """Map a mesh through the plane.

    Parameters
    ----------
    mesh : Mesh
        The checked source.
    listener : callable, optional
        Called with the map.
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
        Of the flat metric only: Newton steps at the most.
    backend : str
        Factorisation, see `igl_spheremap.operators.factor.factorize`.

    Returns
    -------
    Draft
        The map; its notes name the face, and the Newton steps.

    Raises
    ------
    MapError
        If the plane map is not finite.
    NotConverged
        If the Newton iteration for the flat metric did not end.
    ValueError
        If `plane` is unknown or there is no such face.

    References
    ----------
    Angenent, Haker, Tannenbaum, Kikinis 1999; Springborn, Schroeder, Pinkall 2008, *Conformal Equivalence of
    Triangle Meshes*.
    """
    if puncture is not None and not 0 <= puncture < len(mesh.f):
        raise ValueError(
            f"there is no face {puncture} to puncture: the mesh has faces 0 to {len(mesh.f) - 1}"
        )
    if plane not in _PLANES:
        raise ValueError(f"unknown plane map {plane!r}: choose one of {', '.join(_PLANES)}")
    faces = candidate_faces(mesh) if puncture is None else iter([int(puncture)])
    operators = build_operators(mesh, backend)
    if plane == "laplace-beltrami":
        face = next(faces)
        z, notes = dipole_map(mesh, operators, face), [f"face {face} is punctured"]
    else:
        z, notes = _flattened(mesh, operators, faces, tolerance, max_iterations)
    near = np.isfinite(z)
    if near.sum() < len(z) - 1:
        raise MapError("the plane map is not finite; puncture another face")
    x = np.tile([0.0, 0.0, -1.0], (len(z), 1))
    x[near] = to_sphere(z[near], operators.A[near])
    x = center(x, operators.A)
    energy = 0.5 * float(np.vdot(x, operators.L @ x))
    status = Status.CONVERGED
    try:
        if listener is not None:
            listener(Iterate("stereographic", 0, 1, x, energy))
    except StopIteration:
        status = Status.STOPPED
    return Draft(x, energy, status, backend=operators.factor.backend, notes=(*operators.notes, *notes))


def _flattened(
    mesh: Mesh, operators: Operators, faces: Iterator[int], tolerance: float, max_iterations: int
) -> tuple[ComplexArray, list[str]]:
    """The conformally equivalent plane map that breaks the fewest faces, and what there is to say of it."""
    best: tuple[int, FlatMetric] | None = None
    for face in faces:
        first = to_sphere(dipole_map(mesh, operators, face), operators.A)
        flat = flat_metric(
            mesh, int(mesh.f[face, 0]), first, tolerance=tolerance, max_iterations=max_iterations
        )
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
