"""The task of registering a hemisphere's surface to templates: from a white surface to what pipelines expect."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import chain
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from ..._version import __version__
from ...draw.plot import BEHIND, raster, shading
from ...errors import FileError, FoldingsRemain, MeshError, own_errstate
from ...io.files import read_mesh, read_sphere, write_mesh
from ...io.formats import CONVENTIONS, Convention
from ...io.gifti import structure_of
from ...io.hemispheres import SIDES, Hemisphere, Names, atlas_of, fill_sides, hemisphere_of, partner_of
from ...io.records import Label, LoadedMesh
from ...io.replacing import REPLACE, make_folder, replacing
from ...io.scalars import read_labels, read_scalars, write_scalars
from ...io.templates import TEMPLATES, TemplateFiles, template_files
from ...io.textured import write_picture
from ...io.written_map import make_mark, read_mark, write_sphere
from ...maps.balanced import balanced_spherical_map
from ...maps.given_sphere import sphere_map
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.measure import surface_area, vertex_areas
from ...operators.features import depth_potential
from ...populations.job import Job, Task
from ...populations.manifest import began
from ...populations.page import LATERAL, Sheet, check_page, is_newer, share_certified, write_page
from ...populations.run_many import run_many
from ...populations.table import MAPPED, RegistrationRow
from ...resampling.transfer import resample, transfer
from ..correspondence.registration import Registration, reflected, register
from .labels import label_margin

#: Balance of the subjects' own maps: it comes nearest to FreeSurfer's spheres (docs/guide/freesurfer.md).
_BALANCE = 0.85
#: Widths of the depth potentials that are like FreeSurfer's sulc and curv, see `depth_potential`.
_SULC, _CURV = 0.12, 0.05
#: Radians by which registrations are off along each axis: a median of 1.9 mm on fsaverage (docs/correspondence.md),
#: which is 1.18 standard deviations of two axes, on a sphere of 74 mm that has its area.
_ERROR = 1.9 / 1.18 / 74
_UNSURE = 0.5  # a margin below it: less than three quarters of what lies within the error has the label
_BIDS_VERSION = "1.10.0"
#: Pixels of each view; greys of the deepest and the highest folds; brightness of faces that the light grazes; colour.
_SIZE, _DARK, _LIGHT, _AMBIENT = 260, 0.35, 0.95, 0.75
_BORDER = (0.8, 0.15, 0.1)
_REACH = 2.0  # standard deviations of depth to either side, where the greys end


@dataclass(frozen=True)
class LabelFile:
    """A file of labels on a template of a job, by its place there."""

    path: str
    template: int


@dataclass(frozen=True)
class HemisphereJob(Job):
    """A hemisphere, the pial surface beside it if there is one, its templates and atlases, and where the files go."""

    hemisphere: Hemisphere
    pial: str | None
    templates: tuple[TemplateFiles, ...]
    atlases: tuple[LabelFile, ...]
    folder: str
    names: tuple[Names, ...]

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
        """Of the surface that is registered."""
        return "midthickness" if self.pial else self.hemisphere.kind

    def files(self, names: Names) -> list[str]:
        """The files of one convention, registered spheres first."""
        return [os.path.join(self.folder, name) for name in self._files(names)]

    def _files(self, names: Names) -> Iterator[str]:
        for template in self.templates:
            yield names.registered(template.space)
        yield names.surface("sphere")
        yield from (names.scalars("sulc"), names.scalars("curv"), names.scalars("area"))
        if self.pial:
            yield names.surface("midthickness")
        for template in self.templates:
            yield names.distortion(template.space)
            yield names.resampled(template.space, template.size, self.kind)
        for atlas in self.atlases:
            yield from (names.labels(atlas_of(atlas.path)), names.margin(atlas_of(atlas.path)))


@dataclass(frozen=True)
class SphereRegistration(Task[HemisphereJob]):
    """How hemispheres are registered: as they are, or their mirror images to the other side."""

    reflect: bool = False

    def empty(self, job: HemisphereJob) -> RegistrationRow:
        return RegistrationRow(job.source, job.target)

    def surface(self, job: HemisphereJob) -> tuple[LoadedMesh, FloatArray]:
        """The surface that was given, and the positions of what is registered: the midthickness, if there is a pial."""
        given = read_mesh(self.place(job.source))
        if job.pial is None:
            return given, given.v
        v, f = read_mesh(self.place(job.pial))
        if len(v) != len(given.v) or not np.array_equal(f, given.f):
            raise MeshError(f"{job.pial} has other vertices or faces than {job.source}; give surfaces of one mesh, or "
                            "take it out of that folder")
        return given, (given.v + v) / 2

    def template(self, job: HemisphereJob, k: int) -> SphereMap:
        """A template of a job with its sphere."""
        files = job.templates[k]
        v, f, x = replace(files, sphere=self.place(files.sphere), surfaces=tuple(self.places(files.surfaces))).read()
        try:
            return sphere_map(v, f, x)
        except (MeshError, FoldingsRemain) as error:
            raise FileError(f"{files.sphere} with {' and '.join(files.surfaces)}: {error}") from None

    def run(self, job: HemisphereJob, check: Callable[[], None]) -> RegistrationRow:
        """Read, map, register to each template, write."""
        given, v = self.surface(job)
        templates = [self.template(job, k) for k in range(len(job.templates))]
        atlases = [(atlas, *self._atlas(atlas)) for atlas in job.atlases]
        check()
        mark = make_mark(v, given.f, "sphere-reg", {"balance": _BALANCE})
        self._refuse(job, mark)
        own = balanced_spherical_map(v, given.f, balance=_BALANCE)
        found = [register(own, template, reflect=self.reflect) for template in templates]
        spheres = [reflected(each.map) if self.reflect else each.map for each in found]  # they fit the surface as it is
        taken = [label_margin(templates[atlas.template], values, found[atlas.template].map.sphere, _ERROR)
                 for atlas, values, _ in atlases]
        make_folder(self.place(job.folder))
        foldings = moved = 0
        for names in job.names:
            writer = _Writer(self.place(job.folder), names, given, mark)
            writer.sphere(names.surface("sphere"), own.sphere)  # the first, since its mark tells whose the others are
            for files, sphere in zip(job.templates, spheres, strict=True):
                writer.sphere(names.registered(files.space), sphere.sphere)
            writer.features(own, given.v)
            if job.pial:
                writer.surface(names.surface("midthickness"), v, given.f)
            for files, template, each, sphere in zip(job.templates, templates, found, spheres, strict=True):
                ratio = vertex_areas(sphere.sphere, given.f) / vertex_areas(own.sphere, given.f)
                writer.scalars(names.distortion(files.space), "arealdistortion", np.log2(ratio))
                side = job.hemisphere.other if self.reflect else job.hemisphere.structure
                on_template, faces = resample(each.map, template)
                writer.surface(names.resampled(files.space, files.size, job.kind), on_template, faces, side)
            for (atlas, _, table), (labels, margin) in zip(atlases, taken, strict=True):
                writer.labels(names.labels(atlas_of(atlas.path)), atlas_of(atlas.path), labels, table)
                writer.scalars(names.margin(atlas_of(atlas.path)), "margin", margin)
            foldings, moved = foldings + writer.foldings, moved + writer.moved
        return replace(self.empty(job), **_figures(found, [margin for _, margin in taken]), vertices=len(v),
                       status="folded" if foldings else "certified", foldings=foldings,
                       notes="; ".join(_notes(job, found, moved)))

    def _atlas(self, atlas: LabelFile) -> tuple[IntArray, tuple[Label, ...] | None]:
        path = self.place(atlas.path)
        (values,) = read_scalars(path).values()
        return values.astype(np.int64), read_labels(path)

    def _refuse(self, job: HemisphereJob, mark: str) -> None:
        """Raise a FileError if files are there beside which this task's own sphere of this surface is not."""
        for names in job.names:
            there = [target for target in job.files(names) if os.path.lexists(self.place(target))]
            sphere = self.place(os.path.join(job.folder, names.surface("sphere")))
            if there and not self.force and not (os.path.isfile(sphere) and read_mark(sphere) == mark):
                raise FileError(f"{there[0]} exists, and not from this version and surface; it is kept, {REPLACE} "
                                "replaces it")


def _figures(found: Sequence[Registration], margins: Sequence[FloatArray]) -> dict[str, Any]:
    """The figures of the worst template and the worst atlas."""
    ends = [each.stages[-1] for each in found]
    return {"unlike": max(1 - float(end.correlation.mean()) for end in ends),
            "mean_area": max(end.strain for end in ends), "p95_area": max(end.strain_95 for end in ends),
            "unsure": max((float((margin < _UNSURE).mean()) for margin in margins), default=np.nan)}


def _notes(job: HemisphereJob, found: Sequence[Registration], moved: int) -> Iterator[str]:
    for files, each in zip(job.templates, found, strict=True):
        if files.kind != job.kind:
            yield f"{files.name} has no {job.kind} surface here: its {files.kind} was taken"
        yield from (f"{files.name}: {note}" for note in each.notes)
    if moved:
        yield f"{moved} vertices moved to keep float32 from folding"


class _Writer:
    """Writes the files of one convention, with what the source says of itself, and counts what folds in them."""

    def __init__(self, folder: str, names: Names, given: LoadedMesh, mark: str) -> None:
        self._folder, self._names, self._area = folder, names, surface_area(given.v, given.f)
        self._f, self._given = given.f, given.metadata
        self._metadata = {"structure": names.hemisphere.structure, "mark": mark}
        self._turn = -1.0 if names.convention == "hcp" else 1.0  # HCP's sulc and curvature are high on gyri
        self.foldings = self.moved = 0

    def sphere(self, name: str, x: FloatArray) -> None:
        """A sphere about the origin: the coordinate system of the surface is not its own, the volume's geometry is."""
        volume = {"volume": self._given["volume"]} if "volume" in self._given else {}
        written = write_sphere(self._path(name), x, self._f, force=True, metadata=self._metadata | volume)
        self.foldings += written.certificate.foldings
        self.moved += written.moved

    def surface(self, name: str, v: FloatArray, f: IntArray, structure: str | None = None) -> None:
        """A surface in the coordinates of the source."""
        metadata = dict(self._given) | self._metadata | ({"structure": structure} if structure else {})
        write_mesh(self._path(name), v, f, force=True, metadata=metadata)

    def features(self, own: SphereMap, v: FloatArray) -> None:
        """What FreeSurfer calls sulc and curv, in mm and 1/mm, and the areas of the given surface's vertices."""
        unit = np.sqrt(surface_area(own.vertices, own.faces) / (4 * np.pi))
        sulc, curv = (-self._turn * depth_potential(own.vertices, own.faces, ell=ell) for ell in (_SULC, _CURV))
        self.scalars(self._names.scalars("sulc"), "sulc", unit * sulc)
        self.scalars(self._names.scalars("curv"), "curv", curv / (2 * _CURV**2 * unit))  # the potential is 2 H ell^2
        self.scalars(self._names.scalars("area"), "area", vertex_areas(v, own.faces))

    def scalars(self, name: str, quantity: str, values: FloatArray) -> None:
        """Data at the vertices."""
        write_scalars(self._path(name), {quantity: values}, force=True, metadata=self._metadata)

    def labels(self, name: str, atlas: str, values: IntArray, table: tuple[Label, ...] | None) -> None:
        """Labels with their table, to which GIFTI files add what has none."""
        table = table or tuple(Label(key, str(key), _colour(key)) for key in np.unique(values).tolist())
        if not name.endswith(".annot") and (values < 0).any():
            table = (*table, Label(-1, "???", (0.0, 0.0, 0.0, 0.0)))
        whole = values.astype(np.float64)
        write_scalars(self._path(name), {atlas: whole}, force=True, metadata=self._metadata | {"labels": table})

    def _path(self, name: str) -> str:
        return os.path.join(self._folder, name)


def _colour(key: int) -> tuple[float, float, float, float]:
    """A colour for a label that has none: an odd factor gives each of 2^24 keys its own."""
    code = key * 0x9E3779B1 & 0xFFFFFF
    return (code >> 16) / 255, (code >> 8 & 255) / 255, (code & 255) / 255, 1.0


@own_errstate
def register_hemispheres(
    sources: Sequence[str | os.PathLike[str]],
    out: str,
    *,
    to: Sequence[str] = ("fsaverage",),
    names: Sequence[Convention] = ("bids",),
    labels: Sequence[str] = (),
    reflect: bool = False,
    hemisphere: Literal["L", "R"] | None = None,
    executor: Executor | None = None,
    processes: int | None = None,
    force: bool = False,
    manifest: str | os.PathLike[str] | None = None,
    resume: bool = True,
    retry_failed: bool = False,
    timeout: float | None = None,
    memory: float | None = None,
    retries: int = 1,
    report: str | os.PathLike[str] | None = None,
    listener: Callable[[RegistrationRow], None] | None = None,
) -> list[RegistrationRow]:
    """Register cortical surfaces to templates, and write the files that pipelines expect.

    Of each hemisphere: its sphere, the sphere registered to each template, the logarithm to base 2 of how registration
    changed areas, what FreeSurfer calls sulc, curv and area, and the surface with the vertices of each template. If
    the pial surface lies beside a white one, their midthickness is registered, and written, too. Spheres have radius
    100 and are certified as they are written.

    Parameters
    ----------
    sources : sequence of path-like
        White surfaces, one a hemisphere, or midthickness or pial ones.
    out : str
        The folder for the files, made if it is missing: ``{folder}`` is that of the source, ``{subject}`` its subject.
    to : sequence of str
        Templates: fsaverage (the default), fsaverage3 to 7, fsLR, from the folders that `template_files` lists, or
        ``NAME=SURFACE,SPHERE``, files of which ``{hemi}`` is lh or rh and ``{side}`` L or R.
    names : sequence of {"bids", "freesurfer", "hcp"}
        By whose conventions files are named. FreeSurfer's are written in its formats, the others as GIFTI. HCP's sulc
        and curvature have the other sign.
    labels : sequence of str
        Files of labels at the vertices of a template, which are carried to the surfaces, each with its margin, see
        `label_margin`. ``{hemi}`` and ``{side}`` are as above; files whose names tell another side are left out.
    reflect : bool
        Register mirror images to the templates of the other side; the spheres fit the surfaces as they are, and the
        names of the files say ``mirrored``.
    hemisphere : {"L", "R"}, optional
        The side, where neither names nor files tell it.
    executor, processes, force, manifest, resume, retry_failed, timeout, memory, retries, report
        As of `igl_spheremap.map_many`; the page shows the atlases' borders, or those between folds, on each surface
        beside the template.
    listener : callable, optional
        Called with each row; may raise StopIteration to end with what is in flight.

    Returns
    -------
    list of RegistrationRow
        One for each source, in their order.

    Raises
    ------
    ValueError
        If a name is unknown, or two files would have one place.
    FileError
        If a template is not found, a side is not known, or the manifest can't be written.
    MeshError
        If no template has as many vertices as a file has labels.

    Examples
    --------
    >>> import os, tempfile
    >>> import igl_spheremap as ism
    >>> from igl_spheremap.shapes.cortices.sphere_registration import register_hemispheres
    >>> v, f = ism.samples.make("pear", n_vertices=500)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     surface, sphere = (os.path.join(folder, name) for name in ("template.ply", "sphere.ply"))
    ...     ism.write_mesh(surface, v, f)
    ...     _ = ism.write_map(sphere, ism.balanced_spherical_map(v, f))
    ...     source = os.path.join(folder, "sub-01_hemi-L_white.ply")
    ...     ism.write_mesh(source, 1.1 * v, f)
    ...     (row,) = register_hemispheres([source], folder, to=[f"mine={surface},{sphere}"], processes=1)
    ...     sorted(name for name in os.listdir(folder) if name.startswith("sub-01_hemi-L_space"))[1]
    'sub-01_hemi-L_space-mine_desc-reg_arealdistortion.shape.gii'
    >>> row.status, row.unlike < 0.1
    ('certified', True)
    """
    jobs = hemisphere_jobs(sources, out, to=to, names=names, labels=labels, reflect=reflect, hemisphere=hemisphere)
    if report is not None:
        check_page(report)
    task = SphereRegistration(reflect=reflect, force=force, folder=os.getcwd())
    log = manifest or registration_manifest(out)
    rows = run_many(jobs, task, log, executor=executor, processes=processes, resume=resume, retry_failed=retry_failed,
                    timeout=timeout, memory=memory, retries=retries, listener=listener)
    describe_datasets(jobs)
    if report is not None:
        write_page(report, rows, registration_sheet(rows, jobs, task), processes, began=began(log))
    return rows


def registration_manifest(out: str) -> str:
    """The manifest's place: the folder that the pattern gives to all files, which is made if it is missing.

    >>> registration_manifest("./{subject}/surf").replace(os.sep, "/")
    './sphere-reg.manifest.jsonl'
    """
    folder = out if "{" not in out else os.path.dirname(out.partition("{")[0])
    make_folder(folder)
    return os.path.join(folder, "sphere-reg.manifest.jsonl")


def hemisphere_jobs(
    sources: Sequence[str | os.PathLike[str]],
    out: str,
    *,
    to: Sequence[str],
    names: Sequence[Convention],
    labels: Sequence[str],
    reflect: bool,
    hemisphere: str | None,
) -> list[HemisphereJob]:
    """The jobs of `register_hemispheres`; what is wrong with its arguments is found before any work."""
    if unknown := [convention for convention in names if convention not in CONVENTIONS]:
        raise ValueError(f"unknown names {unknown[0]!r}: choose from {', '.join(CONVENTIONS)}")
    if set("{}") & set(out.replace("{folder}", "").replace("{subject}", "")):
        raise ValueError(f"out {out}: only {{folder}} and {{subject}} can stand in it")
    asked = SIDES.get(hemisphere or "")
    template, fit = cache(_template), cache(_fit)  # of many subjects each file is looked for and read once
    places: dict[str, str] = {}
    jobs = []
    for source in [os.fspath(each) for each in sources]:
        known = asked or structure_of(source).get("structure") or _structure_within(source)
        which = hemisphere_of(source, known)
        pial = partner_of(source)
        there = which.other if reflect else which.structure
        kind = "midthickness" if pial else which.kind
        templates = tuple(template(name, there, kind) for name in to)
        atlases = tuple(fit(fill_sides(path, there), templates) for path in labels
                        if structure_of(fill_sides(path, there)).get("structure", there) == there)
        folder = out.replace("{folder}", os.path.dirname(source) or ".").replace("{subject}", which.subject)
        if os.path.exists(folder) and not os.path.isdir(folder):
            raise FileError(f"{folder} is a file; give a folder for the results")
        job = HemisphereJob(source, "", which, pial, templates, atlases, folder,
                            tuple(Names(convention, which, reflect) for convention in dict.fromkeys(names)))
        jobs.append(replace(job, target=job.targets[0]))
        for read in job.sources:
            places.setdefault(os.path.realpath(read), "an input")
    for job in jobs:
        for target in job.targets:
            place = os.path.realpath(target)
            if place in places:
                raise ValueError(f"out gives {job.source} the file {target}, which is {places[place]} already: use "
                                 "{subject}, and each hemisphere, template and atlas once")
            places[place] = f"that of {job.source}"
    return jobs


def _structure_within(source: str) -> str | None:
    """The side that a file of GIFTI names; None where there is none, or the file can't be read."""
    try:
        return read_mesh(source).metadata.get("structure")
    except (FileError, MeshError):
        return None


def _template(name: str, structure: str, kind: str) -> TemplateFiles:
    """The files of a template by its name, or of NAME=SURFACE,SPHERE."""
    own, equals, files = name.partition("=")
    if name in TEMPLATES:
        return template_files(name, structure, kind)
    surface, comma, sphere = fill_sides(files, structure).partition(",")
    if not (own and equals and surface and comma and sphere):
        raise ValueError(f"to {name}: give NAME=SURFACE,SPHERE, or one of {', '.join(TEMPLATES)}")
    return TemplateFiles(own, own, kind, sphere, (surface,), len(read_sphere(sphere).v))


def _fit(path: str, templates: tuple[TemplateFiles, ...]) -> LabelFile:
    """The template whose labels a file holds, by their number; a MeshError if there is none."""
    maps = read_scalars(path)
    if len(maps) > 1:
        raise MeshError(f"{path} holds {len(maps)} maps; give a file with one map of labels")
    (values,) = maps.values()
    fitting = [k for k, template in enumerate(templates) if template.size == len(values)]
    if not fitting:
        there = ", ".join(f"{template.name} has {template.size}" for template in templates)
        raise MeshError(f"{path} has {len(values)} labels, but {there} vertices; give labels at the vertices of a "
                        "template that is asked for")
    return LabelFile(path, fitting[0])


def describe_datasets(jobs: Sequence[HemisphereJob]) -> None:
    """Say of the results' datasets of BIDS that they are derivatives: its readers see no files without that."""
    roots = {Path(job.folder).resolve() for job in jobs if any(names.convention == "bids" for names in job.names)}
    for root in roots:
        while re.fullmatch(r"anat|(ses|sub)-[A-Za-z0-9]+", root.name):
            root = root.parent
        if root.is_dir() and not (root / "dataset_description.json").exists():
            text = {"Name": "Registered cortical surfaces", "BIDSVersion": _BIDS_VERSION, "DatasetType": "derivative",
                    "GeneratedBy": [{"Name": "igl_spheremap", "Version": __version__}]}
            with replacing(root / "dataset_description.json") as temporary:
                temporary.write_text(json.dumps(text, indent=2) + "\n", encoding="utf-8")


def registration_sheet(
    rows: Sequence[RegistrationRow], jobs: Sequence[HemisphereJob], task: SphereRegistration
) -> Sheet:
    """The pictures of registrations: each surface beside the template, both with the same borders."""
    by_target = {job.target: job for job in jobs}
    return Sheet(
        "Registered surfaces", f"{share_certified(rows)} registrations are certified free of foldings", "registrations",
        lambda row: partial(draw_registration, row, job=by_target[row.target], task=task), "borders",
        (("border", _BORDER), ("fold inwards", (_DARK,) * 3)),
        lambda row: f"correlation {1 - row.unlike:.3f}, areas {row.mean_area:.3g}"
                    + (f", {row.unsure:.0%} of the labels unsure" if np.isfinite(row.unsure) else ""),
        lambda row: "The surface beside the template, from the side, then from the middle, a row for each template; "
                    "borders are the template's.",
        lambda row: ("view", row.source, row.target),
    )  # fmt: skip


def draw_registration(row: RegistrationRow, path: str, job: HemisphereJob, task: SphereRegistration) -> bool:
    """Draw a surface beside each of its templates with the template's borders, unless the picture is newer."""
    if row.status not in MAPPED:
        return False
    if is_newer(path, task.place(row.target)):
        return True
    given, v = task.surface(job)
    side = LATERAL[job.hemisphere.other if task.reflect else job.hemisphere.structure].T
    drawn = []
    for k, registered in enumerate(job.targets[: len(job.templates)]):
        own = sphere_map(v, given.f, read_sphere(task.place(registered)).v)
        own, template = reflected(own) if task.reflect else own, task.template(job, k)
        atlas = next((atlas for atlas in job.atlases if atlas.template == k), None)
        depth = depth_potential(template.vertices, template.faces, ell=_SULC)
        regions = (depth > 0).astype(np.int64) if atlas is None else next(iter(
            read_scalars(task.place(atlas.path)).values())).astype(np.int64)
        pairs = ((own, transfer(template, regions, own, labels=True)), (template, regions))
        views = [_views(surface, labels, (side, side * BEHIND)) for surface, labels in pairs]
        drawn.append(np.concatenate([tile for tiles in zip(*views, strict=True) for tile in tiles], axis=1))
    write_picture(path, np.concatenate(drawn), force=True)
    return True


def _views(surface: SphereMap, labels: IntArray, views: Sequence[FloatArray]) -> Iterator[NDArray[np.uint8]]:
    """Views of a surface, grey by its folds, with the borders of labels."""
    v, f = surface.vertices, surface.faces
    depth = depth_potential(v, f, ell=_SULC)
    grey = np.clip(depth[f].mean(axis=1) / (2 * _REACH * depth.std()) + 0.5, 0, 1)
    folds = np.tile((_DARK + (_LIGHT - _DARK) * grey)[:, None], (1, 3))
    for view in views:
        colours = folds * shading(v, f, view, _AMBIENT)[:, None]
        colours[np.ptp(labels[f], axis=1) > 0] = _BORDER
        yield raster(v @ view, f, colours, _SIZE)
