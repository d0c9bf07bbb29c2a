"""Time, memory and quality of this package beside its peers, measured in one run.

    python -m benchmarks peers [--meshes FILE ...] [--levels 3] [--only COMPETITOR ...]

Each mesh, by default a sample, is loop-subdivided. Competitors take turns, each in a process of its own, with one
thread and after a warm-up; figures are medians over the rounds. Writes docs/benchmarks.md and its picture. The page is
made by

    python -m benchmarks peers --meshes fsaverage5_pial_left.obj --smallest 20000
    python -m benchmarks peers --meshes paper_brain_15002.obj sample:dino --levels 0 --add

With `--meshes` alone nothing is measured, and the picture is drawn of the page as it is.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import platform
import re
import statistics
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import igl
import numpy as np
import scipy.sparse as sp

import igl_spheremap as ism
from igl_spheremap.mesh.measure import vertex_areas
from igl_spheremap.operators.factor.factorize import factorize
from igl_spheremap.operators.laplacian import laplacian

from .common import DOCS, IMAGES, ROOT, in_process, load, measured, parser, pyplot, quality

Array = np.ndarray
Competitor = Callable[[Array, Array], "Array | ism.SphereMap"]

_PAGE = re.MULTILINE | re.DOTALL
#: Flow: stop when the radius varies by less than this share of it, or after this many steps.
_ROUND, _FLOW_STEPS = 1e-3, 60
#: Flow: length of a step in time, the surface being scaled to unit area.
_FLOW_TIME = 1.0
#: Rounds for meshes of up to this many vertices.
ROUNDS = ((300_000, 3), (10**9, 1))
#: A competitor that took more CPU seconds than this is not repeated.
LONG = 20.0

HEADER = """# Benchmarks

Time, memory and quality beside other programs, by `python -m benchmarks peers`. CPU seconds from arrays to result,
certificate included for this package; medians over rounds in which the competitors take turns, with one thread, on a
busy machine, so only ratios count. *Memory* is the growth of the peak in MB. *Foldings* are exact; *mean* and
*99 %* are of the angle differences in degrees. *Speed-up* is CPU time of the row over that of `ours` with each backend:
`cvxopt`, `rslab` (the extra `fast`), `scipy` (always there). *Over factor* is CPU time (memory) over those of ordering
and factorisation alone. Compare like with like: `LaPy` factorises by scipy, too, unless it says `cholespy`.

- `LaPy`: `lapy.conformal.spherical_conformal_map`, as it ships; `no refusals`: with its refusals of denominators
  below an absolute 1e-8 switched off; `cholespy`: the same with its optional Cholesky factorisation.
- `mean curvature flow`: conformalised (Kazhdan, Solomon, Ben-Chen 2012), as in `benchmarks/peers.py`,
  factorised by the fastest backend here.
- `lai2014`: the paper's Algorithm 2 around Algorithm 1, up to 20,000 vertices.

Machine: {machine}, Python {python}; igl_spheremap {version}.

![Time against size](images/benchmarks.png)

## In short

Times are of one thread, by `python -m benchmarks tables others`:

<!-- table others -->
<!-- end -->
"""
COLUMNS = ("competitor", "CPU s", "memory", "foldings", "mean", "99 %", "speed-up", "over factor")


def ours(v: Array, f: Array, **options: str) -> ism.SphereMap:
    """This package, its certificate included."""
    return ism.spherical_conformal_map(v, f, **options)


def lapy(v: Array, f: Array, guarded: bool = True, use_cholmod: bool = False) -> Array:
    """LaPy's linear method (after Choi, Lam, Lui 2015), as it ships or with its refusals switched off."""
    from lapy import TriaMesh, conformal

    with np.errstate(all="ignore"):
        if guarded:
            return conformal.spherical_conformal_map(TriaMesh(v, f), use_cholmod=use_cholmod)
        with _without_refusals(conformal):
            return conformal.spherical_conformal_map(TriaMesh(v, f), use_cholmod=use_cholmod)


@contextmanager
def _without_refusals(conformal: object) -> Iterator[None]:
    """LaPy divides by what it finds, instead of refusing denominators below an absolute 1e-8."""
    names = ("_ensure_nonzero", "_ensure_nonzero_array")
    kept = {name: getattr(conformal, name) for name in names}
    for name in names:
        setattr(conformal, name, lambda *_: None)
    try:
        yield
    finally:
        for name, function in kept.items():
            setattr(conformal, name, function)


def mean_curvature_flow(v: Array, f: Array) -> Array:
    """Conformalised mean curvature flow (Kazhdan, Solomon, Ben-Chen 2012), with the fastest factorisation there is."""
    L, x = -igl.cotmatrix(v, f), v / np.sqrt(igl.doublearea(v, f).sum() / 2)
    for _ in range(_FLOW_STEPS):
        # it follows the surface; L stays
        A = igl.massmatrix(x, f, igl.MASSMATRIX_TYPE_BARYCENTRIC).diagonal()
        x = factorize(sp.diags_array(A, format="csr") + _FLOW_TIME * L).solve(A[:, None] * x)
        x -= np.einsum("i,ij->j", A, x) / A.sum()
        x /= np.sqrt(igl.doublearea(x, f).sum() / 2)
        radius = np.linalg.norm(x, axis=1)
        if np.sqrt(A @ (radius * np.sqrt(4 * np.pi) - 1) ** 2 / A.sum()) < _ROUND:
            break
    return x / np.linalg.norm(x, axis=1)[:, None]


def factorised_matrix(v: Array, f: Array) -> sp.csr_matrix:
    """The matrix that the map factorises."""
    mesh = ism.check_mesh(v, f)
    return laplacian(mesh.unit, mesh.f) + sp.diags_array(
        1e-9 * vertex_areas(mesh.unit, mesh.f), format="csr"
    )


BACKENDS = ("cvxopt", "rslab", "scipy")

#: In the order of the tables.
COMPETITORS: dict[str, Competitor] = {
    "ours, cvxopt": partial(ours, backend="cvxopt"),
    "ours, rslab": partial(ours, backend="rslab"),
    "ours, scipy": partial(ours, backend="scipy"),
    "LaPy": lapy,
    "LaPy, no refusals": partial(lapy, guarded=False),
    "LaPy, cholespy": partial(lapy, guarded=False, use_cholmod=True),
    "mean curvature flow": mean_curvature_flow,
    "lai2014": partial(ours, method="lai2014"),
}

#: Ordering and factorisation alone: the least that a map can cost, by backend.
FACTORS = {f"factor, {backend}": backend for backend in BACKENDS}

#: Vertices beyond which a competitor is not tried.
LARGEST = {
    "lai2014": 20_000,
    "mean curvature flow": 300_000,
    "LaPy": 300_000,
    "LaPy, cholespy": 300_000,
    "LaPy, no refusals": 300_000,
    "ours, scipy": 1_500_000,
    "factor, scipy": 1_500_000,
}


def main(argv: list[str]) -> None:
    """Run the benchmark, and write the report after every mesh."""
    if argv[:1] == ["--trial"]:
        with contextlib.redirect_stdout(io.StringIO()):
            figures = trial(*argv[1:])
        print(json.dumps(figures))
        return
    options = arguments().parse_args(argv)
    rows = json.loads(options.results.read_text()) if options.add else []
    with tempfile.TemporaryDirectory() as folder:
        for source in options.meshes:
            for mesh in subdivided(source, options.levels, Path(folder)):
                if options.smallest <= mesh["vertices"] <= options.largest:
                    rows.append(mesh | {"trials": compare(mesh, options)})
                    options.results.write_text(json.dumps(rows, indent=1))
                    write_report(rows, options.report)
                Path(mesh["path"]).unlink()
    plot(options.report, options.image)


def trial(name: str, path: str) -> dict[str, object]:
    """Warm up on a small mesh, run one competitor once, and certify and measure the map afterwards."""
    with np.load(path) as data:
        v, f = data["v"], data["f"]
    small = ism.samples.make("spheroid", n_vertices=1500)
    if name in FACTORS:
        P = factorised_matrix(v, f)
        factorize(factorised_matrix(*small), FACTORS[name])
        return measured(lambda: factorize(P, FACTORS[name]))[1]
    COMPETITORS[name](*small)
    try:
        result, figures = measured(lambda: COMPETITORS[name](v, f))
    except (ValueError, RuntimeError, ArithmeticError) as error:
        return {"failure": f"{type(error).__name__}: {error}"[:160]}
    return figures | quality(v, f, getattr(result, "sphere", result))


def arguments() -> argparse.ArgumentParser:
    """Command line."""
    words = parser(__doc__)
    words.add_argument(
        "--meshes", nargs="*", default=["sample:brain", "sample:dino"], help="files, or sample:NAME"
    )
    words.add_argument("--levels", type=int, default=3, help="loop subdivisions of each mesh (3)")
    words.add_argument(
        "--smallest", type=int, default=1_000, help="vertices below which a level is left out"
    )
    words.add_argument(
        "--largest", type=int, default=700_000, help="vertices above which a level is left out"
    )
    words.add_argument("--only", nargs="+", default=[*COMPETITORS, *FACTORS], help="competitors")
    words.add_argument("--cap", type=int, default=600, help="CPU seconds that a run may take (600)")
    words.add_argument("--add", action="store_true", help="add to the results of earlier runs")
    words.add_argument("--results", type=Path, default=ROOT / "benchmarks" / "peers.json")
    words.add_argument("--report", type=Path, default=DOCS / "benchmarks.md")
    words.add_argument("--image", type=Path, default=IMAGES / "benchmarks.png")
    return words


def subdivided(source: str, levels: int, folder: Path):
    """The mesh and its subdivisions, each in a file."""
    v, f = load(source)
    for level in range(levels + 1):
        if level:
            v, f = igl.loop(v, f)
        path = folder / f"{Path(source).stem.replace(':', '_')}_{level}.npz"
        np.savez(path, v=v, f=f.astype(np.int64))
        yield {
            "name": source.removeprefix("sample:")
            if source.startswith("sample:")
            else Path(source).stem,
            "level": level,
            "vertices": len(v),
            "path": str(path),
        }


def compare(mesh: dict, options: argparse.Namespace) -> dict[str, dict]:
    """Figures of all competitors on one mesh: medians over rounds in which they take turns."""
    names = [name for name in options.only if mesh["vertices"] <= LARGEST.get(name, 10**9)]
    runs: dict[str, list[dict]] = {name: [] for name in names}
    for _ in range(next(rounds for most, rounds in ROUNDS if mesh["vertices"] <= most)):
        for name in names:
            done = runs[name]
            if done and ("failure" in done[-1] or done[-1]["cpu"] > LONG):
                continue
            done.append(in_process("peers", "--trial", name, mesh["path"], seconds=options.cap))
            print(mesh["name"], mesh["vertices"], name, done[-1], file=sys.stderr, flush=True)
    return {name: medians(done) for name, done in runs.items()}


def medians(runs: list[dict]) -> dict:
    """Median of each figure; the failure, if there was one."""
    failed = [run for run in runs if "failure" in run]
    return (
        failed[0]
        if failed
        else {key: statistics.median(run[key] for run in runs) for key in runs[0]}
    )


def write_report(rows: list[dict], path: Path) -> None:
    """Write one table for each mesh; what was written by hand below the mark stays."""
    mark = "\n## Findings\n"
    kept = (
        mark + path.read_text().split(mark, 1)[1]
        if path.exists() and mark in path.read_text()
        else ""
    )
    parts = [
        HEADER.format(
            machine=f"{platform.system()} {platform.machine()}",
            python=platform.python_version(),
            version=ism.__version__.removesuffix(".dev0"),
        ),
        *map(table, rows),
    ]
    path.write_text("\n".join(parts) + kept)


def table(row: dict) -> str:
    """Markdown table of one mesh."""
    lines = [
        f"## {row['name']}, {row['vertices']:,} vertices\n",
        "| " + " | ".join(COLUMNS) + " |",
        "|---|" + "---:|" * (len(COLUMNS) - 1),
    ]
    for name, trial in row["trials"].items():
        if "failure" in trial:
            lines.append(
                f"| {name} | {trial['failure'].replace('|', '/')} |" + " |" * (len(COLUMNS) - 2)
            )
        else:
            lines.append("| " + " | ".join([name, *cells(name, trial, row["trials"])]) + " |")
    return "\n".join(lines) + "\n"


def cells(name: str, trial: dict, trials: dict) -> list[str]:
    """One row's figures."""
    quality = ["-", "-", "-"]
    if "mean" in trial:
        quality = [f"{trial['foldings']:.0f}", f"{trial['mean']:.3f}", f"{trial['p99']:.2f}"]
    base = [trials.get(f"ours, {backend}", {}).get("cpu") for backend in BACKENDS]
    quotient = " / ".join(f"{trial['cpu'] / cpu:.1f}" for cpu in base if cpu)
    factor = trials.get(name.replace("ours", "factor"), {}) if name.startswith("ours") else {}
    over = "-"
    if "cpu" in factor:
        memory = f" ({trial['memory'] / factor['memory']:.2f})" if factor["memory"] else ""
        over = f"{trial['cpu'] / factor['cpu']:.2f}{memory}"
    return [
        f"{trial['cpu']:.2f}",
        f"{trial['memory']:.0f}",
        *quality,
        "-" if name.startswith("factor") else quotient,
        over,
    ]


def plot(page: Path, path: Path) -> None:
    """CPU time against size, a line for each competitor and mesh, from the tables of the page."""
    plt = pyplot()
    tables = re.findall(r"^## (\S+), ([\d,]+) vertices\n(.*?)(?=^## )", page.read_text(), _PAGE)
    points = [
        (name, mesh, int(count.replace(",", "")), float(cpu))
        for mesh, count, rows in tables
        for name, cpu in re.findall(r"^\| (.+?) \| ([\d.]+) \|", rows, re.MULTILINE)
        if not name.startswith("factor")
    ]
    names, meshes = (list(dict.fromkeys(point[k] for point in points)) for k in (0, 1))
    figure, axes = plt.subplots(figsize=(7, 4.5), layout="constrained")
    for colour, name in enumerate(names):
        for mesh in meshes:
            done = sorted(point[2:] for point in points if point[:2] == (name, mesh))
            axes.loglog(
                [n for n, _ in done],
                [cpu for _, cpu in done],
                "o-",
                markersize=3,
                color=f"C{colour}",
                linewidth=2 if name.startswith("ours") else 1,
                label="" if mesh != meshes[0] else name,
            )
    sizes = sorted({point[2] for point in points})
    axes.set(xlabel="vertices; a line for each mesh, subdivided", ylabel="CPU seconds")
    axes.set_xticks(sizes, [f"{n:,}" for n in sizes])
    axes.set_xticks([], minor=True)
    axes.grid(True, which="major", alpha=0.3)
    axes.legend(fontsize=8)
    figure.savefig(path, dpi=130)
    plt.close(figure)
