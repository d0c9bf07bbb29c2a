"""The task of mapping a mesh file to the sphere."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..balance.balanced_spherical_map import balanced_spherical_map
from ..errors import FileError
from ..io.files import read_mesh
from ..io.records import LoadedMesh
from ..io.replacing import REPLACE, check_writable
from ..io.written_map import make_mark, read_mark, write_map
from ..maps.mapper import SphereMapper
from ..maps.options import Auto, Method
from ..maps.sphere_map import SphereMap
from ..mesh.arrays import BoolArray, FloatArray, IntArray
from ..mesh_repair.repair_mesh import repair_mesh
from ..result.findings import moved_for_float32
from ..verify.distortion import log_figures, log_length_ratios
from .job import Job, Task
from .table import Row

_OF_THREAD = threading.local()


@dataclass(frozen=True)
class SphereMapping(Task[Job]):
    """Mapping of meshes: `repair` holds the options of `repair_mesh`, None for no repair."""

    method: Method
    balance: float
    repair: Mapping[str, Any] | None

    def empty(self, job: Job) -> Row:
        return Row(job.source, job.target)

    def read(self, source: str) -> LoadedMesh:
        """The mesh of a file; if it is to be repaired, its polygons are cut into triangles."""
        return read_mesh(source, triangulate=self.repair is not None)

    def repaired(self, loaded: LoadedMesh) -> tuple[FloatArray, IntArray, BoolArray | None]:
        """The mesh that is mapped, and its caps."""
        if self.repair is None:
            return loaded.v, loaded.f, loaded.metadata.get("caps")
        repaired = repair_mesh(loaded.v, loaded.f, **self.repair)
        return repaired.v, repaired.f, repaired.caps

    def run(self, job: Job, check: Callable[[], None]) -> Row:
        """Read, map, write, and measure."""
        source, target = self.place(job.source), self.place(job.target)
        check_writable(target, force=True)
        loaded = self.read(source)
        check()
        v, f, caps = self.repaired(loaded)
        if not (self.force or job.ours) and Path(target).exists():
            settings = self.method.settings()
            if self.balance:
                settings |= {"balance": self.balance}
            if read_mark(target) != make_mark(v, f, self.method.name, settings, caps):
                raise FileError(
                    f"{job.target} exists without the mark of this version, method and mesh; it is kept, "
                    f"{REPLACE} replaces it"
                )
        result = _map(v, f, caps, self)
        written = write_map(target, result, force=True, metadata=loaded.metadata)
        notes = [*result.notes]
        if written.moved:
            notes.append(moved_for_float32(written.moved))
        surface, columns = result.faces[result.mesh.surface], dict[str, Any]()
        for name, values in (
            ("angle", result.angle_differences()),
            ("area", result.log_area_ratios()),
            ("edge", log_length_ratios(result.vertices, surface, result.sphere)),
        ):
            figures = log_figures(values)
            columns |= {f"{kind}_{name}": figures[kind] for kind in ("mean", "p99", "max")}
        status, before = "folded", result.certificate.foldings
        if written.folding_free:
            status = "certified"
        if result.rounds:
            before = result.rounds[0].foldings_before
        return replace(
            self.empty(job), status=status, vertices=len(v), foldings_before=before,
            foldings=written.foldings, energy=result.energy, stretch=result.stretch,
            notes="; ".join(notes), **columns,
        )  # fmt: skip


def _map(v: FloatArray, f: IntArray, caps: BoolArray | None, task: SphereMapping) -> SphereMap:
    """The map of a mesh; if it has the faces of the last mesh, data of faces alone are used again."""
    if not isinstance(task.method, Auto):
        return balanced_spherical_map(v, f, balance=task.balance, method=task.method, caps=caps)
    # if it fails, the next mesh gets a new one
    mapper: SphereMapper | None = _OF_THREAD.__dict__.pop("mapper", None)
    if (
        mapper is not None
        and mapper.method == task.method
        and np.array_equal(mapper.mesh.f, f)
        and np.array_equal(np.asarray(mapper.mesh.caps), np.asarray(caps))
    ):
        mapper.move(v)
    else:
        mapper = None  # two factors at a time would take twice the memory
        mapper = SphereMapper(v, f, method=task.method, caps=caps)
    result = mapper.map()
    _OF_THREAD.mapper = mapper
    return result.rebalance(task.balance)
