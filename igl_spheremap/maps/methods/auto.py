"""The default: one factorisation, a start by two solves, one or two steps, and repair where the map folds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from ...descent.energies.harmonic import HarmonicEnergy
from ...descent.preconditioned import harmonic_map
from ...mesh.arrays import FloatArray
from ...mesh.check import Mesh
from ...operators.laplacian import Operators, build_operators
from ...result.run import Listener, Status
from ...sphere.gauge import fix_gauge
from ...untangle.candidate import Candidate
from ...untangle.local_repair import is_off_centre, restore_gauge
from ...untangle.polish import polish_map
from ...untangle.untangle import untangle
from ...verify.certificate import certify_checked
from ..options import Auto


def auto(mesh: Mesh, options: Auto, listener: Listener) -> Candidate:
    """Map a mesh; certified free of foldings, unless a listener stopped it."""
    return map_factorised(mesh, build_operators(mesh, options.backend), options, listener)


def map_factorised(
    mesh: Mesh, operators: Operators, options: Auto, listener: Listener, start: FloatArray | None = None
) -> Candidate:
    """Map a mesh whose Laplacian is factorised."""
    minimum = harmonic_map(mesh, operators, start, tolerance=options.tolerance, max_iterations=options.max_iterations,
                           listener=listener)
    x = fix_gauge(mesh, minimum.last.x)
    found = Candidate(x, minimum.last.energy, minimum.status, certificate=certify_checked(x, mesh.f),
                      backend=operators.factor.backend, notes=operators.notes)
    if found.status is Status.STOPPED:
        return found
    try:
        found = untangle(mesh, operators, found, listener, centred=options.gauge == "centred",
                         effort=options.effort)
    except StopIteration:
        return replace(found, status=Status.STOPPED)
    if options.polish is not None:
        y = polish_map(mesh, found.x, options.effort)
        y = y if found.gauge == "poles" else restore_gauge(mesh, y)
        energy = HarmonicEnergy(operators.L).evaluate(y)[0]
        found = replace(found, x=y, energy=energy, certificate=certify_checked(y, mesh.f))
    return replace(found, notes=(*found.notes, *_remarks(found, mesh)))


def _remarks(found: Candidate, mesh: Mesh) -> Iterator[str]:
    """What sets a map apart from others, for its notes."""
    if found.gauge == "centred" and is_off_centre(mesh, found.x):
        yield "not Moebius-centred, which would fold huge faces or spoil their angles"
    elif found.gauge == "poles":
        yield "not Moebius-centred: tips of limbs too deep for float64 are at ends of the axes"
    if found.stretch > 1:
        yield f"limbs too deep for float64 are mapped as if up to {found.stretch:.3g} times shorter"
