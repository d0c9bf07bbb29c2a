"""Map random bodies with deep limbs, or random triangulations with bad positions, warnings being errors.

    python -m benchmarks random_meshes bodies|triangulations [--count 1000]

Bodies print a line of JSON each, and a table by their depths. The exit status says whether all maps are certified.
"""

from __future__ import annotations

import json
import sys
import warnings
from itertools import pairwise
from typing import Any

import numpy as np
from bodies import body_and_rings, ring_floor
from triangulations import bad_positions, random_triangulation

import igl_spheremap as ism

from .common import parser, quality, timed

_FIRST = 5000  # no test has seeds from here on
#: Nepers at which the rows of the table begin and end.
_DEPTHS = (10, 20, 40, 60, 80, 120)


def main(argv: list[str]) -> None:
    """Map this many random meshes."""
    arguments = parser(__doc__)
    arguments.add_argument("kind", choices=("bodies", "triangulations"))
    arguments.add_argument("--count", type=int, default=1000)
    options = arguments.parse_args(argv)
    warnings.simplefilter("error")
    certified = {"bodies": body, "triangulations": triangulation}[options.kind]
    found = {seed: certified(seed) for seed in range(_FIRST, _FIRST + options.count)}
    if options.kind == "bodies":
        table(list(found.values()))
    failed = [seed for seed, one in found.items() if not one["certified"]]
    print(
        f"{options.count - len(failed)} of {options.count} certified; seeds that are not: {failed}",
        file=sys.stderr,
    )
    sys.exit(bool(failed))


def table(rows: list[dict[str, Any]]) -> None:
    """Mean angle differences by the depth of the limbs."""
    print(
        "| depth in nepers | bodies | certified | mean (median; 90 %; worst) | mean over floor (median; worst) | "
        "with tips at ends of axes |\n|---|---|---|---|---|---|"
    )
    for low, high in pairwise(_DEPTHS):
        some = [row for row in rows if low <= row["depth"] < high]
        mean, floor = np.array([(row["mean"], row["floor"]) for row in some]).reshape(-1, 2).T
        print(
            f"| {low} to {high} | {len(some)} | {sum(row['certified'] for row in some)} | {np.median(mean):.1f}; "
            f"{np.percentile(mean, 90):.1f}; {mean.max():.1f} | {np.median(mean / floor):.2f}; "
            f"{(mean / floor).max():.2f} | {sum(row['gauge'] == 'poles' for row in some)} |"
        )


def body(seed: int) -> dict[str, Any]:
    """Map a body of 1 to 4 limbs, 10 to 120 nepers deep, rings of 6 and more vertices, noise to a tenth of an edge."""
    rng = np.random.default_rng([seed, 7])
    depth, limbs = float(np.exp(rng.uniform(np.log(10), np.log(120)))), int(rng.integers(1, 5))
    least = int(rng.integers(6, 11))
    around = least, least + int(rng.integers(1, 9))
    v, f, rings = body_and_rings(seed, depth, limbs, around, float(rng.uniform(0, 0.1)))
    result, seconds = timed(lambda: ism.spherical_conformal_map(v, f))
    row = {
        "seed": seed,
        "depth": depth,
        "ring": least,
        "floor": ring_floor(v, f, rings),
        "vertices": len(v),
        "certified": bool(result.certificate),
        "cpu": seconds,
        "gauge": result.gauge,
        "stretch": result.stretch,
    }
    row |= quality(v, f, result.sphere)
    print(json.dumps(row), flush=True)
    return row


def triangulation(seed: int) -> dict[str, Any]:
    """Map a random mesh; those that `check_mesh` refuses count as certified."""
    rng = np.random.default_rng(seed)
    f = random_triangulation(rng)
    v = bad_positions(f.max() + 1, rng)
    try:
        ism.check_mesh(v, f)
    except ism.MeshError:
        return {"certified": True}
    return {"certified": bool(ism.spherical_conformal_map(v, f).certificate)}
