"""Map random triangulations with random positions, warnings being errors: python random_triangulations.py [COUNT]."""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import numpy as np

import igl_spheremap as ism

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from triangulations import bad_positions, random_triangulation


def certified(seed: int) -> bool:
    """Whether the map of a random mesh is certified; meshes that `check_mesh` refuses count."""
    rng = np.random.default_rng(seed)
    f = random_triangulation(rng)
    v = bad_positions(f.max() + 1, rng)
    try:
        ism.check_mesh(v, f)
    except ism.MeshError:
        return True
    return bool(ism.spherical_conformal_map(v, f).certificate)


if __name__ == "__main__":
    warnings.simplefilter("error")
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    failed = [seed for seed in range(count) if not certified(seed)]
    print(f"{count - len(failed)} of {count} certified; seeds that are not: {failed}")
    sys.exit(bool(failed))
