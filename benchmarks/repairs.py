"""Results of repair and polish, the time of embedding, the effect of numbering, and the maps that stay without
foldings.

    python -m benchmarks repairs maps MESH ...
    python -m benchmarks repairs polish MESH ...
    python -m benchmarks repairs gauges MESH ...
    python -m benchmarks repairs rings
    python -m benchmarks repairs embedding
    python -m benchmarks repairs foldings FOLDER
    python -m benchmarks repairs copies MESH ... [--count 8]

`gauges` compares limbs at ends of axes with the centred gauge, `rings` tubes with the floor that their rings set.
`foldings` compares with the conformalised mean curvature flow, and with LaPy where that is
installed; `copies` maps each mesh several times, its vertices and faces renumbered and turned. Seconds are of the CPU.
"""

from __future__ import annotations

import sys
from itertools import permutations
from pathlib import Path

import numpy as np
from bodies import ring_floor, worm
from scipy.spatial import ConvexHull

import igl_spheremap as ism
from igl_spheremap.result.run import Round
from igl_spheremap.untangle.embedding import progressive_embedding

from .common import load, parser, quality, timed
from .peers import lapy, mean_curvature_flow


def main(argv: list[str]) -> None:
    """Print one of the tables."""
    arguments = parser(__doc__)
    arguments.add_argument(
        "table", choices=("maps", "polish", "gauges", "rings", "embedding", "foldings", "copies")
    )
    arguments.add_argument("sources", nargs="*")
    arguments.add_argument("--count", type=int, default=5, help="copies of each mesh")
    options = arguments.parse_args(argv)
    {
        "maps": maps,
        "polish": polish,
        "gauges": gauges,
        "rings": rings,
        "embedding": embedding,
        "foldings": foldings,
        "copies": lambda sources: copies(sources, options.count),
    }[options.table](options.sources)


def maps(sources: list[str]) -> None:
    """Foldings and means of the harmonic map, of the placed or embedded map, and of the result."""
    ism.spherical_conformal_map(*ism.samples.make("octopus", n_vertices=1500))
    print(
        "| mesh | vertices | harmonic map: folds / mean | placed: folds / mean | result: mean / 99 % | CPU, s |"
    )
    print("|---|---|---|---|---|---|")
    for source in sources:
        v, f = load(source)
        result, seconds = timed(lambda v=v, f=f: ism.spherical_conformal_map(v, f))  # type: ignore[misc]
        found = quality(v, f, result.sphere)
        rounds = {each.start: folds_and_mean(each) for each in reversed(result.rounds)}
        first = rounds.get("map", f"0 / {found['mean']:.3g}")
        placed = rounds.get("angles", rounds.get("embedding", ""))
        print(
            f"| {Path(source).stem} | {len(v):,} | {first} | {placed} | {found['mean']:.3g} / {found['p99']:.3g} | "
            f"{seconds:.2f} |",
            flush=True,
        )


def folds_and_mean(entry: Round) -> str:
    """Both after a round; local repairs measure no angles far from their patches, so have no mean."""
    if np.isnan(entry.mean_angle_difference):
        return f"{entry.foldings_after:,}"
    return f"{entry.foldings_after:,} / {entry.mean_angle_difference:.3g}"


def polish(sources: list[str]) -> None:
    """Mean and 99th percentile by default and with all polish, the change of the mean, and the cost."""
    print('| mesh | "auto" | "angles" | change, percent | cost |\n|---|---|---|---|---|')
    for source in sources:
        v, f = load(source)
        ism.spherical_conformal_map(*ism.samples.make("sphere", n_vertices=500))
        (plain, before), (polished, after) = (
            timed(lambda p=p: ism.spherical_conformal_map(v, f, method=ism.Auto(polish=p)))  # noqa: B023
            for p in ("auto", "angles")
        )
        found = [quality(v, f, result.sphere) for result in (plain, polished)]
        cells = [f"{one['mean']:.3g} / {one['p99']:.3g}" for one in found]
        change = 100 * (found[1]["mean"] / found[0]["mean"] - 1)
        print(
            f"| {Path(source).stem} | {' | '.join(cells)} | {change:.1f} | {after / before:.1f} |",
            flush=True,
        )


def gauges(sources: list[str]) -> None:
    """Mean and 99th percentile with the deepest limbs at ends of axes, where that pays, and in the centred gauge."""
    print(
        '| mesh | default: mean / 99 % | limbs shortened by | CPU, s | `gauge="centred"` | limbs shortened by | '
        "CPU, s |\n|---|---|---|---|---|---|---|"
    )
    for source in sources:
        v, f = (
            worm(int(source.removeprefix("worm:"))) if source.startswith("worm:") else load(source)
        )
        cells = []
        for gauge in ("poles", "centred"):
            result, seconds = timed(
                lambda g=gauge: ism.spherical_conformal_map(v, f, method=ism.Auto(gauge=g))  # noqa: B023
            )
            found = quality(v, f, result.sphere)
            cells += [
                f"{found['mean']:.3g} / {found['p99']:.3g}",
                f"{result.stretch:.3g}",
                f"{seconds:.2f}",
            ]
        print(f"| {Path(source).stem} | {' | '.join(cells)} |", flush=True)


def rings(_: list[str]) -> None:
    """Mean angle differences of long tubes, and the floor that rings of 20 vertices set."""
    print(
        "| worm, length in circumferences | vertices | floor | result | CPU, s |\n|---|---|---|---|---|"
    )
    for circumferences in (14, 40, 199):
        v, f = worm(circumferences)
        floor = ring_floor(v, f, np.arange(1, len(v) - 1).reshape(-1, 20))
        result, seconds = timed(lambda: ism.spherical_conformal_map(v, f))  # noqa: B023
        found = quality(v, f, result.sphere)
        print(
            f"| {circumferences} | {len(v):,} | {floor:.2f} | {found['mean']:.2f} | {seconds:.2f} |",
            flush=True,
        )


def embedding(_: list[str]) -> None:
    """Certified positions from random ones, and from good ones of which some are thrown to random places."""
    rng = np.random.default_rng(0)
    print(
        "| input | vertices | folded faces | result | seconds | vertices moved |\n|---|---|---|---|---|---|"
    )
    for n in (20_000, 80_000, 500_000):
        x = rng.normal(size=(n, 3))
        x /= np.linalg.norm(x, axis=1)[:, None]
        f = outward(x, ConvexHull(x).simplices)
        thrown = x.copy()
        some = rng.choice(n, n // 167, replace=False)
        thrown[some] = x[rng.permutation(some)]
        for name, y in (
            ("random positions", x[rng.permutation(n)]),
            ("one vertex in 167 thrown", thrown),
        ):
            folded = ism.certify(y, f).foldings
            z, seconds = timed(lambda: progressive_embedding(y, f))  # noqa: B023
            certified = "certified" if ism.certify(z, f) else "not certified"
            moved = int((z != y).any(axis=1).sum())
            print(
                f"| {name} | {n:,} | {folded:,} | {certified} | {seconds:.2f} | {moved:,} |",
                flush=True,
            )


def outward(x: np.ndarray, f: np.ndarray) -> np.ndarray:
    """Faces of a convex hull, turned outward."""
    inward = np.linalg.det(x[f]) < 0
    return np.where(inward[:, None], f[:, ::-1], f).astype(np.int64)


def foldings(folders: list[str]) -> None:
    """How many of the surfaces below folders each program maps without foldings, and how far angles are off."""
    others = {
        "conformalised mean curvature flow, 60 steps at most": mean_curvature_flow,
        "LaPy's linear method": lapy,
    }
    found: dict[str, list[float]] = {
        name: [] for name in (*others, "the better of the two", "this package")
    }
    count = 0
    for path in sorted(path for folder in folders for path in Path(folder).rglob("*.*")):
        try:
            v, f = ism.repair_mesh(*ism.read_mesh(path))
        except (ism.MeshError, ism.FileError):  # no closed surface of genus 0
            continue
        if len(v) < 500:
            continue
        count += 1
        ours = quality(v, f, ism.spherical_conformal_map(v, f).sphere)
        means = {}
        for name, program in others.items():
            try:
                with np.errstate(all="ignore"):
                    theirs = quality(v, f, program(v, f))
            except (ValueError, RuntimeError, ArithmeticError):
                continue
            if not theirs.get("failure") and not theirs["foldings"]:
                means[name] = theirs["mean"]
        print(path.stem, len(v), ours, means, file=sys.stderr, flush=True)
        if means:
            means["the better of the two"] = min(means.values())
        if not ours["foldings"]:
            means["this package"] = ours["mean"]
        for name, mean in means.items():
            found[name].append(ours["mean"] / mean)
    print(
        f"| program | of {count} free of foldings | mean angle difference here over its: median, 90 %, most |"
    )
    print("|---|---|---|")
    for name, ratios in found.items():
        over = [] if name == "this package" else np.percentile(ratios, [50, 90, 100])
        print(f"| {name} | {len(ratios)} | {', '.join(f'{ratio:.2f}' for ratio in over)} |")


def copies(sources: list[str], count: int) -> None:
    """How often a map is more than 5 percent and .02 degrees worse than that of a renumbered and turned copy."""
    above, several = [], []
    for source in sources:
        v, f = load(source)
        means = []
        for seed in range(count):
            rng = np.random.default_rng(seed)
            order, faces = (rng.permutation(len(rows)) for rows in (v, f))
            turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
            w, g = v[order] @ (turn * np.sign(np.linalg.det(turn))).T, np.argsort(order)[f][faces]
            means.append(quality(w, g, ism.spherical_conformal_map(w, g).sphere)["mean"])
        worse = np.array([[a > max(1.05 * b, b + 0.02) for b in means] for a in means])
        above.append(worse.sum() / (count * (count - 1)))
        several.append(
            np.mean([(worse[a, b] | worse[a, c]) for a, b, c in permutations(range(count), 3)])
        )
        print(Path(source).stem, len(v), np.round(means, 2).tolist(), file=sys.stderr, flush=True)
    print(
        f"of {len(above)} meshes, one copy is worse than another in {100 * np.mean(above):.1f} percent, than "
        f"the better of two in {100 * np.mean(several):.1f}"
    )
