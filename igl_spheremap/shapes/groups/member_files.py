"""Files of groups and series: a folder with the files of their members, and the jobs that make these."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from functools import partial
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...errors import MeshError, without_name
from ...gate import MeshLike, PathLike
from ...io import npz
from ...io.npz import read_arrays, save_arrays
from ...io.objects import vertices_and_faces
from ...io.replacing import make_folder, replacing
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import AnyArray, FloatArray
from ...mesh.check import check_mesh
from ...populations.engine import Engine, started
from ...populations.run_many import run_many
from ...populations.table import MAPPED, JobRow
from ...timings import log_share
from .features import FeatureFiles
from .files import file_names
from .jobs import CarryMember, MapMember, MemberJob, MemberTask, RegisterMember
from .member_registration import MemberRegistration
from .sampling import SurfaceLike, names_of
from .turns import NO_RESTARTS, Restarts, rows

#: The manifest in the folder.
MANIFEST = "manifest.jsonl"


@dataclass(eq=False)
class Entry:
    """A surface in files: its number among the sources, its name, and that of its files."""

    number: int
    name: str
    short: str
    sphere: str = ""  # the file of its last registration
    search: str = ""  # that of the last one that tried other turns or a mirror image


@contextmanager
def member_files(
    out: PathLike | None, results: str, target: str, engine: Engine, least: int
) -> Iterator[MemberFiles]:
    """Files of members in a folder, temporary without `out`, on an icosphere, for a least number of members."""
    with ExitStack() as stack:
        if out is None:
            out = stack.enter_context(TemporaryDirectory())
        folder = os.fspath(out)
        run = partial(
            run_many,
            manifest=os.path.join(folder, MANIFEST),
            engine=stack.enter_context(started(engine)),
        )
        yield MemberFiles(Path(folder), results, target, least, run)


@dataclass(eq=False)
class MemberFiles:
    """The files of members in a folder, and the jobs that make them; some steps leave members out, with the reasons.

    Members' maps in the common frame lie in the folder `results`, all else in ``work``.
    """

    folder: Path
    results: str
    icosphere: str
    least: int
    run: Callable[..., list[JobRow]]
    left_out: dict[str, MeshError] = field(default_factory=dict)

    def path(self, *parts: str) -> str:
        """The path of a file by its folders, which are made, and its name."""
        *folders, name = parts
        folder = self.folder
        for each in folders:
            folder = make_folder(folder / each, follow=False)
        return str(folder / name)

    def of(self, member: Entry, kind: str) -> str:
        """A member's file: "map" with features, "points" on the icosphere, or "carried", points that correspond."""
        return self.path("work", kind, f"{member.short}.npz")

    def result(self, member: Entry) -> str:
        """The member's map in the common frame."""
        return self.path(self.results, f"{member.short}.npz")

    def mapped(
        self, sources: Sequence[SurfaceLike], features: Sequence[ArrayLike] | None, balance: float
    ) -> list[Entry]:
        """Map the sources; return the mapped ones, in their order."""
        names, jobs = names_of(sources), dict[Entry, MemberJob]()
        for k, (name, short, source) in enumerate(
            zip(names, file_names(names), sources, strict=True)
        ):
            member, path, columns = Entry(k, name, short), name, tuple[str, ...]()
            try:
                if not isinstance(source, str | os.PathLike):
                    path = self._surface_file(member, source)
                if features is not None:
                    columns = self._feature_files(member, features[k])
            except MeshError as error:
                self.left_out[name] = error
                continue
            jobs[member] = MemberJob(
                path,
                self.of(member, "map"),
                more=(self.of(member, "points"),),
                features=columns,
                is_map=isinstance(source, SphereMap),
            )
        self._enough(len(jobs), len(names))
        return self._each("maps", jobs, MapMember, balance=balance)

    def _surface_file(self, member: Entry, source: SphereMap | MeshLike) -> str:
        """Write a map or a mesh that was given as arrays."""
        if isinstance(source, SphereMap):
            arrays = npz.arrays_of(source)
        else:
            mesh = check_mesh(*vertices_and_faces(source), caps=getattr(source, "caps", None))
            arrays = {"vertices": mesh.v, "faces": mesh.f}
            if mesh.caps is not None:
                arrays["caps"] = mesh.caps
        path = self.path("work", "given", f"{member.short}.npz")
        save_arrays(path, arrays)
        return path

    def _feature_files(self, member: Entry, features: ArrayLike) -> tuple[str, ...]:
        """The columns of features by FILE:NUMBER; those that were given as an array are written."""
        if isinstance(features, FeatureFiles):
            return features.paths
        rows = np.asarray(features, dtype=np.float64)
        rows = rows.reshape(len(rows), -1)
        path = self.path("work", "given", f"{member.short}.features.npy")
        with replacing(path, force=True) as partial_file:
            np.save(partial_file, rows)
        return tuple(f"{path}:{k}" for k in range(rows.shape[1]))

    def registered(
        self,
        folder: str,
        members: Sequence[Entry],
        templates: Sequence[str],
        restarts: Sequence[Restarts],
    ) -> list[Entry]:
        """Register each member to the points in a file, from its last position, and try its restarts."""
        jobs = {}
        for k, (member, template, each) in enumerate(
            zip(members, templates, restarts, strict=True)
        ):
            jobs[member] = MemberJob(
                self.of(member, "points"),
                self.path("work", folder, f"{k}.npz"),
                restarts=each,
                beside=tuple(filter(None, (template, member.sphere))),
            )
        found = self._each("registrations", jobs, RegisterMember, "it could not be registered: ")
        for member in found:
            member.sphere = jobs[member].target
            if jobs[member].restarts != NO_RESTARTS:
                member.search = member.sphere
        return found

    def carried(
        self, members: Sequence[Entry], turns: Sequence[FloatArray]
    ) -> tuple[list[Entry], list[AnyArray]]:
        """Carry the last registrations, turned, to the members' own meshes.

        Return the members that are left, and their corresponding points, areas and features.
        """
        jobs = {
            member: MemberJob(
                self.of(member, "map"),
                self.result(member),
                more=(self.of(member, "carried"),),
                beside=(self.of(member, "points"), member.sphere),
                turn=rows(turn),
            )
            for member, turn in zip(members, turns, strict=True)
        }
        kept = self._each("members", jobs, CarryMember)
        paths = [self.of(member, "carried") for member in kept]
        return kept, stacked(paths, "points", "areas", "features")

    def last_search(self, member: Entry) -> MemberRegistration:
        """The last registration that tried other turns or a mirror image, or else the last one."""
        path = member.sphere
        if member.search:
            path = member.search
        arrays = read_arrays(path)
        return MemberRegistration(
            arrays["sphere"], *(arrays[name].item() for name in MemberRegistration._fields[1:])
        )

    def _each(
        self,
        name: str,
        jobs: Mapping[Entry, MemberJob],
        kind: Callable[..., MemberTask],
        failing: str = "",
        **options: Any,
    ) -> list[Entry]:
        """The members whose jobs of this kind of task succeeded; if too few, a MeshError with the first reason."""
        done, found = count(1), []
        log_share(name, 0, len(jobs))
        rows = self.run(
            list(jobs.values()),
            kind(icosphere=self.icosphere, force=False, folder=os.getcwd(), **options),
            listener=lambda _: log_share(name, next(done), len(jobs)),
        )
        for member, row in zip(jobs, rows, strict=True):
            if row.status in MAPPED:
                found.append(member)
            else:
                self.left_out[member.name] = MeshError(
                    failing + without_name(row.notes, row.source)
                )
        self._enough(len(found), len(jobs))
        return found

    def _enough(self, left: int, members: int) -> None:
        """If too few of the members are left, raise a MeshError with the first reason."""
        if left < min(self.least, members):
            name, error = next(iter(self.left_out.items()))
            raise MeshError(
                f"{left} of {members} surfaces are left, {self.least} are needed; surface {name}: {error}"
            )


def stacked(paths: Sequence[str], *names: str) -> list[AnyArray]:
    """Arrays of several files, one behind the other."""
    found = [read_arrays(path) for path in paths]
    return [np.stack([arrays[name] for arrays in found]) for name in names]
