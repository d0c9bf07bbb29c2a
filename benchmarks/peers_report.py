"""The benchmark's table and plot, from its figures."""

from __future__ import annotations

import platform
from pathlib import Path

from igl_spheremap import __version__

HEADER = """# Benchmarks

Written by `python benchmarks/peers.py`. CPU and wall seconds from arrays to result, certificate included for this
package; medians over rounds in which the competitors take turns, each in a process of its own, with one thread and
after a warm-up. *Memory* is the growth of the peak, in MB, of a process that holds the mesh. *Foldings* are exact
(`ism.certify`); *mean* and *99 %* are of the angle differences in degrees, over all corners. *Speed-up* is CPU time
of the row over that of `ours, cvxopt` and of `ours, scipy`. *Over factor* is CPU time, and in brackets memory, over
those of ordering and factorisation alone with the same backend.

- `LaPy`: `lapy.conformal.spherical_conformal_map`, as it ships; `no refusals`: with its refusals of denominators
  below an absolute 1e-8 switched off; `cholespy`: the same with its optional Cholesky factorisation.
- `mean curvature flow`: conformalised (Kazhdan, Solomon, Ben-Chen 2012), as in benchmarks/competitors.py,
  factorised by the fastest backend here.
- `lai2014`: the paper's Algorithm 2 around Algorithm 1, up to 20,000 vertices.

Machine: {machine}, Python {python}; igl_spheremap {version}.
"""
COLUMNS = ("competitor", "CPU s", "wall s", "memory", "foldings", "mean", "99 %", "speed-up", "over factor")


def write_report(rows: list[dict], path: Path) -> None:
    """Write one table for each mesh; what was written by hand below the mark stays."""
    mark = "\n## What the figures show\n"
    kept = mark + path.read_text().split(mark, 1)[1] if path.exists() and mark in path.read_text() else ""
    parts = [HEADER.format(machine=f"{platform.system()} {platform.machine()}", python=platform.python_version(),
                           version=__version__.removesuffix(".dev0")),
             "![Time against size](images/benchmarks.png)\n", *map(table, rows)]
    path.write_text("\n".join(parts) + kept)


def table(row: dict) -> str:
    """Markdown table of one mesh."""
    lines = [f"## {row['name']}, {row['vertices']:,} vertices\n", "| " + " | ".join(COLUMNS) + " |",
             "|---|" + "---:|" * (len(COLUMNS) - 1)]
    for name, trial in row["trials"].items():
        if "failure" in trial:
            lines.append(f"| {name} | {trial['failure'].replace('|', '/')} |" + " |" * (len(COLUMNS) - 2))
        else:
            lines.append("| " + " | ".join([name, *cells(name, trial, row["trials"])]) + " |")
    return "\n".join(lines) + "\n\n" + stages(row["trials"])


def stages(trials: dict) -> str:
    """Markdown table of the share of each stage in our wall time."""
    ours = {name: trial for name, trial in trials.items() if any(key.startswith("stage ") for key in trial)}
    names = list(dict.fromkeys(key for trial in ours.values() for key in trial if key.startswith("stage ")))
    lines = ["| share of wall time | " + " | ".join(name.removeprefix("stage ") for name in names) + " |",
             "|---|" + "---:|" * len(names)]
    lines += [f"| {name} | " + " | ".join(f"{trial.get(key, 0) / trial['wall']:.1%}" for key in names) + " |"
              for name, trial in ours.items()]
    return "\n".join(lines) + "\n" if ours else ""


def cells(name: str, trial: dict, trials: dict) -> list[str]:
    """One row's figures."""
    quality = ["-", "-", "-"]
    if "mean" in trial:
        quality = [f"{trial['foldings']:.0f}", f"{trial['mean']:.3f}", f"{trial['p99']:.2f}"]
    base = [trials.get(other, {}).get("cpu") for other in ("ours, cvxopt", "ours, scipy")]
    quotient = " / ".join(f"{trial['cpu'] / cpu:.1f}" for cpu in base if cpu)
    factor = trials.get(name.replace("ours", "factor"), {}) if name.startswith("ours") else {}
    over = "-"
    if "cpu" in factor:
        memory = f" ({trial['memory'] / factor['memory']:.2f})" if factor["memory"] else ""
        over = f"{trial['cpu'] / factor['cpu']:.2f}{memory}"
    return [f"{trial['cpu']:.2f}", f"{trial['wall']:.2f}", f"{trial['memory']:.0f}", *quality,
            "-" if name.startswith("factor") else quotient, over]


def plot(rows: list[dict], path: Path) -> None:
    """CPU time against size, a line for each competitor and mesh."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    names = list(dict.fromkeys(name for row in rows for name in row["trials"] if not name.startswith("factor")))
    figure, axes = plt.subplots(figsize=(7, 4.5), layout="constrained")
    for colour, name in enumerate(names):
        for mesh in dict.fromkeys(row["name"] for row in rows):
            done = sorted((row["vertices"], row["trials"][name]["cpu"]) for row in rows
                          if row["name"] == mesh and "cpu" in row["trials"].get(name, {}))
            axes.loglog([n for n, _ in done], [cpu for _, cpu in done], "o-", markersize=3, color=f"C{colour}",
                        linewidth=2 if name.startswith("ours") else 1, label="" if mesh != rows[0]["name"] else name)
    sizes = sorted({row["vertices"] for row in rows})
    axes.set(xlabel="vertices; a line for each mesh, subdivided", ylabel="CPU seconds")
    axes.set_xticks(sizes, [f"{n:,}" for n in sizes])
    axes.set_xticks([], minor=True)
    axes.grid(True, which="major", alpha=0.3)
    axes.legend(fontsize=8)
    figure.savefig(path, dpi=130)
    plt.close(figure)
