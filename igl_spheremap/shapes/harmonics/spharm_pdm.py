"""The task of expanding a surface as SPHARM-PDM does, into files of its names."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ...errors import FileError
from ...io.files import own_name, read_sphere
from ...io.replacing import REPLACE
from ...io.write_mesh import write_mesh
from ...maps.given_sphere import sphere_map
from ...mesh.arrays import FloatArray
from ...populations.job import Job, Task, check_places
from ...populations.map_many import filled
from ...populations.mapping import SphereMapping
from ...populations.table import Row
from ...samples import sphere
from .files import read_coefficients, write_coefficients
from .harmonics import SphericalHarmonics, spherical_harmonics

#: Its surface axes x and y point against those of the sphere, by the phase (-1)^m of its degree 1.
_AXES = np.array([-1.0, -1.0, 1.0])


@dataclass(frozen=True)
class ShapeJob(Job):
    """A surface, its `X_para.vtk`, and, if given, the aligned shape that directs its axes."""

    template: str | None

    @property
    def sources(self) -> tuple[str, ...]:
        return tuple(filter(None, (self.file, self.template)))

    @property
    def surface(self) -> str:
        """The surface's file, from which the names of those after the map begin."""
        return self.target.removesuffix("_para.vtk") + "_surf.vtk"

    @property
    def expansions(self) -> tuple[str, ...]:
        """Surface and coefficients as the body lies, and both in its own frame."""
        return tuple(
            self.surface.removesuffix(".vtk") + f"_SPHARM{frame}.{kind}"
            for frame in ("", "_ellalign")
            for kind in ("vtk", "coef")
        )

    @property
    def targets(self) -> tuple[str, ...]:
        if Path(self.surface).resolve() == Path(self.source).resolve():
            return self.target, *self.expansions
        return self.target, self.surface, *self.expansions


@dataclass(frozen=True)
class ShapeExpansion(Task[ShapeJob]):
    """Mapping, expansion, and sampling on an icosahedron whose edges have `subdivision` parts."""

    mapping: SphereMapping
    degree: int
    subdivision: int

    def empty(self, job: ShapeJob) -> Row:
        return self.mapping.empty(job)

    def run(self, job: ShapeJob, check: Callable[[], None]) -> Row:
        """Map, certify the file, expand it, write."""
        places = self.places(job.targets[1:])
        there = [place for place in places if Path(place).exists()]
        if there and not (self.force or job.ours):
            raise FileError(
                f"{there[0]} exists, and not from this run; it is kept, {REPLACE} replaces it"
            )
        template = None
        if job.template is not None:
            template = read_coefficients(self.place(job.template))
            template._require_positions()
            template = SphericalHarmonics(template.coefficients * _AXES)
        row = self.mapping.run(job, check)
        if row.status != "certified":
            return row
        loaded = self.mapping.read(self.place(job.source))
        v, f, caps = self.mapping.repaired(loaded)
        result = sphere_map(v, f, read_sphere(self.place(job.target)).v, caps=caps)
        shape = spherical_harmonics(result, degree=self.degree)
        aligned = shape.align(template)
        as_it_lies = shape.rotated(aligned.sphere_rotation)
        in_frame = SphericalHarmonics(aligned.harmonics.coefficients * _AXES)
        x, faces = sphere(10 * self.subdivision**2 + 2)
        if job.surface in job.targets:
            write_mesh(self.place(job.surface), v, f, force=True, metadata=loaded.metadata)
        for k, each in enumerate((as_it_lies, in_frame)):
            mesh, coefficients = self.places(job.expansions)[2 * k : 2 * k + 2]
            write_mesh(
                mesh, each.evaluate(x), faces, force=True, metadata={"point_data": _angles(x)}
            )
            write_coefficients(coefficients, each, force=True)
        return replace(row, notes="; ".join(filter(None, (row.notes, *shape.notes))))


def _angles(x: FloatArray) -> dict[str, FloatArray]:
    """Longitude from -x and angle from the south pole, as SPHARM-PDM writes them for its viewers."""
    return {"_paraPhi": np.arctan2(x[:, 1], x[:, 0]) + np.pi, "_paraTheta": np.arccos(-x[:, 2])}


def shape_jobs(sources: Sequence[str], out: str, template: str | None = None) -> list[ShapeJob]:
    """A job for each surface; a ValueError if two would have the same files, or a file would replace an input.

    >>> [job.target for job in shape_jobs(["a/X_pp_surf.vtk", "a/Y.ply"], "shapes")]
    ['shapes/X_pp_para.vtk', 'shapes/Y_para.vtk']
    """
    stems = [own_name(source).stem.removesuffix("_surf") for source in sources]
    jobs = [
        ShapeJob(
            source, (Path(filled(out, source, "out ")) / f"{stem}_para.vtk").as_posix(), template
        )
        for source, stem in zip(sources, stems, strict=True)
    ]
    check_places(jobs, "use {folder}, and each input once")
    return jobs
