"""Map random bodies with deep limbs, warnings being errors: python random_bodies.py [COUNT]; prints JSON lines."""

from __future__ import annotations

import json
import sys
import time
import warnings
from pathlib import Path

import numpy as np

import igl_spheremap as ism

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from bodies import body_and_rings, ring_floor

_FIRST = 5000  # no test has seeds from here on


def draw(seed: int):
    """A body of 1 to 4 limbs up to 10 to 120 nepers deep, rings of 6 and more vertices, noise to a tenth of an edge."""
    rng = np.random.default_rng([seed, 7])
    depth, limbs = float(np.exp(rng.uniform(np.log(10), np.log(120)))), int(rng.integers(1, 5))
    least = int(rng.integers(6, 11))
    around = least, least + int(rng.integers(1, 9))
    v, f, rings = body_and_rings(seed, depth, limbs, around, float(rng.uniform(0, 0.1)))
    return (v, f), {"seed": seed, "depth": depth, "ring": least, "floor": ring_floor(v, f, rings)}


def mapped(seed: int) -> dict[str, object]:
    """Certificate, angle differences in degrees and CPU seconds of the map of one body."""
    (v, f), row = draw(seed)
    start = time.process_time()
    result = ism.spherical_conformal_map(v, f)
    row |= {"vertices": len(v), "certified": bool(result.certificate), "cpu": time.process_time() - start}
    row |= {"gauge": result.gauge, "stretch": result.stretch}
    size = np.abs(result.angle_differences())
    return row | {"mean": float(size.mean()), "p99": float(np.percentile(size, 99))}


if __name__ == "__main__":
    warnings.simplefilter("error")
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 2000
    certified = 0
    for seed in range(_FIRST, _FIRST + count):
        row = mapped(seed)
        certified += bool(row["certified"])
        print(json.dumps(row), flush=True)
    print(f"{certified} of {count} certified", file=sys.stderr)
    sys.exit(certified < count)
