"""Flat maps: disks laid out in the plane with a free boundary that crosses itself nowhere."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from ..balance import IN_PLANE
from ..balance.energy import BalancedEnergy
from ..balance.family import MOST_WEIGHT, POWER, minimize_balanced
from ..balance.flat_faces import FlatFaces
from ..errors import check_number
from ..gate import takes_mesh
from ..mesh.arrays import FloatArray, own_unit
from ..mesh.disk import Disk, check_disk
from ..mesh.measure import surface_area
from ..newton.system import VertexSystem
from ..result.findings import as_factor
from ..result.run import History, Iterate, Listener, Run, Stage, Status
from ..sphere.rows import weighted_sum
from ..timings import phase, timed
from ..verify.certificate import Certificate
from .disk_map import DiskMap, map_conformally, map_doubled
from .plane_map import PlaneMap, upright
from .problem import RADIUS, FreeProblem
from .tutte import by_lengths, tutte_map
from .unrolling import FLAT, stretch, unrolled

#: Origin of an isometry: its energy is the least of all layouts.
_UNROLLED = Run(Status.CONVERGED, 0.0, gauge="turned")


@dataclass(frozen=True, eq=False, repr=False)
class FlatMap(PlaneMap):
    """A surface with one boundary loop laid out in the plane; its boundary is free, and crosses itself nowhere.

    Attributes
    ----------
    mesh, certificate, run
        As of `PlaneMap`.
    plane : (n, 2) float64 array
        Images of the vertices, in the input's order and units: the image has the area of the source.
    conformal : DiskMap, optional
        A possible start, the map to the disk; none if it was unrolled, or if doubling folds faces.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> ism.flatten([[0, 0, 0], [1, 0, 0], [1, 1, 1], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]]).plane.shape
    (4, 2)
    """

    conformal: DiskMap | None = None

    def _rebalanced(self, balance: float, listener: Listener | None) -> FlatMap:
        """That of `flatten`, bit for bit: it starts from the same disk."""
        history = History(listener)
        if self.conformal is not None:
            history = History(listener, self.conformal.run)
        return _flattened(self.mesh, balance, history, self.conformal)


@takes_mesh
@timed()
def flatten(
    v: ArrayLike,
    f: ArrayLike,
    *,
    caps: ArrayLike | None = None,
    balance: float = IN_PLANE,
    listener: Listener | None = None,
) -> FlatMap:
    """Lay a surface with one boundary loop out in the plane with least distortion, and certify the map.

    A surface that can be unrolled is laid out face by face, whatever `balance` is: lengths are kept to 1e-6, those of
    flat surfaces to 1e-9. On any other, or if that layout overlaps itself, Newton steps minimise nearly the sum over
    faces of squared logarithms of stretches; changes of areas have the weight `balance`, changes of angles 1 -
    `balance`. They start from Tutte's map whose boundary keeps its lengths, or from the conformal disk if doubling
    finds one, whichever has the lower sum. No step folds a face or lets the boundary cross itself, which exact
    arithmetic decides, so the map is injective. If a layout would overlap, a note says where. If lengths are off by a
    factor of 10 or more, and `balance` is not 0, the status is ``SHORT``, and a note names the factor.

    Parameters
    ----------
    v, f, caps, listener
        As of `disk_conformal_map`.
    balance : float
        0 is conformal, 1 preserves areas; at .7, the default, lengths are off least.

    Returns
    -------
    FlatMap
        In the input's units, its area that of the surface, centred, turned to agree best with two of the surface's
        coordinates.

    Raises
    ------
    MeshError, ValueError, TypeError, FoldingsRemain
        As of `balanced_disk_map`.

    See Also
    --------
    disk_conformal_map : to the unit disk.
    repair_disk : makes a mesh that this function takes.

    References
    ----------
    docs/balance.md has the energy and its steps, docs/disks.md compares the map with others.

    Examples
    --------
    >>> import numpy as np
    >>> import igl_spheremap as ism
    >>> turn, height = np.meshgrid(np.linspace(0, 3, 13), np.linspace(0, 1, 5))
    >>> v = np.column_stack((np.cos(turn.ravel()), np.sin(turn.ravel()), height.ravel()))
    >>> i = np.arange(65).reshape(5, 13)
    >>> a, b, c, d = (corner.ravel() for corner in (i[:-1, :-1], i[:-1, 1:], i[1:, 1:], i[1:, :-1]))
    >>> flat = ism.flatten(v, np.vstack((np.column_stack((a, b, c)), np.column_stack((a, c, d)))))
    >>> flat.certificate.folding_free, bool(abs(flat.log_length_ratios()).max() < 1e-6)
    (True, True)
    """
    check_number(balance, "balance", most=1)
    return _flattened(check_disk(v, f, caps=caps), float(balance), History(listener))


def _flattened(
    disk: Disk, balance: float, history: History, start: DiskMap | None = None
) -> FlatMap:
    """The layout of a balance, from a present map to the disk, if any."""
    settings = {"balance": balance}
    with phase("unroll"):
        isometry = unrolled(disk)
        if isometry is not None:
            q = np.ldexp(
                _turned(disk, isometry - weighted_sum(disk.A, isometry)), own_unit(disk.v)[1]
            )
            certificate = Certificate.of_plane(q, disk.f, disk.rim)
            if certificate.folding_free:
                with suppress(StopIteration):
                    history(Iterate(Stage.UNROLLED, 0, 0, q, 0.0))
                return FlatMap(
                    disk, q, certificate, history.complete(_UNROLLED, "flatten", settings)
                )
    tutte, starts = tutte_map(disk, by_lengths(disk)), []
    solve: Callable[[Disk, History], DiskMap | None] = map_conformally
    if Certificate.of_plane(tutte, disk.f, disk.rim).folding_free:
        # Sliding is dear, and finds no better start than Tutte's map.
        starts, solve = [tutte], map_doubled
    if start is None:
        start = solve(disk, History(history))
    if start is not None:
        starts.append(start.plane)
    if start is not None and start.status is Status.STOPPED:
        p, run = start.plane, start.run
    else:
        with phase("flatten"):
            p, run = _spread(disk, starts, balance, history)
    q, certificate = _placed(disk, p)
    if isometry is not None:
        run = replace(
            run,
            notes=(
                *run.notes,
                "the surface can be unrolled, but overlaps itself then: lengths are "
                "distorted instead",
            ),
        )
    if balance > 0 and run.status is not Status.STOPPED:
        run = _judged(PlaneMap(disk, q, certificate, run))
    return FlatMap(disk, q, certificate, history.complete(run, "flatten", settings), start)


def _spread(
    disk: Disk, starts: list[FloatArray], balance: float, listener: Listener
) -> tuple[FloatArray, Run]:
    """Minimise the energy of a balance over maps with a free boundary, from the best of some disks.

    On a long, thin or bent surface lengths of the conformal disk differ by unbounded factors; Tutte's map has those of
    the boundary.
    """
    source = FlatFaces.of(disk.unit, disk.f)
    energy = BalancedEnergy(source, min(balance, MOST_WEIGHT), POWER, np.zeros(len(disk.f)))
    p = min(starts, key=lambda p: energy.by_face(RADIUS * p).sum())
    last, status = minimize_balanced(
        partial(FreeProblem, disk=disk),
        VertexSystem(disk.f, len(disk.v)),
        energy,
        RADIUS * p,
        listener,
    )
    return last.x, Run(status, last.energy, gauge="turned")


def _turned(disk: Disk, p: FloatArray) -> FloatArray:
    """An isometry turned upright, unless rounding then changes lengths, as across a thin strip."""
    q = upright(p, disk)
    # Half, so that the turned map counts as flat even after it is moved and scaled.
    return min((q, p), key=lambda each: max(stretch(disk, each), FLAT / 2))


def _placed(disk: Disk, p: FloatArray) -> tuple[FloatArray, Certificate]:
    """A layout in its units, centred and upright, and its certificate."""
    # A limb too deep for float64 elsewhere has its tip at the origin.
    for middle in (weighted_sum(disk.A, p), np.zeros(2)):
        q = _in_units(disk, p - middle)
        certificate = Certificate.of_plane(q, disk.f, disk.rim)
        if certificate.folding_free:
            break
    return q, certificate


def _judged(found: PlaneMap) -> Run:
    """The record of a layout's run, which says if lengths are far off: by a factor of ten the map has failed."""
    worst = float(np.abs(found.log_length_ratios()).max())
    if worst < np.log(10):
        return found.run
    note = f"lengths are off by a factor of up to {as_factor(worst)}; {found.status.value}"
    return replace(found.run, status=Status.SHORT, notes=(*found.notes, note))


def _in_units(disk: Disk, p: FloatArray) -> FloatArray:
    """A layout turned upright, with the area of the surface in its own units, if it has any."""
    q = p[disk.rim]
    # inside the boundary
    image = (q[:, 0] * np.roll(q[:, 1], -1) - q[:, 1] * np.roll(q[:, 0], -1)).sum() / 2
    source = surface_area(disk.unit, disk.f)
    size = np.ptp(disk.v, axis=0).max() / np.ptp(disk.unit, axis=0).max()
    if source > 0:
        size *= np.sqrt(source / image)
    return np.asarray(upright(p, disk) * size)
