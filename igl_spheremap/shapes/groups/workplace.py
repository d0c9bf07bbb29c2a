"""Where groups and series are made: the files of their members, and who runs the jobs."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import partial
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...errors import MeshError, without_name
from ...io import npz
from ...io.npz import read_arrays
from ...io.replacing import make_folder, replacing
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray
from ...mesh.check import check_mesh
from ...mesh.objects import vertices_and_faces
from ...mesh.timings import log_share
from ...populations.engine import Engine, started
from ...populations.run_many import run_many
from ...populations.table import MAPPED, JobRow
from .features import FeatureFiles
from .files import file_names
from .jobs import MapJob, MapMember, MemberJob, MemberTask, columns_of, write_arrays
from .laying import Laid
from .placing import Source, names_of

#: The manifest in the folder.
MANIFEST = "manifest.jsonl"


@contextmanager
def workplace(
    out: str | os.PathLike[str] | None, results: str, target: str, engine: Engine
) -> Iterator[tuple[Files, Crew]]:
    """A folder, temporary without `out`, for files and results on an icosphere, and a crew of that engine."""
    with ExitStack() as stack:
        place = stack.enter_context(TemporaryDirectory()) if out is None else os.fspath(out)
        run = partial(run_many, manifest=os.path.join(place, MANIFEST), engine=stack.enter_context(started(engine)))
        yield Files(Path(place), results), Crew(run, target)


@dataclass
class Entry:
    """A surface in files: its number among the sources, its name, and that of its files."""

    number: int
    name: str
    short: str
    sphere: str = ""  # the file of its last registration
    search: str = ""  # that of the last one for which other rotations were tried


class Files:
    """Where the files of a group or a series in the making lie; their folders are made as they are asked for."""

    def __init__(self, folder: Path, results: str) -> None:
        self._folder, self._results = folder, results

    def place(self, *parts: str) -> str:
        """The place of a file by its folders and its name."""
        path = self._folder.joinpath(*parts)
        make_folder(path.parent)
        return str(path)

    def of(self, member: Entry, kind: str) -> str:
        """A member's file: "map" with features, "points" on the icosphere, or "placed", points that correspond."""
        return self.place("work", kind, f"{member.short}.npz")

    def result(self, member: Entry) -> str:
        """The member's map in the group's frame."""
        return self.place(self._results, f"{member.short}.npz")

    def place_job(self, member: Entry, registered: str, frame: str) -> MemberJob:
        """To carry a registration, turned into a frame, to the member's own mesh."""
        return MemberJob(self.of(member, "map"), self.result(member), more=(self.of(member, "placed"),),
                         beside=(self.of(member, "points"), registered, frame))

    def laid(self, path: str) -> Laid:
        """A registration that a job wrote."""
        arrays = read_arrays(path)
        rival, angle, mirrored = (float(arrays[name]) for name in ("rival", "angle", "mirrored"))
        return Laid(arrays["sphere"], float(arrays["correlation"]), bool(arrays["turned"]), rival, angle, mirrored)

    def stored(self, name: str, shapes: Iterable[FloatArray], size: tuple[int, int, int]) -> FloatArray:
        """Shapes in a file, as an array of that size, in memory only where it is read."""
        path = self.place("work", f"{name}.f64")
        with replacing(path, force=True) as partial, partial.open("wb") as file:
            for shape in shapes:
                file.write(np.ascontiguousarray(shape).tobytes())
        return np.asarray(np.memmap(path, np.float64, "r", shape=size))


class Crew:
    """Runs a job for each member, and keeps the names of those for which one failed, with the reasons."""

    def __init__(self, run: Callable[..., list[JobRow]], target: str) -> None:
        self._run = run
        self._settings: dict[str, Any] = {"icosphere": target, "force": False, "folder": os.getcwd()}
        self.left_out: dict[str, MeshError] = {}

    def each(self, name: str, members: list[Entry], jobs: Sequence[MemberJob], kind: Callable[..., MemberTask],
             failing: str = "", **options: Any) -> list[Entry]:
        """The members whose jobs of this kind of task succeeded."""
        done = count(1)
        log_share(name, 0, len(jobs))
        rows = self._run(jobs, kind(**self._settings, **options),
                         listener=lambda _: log_share(name, next(done), len(jobs)))
        for member, row in zip(members, rows, strict=True):
            if row.status not in MAPPED:
                self.left_out[member.name] = MeshError(failing + without_name(row.notes, row.source))
        return [member for member, row in zip(members, rows, strict=True) if row.status in MAPPED]


def mapped_all(files: Files, crew: Crew, sources: Sequence[Source], features: Sequence[ArrayLike] | None,
               balance: float) -> list[Entry]:
    """Those of the sources that could be mapped, in their order."""
    names = names_of(sources)
    jobs, known = [], []
    for k, (name, short, source) in enumerate(zip(names, file_names(names), sources, strict=True)):
        member = Entry(k, name, short)
        try:
            jobs.append(_map_job(files, member, source, None if features is None else features[k]))
            known.append(member)
        except MeshError as error:
            crew.left_out[name] = error
    return crew.each("maps", known, jobs, MapMember, balance=balance)


def _map_job(files: Files, member: Entry, source: Source, features: ArrayLike | None) -> MapJob:
    """What is read and written for a member; what was given as an object is written first."""
    path, is_map = member.name, isinstance(source, SphereMap)
    if not isinstance(source, str | os.PathLike):
        path = files.place("work", "given", f"{member.short}.npz")
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
        columns = columns_of(features, files.place("work", "given", f"{member.short}.features.npy"))
    return MapJob(path, files.of(member, "map"), more=(files.of(member, "points"),), is_map=is_map,
                  features=columns)
