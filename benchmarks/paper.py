"""The three settings of the paper's method, and the default method, on bodies of many kinds: foldings, time, angles.

    python -m benchmarks paper [random] [samples] [FOLDER ...] [--csv FILE] [--every K] [--settings NAME ...]
        [--largest 12000] [--printed 4000]

Of a FOLDER all meshes are taken, or every K-th, that have from 880 to `--largest` vertices; its name is theirs in the
table. Settings "as printed" and "as programmed" go up to `--printed` vertices. FILE gets a row a body and setting as
soon as it is made; rows that it has are kept, so that a second call goes on where the first one ended. The table is
that of all its rows.
"""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, fields
from pathlib import Path

import igl
import numpy as np
from bodies import random_body

import igl_spheremap as ism
from igl_spheremap.mesh.arrays import FloatArray, IntArray
from igl_spheremap.mesh.edges import components

from .common import load, parser, quality, timed
from .versions import meshes

Body = tuple[str, str, FloatArray, IntArray]

SETTINGS: dict[str, ism.Lai2014 | ism.Auto] = {
    "auto": ism.Auto(),
    "Lai2014()": ism.Lai2014(),
    "as programmed": ism.Lai2014.as_programmed(),
    "as printed": ism.Lai2014.as_printed(),
}
#: Vertices that a body has at least: the paper's smallest bird has 926.
_FEWEST = 880
#: Random bodies of each kind, and the first seed of the tubes, which no test has.
_CAPSULES, _TUBES, _FIRST = 30, 12, 9100
_SAMPLES = (
    ("bird", 2000),
    ("bird", 5000),
    ("dino", 3000),
    ("dino", 8000),
    ("octopus", 3000),
    ("bunny", 3000),
    ("bunny", 8000),
    ("brain", 4000),
    ("brain", 10000),
    ("spring", 3000),
    ("dumbbell", 3000),
    ("pear", 3000),
    ("spheroid", 4000),
)


@dataclass(frozen=True)
class Row:
    """A setting's result on a body."""

    kind: str
    body: str
    vertices: int
    setting: str
    foldings: int
    mean: float
    iterations: int
    #: Foldings before and after each round, and its iterations.
    rounds: str
    cpu: float
    status: str
    #: Whether limbs go beyond float64 in the centred gauge, as the default method found.
    deep: bool


def main(argv: list[str]) -> None:
    """Map the bodies that the file lacks, and print the table of all its rows."""
    arguments = parser(__doc__)
    arguments.add_argument("sources", nargs="*")
    arguments.add_argument("--csv", type=Path)
    arguments.add_argument("--every", type=int, default=1)
    arguments.add_argument("--settings", nargs="+", choices=tuple(SETTINGS), default=list(SETTINGS))
    arguments.add_argument("--largest", type=int, default=12000)
    arguments.add_argument("--printed", type=int, default=4000)
    options = arguments.parse_args(argv)
    rows = read(options.csv) if options.csv and options.csv.exists() else []
    done = {(row.kind, row.body, row.setting) for row in rows}
    for kind, name, v, f in bodies(options.sources, options.every):
        for setting in options.settings:
            limit = options.printed if setting.startswith("as ") else options.largest
            if _FEWEST <= len(v) <= limit and (kind, name, setting) not in done:
                rows.append(mapped(kind, name, v, f, setting))
                if options.csv:
                    add(options.csv, rows[-1])
    table(rows)


def mapped(kind: str, name: str, v: FloatArray, f: IntArray, setting: str) -> Row:
    """Map a body by a setting."""
    result, cpu = timed(lambda: ism.spherical_conformal_map(v, f, method=SETTINGS[setting]))
    rounds = " ".join(
        f"{each.foldings_before}>{each.foldings_after}:{each.iterations}" for each in result.rounds
    )
    figures = quality(v, f, result.sphere)
    deep = result.gauge == "poles" or result.stretch > 1
    return Row(
        kind,
        name,
        len(v),
        setting,
        figures["foldings"],
        round(figures["mean"], 3),
        result.iterations,
        rounds,
        round(cpu, 2),
        result.status.name,
        deep,
    )


def bodies(sources: Iterable[str], every: int) -> Iterator[Body]:
    """Kinds, names and meshes; those that are no closed surface of genus 0 are left out."""
    for source in sources:
        if made := {"random": random_bodies, "samples": sample_bodies}.get(source):
            found: Iterable[Body] = made()
        else:
            found = (
                (Path(source).name, Path(path).stem, *load(str(path)))
                for path in meshes(source)[::every]
            )
        for body in found:
            try:
                ism.check_mesh(*body[2:])
            except ism.MeshError:
                continue
            yield body


def random_bodies() -> Iterator[Body]:
    """Smooth unions of a ball and random capsules, by marching cubes, every second one smoothed; and random tubes."""
    for seed in range(_CAPSULES):
        v, f = capsules(seed, int(np.random.default_rng([seed, 56]).integers(1500, 6000)))
        if seed % 2:
            A = igl.adjacency_matrix(f).astype(float)
            for _ in range(3):
                v = (v + (A @ v) / A.sum(axis=1).reshape(-1, 1)) / 2
        yield "random", f"capsules{seed:02}", np.asarray(v), f
    for seed in range(_TUBES):
        rng = np.random.default_rng([seed, 57])
        depth, limbs = float(np.exp(rng.uniform(np.log(4), np.log(40)))), int(rng.integers(1, 5))
        yield (
            "random",
            f"tubes{seed:02}",
            *random_body(_FIRST + seed, depth, limbs, noise=float(rng.uniform(0, 0.1))),
        )


def capsules(seed: int, n: int) -> tuple[FloatArray, IntArray]:
    """About `n` vertices around a ball of radius 1 with up to six limbs of two capsules each."""
    rng = np.random.default_rng([seed, 55])
    limbs: list[tuple[FloatArray, FloatArray, float]] = []
    for _ in range(int(rng.integers(1, 7))):
        d = rng.normal(size=3)
        d /= np.linalg.norm(d)
        elbow, side = d * rng.uniform(1.2, 3.2), np.cross(d, rng.normal(size=3))
        hand, r = elbow + side * rng.uniform(0, 1.2), rng.uniform(0.14, 0.4)
        limbs += [(0.6 * d, elbow, r), (elbow, hand, r * rng.uniform(0.7, 1))]
    blend = rng.uniform(0.05, 0.12)
    ends = (
        np.array([(*(a - r), *(b - r)) for a, b, r in limbs]),
        np.array([(*(a + r), *(b + r)) for a, b, r in limbs]),
    )
    low = np.minimum(ends[0].reshape(-1, 3).min(axis=0), -1) - 0.5
    high = np.maximum(ends[1].reshape(-1, 3).max(axis=0), 1) + 0.5
    h = float(np.prod(high - low)) ** (1 / 3) / 40
    for _ in range(4):
        size = np.maximum(((high - low) / h).astype(int) + 1, 8)
        z, y, x = np.meshgrid(*(low[k] + h * np.arange(size[k]) for k in (2, 1, 0)), indexing="ij")
        grid = np.column_stack((x.ravel(), y.ravel(), z.ravel()))
        v, f, *_ = igl.marching_cubes(union(grid, limbs, blend), grid, *map(int, size), 0.0)
        v, f = largest(v, f.astype(np.int64))
        if abs(len(v) / n - 1) < 0.15:
            break
        h *= (len(v) / n) ** 0.5
    return v, f if np.linalg.det(v[f] - v.mean(axis=0)).sum() > 0 else f[:, ::-1].copy()


def union(
    points: FloatArray, limbs: list[tuple[FloatArray, FloatArray, float]], blend: float
) -> FloatArray:
    """Distances of points from the smooth union of a ball and capsules, negative inside."""
    parts = [np.linalg.norm(points, axis=1) - 1]
    for a, b, r in limbs:
        t = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
        parts.append(np.linalg.norm(points - a - t[:, None] * (b - a), axis=1) - r)
    distance = np.array(parts)
    least = distance.min(axis=0)
    return least - blend * np.log(np.exp((least - distance) / blend).sum(axis=0))


def largest(v: FloatArray, f: IntArray) -> tuple[FloatArray, IntArray]:
    """The connected component with the most vertices."""
    label = components(f.ravel(), f[:, [1, 2, 0]].ravel(), len(v))[1]
    used, local = np.unique(f[label[f[:, 0]] == np.bincount(label).argmax()], return_inverse=True)
    return v[used], local.reshape(-1, 3)


def sample_bodies() -> Iterator[Body]:
    """Samples as they are, with noise of a fifth of an edge, and stretched along the axes."""
    for seed, (name, n) in enumerate(_SAMPLES):
        v, f = ism.samples.make(name, n_vertices=n)
        rng, edge = np.random.default_rng([seed, 58]), igl.edge_lengths(v, f).mean()
        stretch = np.exp(0.6 * rng.normal(size=3))
        yield "samples", f"{name}_{n}", v, f
        yield "samples", f"{name}_{n}_noise", v + 0.2 * edge * rng.normal(size=v.shape), f
        yield "samples", f"{name}_{n}_stretched", v * stretch, f


def read(file: Path) -> list[Row]:
    """The rows of a file."""
    kinds = {
        field.name: {"int": int, "float": float, "bool": "True".__eq__}.get(str(field.type), str)
        for field in fields(Row)
    }
    with file.open(newline="") as opened:
        return [
            Row(**{name: kinds[name](cell) for name, cell in row.items()})
            for row in csv.DictReader(opened)
        ]


def add(file: Path, row: Row) -> None:
    """Add a row to a file, which is made if it is not there."""
    new = not file.exists()
    with file.open("a", newline="") as opened:
        out = csv.DictWriter(opened, [field.name for field in fields(Row)], lineterminator="\n")
        if new:
            out.writeheader()
        out.writerow(asdict(row))


def table(rows: list[Row]) -> None:
    """Print counts, medians and sums by kind and setting."""
    deep = {(row.kind, row.body) for row in rows if row.deep}
    print(
        "| bodies | setting | number | with foldings left | of these beyond float64; collapsed | "
        "corrections: 0; 1; 2; 3 | iterations (median; most) | CPU s (median; sum) | mean angle (median; 90 %) |\n"
        "|---|---|---:|---:|---:|---|---:|---:|---:|"
    )
    small = {(row.kind, row.body) for row in rows if row.setting == "as printed"}
    groups = {
        kind: [row for row in rows if row.kind == kind]
        for kind in dict.fromkeys(row.kind for row in rows)
    }
    groups |= {
        "all": rows,
        "all that were mapped as printed": [row for row in rows if (row.kind, row.body) in small],
    }
    for name, group in groups.items():
        for setting in SETTINGS:
            if some := [row for row in group if row.setting == setting]:
                print(f"| {name} | {setting} | {summary(some, deep)} |")


def summary(rows: list[Row], deep: set[tuple[str, str]]) -> str:
    """Cells of the table for the rows of a setting."""
    left = [row for row in rows if row.foldings]
    beyond = sum((row.kind, row.body) in deep for row in left)
    collapsed = sum(row.status == "COLLAPSED" for row in left)
    removed = Counter(max(len(row.rounds.split()) - 1, 0) for row in rows if row.setting != "auto")
    iterations, cpu, mean = np.array([(row.iterations, row.cpu, row.mean) for row in rows]).T
    return (
        f"{len(rows)} | {len(left)} | {beyond}; {collapsed} | {'; '.join(str(removed[k]) for k in range(4))} | "
        f"{np.median(iterations):,.0f}; {iterations.max():,.0f} | {np.median(cpu):.2f}; {cpu.sum():,.0f} | "
        f"{np.median(mean):.2f}; {np.percentile(mean, 90):.1f}"
    )
