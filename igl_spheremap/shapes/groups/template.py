"""The template of a group of surfaces: the mean to which all are registered; no single member decides it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import count

import numpy as np
from numpy.typing import ArrayLike

from ...balance import AREA_PRESERVING
from ...errors import MeshError, check_list, check_number, check_whole, one_line
from ...gate import PathLike, gate
from ...io.npz import read_arrays, save_arrays
from ...io.written_map import read_map
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import ROUNDING, FloatArray, IntArray
from ...mesh.check import check_mesh
from ...populations.engine import USUAL, Engine
from ...resampling.transfer import sphere_mesh
from ...sphere.moebius import best_rotation, orientation_target
from .doubts import copy_doubts, group_doubts, member_doubts, symmetric
from .features import check_features
from .fixed_point import FixedPoint, Register, Registered, fixed_point
from .group import Group, Member
from .member_files import Entry, MemberFiles, member_files, stacked
from .modes import principal_modes
from .procrustes import generalised_procrustes
from .sampling import SurfaceLike, names_of
from .turns import Restarts


@gate
def template(
    sources: Iterable[SurfaceLike],
    *,
    features: Sequence[ArrayLike] | None = None,
    modes: int = 10,
    target: str = "ico:4",
    balance: float = AREA_PRESERVING,
    rigid: bool = False,
    out: PathLike | None = None,
    engine: Engine = USUAL,
) -> Group:
    """Make the unbiased template of surfaces: their mean, its modes, and each member in correspondence with it.

    Each surface is mapped to the sphere and registered to a first template. The members' corresponding points are
    aligned by generalised Procrustes, and their mean is mapped to the sphere as each member is: that is the next
    template. The rounds end when the mean no longer moves. The same members give the same group bit for bit, in any
    order.

    Parameters
    ----------
    sources : iterable of path-like, SphereMap or mesh objects
        The surfaces, three or more; maps are taken as they are, and files and meshes are mapped.
    features : sequence of (n,) or (n, k) array_like, optional
        Data over the vertices of each source, whose mean and standard deviation are taken at corresponding points.
    modes : int, default 10
        Number of principal modes to keep; at most members less 1.
    target : str, default ``ico:4``
        The mesh of the mean surface, on which members are registered: ``ico:4`` has 2,562 vertices, ``ico:5``, which
        cortices need, 10,242.
    balance : float, default 1
        Of the maps: 0 is conformal, 1 preserves areas and is for bodies with limbs; .85 is better for cortices.
    rigid : bool, default False
        Remove place and pose of the members, but keep their sizes.
    out : path-like, optional
        A folder for results: the members' maps in its folder ``members``, intermediate results in ``work``, and a
        manifest, from which another call continues. Without it a temporary folder is used, and the members hold their
        maps.
    engine : Engine
        As of `igl_spheremap.map_many`. Workers on other machines need to see `out`.

    Returns
    -------
    Group
        The mean surface, modes and scores, and the members with their registered maps. Sources that could not be read,
        mapped or registered are in its ``left_out``. With `out`, its members hold no maps.

    Raises
    ------
    MeshError
        If there are fewer than three surfaces, or fewer than three members are left.
    ValueError
        If there is no such icosphere, or an option is out of range.

    References
    ----------
    Gower 1975, *Generalized Procrustes Analysis*.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("pear", n_vertices=100)
    >>> ism.shapes.template([(v * [1.3 + 0.1 * k, 1, 1], f) for k in range(3)], target="ico:2", modes=2)
    Group(3 members, 162 vertices, 2 modes with 100% of the variance)
    """
    check_whole(modes, "modes", 1)
    check_number(balance, "balance", most=1)
    mesh = sphere_mesh(target)
    sources = check_list(sources, "sources")
    fewest = 3  # two have one mode and no median
    if len(sources) < fewest:
        raise MeshError(f"a group needs {fewest} surfaces or more, not {len(sources)}")
    check_features(features, names_of(sources))
    with member_files(out, "members", target, engine, least=fewest) as files:
        members = files.mapped(sources, features, balance)
        # Sums are taken in the order of contents: so no bit depends on the sources' order.
        points = {member: read_arrays(files.of(member, "points")) for member in members}
        members.sort(key=lambda member: points[member]["digest"].tobytes())
        copies = copy_doubts(
            [member.name for member in members],
            [points[member]["digest"].tobytes() for member in members],
        )
        # Powers of harmonics compare shapes: neither pose nor mirroring changes them.
        powers = np.stack([points[member]["powers"] for member in members])
        medoid = int(np.argmin(np.linalg.norm(powers - powers.mean(axis=0), axis=1)))
        fixed = fixed_point(
            _registering(files),
            members,
            points[members[medoid]]["points"],
            *mesh,
            balance=balance,
            rigid=rigid,
        )
        group = _group(files, fixed, mesh, modes, rigid, keep=out is None)
        return replace(group, balance=balance, notes=(*copies, *group.notes))


def _registering(files: MemberFiles) -> Register:
    """Register members to a template, from their positions in the round before; each call is a round."""
    rounds = count(1)

    def registered(
        members: Sequence[Entry], target: SphereMap, restarts: Sequence[Restarts]
    ) -> Registered:
        folder = f"rounds/{next(rounds)}"
        template = files.path("work", folder, "template.npz")
        save_arrays(template, {"points": target.vertices, "sphere": target.sphere})
        found = files.registered(folder, members, [template] * len(members), restarts)
        points, areas, turned = stacked(
            [member.sphere for member in found], "points", "areas", "turned"
        )
        return Registered(found, points, (areas / len(found)).sum(axis=0), int(turned.sum()))

    return registered


def _group(
    files: MemberFiles,
    fixed: FixedPoint,
    mesh: tuple[FloatArray, IntArray],
    modes: int,
    rigid: bool,
    keep: bool,
) -> Group:
    """The group: each registration is carried to the member's own mesh, and sampled there; it may keep the maps."""
    x, f = mesh
    mean = check_mesh(fixed.mean, f)
    turn = best_rotation(x, orientation_target(mean), mean.A)
    members, (points, own, features) = files.carried(
        fixed.members, [R.T @ turn for R in fixed.turns]
    )
    areas = (own / len(members)).sum(axis=0)
    aligned = generalised_procrustes(points, areas, rigid)
    away = aligned.shapes - aligned.mean
    if np.abs(away).max() <= ROUNDING * np.ptp(aligned.mean, axis=0).max():
        raise MeshError("the surfaces are all the same: nothing differs that a group could show")
    found = principal_modes(away, areas, modes)
    (correlations,) = stacked([member.sphere for member in members], "correlation")
    registrations = [files.last_search(member) for member in members]
    alike, rows = symmetric(registrations), []
    columns = np.column_stack((correlations, aligned.sizes, aligned.distances))
    for member, each, (correlation, size, distance) in zip(
        members, registrations, columns.tolist(), strict=True
    ):
        onto = None
        if keep:
            onto = read_map(files.result(member))
        said = member_doubts(each, distance, aligned.distances, correlations, alike)
        rows.append(Member(member.name, onto, correlation, size, distance, said))
    axis = None
    if fixed.axis is not None:
        heights = x @ fixed.axis
        axis = fixed.mean[heights.argmax()] - fixed.mean[heights.argmin()]
    order = np.argsort([member.number for member in members])  # as the sources came
    return Group(
        aligned.mean, f, x, aligned.shapes[order], found.modes, found.variances, found.scores[order],
        tuple(rows[k] for k in order), areas, np.sqrt((away**2).sum(axis=(0, 2)) / (len(members) - 1)),
        features[order], {name: one_line(error) for name, error in files.left_out.items()}, fixed.changes, rigid,
        notes=tuple(group_doubts(fixed.changes, fixed.settled, axis, registrations, found.scores)),
    )  # fmt: skip
