"""Maps of disks to the unit disk: conformal, area-preserving, or between the two."""

from __future__ import annotations

from dataclasses import dataclass, replace

from numpy.typing import ArrayLike

from ..balance import ON_SPHERE
from ..errors import FoldingsRemain, check_number
from ..gate import takes_mesh
from ..mesh.arrays import FloatArray
from ..mesh.disk import Disk, check_disk
from ..result.run import History, Listener, Run, Status
from ..timings import phase, timed
from .plane_map import PlaneMap
from .sliding import balanced_disk, conformal_disk, doubled, presentable, straight_sides


@dataclass(frozen=True, eq=False, repr=False)
class DiskMap(PlaneMap):
    """A map of a surface with one boundary loop to the unit disk; the boundary goes to the circle.

    Attributes
    ----------
    mesh, certificate, run
        As of `PlaneMap`.
    plane : (n, 2) float64 array
        Images of the vertices, in the input's order; boundary vertices have length 1 to rounding.
    conformal : DiskMap, optional
        The conformal map that a balanced one started from.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> disk = ism.disk_conformal_map([[0, 0, 0], [1, 0, 0], [1, 1, 1], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    >>> disk.rim.tolist(), disk.certificate.folding_free
    ([0, 1, 2, 3], True)
    """

    conformal: DiskMap | None = None

    def _rebalanced(self, balance: float, listener: Listener | None) -> DiskMap:
        conformal = self._conformal_one()
        if balance == 0 or conformal.status is Status.STOPPED:
            return conformal
        history = History(listener, conformal.run)
        p, certificate, run = balanced_disk(
            self.mesh, conformal.plane, self.plane, balance, history
        )
        notes = (*conformal.notes, *straight_sides(self.mesh, conformal.plane, p))
        run = replace(run, backend=conformal.backend, notes=notes)
        return DiskMap(
            self.mesh,
            p,
            certificate,
            history.complete(run, conformal.method, {"balance": balance}),
            conformal,
        )


@takes_mesh
@timed()
def disk_conformal_map(
    v: ArrayLike, f: ArrayLike, *, caps: ArrayLike | None = None, listener: Listener | None = None
) -> DiskMap:
    """Map a surface with one boundary loop conformally to the unit disk, and certify the map.

    Two copies of the surface, joined along the boundary, are mapped to the sphere, and the map is made symmetric, so
    that the boundary is a great circle. If that folds faces, as on coarse meshes with slivers, the boundary slides
    along the circle instead, in Newton steps from Tutte's map with the boundary of a conformal map.

    Parameters
    ----------
    v : (n, 3) array_like
        Vertex positions, any units. Never mutated.
    f : (m, 3) array_like
        Faces as 0-based vertex indices: oriented, connected, one boundary loop, no handle.
    caps : (m,) array_like of bool, optional
        Faces that only fill holes, of a mesh that `repair_disk` made: they stay out of all figures. By default there
        are none.
    listener : callable, optional
        Called with every `Iterate`, those of the doubled surface first, those in the plane with rows of two
        coordinates; may raise StopIteration to stop with the current map.

    Returns
    -------
    DiskMap
        Its boundary runs counterclockwise along the unit circle. It balances the doubled surface on the sphere, and is
        turned to agree best with two of the surface's coordinates.

    Raises
    ------
    MeshError
        If `v, f` is not such a mesh.
    FoldingsRemain
        If rounding folds every start.

    See Also
    --------
    balanced_disk_map : gives limbs more room.
    flatten : leaves the boundary free.
    repair_disk : makes a mesh that this function takes.

    References
    ----------
    docs/disks.md compares the map with others.

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
    history = History(listener)
    return map_conformally(check_disk(v, f, caps=caps), history)


@takes_mesh
def balanced_disk_map(
    v: ArrayLike,
    f: ArrayLike,
    *,
    caps: ArrayLike | None = None,
    balance: float = ON_SPHERE,
    listener: Listener | None = None,
) -> DiskMap:
    """Map a surface with one boundary loop to the unit disk, between conformal and area-preserving.

    Parameters
    ----------
    v, f, caps, listener
        As of `disk_conformal_map`.
    balance : float
        0 is conformal, the map of `disk_conformal_map` bit for bit; 1 preserves areas; .85 by default.

    Returns
    -------
    DiskMap
        Its boundary runs counterclockwise along the unit circle; if one edge is a long straight side, a note says so.
        Its ``conformal`` is the map that it started from.

    Raises
    ------
    MeshError
        If `v, f` is not such a mesh.
    ValueError
        If `balance` is not in [0, 1].
    TypeError
        If it is not a number.
    FoldingsRemain
        If rounding folds every start of the conformal map.

    References
    ----------
    The energy and its steps are in docs/balance.md; docs/disks.md compares the map with others.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("spheroid", n_vertices=1000)
    >>> half = ism.repair_disk(v, f[v[f, 2].mean(axis=1) > 0])
    >>> disk = ism.balanced_disk_map(half, balance=1)
    >>> disk.certificate.folding_free, bool(abs(disk.log_area_ratios()).mean() < 0.05)
    (True, True)
    """
    check_number(balance, "balance", most=1)
    return disk_conformal_map(v, f, caps=caps, listener=listener).rebalance(
        balance, listener=listener
    )


def map_conformally(disk: Disk, history: History) -> DiskMap:
    """The map of `disk_conformal_map`, of a mesh that is checked."""
    with phase("disk"):
        result = _presented(disk, history, conformal_disk(disk, history))
    if not result.certificate.folding_free and result.status is not Status.STOPPED:
        raise FoldingsRemain(
            f"no map to the disk without foldings was found: {result.certificate}; "
            "remesh the surface where it is deepest",
            result,
        )
    return result


def map_doubled(disk: Disk, history: History) -> DiskMap | None:
    """That map if doubling alone finds it, at a small part of the cost; None if the double folds."""
    with phase("disk"):
        found = doubled(disk, history, "left")
        if found is None:
            return None
        return _presented(disk, history, found)


def _presented(disk: Disk, history: History, found: tuple[FloatArray, Run]) -> DiskMap:
    p, run = found
    p, certificate = presentable(disk, p)
    return DiskMap(disk, p, certificate, history.complete(run, "disk"))
