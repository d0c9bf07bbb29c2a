"""Hemispheres to be registered: their surfaces, templates and atlases, and the files that are made of each."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import chain
from pathlib import Path

import numpy as np

from ..._version import __version__
from ...errors import FileError, MeshError, Remedy, printable
from ...gate import PathLike
from ...io.files import read_mesh, read_sphere
from ...io.formats import CONVENTIONS, Convention
from ...io.hemispheres import (
    SIDES,
    Hemisphere,
    Names,
    atlas_of,
    fill_sides,
    hemisphere_of,
    partner_of,
    structure_of,
)
from ...io.records import Label
from ...io.replacing import replacing
from ...io.scalars import read_labels, read_scalars
from ...io.templates import TEMPLATES, TemplateFiles, template_files
from ...populations.job import Job, check_places

_BIDS_VERSION = "1.10.0"
_WALL = re.compile(r"(?i)unknown|corpus_?callosum|.*medial_?wall|\?\?\?")


@dataclass(frozen=True)
class LabelFile:
    """A file of labels on a template of a job, by its place there."""

    path: str
    template: int

    @property
    def name(self) -> str:
        """Name of the atlas."""
        return atlas_of(self.path)


@dataclass(frozen=True)
class HemisphereJob(Job):
    """A hemisphere, the pial surface, if any, beside it, its templates and atlases, and the places of its files.

    `wall` is the atlas, if any, whose table names the medial wall.
    """

    hemisphere: Hemisphere
    pial: str | None
    templates: tuple[TemplateFiles, ...]
    atlases: tuple[LabelFile, ...]
    folder: str
    names: tuple[Names, ...]
    wall: LabelFile | None = None

    @property
    def sources(self) -> tuple[str, ...]:
        surfaces = (self.source, *((self.pial,) if self.pial else ()))
        templates = chain.from_iterable(template.paths for template in self.templates)
        return (*surfaces, *templates, *(atlas.path for atlas in self.atlases))

    @property
    def targets(self) -> tuple[str, ...]:
        return tuple(path for names in self.names for path in self.files(names))

    @property
    def kind(self) -> str:
        """The kind of the surface that is registered."""
        return "midthickness" if self.pial else self.hemisphere.kind

    @property
    def alone(self) -> str:
        """A remark on a white surface, or one of no known kind, that is registered without a pial one."""
        if self.kind not in ("white", "surface"):
            return ""
        name = {"white": "a white surface"}.get(
            self.kind, "a surface that is called neither white nor pial"
        )
        pial = Remedy(options={"pial": None})
        return f"registered as {name}, whose files are called {self.kind}; for the midthickness give {pial} FILE"

    def files(self, names: Names) -> list[str]:
        """The files of one convention, registered spheres first."""
        return [os.path.join(self.folder, name) for name in self._files(names)]

    def _files(self, names: Names) -> Iterator[str]:
        for template in self.templates:
            yield names.of("registered", template.space)
        yield names.of("sphere")
        yield from (names.of("sulc"), names.of("curv"), names.of("area"))
        if self.pial:
            yield names.of("midthickness")
        for template in self.templates:
            yield names.of("distortion", template.space)
            yield names.of("resampled", template.space, vertices=template.size, kind=self.kind)
        for atlas in self.atlases:
            yield from (names.of("labels", atlas.name), names.of("margin", atlas.name))
        if names.convention == "fmriprep":
            yield from (names.of("msmsulc", "fsLR"), names.of("thickness"), names.of("cortex"))
            yield from (names.of(kind) for kind, _ in self.copied(names))

    def copied(self, names: Names) -> list[tuple[str, str]]:
        """The kinds and files of the given surfaces, without those at the places of their copies."""
        given = (("white", self.source), ("pial", self.pial))
        return [
            (kind, path)
            for kind, path in given
            if path
            and os.path.realpath(path)
            != os.path.realpath(os.path.join(self.folder, names.of(kind)))
        ]


def hemisphere_jobs(
    sources: Sequence[PathLike],
    out: str,
    *,
    to: Sequence[str],
    names: Sequence[Convention],
    labels: Sequence[str],
    reflect: bool,
    hemisphere: str | None,
    pial: str | None = None,
) -> list[HemisphereJob]:
    """Make the jobs of `register_hemispheres`; faults of its arguments are found before any work."""
    if unknown := [convention for convention in names if convention not in CONVENTIONS]:
        raise ValueError(f"unknown names {unknown[0]!r}: choose from {', '.join(CONVENTIONS)}")
    if set("{}") & set(out.replace("{folder}", "").replace("{subject}", "")):
        raise ValueError(f"out {printable(out)}: only {{folder}} and {{subject}} can stand in it")
    asked = SIDES.get(hemisphere or "")
    # of many subjects each file is looked for and read once
    template, fit = cache(_template), cache(_fit)
    jobs = []
    for source in [os.fspath(each) for each in sources]:
        known = asked or structure_of(source).get("structure") or _structure_within(source)
        which = hemisphere_of(source, known)
        places = {"{folder}": os.path.dirname(source) or ".", "{subject}": which.subject}
        outer = (
            partner_of(source)
            if pial is None
            else _filled(fill_sides(pial, which.structure), places)
        )
        there = which.other if reflect else which.structure
        kind = "midthickness" if outer else which.kind
        templates = tuple(template(name, there, kind) for name in to)
        atlases = tuple(
            fit(fill_sides(path, there), templates)
            for path in labels
            if structure_of(fill_sides(path, there)).get("structure", there) == there
        )
        wall = next((atlas for atlas in atlases if wall_of(read_labels(atlas.path))), None)
        folder = _filled(out, places)
        if os.path.exists(folder) and not os.path.isdir(folder):
            raise FileError(f"{folder} is a file; give a folder for the results")
        job = HemisphereJob(
            source,
            "",
            which,
            outer,
            templates,
            atlases,
            folder,
            tuple(Names(convention, which, reflect) for convention in dict.fromkeys(names)),
            wall,
        )
        if "fmriprep" in names:
            _check_complete(job)
        jobs.append(replace(job, target=job.targets[0]))
    check_places(jobs, "use {subject}, and each hemisphere, template and atlas once")
    return jobs


def _check_complete(job: HemisphereJob) -> None:
    """Refuse a hemisphere without the inputs of fMRIPrep's set."""
    needed = {
        "a pial surface beside it": job.pial,
        "labels whose table names the medial wall": job.wall,
        "the templates fsaverage and fsLR": {"fsaverage", "fsLR"}
        <= {each.space for each in job.templates},
    }
    if missing := [words for words, given in needed.items() if not given]:
        raise FileError(f"{job.source}: fMRIPrep's set needs {' and '.join(missing)}")


def _filled(pattern: str, places: dict[str, str]) -> str:
    for field, text in places.items():
        pattern = pattern.replace(field, text)
    return pattern


def wall_of(table: tuple[Label, ...] | None) -> list[int]:
    """The keys of the labels that stand for the medial wall, by the names that FreeSurfer and HCP give them.

    Beside these it has -1, which is no label.
    """
    return [label.key for label in table or () if _WALL.fullmatch(label.name)]


def _structure_within(source: str) -> str | None:
    """Read the side that a GIFTI file names; if it names none or can't be read, None."""
    try:
        return read_mesh(source).metadata.get("structure")
    except (FileError, MeshError):
        return None


def _template(name: str, structure: str, kind: str) -> TemplateFiles:
    """Find the files of a template by its name, or take those of NAME=SURFACE,SPHERE."""
    own, equals, files = name.partition("=")
    if name in TEMPLATES:
        return template_files(name, structure, kind)
    surface, comma, sphere = fill_sides(files, structure).partition(",")
    if not (own and equals and surface and comma and sphere):
        raise ValueError(
            f"to {printable(name)}: give NAME=SURFACE,SPHERE, or one of {', '.join(TEMPLATES)}"
        )
    return TemplateFiles(own, own, kind, sphere, (surface,), len(read_sphere(sphere).v))


def _fit(path: str, templates: tuple[TemplateFiles, ...]) -> LabelFile:
    """Find the template whose labels a file holds, by their number; a MeshError if there is none."""
    maps = read_scalars(path)
    if len(maps) > 1:
        raise MeshError(f"{path} holds {len(maps)} maps; give a file with one map of labels")
    (values,) = maps.values()
    if len(bad := np.flatnonzero(values != np.rint(values))):
        raise MeshError(
            f"{path} has the label {values[bad[0]]:g} at vertex {bad[0]}; give whole numbers"
        )
    fitting = [k for k, template in enumerate(templates) if template.size == len(values)]
    if not fitting:
        there = ", ".join(f"{template.name} has {template.size}" for template in templates)
        raise MeshError(
            f"{path} has {len(values)} labels, but {there} vertices; give labels at the vertices of a "
            "template that is asked for"
        )
    return LabelFile(path, fitting[0])


def describe_datasets(jobs: Sequence[HemisphereJob]) -> None:
    """Describe the results' datasets of BIDS as derivatives: without that its readers see no files."""
    bids = {"bids", "fmriprep"}
    roots = {
        Path(job.folder).resolve()
        for job in jobs
        if bids & {names.convention for names in job.names}
    }
    for root in roots:
        while re.fullmatch(r"anat|(ses|sub)-[A-Za-z0-9]+", root.name):
            root = root.parent
        if root.is_dir() and not (root / "dataset_description.json").exists():
            text = {
                "Name": "Registered cortical surfaces",
                "BIDSVersion": _BIDS_VERSION,
                "DatasetType": "derivative",
                "GeneratedBy": [{"Name": "igl_spheremap", "Version": __version__}],
            }
            with replacing(root / "dataset_description.json") as temporary:
                temporary.write_text(json.dumps(text, indent=2) + "\n", encoding="utf-8")
