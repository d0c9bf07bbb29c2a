"""Maps of disks to the unit disk: conformal, area-preserving, or between the two."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice

import numpy as np
from numpy.typing import ArrayLike

from ..balance.energy import BalancedEnergy
from ..balance.family import balanced_energy, minimize_balanced
from ..balance.flat_faces import FlatFaces
from ..errors import FactorisationFailed, FoldingsRemain, check_number, own_errstate
from ..mesh.arrays import FloatArray
from ..mesh.disk import Disk, check_disk
from ..mesh.objects import takes_mesh
from ..mesh.timings import stage, timed
from ..newton.loop import LineSearch, newton
from ..newton.system import VertexSystem
from ..result.plane_map import PlaneMap, in_space, upright
from ..result.run import History, Listener, Run, Status
from ..verify.certificate import Certificate
from ..verify.distortion import mean_angle_difference
from .doubling import centred, double_map
from .problem import RADIUS, CircleProblem, ConformalEnergy
from .tutte import by_harmonic_measure, by_lengths, evenly, tutte_map

#: Weights of the areas where only they are to count: .97, with which it begins, leaves them 7 percent off (median of
#: 24 disks), these 4 and 3: a circle bends what a sphere or a free boundary would not.
_EVEN_WEIGHTS = (0.99, 0.997)
#: Exponent k of the conformal energy: slivers may spoil the angles of single faces. With .9, as balanced maps have it,
#: the means of angle differences of 53 disks whose doubles fold are 4 percent larger.
_POWER = 0.5
#: The boundary slides far where it is jagged: after 5 steps the mean angle difference of two of 50 disks is still twice
#: as large as after 30, from which on none changes.
_HARMONIC_STEPS = 30


@dataclass(frozen=True, eq=False, repr=False)
class DiskMap(PlaneMap):
    """A map of a surface with one boundary loop to the unit disk; the boundary goes to the circle.

    Attributes
    ----------
    mesh : Disk
        The source, checked.
    plane : (n, 2) float64 array
        Images of the vertices, in the input's order; boundary vertices have length 1 to rounding.
    certificate : Certificate
        Of ``plane`` and ``faces``, in exact arithmetic.
    run : Run
        How the map came about.
    conformal : DiskMap, optional
        The conformal map that a balanced one started from.
    """

    conformal: DiskMap | None = None

    @own_errstate
    @timed()
    def rebalance(self, balance: float, *, listener: Listener | None = None) -> DiskMap:
        """Take the map to another balance, as a slider does.

        Parameters
        ----------
        balance : float
            0 gives the conformal map back, 1 is area-preserving.
        listener : callable, optional
            Called with every `Iterate`, whose rows have two coordinates; may raise StopIteration to stop with the
            current map.

        Returns
        -------
        DiskMap
            As from `disk_conformal_map`.

        Raises
        ------
        ValueError
            If `balance` is not in [0, 1].
        TypeError
            If it is no number.

        Examples
        --------
        >>> import numpy as np
        >>> import igl_spheremap as ism
        >>> v, f = ism.samples.make("spheroid", n_vertices=1000)
        >>> half = f[v[f, 2].mean(axis=1) > 0]
        >>> rows, half = np.unique(half, return_inverse=True)
        >>> disk = ism.disk_conformal_map(v[rows], half.reshape(-1, 3))
        >>> disk.rebalance(0.5).certificate.folding_free
        True
        """
        check_number(balance, "balance", most=1)
        history = History(listener)
        conformal, disk = self.conformal or self, self.mesh
        if balance == 0 or conformal.status is Status.STOPPED:
            return conformal
        source, system = FlatFaces.of(disk.v, disk.f), VertexSystem(disk.f, len(disk.v))
        energy = balanced_energy(source, RADIUS * conformal.plane, balance)
        p, run = slide(disk, energy, self.plane, history, system)
        for weight in _EVEN_WEIGHTS if balance > energy.weight else ():
            if run.status is not Status.STOPPED:
                p, run = min(((p, run), slide(disk, replace(energy, weight=weight), p, history, system)),
                             key=lambda each: energy.area_error(RADIUS * each[0]))
        p, certificate = _presentable(disk, p)
        own = history.complete(run, conformal.run.method, {"balance": float(balance)})
        run = replace(own, history=conformal.run.history + own.history, seconds=conformal.run.seconds + own.seconds)
        return DiskMap(disk, p, certificate, run, conformal)


@takes_mesh
@own_errstate
@timed()
def disk_conformal_map(
    v: ArrayLike, f: ArrayLike, balance: float = 0.0, *, listener: Listener | None = None
) -> DiskMap:
    """Map a surface with one boundary loop to the unit disk, conformally or with another balance, and certify the map.

    Two copies of the surface, joined along the boundary, are mapped to the sphere, and the map is made symmetric: the
    boundary is a great circle then. Where that folds faces, as it may on coarse meshes with slivers, the boundary
    slides along the circle instead, in Newton steps from Tutte's map with the boundary of a conformal map.

    Parameters
    ----------
    v : (n, 3) array_like
        Vertex positions, any units. Never mutated.
    f : (m, 3) array_like
        Faces as 0-based vertex indices: oriented, connected, one boundary loop, no handle.
    balance : float
        0 (the default) is conformal, 1 preserves areas.
    listener : callable, optional
        Called with every `Iterate`, those of the doubled surface first, those in the plane with rows of two
        coordinates; may raise StopIteration to stop with the current map.

    Returns
    -------
    DiskMap
        Its boundary runs counterclockwise along the unit circle. Of all conformal maps it is the one for which the
        doubled surface is balanced on the sphere, turned to agree best with two of the surface's coordinates.

    Raises
    ------
    MeshError
        If `v, f` is no such mesh.
    ValueError
        If `balance` is not in [0, 1].
    TypeError
        If it is no number.
    FoldingsRemain
        If rounding folds every start.

    References
    ----------
    The energy and its steps are in docs/balance.md; docs/disks.md compares the map with others.

    Examples
    --------
    >>> import numpy as np
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("spheroid", n_vertices=1000)
    >>> half = f[v[f, 2].mean(axis=1) > 0]
    >>> rows, half = np.unique(half, return_inverse=True)
    >>> disk = ism.disk_conformal_map(v[rows], half.reshape(-1, 3))
    >>> disk.certificate.folding_free, disk.plane.shape == (len(rows), 2)
    (True, True)
    >>> bool(abs(np.hypot(*disk.plane[disk.rim].T) - 1).max() < 1e-15)
    True
    """
    check_number(balance, "balance", most=1)
    history = History(listener)
    disk = check_disk(v, f)
    with stage("disk"):
        p, run = _conformal(disk, history)
        p, certificate = _presentable(disk, p)
    result = DiskMap(disk, p, certificate, history.complete(run, "disk"))
    if not certificate.folding_free and run.status is not Status.STOPPED:
        raise FoldingsRemain(f"no map to the disk without foldings was found: {certificate}; "
                             "remesh the surface where it is deepest", result)
    return result.rebalance(balance, listener=listener)


def slide(disk: Disk, energy: BalancedEnergy, p: FloatArray, listener: Listener,
          system: VertexSystem) -> tuple[FloatArray, Run]:
    """Minimise an energy from a map without foldings to the unit disk; the boundary slides along the circle."""
    minimum = minimize_balanced(partial(CircleProblem, disk=disk), system, energy, RADIUS * p, listener)
    return minimum.last.x / RADIUS, Run(minimum.status, minimum.last.energy, gauge="turned")


def _conformal(disk: Disk, listener: Listener) -> tuple[FloatArray, Run]:
    """A conformal map without foldings: by doubling, or else by sliding."""
    if len(disk.f) > 1:  # a triangle has no double
        try:
            p, double = double_map(disk, listener)
        except (FactorisationFailed, FoldingsRemain):
            pass
        else:
            if Certificate.of_plane(p, disk.f, disk.rim).folding_free or double.status is Status.STOPPED:
                return p, Run(double.status, double.energy, backend=double.backend, notes=double.notes)
    p, run = slid_map(disk, listener)
    note = "the doubled surface folds faces: the boundary was slid along the circle instead"
    return p, replace(run, notes=(note,) if len(disk.f) > 1 and run.status is not Status.STALLED else ())


def slid_map(disk: Disk, listener: Listener) -> tuple[FloatArray, Run]:
    """A conformal map without foldings by sliding alone, if rounding folds not every start."""
    source, system = FlatFaces.of(disk.v, disk.f), VertexSystem(disk.f, len(disk.v))
    energy = BalancedEnergy(source, 0.0, _POWER, np.zeros(len(disk.f)))
    found: list[tuple[FloatArray, Run]] = []
    for p in _starts(disk, found):
        if _is_free(disk, p):
            q, run = slide(disk, energy, p, listener, system)
            if run.status is Status.STOPPED:
                return (q if _is_free(disk, q) else p), run
            # Steps keep faces positive, but not the order of boundary vertices that all but coincide.
            found += [(x, run) for x in (p, q, _harmonic(disk, source, q, system)) if _is_free(disk, x)]
    if not found:
        return p, Run(Status.STALLED, float("nan"))
    return min(found, key=lambda each: mean_angle_difference(disk, in_space(each[0])))


def _is_free(disk: Disk, p: FloatArray) -> bool:
    """Whether a map is certified free of foldings, as it would be returned."""
    return _presentable(disk, p)[1].folding_free


def _harmonic(disk: Disk, source: FlatFaces, p: FloatArray, system: VertexSystem) -> FloatArray:
    """The map that a few steps of the quadratic energy lead to."""
    x = RADIUS * p
    steps = newton(CircleProblem(ConformalEnergy(source, x), disk), LineSearch(system), x)
    for trial in islice(steps, _HARMONIC_STEPS):
        x = trial.x
    return x / RADIUS


def _starts(disk: Disk, found: list[tuple[FloatArray, Run]]) -> Iterator[FloatArray]:
    """Tutte's maps: the boundary as a balanced conformal map has it, by its lengths; evenly spread if both fold."""
    try:
        p = tutte_map(disk, by_harmonic_measure(disk))
    except FactorisationFailed:
        pass
    else:
        yield tutte_map(disk, centred(p, disk)[disk.rim])
    yield tutte_map(disk, by_lengths(disk))
    if not found:
        yield tutte_map(disk, evenly(disk))


def _presentable(disk: Disk, p: FloatArray) -> tuple[FloatArray, Certificate]:
    """A map as it is returned: balanced, upright, and its boundary on the circle; unless that folds faces, as it is."""
    for q in (upright(centred(p, disk), disk), upright(p, disk)):
        q[disk.rim] /= np.hypot(q[disk.rim, 0], q[disk.rim, 1])[:, None]
        certificate = Certificate.of_plane(q, disk.f, disk.rim)
        if certificate.folding_free:
            return q, certificate
    return p, Certificate.of_plane(p, disk.f, disk.rim)
