"""The task of registering a hemisphere's surface to templates."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...balance import ON_SPHERE
from ...balance.balanced_spherical_map import balanced_spherical_map
from ...errors import FileError, FoldingsRemain, MeshError
from ...io.files import read_mesh
from ...io.hemispheres import LEFT, RIGHT
from ...io.records import Label, LoadedMesh
from ...io.replacing import REPLACE
from ...io.scalars import read_labels, read_scalars
from ...io.written_map import make_mark, read_mark
from ...maps.given_sphere import sphere_map
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.measure import inside_out, vertex_areas
from ...populations.job import Task
from ...populations.table import RegistrationRow
from ...resampling.transfer import resample
from ...result.findings import moved_for_float32
from ..correspondence.registration import Registration, reflected, register
from .jobs import HemisphereJob, LabelFile, wall_of
from .labels import label_margin
from .writer import Writer, thickness_of

#: Error of registrations along each axis, in radians: a median of 1.9 mm on fsaverage (docs/correspondence.md), 1.18
#: standard deviations of two axes, on a sphere of 74 mm that has its area.
_ERROR = 1.9 / 1.18 / 74
#: The mask of the cortex, as a table of labels.
_CORTEX = (Label(0, "???", (0.0, 0.0, 0.0, 0.0)), Label(1, "cortex", (0.9, 0.7, 0.6, 1.0)))
# a margin below it: less than three quarters of the neighbourhood within the error has the label
_UNSURE = 0.5


@dataclass(frozen=True)
class SphereRegistration(Task[HemisphereJob]):
    """Registration of hemispheres: as they are, or their mirror images to the other side."""

    reflect: bool = False

    def empty(self, job: HemisphereJob) -> RegistrationRow:
        return RegistrationRow(job.source, job.target)

    def surface(self, job: HemisphereJob) -> tuple[LoadedMesh, FloatArray, FloatArray]:
        """Read the given surface, positions of the pial one, and of the registered one: the midthickness of both."""
        given = read_mesh(self.place(job.source))
        if (
            given.metadata.get("structure") in (LEFT, RIGHT)
            and given.metadata["structure"] != job.hemisphere.structure
        ):
            raise MeshError(
                f"{job.source} is taken for {job.hemisphere.structure}, and says itself that it is "
                f"{given.metadata['structure']}; correct its name or what it holds"
            )
        if job.pial is None:
            return given, given.v, given.v
        v, f = read_mesh(self.place(job.pial))
        if len(v) != len(given.v) or not np.array_equal(f, given.f):
            raise MeshError(
                f"{job.pial} has other vertices or faces than {job.source}; give surfaces of one mesh, or "
                "take it out of that folder"
            )
        return given, v, (given.v + v) / 2

    def template(self, job: HemisphereJob, k: int) -> SphereMap:
        """Read a template of a job with its sphere."""
        files = job.templates[k]
        v, f, x = replace(
            files, sphere=self.place(files.sphere), surfaces=tuple(self.places(files.surfaces))
        ).read()
        try:
            if inside_out(v, f):
                raise MeshError("inside out: its faces point inwards; reverse them")
            return sphere_map(v, f, x)
        except (MeshError, FoldingsRemain) as error:
            raise FileError(
                f"{files.sphere} with {' and '.join(files.surfaces)}: {error}"
            ) from None

    def run(self, job: HemisphereJob, check: Callable[[], None]) -> RegistrationRow:
        """Read, map, register to each template, write."""
        given, pial, v = self.surface(job)
        templates = [self.template(job, k) for k in range(len(job.templates))]
        atlases = [(atlas, *self._atlas(atlas)) for atlas in job.atlases]
        check()
        mark = make_mark(v, given.f, "sphere-reg", {"balance": ON_SPHERE})
        self._refuse(job, mark)
        own = balanced_spherical_map(v, given.f, balance=ON_SPHERE)
        found = [register(own, template, reflect=self.reflect) for template in templates]
        # they fit the surface as it is
        spheres = [reflected(each.map) if self.reflect else each.map for each in found]
        taken = [
            (
                *label_margin(
                    templates[atlas.template], values, found[atlas.template].map.sphere, _ERROR
                ),
                table,
            )
            for atlas, values, table in atlases
        ]
        foldings = moved = 0
        for names in job.names:
            writer = Writer(self.place(job.folder), names, given, mark)
            # the first, since its mark tells the others' owner
            writer.sphere(own.sphere, "sphere")
            writer.features(own, given.v)
            if job.pial:
                writer.surface(v, given.f, "midthickness")
            for files, template, each, sphere in zip(
                job.templates, templates, found, spheres, strict=True
            ):
                writer.sphere(sphere.sphere, "registered", files.space)
                ratio = vertex_areas(sphere.sphere, given.f) / vertex_areas(own.sphere, given.f)
                writer.scalars("arealdistortion", np.log2(ratio), "distortion", files.space)
                side = job.hemisphere.other if self.reflect else job.hemisphere.structure
                on_template, faces = resample(each.map, template)
                writer.surface(on_template, faces, "resampled", files.space, side, job.kind)
            for atlas, (labels, margin, table) in zip(job.atlases, taken, strict=True):
                writer.labels(atlas.name, labels, table, "labels", atlas.name)
                writer.scalars("margin", margin, "margin", atlas.name)
            if names.convention == "fmriprep" and job.wall is not None:
                labels, _, table = taken[job.atlases.index(job.wall)]
                mask = ~np.isin(labels, [*wall_of(table), -1])
                writer.labels("cortex", mask.astype(np.int64), _CORTEX, "cortex")
                thickness = mask * thickness_of(given.v, pial, given.f)
                writer.scalars("thickness", thickness, "thickness")
                spaces = [files.space for files in job.templates]
                writer.sphere(spheres[spaces.index("fsLR")].sphere, "msmsulc", "fsLR")
                for kind, _ in job.copied(names):
                    writer.surface(given.v if kind == "white" else pial, given.f, kind)
            foldings, moved = foldings + writer.foldings, moved + writer.moved
        return replace(
            self.empty(job),
            **_figures(found, [margin for _, margin, _ in taken]),
            vertices=len(v),
            status="folded" if foldings else "certified",
            foldings=foldings,
            notes="; ".join(_notes(job, found, moved)),
        )

    def _atlas(self, atlas: LabelFile) -> tuple[IntArray, tuple[Label, ...] | None]:
        path = self.place(atlas.path)
        (values,) = read_scalars(path).values()
        return values.astype(np.int64), read_labels(path)

    def _refuse(self, job: HemisphereJob, mark: str) -> None:
        """If there are files, but no sphere among them that this task made of this surface, raise a FileError."""
        for names in job.names:
            there = [target for target in job.files(names) if os.path.lexists(self.place(target))]
            sphere = self.place(os.path.join(job.folder, names.of("sphere")))
            if (
                there
                and not self.force
                and not (os.path.isfile(sphere) and read_mark(sphere) == mark)
            ):
                raise FileError(
                    f"{there[0]} exists, and not from this version and surface; it is kept, {REPLACE} "
                    "replaces it"
                )


def _figures(found: Sequence[Registration], margins: Sequence[FloatArray]) -> dict[str, Any]:
    """Return the figures of the worst template and of the worst atlas."""
    ends = [each.stages[-1] for each in found]
    return {
        "unlike": max(1 - float(end.correlation.mean()) for end in ends),
        "mean_area": max(end.strain for end in ends),
        "p95_area": max(end.strain_95 for end in ends),
        "unsure": max((float((margin < _UNSURE).mean()) for margin in margins), default=np.nan),
    }


def _notes(job: HemisphereJob, found: Sequence[Registration], moved: int) -> Iterator[str]:
    if job.alone:
        yield job.alone
    for files, each in zip(job.templates, found, strict=True):
        if files.kind != job.kind != "surface":
            yield f"{files.name} has no {job.kind} surface here: its {files.kind} was taken"
        yield from (f"{files.name}: {note}" for note in each.notes)
    if moved:
        yield moved_for_float32(moved)
