"""Many files by one call."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import Any, Literal

from ..errors import check_list, check_listener, check_number, own_errstate
from ..io.formats import format_of
from ..maps.options import Auto, Method, Polish, method_of
from ..mesh.clean import asked_for
from .job import Job, check_places
from .manifest import began
from .mapping import SphereMapping
from .page import check_page, map_sheet, write_page
from .run_many import run_many
from .table import Row

_FIELD = re.compile(r"\{(folder|name|stem)\}")


@own_errstate
def map_many(
    sources: Iterable[str | os.PathLike[str]],
    out: str,
    *,
    executor: Executor | None = None,
    processes: int | None = None,
    method: str | Method = "auto",
    polish: Polish | None = None,
    balance: float = 0.0,
    repair: bool = False,
    weld: float = 0.0,
    keep_largest: bool = False,
    holes: Literal["refuse", "fill"] = "refuse",
    handles: Literal["refuse", "cut"] = "refuse",
    force: bool = False,
    manifest: str | os.PathLike[str] | None = None,
    resume: bool = True,
    retry_failed: bool = False,
    timeout: float | None = None,
    memory: float | None = None,
    retries: int = 1,
    report: str | os.PathLike[str] | None = None,
    listener: Callable[[Row], None] | None = None,
) -> list[Row]:
    """Map many mesh files to spheres, each in a process, and continue where an earlier run ended.

    Whatever is wrong with one file is in its row and does not end the others.

    Parameters
    ----------
    sources : iterable of path-like
        Mesh files.
    out : str
        Where each sphere goes: ``{folder}``, ``{name}`` and ``{stem}`` are those of the source.
    executor : concurrent.futures.Executor, optional
        Who runs the jobs, such as that of a Dask client; by default processes of its own, with one thread each. It is
        not shut down.
    processes : int, optional
        How many processes of its own; by default one for each processor.
    method : str or Method
        A method by its name, or with its options, see `igl_spheremap.spherical_conformal_map`.
    polish : {"auto", "angles"} or None
        That of method "auto" by its name, see `Auto`. By default no steps are taken on good maps, so that all members
        of a population are treated alike. A record of options has its own.
    balance : float
        As of `igl_spheremap.balanced_spherical_map`; 0, the default, is conformal.
    repair : bool
        Repair the meshes first.
    weld, keep_largest, holes, handles
        Options of ``repair=True``, with the meanings and defaults of `igl_spheremap.repair_mesh`.
    force : bool
        Replace files at targets that no run made; without it they are kept, and their rows have the status "file".
    manifest : path-like, optional
        Where inputs, options and results are recorded, as JSON lines; by default in the folder that `out` gives to all
        targets.
    resume : bool
        Take a result from the manifest, as by default, if mesh file, options and version are the same, and the target
        is still what was written.
    retry_failed : bool
        Run again the jobs that the manifest records without a map, as `force` does.
    timeout, memory : float, optional
        Seconds, and MB of memory, after which a job is ended. Memory is read from Linux's /proc.
    retries : int
        How often a job is run again whose worker died; once by default.
    report : path-like, optional
        A page with distributions and pictures of the maps, the worst first: a file that ends in .html, or a folder
        for `index.html`. Needs Pillow.
    listener : callable, optional
        Called with each `Row`, those of earlier runs first; may raise StopIteration to end with what is in flight.

    Returns
    -------
    list of Row
        One for each source that was not left out by an early end, in their order.

    Raises
    ------
    ValueError
        If two sources have the same target, the method is unknown, a repair is chosen without ``repair=True``, or
        limits are given for an executor that can't keep them.
    TypeError
        If `balance` is not a number, the listener can't be called, or `polish` is given beside another method.
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
    check_listener(listener)
    names = [os.fspath(source) for source in check_list(sources, "sources")]
    targets = targets_of(out, names)
    repairs: dict[str, Any] = {"weld": weld, "keep_largest": keep_largest, "holes": holes, "handles": handles}
    asked = asked_for("repair_mesh", **repairs).options
    if asked and not repair:
        raise ValueError(f"{' and '.join(asked)}: only repair=True repairs meshes; give it, too")
    if method != Auto.name and polish is not None:
        raise TypeError("polish: an option of method 'auto' only; give another method its options in its record")
    chosen = Auto(polish=polish) if method == Auto.name else method_of(method)
    task = SphereMapping(chosen, float(balance), repairs if repair else None, force=force, folder=os.getcwd())
    if report is not None:
        check_page(report)
    log = manifest or manifest_of(out)
    jobs = [Job(source, target) for source, target in zip(names, targets, strict=True)]
    rows = run_many(jobs, task, log, executor=executor, processes=processes, resume=resume,
                    retry_failed=retry_failed, timeout=timeout, memory=memory, retries=retries, listener=listener)
    if report is not None:
        write_page(report, rows, map_sheet(rows, task), processes, began=began(log))
    return rows


def targets_of(pattern: str, sources: Sequence[str]) -> list[str]:
    """The pattern with the parts of each source's path.

    Raises a ValueError unless each source has a target of its own, in a format that keeps the order of vertices.

    >>> targets_of("spheres/{stem}.ply", ["a/one.obj", "b/two.obj"])
    ['spheres/one.ply', 'spheres/two.ply']
    """
    targets = [filled(pattern, source, "out ") for source in sources]
    for target in targets:
        if not format_of(target).ordered:
            raise ValueError(f"out gives {target}, whose format keeps no vertex order; give .ply, .obj or .npz")
    check_places(list(map(Job, sources, targets)), "use {folder} or {stem}, and each input once")
    return targets


def manifest_of(pattern: str) -> str:
    """The manifest's place, in the folder that the pattern gives to all targets.

    >>> manifest_of("spheres/{stem}.ply"), manifest_of("{folder}/lh.sphere.conformal")
    ('spheres/stem.ply.manifest.jsonl', 'folder_lh.sphere.conformal.manifest.jsonl')
    """
    folder = pattern.partition("{")[0].rpartition("/")[0]
    name = pattern.removeprefix(f"{folder}/").replace("{", "").replace("}", "").replace("/", "_")
    return str(Path(folder or ("/" if pattern.startswith("/") else ""), f"{name}.manifest.jsonl"))


def filled(pattern: str, source: str, option: str = "") -> str:
    """The pattern with the parts of a source's path; it is not a format string, whose fields can do anything.

    A ValueError, which names the option that the pattern comes from, says if it has other fields.

    >>> filled("{folder}/{stem}.thickness", "a/lh.white.ply")
    'a/lh.white.thickness'
    """
    if set("{}") & set(_FIELD.sub("", pattern)):
        raise ValueError(f"{option}{pattern}: only {{folder}}, {{name}} and {{stem}} can stand in it")
    path = Path(source)
    parts = {"folder": str(path.parent), "name": path.name, "stem": path.stem}
    return _FIELD.sub(lambda field: parts[field[1]], pattern)
