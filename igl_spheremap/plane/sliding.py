"""Search for maps to the unit disk: by doubling, and by steps in which the boundary slides along the circle."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from ..angles.plan import Large
from ..balance.energy import BalancedEnergy
from ..balance.family import balanced_energy, minimize_balanced
from ..balance.flat_faces import FlatFaces
from ..errors import FactorisationFailed, FoldingsRemain
from ..mesh.arrays import FloatArray
from ..mesh.disk import Disk
from ..newton.system import VertexSystem
from ..result.run import Listener, Run, Status
from ..sphere.rows import row_lengths
from ..verify.certificate import Certificate
from ..verify.distortion import mean_angle_difference
from .doubling import centred, double_map
from .plane_map import in_space, upright
from .problem import RADIUS, CircleProblem
from .tutte import by_harmonic_measure, by_lengths, evenly, tutte_map

#: Radians that an edge of the boundary may span: one of 30 degrees is 1.7 percent of the diameter inside the circle.
_STRAIGHT = np.radians(30)


def balanced_disk(
    disk: Disk, conformal: FloatArray, p: FloatArray, balance: float, listener: Listener
) -> tuple[FloatArray, Certificate, Run]:
    """The map of a balance from a map p without foldings, given the conformal one."""
    source, system = FlatFaces.of(disk.unit, disk.f), VertexSystem(disk.f, len(disk.v))
    energy = balanced_energy(source, RADIUS * conformal, balance)
    p, run = slide(disk, energy, p, listener, system)
    # At balance 1 steps with the weight .97 leave areas 7 percent off (median of 24 disks), these two 4 and 3 percent.
    # Spheres and flat maps do not need them, as no circle bends their boundary.
    for weight in (0.99, 0.997):
        if balance > energy.weight and run.status is not Status.STOPPED:
            p, run = min(
                ((p, run), slide(disk, replace(energy, weight=weight), p, listener, system)),
                key=lambda each: energy.area_error(RADIUS * each[0]),
            )
    return *presentable(disk, p), run


def straight_sides(disk: Disk, conformal: FloatArray, p: FloatArray) -> tuple[str, ...]:
    """A note if an edge of the boundary spans far more of the circle than in the conformal map."""
    rings = conformal[disk.rim], p[disk.rim]
    before, after = (
        2 * np.arcsin(np.minimum(row_lengths(np.roll(q, -1, axis=0) - q).max() / 2, 1))
        for q in rings
    )
    if after < max(_STRAIGHT, 2 * before):
        return ()
    return (
        f"one edge of the boundary spans {np.degrees(after):.0f} degrees of the circle, a straight side: where "
        "areas count nearly alone, faces beside it are stretched without end; at a balance of .95 it is round",
    )


def slide(
    disk: Disk, energy: BalancedEnergy, p: FloatArray, listener: Listener, system: VertexSystem
) -> tuple[FloatArray, Run]:
    """Minimise an energy from a map without foldings to the unit disk; the boundary slides along the circle."""
    last, status = minimize_balanced(
        partial(CircleProblem, disk=disk), system, energy, RADIUS * p, listener
    )
    return last.x / RADIUS, Run(status, last.energy, gauge="turned")


def conformal_disk(disk: Disk, listener: Listener) -> tuple[FloatArray, Run]:
    """A conformal map by doubling, else by sliding, else by a double that is embedded.

    It folds only if rounding folds every start.
    """
    large: Large = "laid out"
    if 2 * len(disk.rim) > len(disk.v):
        large = "left"  # layouts distort angles at the boundary
    if found := doubled(disk, listener, large):
        return found
    p, run = slid_map(disk, listener)
    if run.status is Status.STALLED and (found := doubled(disk, listener, "embedded")):
        return found
    if len(disk.f) > 1 and run.status is not Status.STALLED:
        note = "the doubled surface folds faces: the boundary was slid along the circle instead"
        run = replace(run, notes=(note,))
    return p, run


def doubled(disk: Disk, listener: Listener, large: Large) -> tuple[FloatArray, Run] | None:
    """The map by doubling, if it is free of foldings, or was stopped."""
    if len(disk.f) == 1:  # a triangle has no double
        return None
    try:
        p, double = double_map(disk, listener, large)
    except (FactorisationFailed, FoldingsRemain):
        return None
    # the second certificate is long where a folded double crowds its images
    if double.status is Status.STOPPED or (
        double.certificate.folding_free and Certificate.of_plane(p, disk.f, disk.rim).folding_free
    ):
        return p, Run(double.status, double.energy, backend=double.backend, notes=double.notes)
    return None


def slid_map(disk: Disk, listener: Listener, power: float = 0.5) -> tuple[FloatArray, Run]:
    """A conformal map by sliding alone: without foldings, unless rounding folds every start.

    The `power` is below that of balanced maps: slivers may spoil the angles of single faces. With .9 the mean angle
    differences of 53 disks whose doubles fold are 4 percent larger (benchmarks/tried.md has others).
    """
    source, system = FlatFaces.of(disk.unit, disk.f), VertexSystem(disk.f, len(disk.v))
    energy = BalancedEnergy(source, 0.0, power, np.zeros(len(disk.f)))
    found: list[tuple[FloatArray, Run]] = []
    for p in _starts(disk, found):
        if _is_free(disk, p):
            q, run = slide(disk, energy, p, listener, system)
            # Steps keep faces positive, but not the order of boundary vertices that all but coincide.
            free = [(x, run) for x in (q, p) if _is_free(disk, x)]
            if run.status is Status.STOPPED:
                return free[0]
            found += free
    if not found:
        return p, Run(Status.STALLED, float("nan"))
    return min(found, key=lambda each: mean_angle_difference(disk, in_space(each[0])))


def _is_free(disk: Disk, p: FloatArray) -> bool:
    """Whether a map is certified free of foldings in its returned form."""
    return presentable(disk, p)[1].folding_free


def _starts(disk: Disk, found: list[tuple[FloatArray, Run]]) -> Iterator[FloatArray]:
    """Tutte's maps: the boundary of a balanced conformal map; by its lengths; if both fold, evenly spread."""
    try:
        p = tutte_map(disk, by_harmonic_measure(disk))
    except FactorisationFailed:
        pass
    else:
        yield tutte_map(disk, centred(p, disk)[disk.rim])
    yield tutte_map(disk, by_lengths(disk))
    if not found:
        yield tutte_map(disk, evenly(disk))


def presentable(disk: Disk, p: FloatArray) -> tuple[FloatArray, Certificate]:
    """A map for return: balanced, upright, and its boundary on the circle; if that folds faces, the map as it is."""
    for q in (upright(centred(p, disk), disk), upright(p, disk)):
        q[disk.rim] /= np.hypot(q[disk.rim, 0], q[disk.rim, 1])[:, None]
        certificate = Certificate.of_plane(q, disk.f, disk.rim)
        if certificate.folding_free:
            return q, certificate
    return p, Certificate.of_plane(p, disk.f, disk.rim)
