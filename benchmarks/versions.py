"""Results beside those of another version: mean angle differences in degrees, and CPU seconds.

    python -m benchmarks versions CHECKOUT MESH|FOLDER ... [--of maps balance matches disks] [--every K] [--turns 2]
        [--csv FILE] [--polish angles] [--set ROOM.FILE.NAME=NUMBER ...]

CHECKOUT is a checkout of the other version; of a FOLDER, such as those of `gather`, all meshes are taken, or every
K-th. Each version has a process of its own with one thread, after a warm-up; they take turns, mesh by mesh. A ratio of
CPU seconds is that of one turn: the table has the median and the quartiles of all, and the ratio of the sums of the
fastest turns, which FILE gets, a row a mesh. Disks are halves of the meshes, and a mesh is matched with itself,
stretched by a fifth. The mean of a match is the median symmetric Dirichlet energy. A result is worse, or better, if its
mean is off by more than 5 percent and .02. ``--set`` gives constants of CHECKOUT, which may be this one, other values;
NAME is that of a module's or class's constant, or of a function's argument: ``angles.candidates.layouts.deepest=18``.
"""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from argparse import Namespace
from collections.abc import Callable
from dataclasses import asdict, dataclass
from inspect import Parameter, isfunction, ismodule, signature, unwrap
from pathlib import Path
from pkgutil import resolve_name
from typing import Any

import numpy as np
from disks import cut

import igl_spheremap as ism

from .common import ROOT, load, parser, quality, timed

#: Vertices at which the rows of the table begin.
_FROM = (0, 200, 1000, 4000)


@dataclass(frozen=True)
class Row:
    """A mesh, and both versions' results."""

    of: str
    mesh: str
    vertices: int
    mean_before: float
    mean: float
    cpu_before: float
    cpu: float
    certified: bool
    ratios: tuple[float, ...]


def main(argv: list[str]) -> None:
    """Print the table, or, without a turn, a line of JSON for each line that names what to make of which mesh."""
    arguments = parser(__doc__)
    arguments.add_argument("checkout", type=Path)
    arguments.add_argument("sources", nargs="*")
    arguments.add_argument("--of", nargs="+", choices=tuple(KINDS), default=["maps"])
    arguments.add_argument("--every", type=int, default=1, help="take every K-th mesh (1)")
    arguments.add_argument(
        "--turns", type=int, default=2, help="of each version (2); 0: answer lines"
    )
    arguments.add_argument("--csv", type=Path, help="write a row for each mesh")
    arguments.add_argument("--polish", choices=("auto", "angles"), default="auto")
    arguments.add_argument("--set", nargs="+", default=[], metavar="ROOM.FILE.NAME=NUMBER")
    options = arguments.parse_args(argv)
    if not options.turns:
        for assignment in options.set:
            give(*assignment.rpartition("=")[::2])
        for line in sys.stdin:
            print(json.dumps(measured(*line.split(maxsplit=1), options.polish)), flush=True)
        return
    sources = [str(path) for source in options.sources for path in meshes(source)][:: options.every]
    workers = [worker(options.checkout, options, options.set), worker(ROOT, options, [])]
    found = [
        row(
            kind,
            source,
            [[answer(one, kind, source) for one in workers] for _ in range(options.turns)],
        )
        for kind in options.of
        for source in sources
    ]
    report(found, options.csv)


def meshes(source: str) -> list[str | Path]:
    """A mesh, or those of a folder."""
    folder = Path(source)
    return (
        sorted(path for path in folder.rglob("*.*") if path.is_file())
        if folder.is_dir()
        else [source]
    )


def give(constant: str, value: str) -> None:
    """Give another value to a constant of a module or a class, or to the default of a function's argument.

    A public constant of a module gets it in those that have imported it, too.
    """
    path, _, name = constant.rpartition(".")
    home = resolve_name(f"{ism.__name__}.{path}")
    if isfunction(home):
        function = unwrap(home)
        defaults = {
            key: parameter.default
            for key, parameter in signature(function).parameters.items()
            if parameter.default is not Parameter.empty
        }
        defaults[name] = type(defaults[name])(value)
        alone = function.__kwdefaults__ or {}
        function.__defaults__ = tuple(defaults[key] for key in defaults if key not in alone)
        function.__kwdefaults__ = {key: defaults[key] for key in alone}
        return
    number = type(getattr(home, name))(value)
    homes = [home]
    if ismodule(home) and not name.startswith("_"):
        homes = [
            each
            for each in sys.modules.values()
            if each.__name__.startswith(ism.__name__) and name in vars(each)
        ]
    for each in homes:
        setattr(each, name, number)


def worker(version: Path, options: Namespace, constants: list[str]) -> subprocess.Popen[str]:
    """A process that answers lines by a version, warmed up."""
    command = [
        sys.executable,
        "-m",
        "benchmarks",
        "--package",
        str(version),
        "versions",
        str(version),
        "--turns",
        "0",
        "--polish",
        options.polish,
        *(["--set", *constants] if constants else []),
    ]
    process = subprocess.Popen(
        command, cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    for kind in options.of:
        answer(
            process,
            kind,
            "sample:octopus:n_vertices=1500" if kind == "maps" else "sample:pear:n_vertices=600",
        )
    return process


def answer(process: subprocess.Popen[str], kind: str, source: str) -> dict[str, Any]:
    """A process's measures of a mesh."""
    print(kind, source, file=process.stdin, flush=True)
    if not (line := process.stdout.readline()):  # type: ignore[union-attr]
        raise SystemExit(f"{kind} of {source}: {' '.join(map(str, process.args))} ended")  # type: ignore[arg-type]
    return dict(json.loads(line))


def conformal(v: np.ndarray, f: np.ndarray, polish: str) -> tuple[float, dict[str, Any]]:
    """A map to the sphere."""
    result, cpu = timed(lambda: ism.spherical_conformal_map(v, f, method=ism.Auto(polish=polish)))  # type: ignore
    return cpu, quality(v, f, result.sphere)


def balanced(v: np.ndarray, f: np.ndarray, _: str) -> tuple[float, dict[str, Any]]:
    """A balanced map."""
    result, cpu = timed(lambda: ism.balanced_spherical_map(v, f, balance=0.75))
    return cpu, quality(v, f, result.sphere)


def disk(v: np.ndarray, f: np.ndarray, _: str) -> tuple[float, dict[str, Any]]:
    """The conformal map to the disk of the half around the first vertex."""
    w, g = cut(v, f, 0, 0.5)
    result, cpu = timed(lambda: ism.disk_conformal_map(w, g))
    size = np.abs(ism.angle_differences(w, g, np.column_stack((result.plane, np.zeros(len(w))))))
    return cpu, {"foldings": ism.certify(result.plane, g).foldings, "mean": float(size.mean())}


def matched(v: np.ndarray, f: np.ndarray, _: str) -> tuple[float, dict[str, Any]]:
    """A match of the surface with itself, stretched."""
    maps = [ism.spherical_conformal_map(each, f) for each in (v, v * [1.0, 1.0, 1.2])]
    result, cpu = timed(lambda: ism.shapes.match(*maps))
    energy = result.distortion().symmetric_dirichlet
    return cpu, {"foldings": int(not result.map.certificate), "mean": float(np.median(energy))}


KINDS: dict[str, Callable[[np.ndarray, np.ndarray, str], tuple[float, dict[str, Any]]]] = {
    "maps": conformal,
    "balance": balanced,
    "disks": disk,
    "matches": matched,
}


def measured(kind: str, source: str, polish: str) -> dict[str, Any]:
    """Figures of a result, its CPU seconds and the number of vertices."""
    v, f = load(source.strip())
    cpu, figures = KINDS[kind](v, f, polish)
    return figures | {"cpu": cpu, "vertices": len(v)}


def row(kind: str, source: str, turns: list[list[dict[str, Any]]]) -> Row:
    """Both versions' results for a mesh, turn by turn."""
    old, new = (min(version, key=lambda one: one["cpu"]) for version in zip(*turns, strict=True))
    ratios = tuple(after["cpu"] / before["cpu"] for before, after in turns)
    return Row(
        kind,
        Path(source).stem,
        new["vertices"],
        old["mean"],
        new["mean"],
        old["cpu"],
        new["cpu"],
        not new["foldings"],
        ratios,
    )


def report(found: list[Row], file: Path | None) -> None:
    """Print sums, counts and times by the number of vertices, and write the rows to a file."""
    if file is not None:
        with file.open("w", newline="") as opened:
            table = csv.writer(opened, lineterminator="\n")
            names = [name for name in Row.__dataclass_fields__ if name != "ratios"]
            table.writerow(names)
            for each in found:
                cells = [asdict(each)[name] for name in names]
                table.writerow(
                    [f"{cell:.3f}" if isinstance(cell, float) else cell for cell in cells]
                )
    print(
        "| of | vertices | number | sum of means | now | worse / better | CPU ratio: median (quartiles) | 90 % | "
        "of sums | certified |\n|---|---|---:|---:|---:|---:|---:|---:|---:|---:|"
    )
    for kind in dict.fromkeys(each.of for each in found):
        part = [each for each in found if each.of == kind]
        for low, high in zip(_FROM, (*_FROM[1:], np.inf), strict=True):
            if 0 < len(some := [each for each in part if low <= each.vertices < high]) < len(part):
                print(summary(f"{kind} | from {low:,}", some))
        print(summary(f"{kind} | all", part))


def summary(name: str, found: list[Row]) -> str:
    """A row of the table."""
    before, now, cpu_before, cpu = np.array(
        [(r.mean_before, r.mean, r.cpu_before, r.cpu) for r in found]
    ).T
    worse, better = (
        (a > np.maximum(1.05 * b, b + 0.02)).sum() for a, b in ((now, before), (before, now))
    )
    first, median, third, ninth = np.percentile(
        [ratio for r in found for ratio in r.ratios], [25, 50, 75, 90]
    )
    return (
        f"| {name} | {len(found)} | {before.sum():.1f} | {now.sum():.1f} | {worse} / {better} | {median:.2f} "
        f"({first:.2f} to {third:.2f}) | {ninth:.2f} | {cpu.sum() / cpu_before.sum():.2f} | "
        f"{sum(r.certified for r in found)} |"
    )
