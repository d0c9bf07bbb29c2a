"""Certify balanced maps at every iterate, measure them, and compare them with other programs' maps.

    python -m benchmarks balanced_maps maps [FOLDER] [--bodies 32]
    python -m benchmarks balanced_maps programs FILE ...
    python -m benchmarks balanced_maps lengths

`maps` takes every sample, every mesh below FOLDER and random bodies with limbs at two balances. `programs` needs lapy,
u-unwrap3d, and Octave with SDEM for their rows, `lengths` of a cortex in nilearn cat-surf. Times are CPU seconds of one
thread.
"""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

import numpy as np
from bodies import random_body

import igl_spheremap as ism
from igl_spheremap.verify.distortion import log_length_ratios

from .common import fsaverage5, octave, parser, timed
from .judge_programs import cat_surf

BALANCES = (0.5, 1.0)
#: What a program in a process of its own may take.
SECONDS = 300
#: Nepers of the random bodies' limbs.
DEPTHS = (8, 15, 30, 60)
COLUMNS = ("area", "area 99 %", "angles", "cost", "steps")


def maps(folder, bodies):
    """The table of all meshes at each balance, and of medians of random bodies."""
    heads = [
        f"{str(balance).lstrip('0').removesuffix('.0')}: {column}"
        for balance in BALANCES
        for column in COLUMNS
    ]
    print(
        "| mesh | vertices | map, CPU s | "
        + " | ".join(heads)
        + " | folded faces in all iterates |"
    )
    print("|---" * (4 + len(heads)) + "|")
    ism.balanced_spherical_map(*ism.samples.make("octopus", n_vertices=1500))
    costs = []
    for name, path, make in sources(folder):
        try:
            row = measured(*make())
        except ism.MeshError:  # no closed surface of genus 0
            continue
        print(line(name, [row]), flush=True)
        if path:
            costs.append([row[balance]["cost"] for balance in BALANCES])
    for depth in DEPTHS:
        rows = [
            measured(*random_body(seed, depth, 2 + seed % 3, (6, 12)))
            for seed in range(bodies)
            if DEPTHS[seed % len(DEPTHS)] == depth
        ]
        print(line(f"{len(rows)} bodies, {depth} nepers", rows), flush=True)
    before, after = COLUMNS.index("cost") * " |", (len(COLUMNS) - COLUMNS.index("cost")) * " |"
    cells = "".join(f"{before} {median(each):.1f}{after}" for each in zip(*costs, strict=True))
    print(f"| median of {len(costs)} files | | |{cells} |")


def sources(folder):
    """Names, files, and functions that make meshes."""
    for name in ism.samples.names():
        yield f"sample:{name}", None, lambda name=name: ism.samples.make(name)
    for path in sorted(folder.glob("*/*.obj")) if folder else ():
        if path.parent.name != "invalid":
            yield path.stem, path, lambda path=path: ism.read_mesh(path)


def line(name, rows):
    """A row of the table: medians, and sums of foldings."""

    def middle(*keys):
        return median(row[keys[0]] if len(keys) == 1 else row[keys[0]][keys[1]] for row in rows)

    cells = [name, f"{middle('vertices'):.0f}", f"{middle('seconds'):.2f}"]
    for balance in BALANCES:
        short = sum(row[balance]["short"] for row in rows)
        mark = " SHORT" if short and len(rows) == 1 else f" ({short} SHORT)" if short else ""
        cells += [
            f"{middle(balance, 'area'):.3g}",
            f"{middle(balance, 'area 99 %'):.3g}",
            f"{middle(balance, 'angles'):.1f}",
            f"{middle(balance, 'cost'):.1f}",
            f"{middle(balance, 'steps'):.0f}{mark}",
        ]
    return "| " + " | ".join((*cells, str(sum(row["folded"] for row in rows)))) + " |"


def measured(v, f):
    """Figures of each balance, and of the folded faces of all iterates and results."""
    folded, watched, row = 0, 0.0, {"vertices": len(v)}

    def count(iterate):
        nonlocal folded, watched
        began = time.process_time()
        if iterate.stage in ("opening", "balance"):
            folded += ism.certify(iterate.x, f).foldings
        watched += time.process_time() - began

    conformal, row["seconds"] = timed(lambda: ism.spherical_conformal_map(v, f))
    f = conformal.faces
    for balance in BALANCES:
        watched = 0.0
        result, seconds = timed(lambda: conformal.rebalance(balance, listener=count))  # noqa: B023
        folded += ism.certify(result.sphere, f).foldings
        row[balance] = figures(
            result,
            1 + (seconds - watched) / row["seconds"],
            result.iterations - conformal.iterations,
        )
    return row | {"folded": folded}


def figures(result, cost, steps):
    """Figures of the table; faces whose source has no area have no ratio."""
    area, angle = np.abs(result.log_area_ratios()), np.abs(result.angle_differences())
    area = area[np.isfinite(area)]
    return {
        "area": float(area.mean()),
        "area 99 %": float(np.quantile(area, 0.99)),
        "angles": float(angle.mean()),
        "cost": cost,
        "steps": steps,
        "short": result.status.name == "SHORT",
    }


def programs(paths):
    """Maps by other programs of some meshes; each starts from this package's conformal map where it takes one."""
    print("| mesh | map by | mean abs log area ratio | angles, degrees | folded faces | CPU s |")
    print("|---|---|---|---|---|---|")
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
                cells = "", str(error)[:80], "", ""
            else:
                seconds = seconds or time.process_time() - began
                x = x / np.linalg.norm(x, axis=1, keepdims=True)
                cells = (
                    f"{np.abs(ism.log_area_ratios(v, f, x)).mean():.3g}",
                    f"{np.abs(ism.angle_differences(v, f, x)).mean():.1f}",
                    str(ism.certify(x, conformal.faces).foldings),
                    f"{seconds:.2f}",
                )
            print("| " + " | ".join((Path(path).stem, name, *cells)) + " |", flush=True)


def lengths():
    """Spheres of the left white surface of fsaverage5 by balances, cat-surf, and FreeSurfer."""
    v, f = ism.read_mesh(fsaverage5() / "white_left.gii.gz")
    made = {
        f"`balance={b}`": timed(lambda b=b: ism.balanced_spherical_map(v, f, balance=b).sphere)
        for b in (0.8, 0.85, 0.9)
    }
    made |= {
        "cat-surf's, relaxed": cat_surf(v, f, relax=True),
        "FreeSurfer's, in nilearn": (ism.read_mesh(fsaverage5() / "sphere_left.gii.gz").v, None),
    }
    print(
        "| sphere | log area ratio | angles, degrees | log edge ratio | folded faces | CPU s |\n"
        "|---|---|---|---|---|---|"
    )
    for name, (x, seconds) in made.items():
        x = x / np.linalg.norm(x, axis=1, keepdims=True)
        area, angle, edge = (
            np.abs(measure(v, f, x)).mean()
            for measure in (ism.log_area_ratios, ism.angle_differences, log_length_ratios)
        )
        print(
            f"| {name} | {area:.3f} | {angle:.1f} | {edge:.3f} | {ism.certify(x, f).foldings} | "
            f"{'' if seconds is None else f'{seconds:.2f}'} |"
        )


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
        raise ImportError(
            "u-unwrap3d is not installed, or UNWRAP3D_PYTHON names no Python with libigl < 2.6"
        )
    meshtools = Path(spec.submodule_search_locations[0]) / "Mesh" / "meshtools.py"
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "in.npz", Path(folder) / "out.npz"
        np.savez(source, v=v, f=f, x=x)
        subprocess.run(
            [
                os.environ["UNWRAP3D_PYTHON"],
                Path(__file__).with_name("unwrap3d_flow.py"),
                meshtools,
                source,
                target,
            ],
            check=True,
            capture_output=True,
        )
        with np.load(target) as found:
            return found["x"], float(found["seconds"])


def density_equalizing(v, f, x):
    """SDEM from the conformal map, at its defaults, in Octave; SDEM_FOLDER names the folder of its code."""
    return octave(
        "SDEM_FOLDER",
        "SDEM(v, f, face_area(f, v), x, 0.1, 1e-3, 200)",
        SECONDS,
        v=v,
        f=f + 1.0,
        x=x,
    )


PEERS = {
    "balance 0.5": by_balance(0.5),
    "balance 1": by_balance(1.0),
    "LaPy, conformal": lapy_conformal,
    "LaPy, spectral": lapy_spectral,
    "u-unwrap3D, area flow": unwrap3d_flow,
    "density-equalizing (SDEM)": density_equalizing,
}


def main(argv: list[str]) -> None:
    """Print one of the tables."""
    arguments = parser(__doc__)
    commands = arguments.add_subparsers(dest="command", required=True)
    commands.add_parser("maps").add_argument("folder", type=Path, nargs="?")
    commands.choices["maps"].add_argument("--bodies", type=int, default=32)
    commands.add_parser("programs").add_argument("paths", nargs="+")
    commands.add_parser("lengths")
    options = vars(arguments.parse_args(argv))
    globals()[options.pop("command")](**options)
