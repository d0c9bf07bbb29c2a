"""Certify balanced maps at every iterate, measure them, and compare them with what other programs make.

    python -m benchmarks balanced_maps run RESULTS.jsonl [--meshes FOLDER] [--bodies 30]
    python -m benchmarks balanced_maps field RESULTS.jsonl FILE ...
    python -m benchmarks balanced_maps report RESULTS.jsonl docs/balance_figures.md

`run` maps every sample, every mesh below FOLDER and random bodies with limbs at five balances, adds a line of JSON a
mesh, and leaves out what RESULTS already has. `field` needs lapy, u-unwrap3d, and Octave with SDEM for their rows.
Times are CPU seconds of one thread.
"""

from __future__ import annotations

import importlib.util
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

import numpy as np
from bodies import random_body
from scipy.io import loadmat, savemat

import igl_spheremap as ism

from .common import parser, timed

BALANCES = (0.25, 0.5, 0.75, 1.0)
#: What a program in a process of its own may take.
SECONDS = 300
COLUMNS = ("area", "area 99 %", "angles", "cost", "steps")


def run(results, meshes, bodies):
    """Measure what is not in the results yet."""
    done = {row["name"] for row in rows_of(results)}
    for name, make in sources(meshes, bodies):
        if name in done:
            continue
        try:
            v, f = make()
            row = {"name": name, **measured(v, f)}
        except ism.MeshError:  # no closed surface of genus 0
            continue
        print(row["name"], row["folded"], row["failure"], file=sys.stderr, flush=True)
        with results.open("a") as file:
            file.write(json.dumps(row) + "\n")


def sources(meshes, bodies):
    """Names, and functions that make meshes."""
    for name in ism.samples.names():
        yield f"sample:{name}", lambda name=name: ism.samples.make(name)
    for path in sorted(meshes.glob("*/*.obj")) if meshes else ():
        if path.parent.name != "invalid":
            yield path.stem, lambda path=path: ism.read_mesh(path)
    for seed in range(bodies):
        depth = (8, 15, 30, 60)[seed % 4]
        yield f"body {seed}", lambda seed=seed, depth=depth: random_body(seed, depth, 2 + seed % 3, (6, 12))


def measured(v, f):
    """Figures of five balances, and of the folded faces of all iterates."""
    folded, watched, row = 0, 0.0, {"vertices": len(v), "balances": {}, "failure": ""}

    def count(iterate):
        nonlocal folded, watched
        began = time.process_time()
        if iterate.stage in ("opening", "balance"):
            folded += ism.certify(iterate.x, f).foldings
        watched += time.process_time() - began

    try:
        conformal, seconds = timed(lambda: ism.spherical_conformal_map(v, f))
        f = conformal.faces
        row["balances"]["0"] = figures(conformal, 1.0, 0)
        for balance in BALANCES:
            began, watched = time.process_time(), 0.0
            result = conformal.rebalance(balance, listener=count)
            cost = 1 + (time.process_time() - began - watched) / seconds
            claimed = result.certificate.folding_free
            if claimed != ism.certify(result.sphere, f).folding_free or not claimed:
                row["failure"] += f"balance {balance}: claims {claimed}; "
            row["balances"][f"{balance:g}"] = figures(result, cost, result.iterations - conformal.iterations)
        row["seconds"] = seconds
    except (RuntimeError, ArithmeticError, IndexError) as error:
        row["failure"] += f"{type(error).__name__}: {error}"
    return row | {"folded": folded}


def figures(result, cost, steps):
    """What the table shows; faces whose source has no area have no ratio."""
    area, angle = np.abs(result.log_area_ratios()), np.abs(result.angle_differences())
    area = area[np.isfinite(area)]
    return {"area": float(area.mean()), "area 99 %": float(np.quantile(area, 0.99)), "angles": float(angle.mean()),
            "cost": cost, "steps": steps, "status": result.status.name}


def field(results, paths):
    """Maps by other programs of some meshes; each starts from this package's conformal map where it takes one."""
    for path in paths:
        v, f = ism.read_mesh(path)
        conformal = ism.spherical_conformal_map(v, f)
        for name, make in PEERS.items():
            began = time.process_time()
            try:
                x, seconds = make(v, conformal.faces, conformal.sphere)
            except ImportError as error:
                print(name, error, file=sys.stderr)
                continue
            except (ValueError, RuntimeError, subprocess.SubprocessError) as error:
                found = {"failure": str(error)[:80]}
            else:
                seconds = seconds or time.process_time() - began
                x = x / np.linalg.norm(x, axis=1, keepdims=True)
                found = {"area": float(np.abs(ism.log_area_ratios(v, f, x)).mean()), "seconds": seconds,
                         "angles": float(np.abs(ism.angle_differences(v, f, x)).mean()),
                         "foldings": ism.certify(x, conformal.faces).foldings}
            with results.open("a") as file:
                file.write(json.dumps({"name": Path(path).stem, "peer": name} | found) + "\n")


def by_balance(balance):
    """A map of this package from the conformal map that it made itself."""
    return lambda v, f, x: (ism.balanced_spherical_map(v, f, balance=balance).sphere, None)


def lapy_conformal(v, f, x):
    """Choi's conformal map as LaPy has it."""
    from lapy import TriaMesh
    from lapy.conformal import spherical_conformal_map

    return spherical_conformal_map(TriaMesh(v, f)), None


def lapy_spectral(v, f, x):
    """LaPy's projection of three eigenfunctions."""
    from lapy import TriaMesh
    from lapy.diffgeo import tria_spherical_project

    return tria_spherical_project(TriaMesh(v, f)).v, None


def unwrap3d_flow(v, f, x):
    """Area flow of u-unwrap3D from the conformal map, by the Python that UNWRAP3D_PYTHON names."""
    spec = importlib.util.find_spec("unwrap3D")
    if spec is None or "UNWRAP3D_PYTHON" not in os.environ:
        raise ImportError("u-unwrap3d is not installed, or UNWRAP3D_PYTHON names no Python with libigl < 2.6")
    meshtools = Path(spec.submodule_search_locations[0]) / "Mesh" / "meshtools.py"
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "in.npz", Path(folder) / "out.npz"
        np.savez(source, v=v, f=f, x=x)
        subprocess.run([os.environ["UNWRAP3D_PYTHON"], Path(__file__).with_name("unwrap3d_flow.py"), meshtools, source,
                        target], check=True, capture_output=True)
        with np.load(target) as found:
            return found["x"], float(found["seconds"])


def density_equalizing(v, f, x):
    """SDEM from the conformal map, at its defaults, in Octave; SDEM_FOLDER names the folder of its code."""
    if "SDEM_FOLDER" not in os.environ or shutil.which("octave-cli") is None:
        raise ImportError("Octave is not installed, or SDEM_FOLDER does not name the folder of SDEM.m")
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "in.mat", Path(folder) / "out.mat"
        savemat(source, {"v": v, "f": f + 1.0, "x": x})
        script = Path(__file__).with_name("sdem.m")
        subprocess.run(["octave-cli", "--path", os.environ["SDEM_FOLDER"], script, source, target], check=True,
                       capture_output=True, timeout=SECONDS)
        found = loadmat(target)
        return found["map"], float(found["seconds"].item())


PEERS = {"balance 0.5": by_balance(0.5), "balance 1": by_balance(1.0), "LaPy, conformal": lapy_conformal,
         "LaPy, spectral": lapy_spectral, "u-unwrap3D, area flow": unwrap3d_flow,
         "density-equalizing (SDEM)": density_equalizing}


def report(results, target):
    """Write the tables."""
    rows = [row for row in rows_of(results) if "balances" in row]
    peers = [row for row in rows_of(results) if "peer" in row]
    target.write_text("\n".join((*summary(rows), *table(rows), *field_table(peers), "")))


def summary(rows):
    """What holds over all meshes."""
    shared = [row for row in rows if not row["name"].startswith(("body", "sample")) and not row["failure"]]
    order = [row["name"] for row in rows if not row["failure"] and not is_monotone(row)]
    failed = [f"{row['name']} ({row['failure']})" for row in rows if row["failure"]]
    yield "# Figures of balanced maps\n"
    version = ism.__version__.removesuffix(".dev0")
    yield (f"Written by `python -m benchmarks balanced_maps` at version {version}. The energy is in "
           "[Between angles and areas](balance.md).\n")
    yield (f"{len(rows)} meshes (samples, {len(shared)} meshes of the [corpus](corpus.md), random bodies with limbs) "
           f"at balance .25, .5, .75 and 1: {sum(row['folded'] for row in rows)} folded faces in all iterates, "
           f"{len(failed)} failures{': ' + '; '.join(failed) if failed else ''}.")
    yield (f"Areas fall and angles rise over the balances that converged on all meshes "
           f"whose conformal area distortion exceeds .05{', but for ' + ', '.join(order) if order else ''}.\n")
    for balance in ("0.5", "1"):
        cost = median(row["balances"][balance]["cost"] for row in shared)
        yield f"Median cost at balance {balance} over the corpus: {cost:.1f} times the conformal map.\n"


def is_monotone(row):
    """True where areas fall and angles rise over the balances that converged."""
    if row["balances"]["0"]["area"] <= 0.05:
        return True
    found = [found for found in row["balances"].values() if found["status"] == "CONVERGED"]
    area, angle = ([one[key] for one in found] for key in ("area", "angles"))
    return bool((np.diff(area) < 0).all() and (np.diff(angle) > 0).all())


def table(rows):
    """All meshes at balance .5 and 1; the area distortion of the worst five at 1 in bold."""
    rows = [row for row in rows if not row["failure"]]
    worst = sorted(row["balances"]["1"]["area"] for row in rows if not row["name"].startswith("body"))[-5:]
    yield ("Mean and 99th percentile of the absolute log area ratio, mean angle difference in degrees, cost as a "
           "multiple of the conformal map, Newton steps; SHORT where areas are off what was asked by more than 35 "
           "percent. The five largest area distortions at balance 1 (random bodies aside) are bold.\n")
    heads = [f"{balance}: {column}" for balance in (".5", "1") for column in COLUMNS]
    yield "| " + " | ".join(("mesh", "vertices", "map, s", *heads)) + " |"
    yield "|---" * (3 + len(heads)) + "|"
    for row in rows:
        cells = [row["name"], str(row["vertices"]), f"{row['seconds']:.2f}"]
        for balance in ("0.5", "1"):
            found = row["balances"][balance]
            area = f"{found['area']:.3g}"
            bold = balance == "1" and found["area"] in worst
            cells += [f"**{area}**" if bold else area, f"{found['area 99 %']:.3g}", f"{found['angles']:.1f}",
                      f"{found['cost']:.1f}", f"{found['steps']}{' SHORT' if found['status'] == 'SHORT' else ''}"]
        yield "| " + " | ".join(cells) + " |"


def field_table(peers):
    """Other programs."""
    if not peers:
        return
    yield "\n## Other programs\n"
    yield ("u-unwrap3D and SDEM start from this package's conformal map, whose time is not counted; balances count it. "
           "50 steps of u-unwrap3D's flow, and SDEM in Octave (Lyu, Lui, Choi 2024), at their defaults.\n")
    yield "| mesh | map by | mean abs log area ratio | angles, degrees | folded faces | CPU s |"
    yield "|---|---|---|---|---|---|"
    for row in peers:
        cells = (["", row["failure"], "", ""] if "failure" in row else
                 [f"{row['area']:.3g}", f"{row['angles']:.1f}", str(row["foldings"]), f"{row['seconds']:.2f}"])
        yield "| " + " | ".join((row["name"], row["peer"], *cells)) + " |"


def rows_of(results):
    """Lines of a file of JSON, if there is one."""
    return [json.loads(line) for line in results.read_text().splitlines()] if results.exists() else []


def main(argv: list[str]) -> None:
    """Parse the command line."""
    arguments = parser(__doc__)
    commands = arguments.add_subparsers(dest="command", required=True)
    for name in ("run", "field", "report"):
        commands.add_parser(name).add_argument("results", type=Path)
    commands.choices["run"].add_argument("--meshes", type=Path)
    commands.choices["run"].add_argument("--bodies", type=int, default=30)
    commands.choices["field"].add_argument("paths", nargs="+")
    commands.choices["report"].add_argument("target", type=Path)
    options = vars(arguments.parse_args(argv))
    globals()[options.pop("command")](**options)
