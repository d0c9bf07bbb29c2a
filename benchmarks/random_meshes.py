"""Map random bodies with deep limbs, or random triangulations with bad positions, warnings being errors.

    python -m benchmarks random_meshes bodies|triangulations [--count 1000]

Bodies print a line of JSON each. The exit status says whether all maps are certified.
"""

from __future__ import annotations

import json
import sys
import warnings

import numpy as np
from bodies import body_and_rings, ring_floor
from triangulations import bad_positions, random_triangulation

import igl_spheremap as ism

from .common import parser, quality, timed

_FIRST = 5000  # no test has seeds from here on


def main(argv: list[str]) -> None:
    """Map this many random meshes."""
    arguments = parser(__doc__)
    arguments.add_argument("kind", choices=("bodies", "triangulations"))
    arguments.add_argument("--count", type=int, default=1000)
    options = arguments.parse_args(argv)
    warnings.simplefilter("error")
    certified = {"bodies": body, "triangulations": triangulation}[options.kind]
    failed = [seed for seed in range(_FIRST, _FIRST + options.count) if not certified(seed)]
    print(f"{options.count - len(failed)} of {options.count} certified; seeds that are not: {failed}", file=sys.stderr)
    sys.exit(bool(failed))


def body(seed: int) -> bool:
    """Map a body of 1 to 4 limbs, 10 to 120 nepers deep, rings of 6 and more vertices, noise to a tenth of an edge."""
    rng = np.random.default_rng([seed, 7])
    depth, limbs = float(np.exp(rng.uniform(np.log(10), np.log(120)))), int(rng.integers(1, 5))
    least = int(rng.integers(6, 11))
    around = least, least + int(rng.integers(1, 9))
    v, f, rings = body_and_rings(seed, depth, limbs, around, float(rng.uniform(0, 0.1)))
    result, seconds = timed(lambda: ism.spherical_conformal_map(v, f))
    row = {"seed": seed, "depth": depth, "ring": least, "floor": ring_floor(v, f, rings), "vertices": len(v),
           "certified": bool(result.certificate), "cpu": seconds, "gauge": result.gauge, "stretch": result.stretch}
    print(json.dumps(row | quality(v, f, result.sphere)), flush=True)
    return bool(result.certificate)


def triangulation(seed: int) -> bool:
    """Map a random mesh; those that `check_mesh` refuses count as certified."""
    rng = np.random.default_rng(seed)
    f = random_triangulation(rng)
    v = bad_positions(f.max() + 1, rng)
    try:
        ism.check_mesh(v, f)
    except ism.MeshError:
        return True
    return bool(ism.spherical_conformal_map(v, f).certificate)
