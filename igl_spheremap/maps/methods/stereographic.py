"""The punctured-plane baselines: a conformal map to the plane, then inverse stereographic projection."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...descent.energies.harmonic import HarmonicEnergy
from ...errors import MapError
from ...mesh.arrays import ComplexArray, FloatArray
from ...mesh.check import Mesh
from ...operators.laplacian import Operators, build_operators
from ...result.run import Iterate, Listener, Status
from ...sphere.moebius import center
from ...start.flat_metric import FlatMetric, flat_metric, lay_out
from ...start.punctured import candidate_faces, dipole_map, to_sphere
from ...untangle.candidate import Candidate
from ..options import Stereographic


def stereographic(mesh: Mesh, options: Stereographic, listener: Listener) -> Candidate:
    """Map a mesh; the notes name the face, and the Newton steps."""
    faces = candidate_faces(mesh) if options.puncture is None else iter([_checked_face(mesh, options.puncture)])
    operators = build_operators(mesh, options.backend)
    if options.plane == "laplace-beltrami":
        face = next(faces)
        z, notes = dipole_map(mesh, operators, face), [f"face {face} is punctured"]
    else:
        z, notes = _flattened(mesh, operators, faces, options)
    x = _lifted(z, mesh.A)
    energy = HarmonicEnergy(operators.L).evaluate(x)[0]
    status = Status.CONVERGED
    try:
        listener(Iterate("stereographic", 0, 1, x, energy))
    except StopIteration:
        status = Status.STOPPED
    return Candidate(x, energy, status, backend=operators.factor.backend, notes=(*operators.notes, *notes))


def _flattened(
    mesh: Mesh, operators: Operators, faces: Iterator[int], options: Stereographic
) -> tuple[ComplexArray, list[str]]:
    """The conformally equivalent plane map that breaks the fewest faces, and notes on it."""
    best: tuple[int, FlatMetric] | None = None
    for face in faces:
        first = to_sphere(dipole_map(mesh, operators, face), mesh.A)
        flat = flat_metric(mesh, int(mesh.f[face, 0]), first, tolerance=options.tolerance,
                           max_iterations=options.max_iterations)
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
    if face not in range(len(mesh.f)):
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
