"""One input from file to file, and its row."""

from __future__ import annotations

import os
import socket
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from .._version import __version__
from ..errors import FileError, FoldingsRemain, MeshError, WorkersUnavailable, one_line
from ..io.files import read_mesh
from ..io.records import LoadedMesh
from ..io.replacing import check_writable, remove_partial_files
from ..io.written_map import make_mark, read_mark, write_map
from ..maps.balanced import balanced_spherical_map
from ..maps.mapper import SphereMapper
from ..maps.options import Auto, Method
from ..mesh.arrays import BoolArray, FloatArray, IntArray
from ..mesh.clean import repair_mesh
from ..result.sphere_map import SphereMap
from ..verify.distortion import edge_distortion, log_figures
from .child import WorkerDied, own_child, peak_memory
from .manifest import Fingerprint, Result, fingerprint, is_still
from .table import Row

_OF_THREAD = threading.local()
_STATUS: dict[type[Exception], str] = {MeshError: "no mesh", FoldingsRemain: "folded", OSError: "file"}


@dataclass(frozen=True)
class Options:
    """What is done to every mesh, and by which version.

    `repair` holds the options of `repair_mesh`, None for no repair; relative paths begin in `folder`.
    """

    method: Method
    balance: float
    repair: Mapping[str, Any] | None
    force: bool
    folder: str
    version: str = __version__

    def text(self) -> str:
        """All that changes a result."""
        settings = ",".join(f"{key}={value}" for key, value in sorted(self.method.settings().items()))
        return f"{self.version} {self.method.name} {settings} {self.balance!r} {self.repair}"

    def place(self, path: str) -> str:
        """Where a path is, on a machine whose working directory may be another."""
        return path if os.getcwd() == self.folder else os.path.join(self.folder, path)

    def read(self, source: str) -> LoadedMesh:
        """The mesh of a file, its polygons cut into triangles if it is to be repaired."""
        return read_mesh(source, triangulate=self.repair is not None)

    def repaired(self, loaded: LoadedMesh) -> tuple[FloatArray, IntArray, BoolArray | None]:
        """The mesh that is mapped, and its caps."""
        if self.repair is None:
            return loaded.v, loaded.f, loaded.metadata.get("caps")
        repaired = repair_mesh(loaded.v, loaded.f, **self.repair)
        caps = repaired.face_source < 0
        return repaired.v, repaired.f, caps if caps.any() else None


@dataclass(frozen=True)
class Job:
    """An input, the file of its sphere, and the key of the result: a digest of the target's place and the options."""

    source: str
    target: str
    key: str


def key_of(target: str, options: Options) -> str:
    """The key of a result; `target` is relative to the manifest, which may move with it."""
    return sha256(f"{options.text()} {target}".encode("utf-8", "surrogateescape")).hexdigest()[:32]


def map_one(job: Job, options: Options) -> Result:
    """Map one file; whatever is wrong with it is in its row."""
    if options.version != __version__:
        raise WorkersUnavailable(f"{host_and_process()} has igl_spheremap {__version__} where {options.version} is "
                                 "asked for")
    began = time.perf_counter()
    source, target = options.place(job.source), options.place(job.target)
    row, read = Row(job.source, job.target), fingerprint(source)
    try:
        row = _mapped(row, source, target, options, read)
    except Exception as error:  # one mesh must not end the others
        status = next((status for kind, status in _STATUS.items() if isinstance(error, kind)), "failed")
        row = replace(row, status=status, notes=one_line(error))
        if status == "file" or not is_still(source, read):
            read = None
    row = replace(row, seconds=time.perf_counter() - began, memory=peak_memory(), worker=host_and_process())
    return Result(row, read, fingerprint(target))


def map_in_child(job: Job, options: Options, timeout: float | None, memory: float | None) -> Result:
    """`map_one` in the process of this thread; a job that passes a limit gets a row with the reason."""
    try:
        return own_child().call(map_one, job, options, timeout=timeout, memory=memory)
    except WorkerDied as died:
        remove_partial_files(options.place(job.target), died.pid)
        if not died.reason:
            raise
        return failed(job, options, died.reason)


def failed(job: Job, options: Options, reason: str) -> Result:
    """The result of a job whose process ended before it did."""
    row = Row(job.source, job.target, status="failed", notes=reason)
    return Result(row, fingerprint(options.place(job.source)), fingerprint(options.place(job.target)))


def host_and_process() -> str:
    """What runs this, as `host:pid`."""
    return f"{socket.gethostname()}:{os.getpid()}"


def _mapped(row: Row, source: str, target: str, options: Options, read: Fingerprint | None) -> Row:
    """Read, map, write, and measure."""
    check_writable(target, force=True)
    loaded = options.read(source)
    if not is_still(source, read):
        raise FileError(f"{row.source} changed while it was read; run it again")
    v, f, caps = options.repaired(loaded)
    if not options.force and Path(target).exists():
        balance = {"balance": options.balance} if options.balance else {}
        if read_mark(target) != make_mark(v, f, options.method.name, options.method.settings() | balance, caps):
            raise FileError(f"{row.target} exists without the mark of this version, method and mesh; it is kept, "
                            "force=True replaces it")
    result = _map(v, f, caps, options)
    written = write_map(target, result, force=True, metadata=loaded.metadata)
    certificate = written.certificate
    moved = (f"{written.moved} vertices moved to keep float32 from folding",) if written.moved else ()
    figures = {
        "angle": log_figures(result.angle_differences()),
        "area": log_figures(result.area_ratios()),
        "edge": log_figures(edge_distortion(result.vertices, result.faces[result.mesh.surface], result.sphere)),
    }
    columns: dict[str, Any] = {f"{kind}_{name}": figures[name][kind] for name in figures
                               for kind in ("mean", "p99", "max")}
    return replace(
        row, status="certified" if certificate.folding_free else "folded", vertices=len(v),
        foldings_before=result.rounds[0].foldings_before if result.rounds else result.certificate.foldings,
        foldings=certificate.foldings, energy=result.energy, stretch=result.stretch,
        notes="; ".join((*result.notes, *moved)), **columns,
    )  # fmt: skip


def _map(v: FloatArray, f: IntArray, caps: BoolArray | None, options: Options) -> SphereMap:
    """The map of a mesh; if it has the faces of the last mesh, what depends on faces alone is used again."""
    if not isinstance(options.method, Auto):
        return balanced_spherical_map(v, f, options.balance, method=options.method, caps=caps)
    mapper: SphereMapper | None = _OF_THREAD.__dict__.pop("mapper", None)  # if it fails, the next mesh gets a new one
    if (mapper is not None and mapper.method == options.method and np.array_equal(mapper.mesh.f, f)
            and np.array_equal(np.asarray(mapper.mesh.caps), np.asarray(caps))):
        mapper.move(v)
    else:
        mapper = None  # two factors at a time would take twice the memory
        mapper = SphereMapper(v, f, options.method, caps=caps)
    result = mapper.map()
    _OF_THREAD.mapper = mapper
    return mapper.rebalance(result, options.balance) if options.balance else result
