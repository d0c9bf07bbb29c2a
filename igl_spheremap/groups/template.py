"""The template of a group of surfaces: the mean to which all its members are registered, and which no one decides."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from hashlib import sha256
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..correspondence.registration import Registration, register
from ..errors import MeshError, check_number, check_whole, one_line, own_errstate
from ..maps.balanced import balanced_spherical_map
from ..maps.given_sphere import certified
from ..maps.sphere_map import SphereMap
from ..mesh.arrays import FloatArray, IntArray, check_values
from ..mesh.check import check_mesh
from ..mesh.measure import vertex_areas
from ..mesh.timings import counted
from ..shapes.basis import power
from ..shapes.harmonics import spherical_harmonics
from ..shapes.transfer import resample, sphere_mesh, transfer
from ..sphere.moebius import best_rotation, orientation_target
from ..sphere.rows import weighted_sum
from ..untangle.local_repair import unfolded
from . import FARTHEST
from .crew import Crew
from .group import Group, Member
from .modes import principal_modes
from .placing import Source, areas_of, at_points, carried, mapped
from .procrustes import generalised_procrustes, placed

#: Of the mean's moves, over its root mean square radius: on 2,562 points its faces are as far from the body.
_TOLERANCE = 5e-3
_ROUNDS = 6  # at most: 3 to 5 are usual
_FEWEST = 3  # members: two have one mode and no median
_DEGREE = 8  # of the harmonics whose powers distinguish the members


@own_errstate
def template(
    sources: Sequence[Source],
    *,
    features: Sequence[ArrayLike] | None = None,
    modes: int = 10,
    target: str = "ico:4",
    balance: float = 1.0,
    rigid: bool = False,
    farthest: float = FARTHEST,
    processes: int = 1,
) -> Group:
    """Make the unbiased template of surfaces: their mean, its modes, and each member in correspondence with it.

    Each surface is mapped to the sphere and registered to a first template. The members' corresponding points are
    aligned by generalised Procrustes, and their mean is mapped to the sphere as each member is: that is the next
    template. It ends where the mean stays. The same members give the same group bit for bit, in any order.

    Parameters
    ----------
    sources : sequence of path-like, SphereMap or mesh objects
        The surfaces, three or more; maps are taken as they are, and files and meshes are mapped.
    features : sequence of (n,) or (n, k) array_like, optional
        Data over the vertices of each source, whose mean and standard deviation are taken at corresponding points.
    modes : int, default 10
        How many principal modes to keep; members less 1 at most.
    target : str, default ``ico:4``
        The mesh of the mean surface, on which members are registered: ``ico:4`` has 2,562 vertices, ``ico:5``, which
        cortices need, 10,242.
    balance : float, default 1
        Of the maps: 0 is conformal, 1 preserves areas and is for bodies with limbs; .85 is better for cortices.
    rigid : bool, default False
        Take place and pose of the members away, but keep their sizes.
    farthest : float, default 6
        Members are left out whose distance from the mean is larger than this many times the median of all.

    Returns
    -------
    Group
        The mean surface, modes and scores, and the members with their registered maps. What could not be read, mapped
        or registered, or lies too far off, is in its ``left_out``.

    Raises
    ------
    MeshError
        If fewer than three members are left.
    ValueError
        If there is no such icosphere, or an option is out of range.

    References
    ----------
    Gower 1975, *Generalized Procrustes Analysis*.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("pear", n_vertices=100)
    >>> ism.template([(v * [1.3 + 0.1 * k, 1, 1], f) for k in range(3)], target="ico:2", modes=2)
    Group(3 members, 162 vertices, 2 modes with 100% of the variance)
    """
    check_whole(modes, "modes", 1)
    check_number(balance, "balance", most=1)
    check_number(farthest, "farthest", 1)
    check_whole(processes, "processes", 1)
    x, f = sphere_mesh(target)
    if features is not None and len(features) != len(sources):
        raise ValueError(f"features are of {len(features)} surfaces, sources are {len(sources)}; give one for each")
    left_out: dict[str, str] = {}
    found: list[_Surface] = []
    names = [os.fspath(source) if isinstance(source, str | os.PathLike) else str(k)
             for k, source in enumerate(sources)]
    with Crew(processes) as crew:
        jobs = [(k, name, source, x, f, balance, None if features is None else features[k])
                for k, (name, source) in enumerate(zip(names, sources, strict=True))]
        for name, surface in zip(names, crew.each("maps", _surface, jobs), strict=True):
            if isinstance(surface, Exception):
                left_out[name] = one_line(surface)
            else:
                found.append(surface)
        found.sort(key=lambda surface: surface.digest)
        return _without_outliers(found, crew, x, f, balance, rigid, modes, farthest, left_out)


def _without_outliers(found: list[_Surface], crew: Crew, x: FloatArray, f: IntArray, balance: float, rigid: bool,
                       modes: int, farthest: float, left_out: dict[str, str]) -> Group:
    """The group of those that lie near enough to each other's mean."""
    changes: list[float] = []
    while True:
        fitted, turn = _fixed_point(found, crew, x, f, balance, rigid, changes, left_out)
        group = _joined(fitted, turn, x, f, balance, rigid, modes, changes, left_out)
        distances = np.array([member.distance for member in group.members])
        usual = float(np.median(distances))
        far = {member.name: f"it lies {member.distance / usual:.1f} times as far from the mean as half of the members: "
                            "look at it, or raise farthest" for member in group.members
               if member.distance > farthest * usual}
        if not far:
            return group
        left_out |= far
        found = [surface for surface in found if surface.name not in left_out]


@dataclass(frozen=True, eq=False)
class _Surface:
    """A source: its map, and the same surface on the group's icosphere, which is registered in its place."""

    number: int
    name: str
    map: SphereMap
    coarse: SphereMap
    features: FloatArray
    powers: FloatArray
    digest: bytes


def _surface(number: int, name: str, source: Source, x: FloatArray, f: IntArray, balance: float,
             features: ArrayLike | None) -> _Surface:
    """Read and map a source."""
    result = mapped(source, balance)
    values = np.empty((len(result.sphere), 0)) if features is None else check_values(
        features, len(result.sphere), f"features of source {name}")
    coarse = at_points(result, x, f)
    powers = np.sqrt(power(spherical_harmonics(coarse, degree=_DEGREE).coefficients)[1:])
    digest = sha256(b"".join(array.tobytes() for array in (result.vertices, result.faces, result.sphere, values)))
    return _Surface(number, name, result, coarse, values, powers / np.linalg.norm(powers), digest.digest())


class _Fitted(NamedTuple):
    """A surface, how its sphere was turned, and its registration from there."""

    surface: _Surface
    turn: FloatArray
    registration: Registration


def _fixed_point(found: list[_Surface], crew: Crew, x: FloatArray, f: IntArray, balance: float, rigid: bool,
             changes: list[float], left_out: dict[str, str]) -> tuple[list[_Fitted], FloatArray]:
    """Registrations to a template that is the mean of what is registered to it, and how its sphere is to be turned.

    All have turned with the start so far; at the end they turn to the Gauss map of the mean.
    """
    target, stages = _medoid(found).coarse, ["rotation", "elastic"]
    before = target.vertices
    turns = {surface.number: np.eye(3) for surface in found}
    for step in range(_ROUNDS):
        fitted: list[_Fitted] = []
        jobs = [(surface.coarse, turns[surface.number], target, stages) for surface in found]
        for surface, registration in zip(found, crew.each("registrations", _registered, jobs), strict=True):
            if isinstance(registration, Exception):
                left_out[surface.name] = f"it could not be registered: {one_line(registration)}"
            else:
                fitted.append(_Fitted(surface, turns[surface.number], registration))
        found = _enough([each.surface for each in fitted], left_out)
        shapes = np.stack([resample(each.registration.map, (x, f)).v for each in fitted])
        areas = np.mean([vertex_areas(shape, f) for shape in shapes], axis=0)
        mean = generalised_procrustes(shapes, areas, rigid).mean
        moved = placed(before, mean, areas)[0] - mean
        offset = mean - weighted_sum(areas / areas.sum(), mean)
        changes.append(float(np.sqrt((areas @ moved**2).sum() / (areas @ offset**2).sum())))
        if changes[-1] < _TOLERANCE or step == _ROUNDS - 1:
            break
        before, target = mean, balanced_spherical_map(mean, f, balance=balance)
        as_before = best_rotation(target.sphere, x, areas)
        target = certified(target.mesh, unfolded(target.mesh, target.sphere @ as_before))
        turns = {each.surface.number: each.turn @ each.registration.rotation.T for each in fitted}
        stages = ["elastic"]
    mesh = check_mesh(mean, f)
    return fitted, best_rotation(x, orientation_target(mesh), mesh.A)


def _registered(coarse: SphereMap, turn: FloatArray, target: SphereMap, stages: list[str]) -> Registration:
    """A surface registered to the template, its sphere turned first."""
    turned = certified(coarse.mesh, unfolded(coarse.mesh, coarse.sphere @ turn))
    return register(turned, target, stages=stages)


def _medoid(found: list[_Surface]) -> _Surface:
    """Whose harmonics' powers, which neither pose nor mirroring changes, are nearest to the mean of all: the start."""
    mean = np.mean([surface.powers for surface in found], axis=0)
    return found[int(np.argmin([np.linalg.norm(surface.powers - mean) for surface in found]))]


def _enough(found: list[_Surface], left_out: dict[str, str]) -> list[_Surface]:
    if len(found) < _FEWEST:
        reason = "".join(f"; {name}: {why}" for name, why in list(left_out.items())[:1])
        raise MeshError(f"{len(found)} of {len(found) + len(left_out)} members are left, and a group needs {_FEWEST}"
                        f"{reason}")
    return found


def _joined(fitted: list[_Fitted], turn: FloatArray, x: FloatArray, f: IntArray, balance: float, rigid: bool,
            modes: int, changes: list[float], left_out: dict[str, str]) -> Group:
    """The group of registered surfaces: each is carried on its own mesh, and sampled there."""
    maps = [carried(each.surface.map, each.surface.coarse, each.registration.map.sphere @ turn)
            for each in counted("members", fitted)]
    shapes = np.stack([resample(each, (x, f)).v for each in maps])
    areas = np.mean([areas_of(each, x, f) for each in maps], axis=0)
    features = np.stack([transfer(each, fit.surface.features, (x, f))
                         for each, fit in zip(maps, fitted, strict=True)])
    aligned = generalised_procrustes(shapes, areas, rigid)
    away = aligned.aligned - aligned.mean
    found = principal_modes(away, areas, modes)
    distances = np.sqrt(np.einsum("n,knd->k", areas / areas.sum(), away**2))
    members = [Member(fit.surface.name, each, float(fit.registration.stages[-1].correlation.mean()), float(size),
                      float(distance))
               for each, fit, size, distance in zip(maps, fitted, aligned.sizes, distances, strict=True)]
    order = np.argsort([fit.surface.number for fit in fitted])  # as the sources came
    several = len(members) - 1
    return Group(
        aligned.mean, f, x, aligned.aligned[order], found.modes, found.variances, found.scores[order],
        tuple(members[k] for k in order), areas, np.sqrt((away**2).sum(axis=(0, 2)) / several),
        features.mean(axis=0), features.std(axis=0, ddof=1), dict(left_out), tuple(changes), rigid, balance,
    )  # fmt: skip

