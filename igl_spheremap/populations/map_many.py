"""Many files by one call."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ..balance import CONFORMAL
from ..errors import check_list, check_number, printable, shown
from ..gate import PathLike, gate
from ..io.files import own_name
from ..io.formats import format_of, stem_of
from ..maps.options import Auto, Method, method_of
from ..mesh_repair import REPAIRS
from ..mesh_repair.repair_mesh import asked_for
from .engine import USUAL, Engine
from .job import Job, check_places
from .mapping import SphereMapping
from .page import check_page, map_sheet, write_population_page
from .run_many import run_many
from .table import Row

_FIELD = re.compile(r"\{(folder|name|stem)\}")
_OF_MESHES = ("weld", "keep_largest", "holes", "handles")


@gate
def map_many(
    sources: Iterable[PathLike],
    out: str,
    *,
    method: str | Method = "auto",
    balance: float = CONFORMAL,
    repair: bool | Mapping[str, Any] = False,
    force: bool = False,
    manifest: PathLike | None = None,
    engine: Engine = USUAL,
    report: PathLike | None = None,
    listener: Callable[[Row], None] | None = None,
) -> list[Row]:
    """Map many mesh files to spheres, each in a process, and continue where an earlier run ended.

    The faults of one file are in its row and do not end the others.

    Parameters
    ----------
    sources : iterable of path-like
        Mesh files.
    out : str
        Path of each sphere: ``{folder}``, ``{name}`` and ``{stem}`` are those of the source.
    method : str or Method
        A method by its name, or with its options, see `igl_spheremap.spherical_conformal_map`. By the name "auto" no
        steps are taken on good maps, so that all members of a population are treated alike: ``Auto(polish=None)``.
    balance : float
        As of `igl_spheremap.balanced_spherical_map`; 0, the default, is conformal.
    repair : bool or mapping
        Repair the meshes first; a mapping has options of `igl_spheremap.repair_mesh`.
    force : bool
        Replace files at targets that no run made; without it they are kept, and their rows have the status "file".
    manifest : path-like, optional
        Record of inputs, options and results, as JSON lines; by default in the folder that `out` gives to all targets.
    engine : Engine
        The executor of the jobs, repeats, and limits; by default a process for each processor.
    report : path-like, optional
        A page with distributions and pictures of the maps, the worst first: a file that ends in .html, or a folder
        for `index.html`. Needs Pillow.
    listener : callable, optional
        Called with each `Row`, those of earlier runs first; may raise StopIteration to end with the jobs in flight.

    Returns
    -------
    list of Row
        One for each source that was not left out by an early end, in their order.

    Raises
    ------
    ValueError
        If two sources have the same target, or the method or an option of the repair is unknown.
    TypeError
        If `balance` is not a number, or the listener can't be called.
    FileError
        If the manifest can't be written, or another run writes it; of a report, if Pillow is missing.
    WorkersUnavailable
        If the scheduler of the executor is gone, or a worker has another version.

    Examples
    --------
    >>> import os, tempfile
    >>> import igl_spheremap as ism
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     sources = [os.path.join(folder, f"{size}.ply") for size in (300, 400)]
    ...     for size, source in zip((300, 400), sources):
    ...         ism.write_mesh(source, *ism.samples.make("spheroid", n_vertices=size))
    ...     rows = ism.map_many(sources, "{folder}/{stem}_sphere.ply", manifest=os.path.join(folder, "all.jsonl"))
    >>> [row.status for row in rows]
    ['certified', 'certified']
    """
    check_number(balance, "balance", most=1)
    names = []
    for source in check_list(sources, "sources"):
        if not isinstance(source, str | os.PathLike):
            raise TypeError(f"sources is {shown(source)}; give the name of a file")
        names.append(os.fspath(source))
    targets = targets_of(out, names)
    repairs: dict[str, Any] | None = None
    if repair is not False:
        repairs = {name: REPAIRS[name] for name in _OF_MESHES}
        if isinstance(repair, Mapping):
            repairs |= repair
        if unknown := [name for name in repairs if name not in _OF_MESHES]:
            raise ValueError(
                f"repair has {unknown[0]!r}; give options of repair_mesh: {', '.join(_OF_MESHES)}"
            )
        asked_for("repair_mesh", **repairs)
    chosen: Method = Auto(polish=None)
    if method != Auto.name:
        chosen = method_of(method)
    task = SphereMapping(chosen, float(balance), repairs, force=force, folder=os.getcwd())
    if report is not None:
        check_page(report)
    if not manifest:
        manifest = manifest_of(out)
    jobs = [Job(source, target) for source, target in zip(names, targets, strict=True)]
    rows = run_many(jobs, task, manifest, engine, listener)
    if report is not None:
        write_population_page(report, rows, map_sheet(rows, task), engine.processes)
    return rows


def targets_of(pattern: str, sources: Sequence[str]) -> list[str]:
    """The pattern with the parts of each source's path.

    Raises a ValueError unless each source has a target of its own, in a format that keeps the order of vertices.

    >>> targets_of("spheres/{stem}.ply", ["a/one.obj", "b/two.obj"])
    ['spheres/one.ply', 'spheres/two.ply']
    """
    if "{" not in pattern and not Path(pattern).suffix:
        name = printable(str(Path(pattern)))
        raise ValueError(f"out {name} has no ending; give '{name}/{{stem}}.ply'")
    targets = [filled(pattern, source, "out ") for source in sources]
    for target in targets:
        if not format_of(target).ordered:
            raise ValueError(
                f"out gives {printable(target)}, whose format keeps no vertex order; give .ply, .obj or .npz"
            )
    check_places(list(map(Job, sources, targets)), "use {folder} or {stem}, and each input once")
    return targets


def manifest_of(pattern: str, kind: str = "maps") -> str:
    """The manifest's place, in the folder that the pattern gives to all targets.

    >>> manifest_of("spheres/{stem}.ply"), manifest_of("{folder}/lh.sphere.conformal")
    ('spheres/maps.manifest.jsonl', 'maps.manifest.jsonl')
    """
    return os.path.join(os.path.dirname(pattern.partition("{")[0]), f"{kind}.manifest.jsonl")


def filled(pattern: str, source: str, option: str = "") -> str:
    """The pattern with the parts of a source's path; it is not a format string, whose fields can do anything.

    Other fields are a ValueError, which names the option of the pattern.

    >>> filled("{folder}/{stem}.thickness", "a/lh.white.ply")
    'a/lh.white.thickness'
    >>> filled("{stem}.ply", "labels.nii.gz:3")
    'labels_3.ply'
    """
    if set("{}") & set(_FIELD.sub("", pattern)):
        raise ValueError(
            f"{option}{printable(pattern)}: only {{folder}}, {{name}} and {{stem}} can stand in it"
        )
    path = own_name(source)
    parts = {"folder": str(path.parent), "name": path.name, "stem": stem_of(path)}
    return _FIELD.sub(lambda field: parts[field[1]], pattern)
