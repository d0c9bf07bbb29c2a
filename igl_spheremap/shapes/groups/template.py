"""The template of a group of surfaces: the mean to which all its members are registered, and which no one decides."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...errors import MeshError, check_list, check_number, check_whole, one_line, own_errstate, without_name
from ...io import npz
from ...io.npz import read_arrays
from ...io.replacing import make_folder, replacing
from ...io.written_map import read_map
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.check import check_mesh
from ...mesh.objects import vertices_and_faces
from ...mesh.timings import log_share
from ...populations.executors import executor_of
from ...populations.run_many import check_engine, run_many
from ...populations.table import MAPPED, JobRow
from ...resampling.transfer import sphere_mesh
from ...sphere.moebius import best_rotation, orientation_target
from . import FARTHEST
from .doubts import group_doubts, member_doubts, symmetric
from .features import FeatureFiles, check_features
from .files import file_names
from .fixed_point import FixedPoint, Registered, distances, fixed_point
from .group import Group, Member
from .jobs import MapJob, MapMember, MemberJob, MemberTask, PlaceMember, RegisterMember, columns_of, write_arrays
from .laying import Laid
from .modes import principal_modes
from .placing import Source, names_of
from .procrustes import blocks, generalised_procrustes

#: The manifest in a group's folder.
MANIFEST = "manifest.jsonl"
_FEWEST = 3  # members: two have one mode and no median


@own_errstate
def template(
    sources: Iterable[Source],
    *,
    features: Sequence[ArrayLike] | None = None,
    modes: int = 10,
    target: str = "ico:4",
    balance: float = 1.0,
    rigid: bool = False,
    farthest: float = FARTHEST,
    out: str | os.PathLike[str] | None = None,
    executor: Executor | None = None,
    processes: int | None = None,
    resume: bool = True,
    retry_failed: bool = False,
    timeout: float | None = None,
    memory: float | None = None,
    retries: int = 1,
) -> Group:
    """Make the unbiased template of surfaces: their mean, its modes, and each member in correspondence with it.

    Each surface is mapped to the sphere and registered to a first template. The members' corresponding points are
    aligned by generalised Procrustes, and their mean is mapped to the sphere as each member is: that is the next
    template. It ends where the mean stays. The same members give the same group bit for bit, in any order.

    Parameters
    ----------
    sources : iterable of path-like, SphereMap or mesh objects
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
    out : path-like, optional
        A folder for what the work leaves: the members' maps in its folder ``members``, what is between in ``work``,
        and a manifest, by which another call continues where this one ended. Without it a temporary folder is used,
        and the members hold their maps.
    executor, processes, resume, retry_failed, timeout, memory, retries
        As of `igl_spheremap.map_many`. Workers on other machines need to see `out`.

    Returns
    -------
    Group
        The mean surface, modes and scores, and the members with their registered maps. What could not be read, mapped
        or registered, or lies too far off, is in its ``left_out``. With `out`, its members hold no maps, and its shapes
        are read from a file there as they are used.

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
    check_number(farthest, "farthest", 1)
    check_engine(executor, processes, timeout, memory, retries)
    mesh = sphere_mesh(target)
    sources = check_list(sources, "sources")
    if len(sources) < _FEWEST:
        raise MeshError(f"a group needs {_FEWEST} surfaces or more, not {len(sources)}")
    check_features(features, names_of(sources))
    with ExitStack() as stack:
        place = stack.enter_context(TemporaryDirectory()) if out is None else os.fspath(out)
        crew = stack.enter_context(executor_of(executor, processes))
        run = partial(run_many, manifest=os.path.join(place, MANIFEST), executor=crew, resume=resume,
                      retry_failed=retry_failed, timeout=timeout, memory=memory, retries=retries)
        people = _People(_Files(Path(place)), _Crew(run, target), mesh)
        first = people.mapped(sources, features, balance)
        fixed = fixed_point(people.registered, people.members, first, *mesh, balance=balance, rigid=rigid,
                            farthest=farthest)
        return people.group(fixed, modes, balance=balance, rigid=rigid, keep=out is None)


@dataclass
class _Member:
    """A member in files: its number among the sources, its name, and that of its files."""

    number: int
    name: str
    short: str
    sphere: str = ""  # the file of its last registration
    search: str = ""  # that of the last one for which other rotations were tried


class _Files:
    """Where the files of a group in the making lie; their folders are made as they are asked for."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def place(self, *parts: str) -> str:
        """The place of a file by its folders and its name."""
        path = self._folder.joinpath(*parts)
        make_folder(path.parent)
        return str(path)

    def map(self, member: _Member) -> str:
        """The member's map, and its features."""
        return self.place("work", "maps", f"{member.short}.npz")

    def points(self, member: _Member) -> str:
        """The member at the points of the icosphere, which is registered in its place."""
        return self.place("work", "points", f"{member.short}.npz")

    def placed(self, member: _Member) -> str:
        """Points, areas and features of the member in correspondence."""
        return self.place("work", "placed", f"{member.short}.npz")

    def result(self, member: _Member) -> str:
        """The member's map in the group's frame."""
        return self.place("members", f"{member.short}.npz")

    def stored(self, name: str, shapes: Iterable[FloatArray], size: tuple[int, int, int]) -> FloatArray:
        """Shapes in a file, as an array of that size, in memory only where it is read."""
        path = self.place("work", f"{name}.f64")
        with replacing(path, force=True) as partial, partial.open("wb") as file:
            for shape in shapes:
                file.write(np.ascontiguousarray(shape).tobytes())
        return np.asarray(np.memmap(path, np.float64, "r", shape=size))


class _Crew:
    """Runs a job for each member, and keeps the names of those for which one failed, with the reasons."""

    def __init__(self, run: Callable[..., list[JobRow]], target: str) -> None:
        self._run = run
        self._settings: dict[str, Any] = {"icosphere": target, "force": False, "folder": os.getcwd()}
        self.left_out: dict[str, str] = {}

    def each(self, name: str, members: list[_Member], jobs: Sequence[MemberJob], kind: Callable[..., MemberTask],
             failing: str = "", **options: Any) -> list[_Member]:
        """The members whose jobs of this kind of task succeeded."""
        done = count(1)
        log_share(name, 0, len(jobs))
        rows = self._run(jobs, kind(**self._settings, **options),
                         listener=lambda _: log_share(name, next(done), len(jobs)))
        for member, row in zip(members, rows, strict=True):
            if row.status not in MAPPED:
                self.left_out[member.name] = failing + without_name(row.notes, row.source)
        found = [member for member, row in zip(members, rows, strict=True) if row.status in MAPPED]
        if len(found) < _FEWEST:
            reason = "".join(f"; {name}: {why}" for name, why in list(self.left_out.items())[:1])
            raise MeshError(f"{len(found)} of {len(found) + len(self.left_out)} members are left, and a group needs "
                            f"{_FEWEST}{reason}")
        return found


class _People:
    """The members of a group in files, and the jobs that make them.

    They are in the order of their contents, in which sums are taken: so no bit depends on the sources' order.
    """

    def __init__(self, files: _Files, crew: _Crew, mesh: tuple[FloatArray, IntArray]) -> None:
        self._files, self._crew, (self._x, self._f) = files, crew, mesh
        self._known: dict[int, _Member] = {}
        self._round = 0

    @property
    def members(self) -> list[int]:
        """Their numbers among the sources."""
        return list(self._known)

    def mapped(self, sources: Sequence[Source], features: Sequence[ArrayLike] | None, balance: float) -> FloatArray:
        """Map all, and return the points of the one whose shape is nearest to the mean.

        That is by powers of harmonics, which neither pose nor mirroring changes.
        """
        names = names_of(sources)
        members = [_Member(k, *each) for k, each in enumerate(zip(names, file_names(names), strict=True))]
        jobs, known = [], []
        for member, source in zip(members, sources, strict=True):
            try:
                jobs.append(self._map_job(member, source, None if features is None else features[member.number]))
                known.append(member)
            except MeshError as error:
                self._crew.left_out[member.name] = one_line(error)
        found = {member.number: (member, read_arrays(self._files.points(member)))
                 for member in self._crew.each("maps", known, jobs, MapMember, balance=balance)}
        order = sorted(found, key=lambda k: found[k][1]["digest"].tobytes())
        self._known = {k: found[k][0] for k in order}
        powers = np.stack([found[k][1]["powers"] for k in order])
        medoid = order[int(np.argmin(np.linalg.norm(powers - powers.mean(axis=0), axis=1)))]
        return np.asarray(found[medoid][1]["points"])

    def _map_job(self, member: _Member, source: Source, features: ArrayLike | None) -> MapJob:
        """What is read and written for a member; what was given as an object is written first."""
        path, is_map = member.name, isinstance(source, SphereMap)
        if not isinstance(source, str | os.PathLike):
            path = self._files.place("work", "given", f"{member.short}.npz")
            if isinstance(source, SphereMap):
                write_arrays(path, npz.arrays_of(source))
            else:
                mesh = check_mesh(*vertices_and_faces(source), caps=getattr(source, "caps", None))
                write_arrays(path, {"vertices": mesh.v, "faces": mesh.f}
                             | ({} if mesh.caps is None else {"caps": mesh.caps}))
        columns: tuple[str, ...] = ()
        if isinstance(features, FeatureFiles):
            columns = features.paths
        elif features is not None:
            columns = columns_of(features, self._files.place("work", "given", f"{member.short}.features.npy"))
        return MapJob(path, self._files.map(member), more=(self._files.points(member),), is_map=is_map,
                      features=columns)

    def registered(self, numbers: Sequence[int], target: SphereMap, search: bool) -> Registered:
        """Members registered to a template, from where they were in the round before."""
        self._round += 1
        template = self._files.place("work", "rounds", str(self._round), "template.npz")
        write_arrays(template, {"vertices": target.vertices, "faces": target.faces, "sphere": target.sphere})
        members = [self._known[k] for k in numbers]
        jobs = [MemberJob(self._files.points(member),
                          self._files.place("work", "rounds", str(self._round), f"{member.short}.npz"),
                          beside=(template, *filter(None, (member.sphere,)))) for member in members]
        written = {member.number: job.target for member, job in zip(members, jobs, strict=True)}
        found = self._crew.each("registrations", members, jobs, RegisterMember, "it could not be registered: ",
                                search=search)
        for member in found:
            member.sphere = written[member.number]
            member.search = member.sphere if search else member.search
        shapes, areas = self._read([member.sphere for member in found])
        turned = sum(bool(read_arrays(member.sphere)["turned"]) for member in found) if search else 0
        return Registered([member.number for member in found], shapes, areas, turned)

    def _read(self, files: Sequence[str]) -> tuple[FloatArray, FloatArray]:
        """The points of all members in one file, and their mean area around each."""
        areas = np.zeros(len(self._x))

        def points() -> Iterator[FloatArray]:
            nonlocal areas
            for file in files:
                arrays = read_arrays(file)
                areas = areas + arrays["areas"] / len(files)
                yield arrays["points"]

        size = len(files), len(self._x), 3
        return self._files.stored("points", points(), size), areas

    def group(self, fixed: FixedPoint, modes: int, *, balance: float, rigid: bool, keep: bool) -> Group:
        """The group: each registration is carried to the member's own mesh, and sampled there.

        With `keep` it holds maps and shapes; else they lie in files.
        """
        mesh = check_mesh(fixed.mean, self._f)
        frame = self._files.place("work", "frame.npz")
        write_arrays(frame, {"turn": best_rotation(self._x, orientation_target(mesh), mesh.A)})
        self._crew.left_out |= {self._known[k].name: why for k, why in fixed.left_out.items()}
        members = [self._known[k] for k in fixed.members]
        jobs = [MemberJob(self._files.map(member), self._files.result(member),
                          beside=(self._files.points(member), member.sphere, frame),
                          more=(self._files.placed(member),)) for member in members]
        members = self._crew.each("members", members, jobs, PlaceMember)
        files = [self._files.placed(member) for member in members]
        shapes, areas = self._read(files)
        size = shapes.shape
        aligned = generalised_procrustes(shapes, areas, rigid)
        away = distances(shapes, areas, aligned)
        shapes = self._files.stored("aligned", (aligned.laid(shapes, slice(k, k + 1))[0] for k in range(len(files))),
                                    size)
        mean, several = aligned.mean, len(members) - 1
        found = principal_modes(shapes, areas, modes, mean)
        variance = sum((((shapes[part] - mean) ** 2).sum(axis=(0, 2)) for part in blocks(shapes)),
                       np.zeros(len(mean))) / several
        feature_mean = _mean_of(files, lambda values: values)
        feature_variance = _mean_of(files, lambda values: (values - feature_mean) ** 2)
        order = np.argsort([member.number for member in members])  # as the sources came
        shapes = self._files.stored("shapes", (shapes[k] for k in order), size)
        correlations = np.array([float(read_arrays(member.sphere)["correlation"]) for member in members])
        laid = [self._laid(member) for member in members]
        alike = symmetric(laid)
        rows = [Member(member.name, read_map(self._files.result(member)) if keep else None, correlation, size, distance,
                       member_doubts(each, distance, away, correlations, alike))
                for member, each, correlation, size, distance in zip(
                    members, laid, correlations.tolist(), aligned.sizes.tolist(), away.tolist(), strict=True)]
        return Group(
            mean, self._f, self._x, np.array(shapes) if keep else shapes, found.modes, found.variances,
            found.scores[order], tuple(rows[k] for k in order), areas, np.sqrt(variance), feature_mean,
            np.sqrt(feature_variance * len(files) / several), dict(self._crew.left_out), fixed.changes, rigid,
            balance, notes=tuple(group_doubts(fixed.changes, fixed.settled, laid, found.scores)),
        )  # fmt: skip

    def _laid(self, member: _Member) -> Laid:
        """How a member lies, as the last search for other rotations found it."""
        arrays = read_arrays(member.search)
        rival, angle, mirrored = (float(arrays[name]) for name in ("rival", "angle", "mirrored"))
        return Laid(arrays["sphere"], float(arrays["correlation"]), bool(arrays["turned"]), rival, angle, mirrored)


def _mean_of(files: list[str], of: Callable[[FloatArray], FloatArray]) -> FloatArray:
    """Mean over the members of a function of their features."""
    total: Any = 0.0
    for file in files:
        total = total + of(read_arrays(file)["features"])
    return np.asarray(total / len(files))
