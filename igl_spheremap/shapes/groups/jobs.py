"""Work on each member of a group, from files to files."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from hashlib import sha256

import numpy as np

from ...balance.balanced_spherical_map import balanced_spherical_map
from ...io import npz
from ...io.files import read_mesh
from ...io.npz import read_arrays
from ...io.scalars import file_of
from ...io.written_map import read_map, write_map
from ...maps.given_sphere import certified
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import check_values
from ...mesh.check import check_mesh
from ...mesh.measure import vertex_areas
from ...populations.job import Job, Task
from ...populations.table import JobRow
from ...resampling.transfer import resample, sphere_mesh, transfer
from ...resampling.weights import adaptive_area
from ..harmonics.basis import power
from ..harmonics.harmonics import spherical_harmonics
from .features import FeatureFiles
from .member_registration import register_member
from .sampling import at_points, carried, check_member
from .turns import NO_RESTARTS, Restarts, Rows


@dataclass(frozen=True)
class MemberJob(Job):
    """A member's files: those that are read beside the source, its features among them, and written beside the target.

    `is_map` says that the source is a map, which is taken as it is; `restarts` are tried by its registration,
    and the matrix `turn` multiplies its sphere.
    """

    beside: tuple[str, ...] = ()
    more: tuple[str, ...] = ()
    features: tuple[str, ...] = ()
    is_map: bool = False
    restarts: Restarts = NO_RESTARTS
    turn: Rows = ()

    @property
    def sources(self) -> tuple[str, ...]:
        features = (file_of(path)[0] for path in self.features)
        return (self.file, *self.beside, *features)

    @property
    def targets(self) -> tuple[str, ...]:
        return (self.target, *self.more)

    @property
    def chosen(self) -> tuple[object, ...]:
        columns = [file_of(path)[1] for path in self.features]
        return *super().chosen, self.is_map, tuple(self.restarts), self.turn, *columns


@dataclass(frozen=True, kw_only=True)
class MemberTask(Task[MemberJob]):
    """Common part of a group's tasks: the icosphere of its mean."""

    icosphere: str

    def surface(self, path: str) -> SphereMap:
        """A surface on the icosphere; unless it has a sphere of its own, these points are its map."""
        x, f = sphere_mesh(self.icosphere)
        arrays = read_arrays(self.place(path))
        return certified(check_mesh(arrays["points"], f), arrays.get("sphere", x))


@dataclass(frozen=True, kw_only=True)
class MapMember(MemberTask):
    """Read and map a member, and take its points at those of the icosphere, which are registered in its place."""

    balance: float

    def run(self, job: MemberJob, check: Callable[[], None]) -> JobRow:
        source = self.place(job.source)
        if job.is_map:
            result = read_map(source)
        else:
            result = balanced_spherical_map(read_mesh(source), balance=self.balance)
        check_member(result)
        n = len(result.sphere)
        values = np.empty((n, 0))
        if job.features:
            values = check_values(
                FeatureFiles(tuple(self.places(job.features))), n, f"features of {job.source}"
            )
        check()
        coarse = at_points(result, *sphere_mesh(self.icosphere))
        # of limbs and lobes, no details: they tell which member is nearest to the mean
        powers = np.sqrt(power(spherical_harmonics(coarse, degree=8).coefficients)[1:])
        content = (result.vertices, result.faces, result.sphere, values)
        digest = sha256(
            b"".join(np.ascontiguousarray(array).tobytes() for array in content)
        ).digest()
        npz.save_arrays(self.place(job.target), npz.arrays_of(result) | {"values": values})
        npz.save_arrays(
            self.place(job.more[0]),
            {
                "points": coarse.vertices,
                "powers": powers / np.linalg.norm(powers),
                "digest": np.frombuffer(digest, dtype=np.uint8),
            },
        )
        return replace(self.empty(job), vertices=n)


@dataclass(frozen=True, kw_only=True)
class RegisterMember(MemberTask):
    """Register a member's points to a template, from their positions in the round before, if any."""

    def run(self, job: MemberJob, check: Callable[[], None]) -> JobRow:
        coarse, target = self.surface(job.source), self.surface(job.beside[0])
        before = next((read_arrays(self.place(path))["sphere"] for path in job.beside[1:]), None)
        check()
        registered = register_member(coarse, target, before, job.restarts)
        points, f = resample(
            certified(coarse.mesh, registered.sphere), (coarse.sphere, coarse.faces)
        )
        arrays = registered._asdict() | {"points": points, "areas": vertex_areas(points, f)}
        npz.save_arrays(self.place(job.target), arrays)
        return replace(self.empty(job), vertices=len(points))


@dataclass(frozen=True, kw_only=True)
class CarryMember(MemberTask):
    """Carry a registration, turned, to the member's own mesh, and sample it there."""

    def run(self, job: MemberJob, check: Callable[[], None]) -> JobRow:
        arrays = read_arrays(self.place(job.source))
        points, registered = map(self.place, job.beside)
        coarse, y = self.surface(points), read_arrays(registered)["sphere"]
        check()
        onto = carried(npz.map_of(arrays), coarse, y @ np.array(job.turn))
        there = coarse.sphere, coarse.faces
        write_map(self.place(job.target), onto, force=True)
        npz.save_arrays(
            self.place(job.more[0]),
            {
                "points": resample(onto, there).v,
                "areas": adaptive_area(onto, *there).received,
                "features": transfer(onto, arrays["values"], there),
            },
        )
        return replace(self.empty(job), vertices=len(onto.sphere))
