"""Animals: bodies with limbs, whose Gauss maps fold badly."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .implicit import mesh_implicit
from .limbs import SmoothUnion, limb


def dino(n_vertices: int = 5000) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Four-legged dinosaur with a long neck and tail, z up, facing x."""
    spine = limb(
        [
            (-5.0, 0.95, 0.95, 0.10),
            (-4.0, 0.55, 0.85, 0.15),
            (-3.0, 0.20, 1.05, 0.24),
            (-2.0, 0.02, 1.45, 0.42),
            (-1.0, 0.00, 1.75, 0.68),
            (0.0, 0.00, 1.80, 0.80),
            (0.9, 0.00, 1.85, 0.64),
            (1.6, 0.00, 2.20, 0.42),
            (2.1, -0.02, 2.85, 0.30),
            (2.4, -0.08, 3.60, 0.24),
            (2.75, -0.18, 4.20, 0.21),
            (3.15, -0.30, 4.38, 0.25),
            (3.55, -0.42, 4.28, 0.23),
            (3.90, -0.52, 4.15, 0.17),
        ]
    )
    legs = [
        limb([(0.65, 0.45, 1.5, 0.34), (0.85, 0.55, 0.85, 0.26), (0.95, 0.56, 0.25, 0.22), (1.08, 0.56, 0.18, 0.22)]),
        limb([(0.65, -0.45, 1.5, 0.34), (0.60, -0.55, 0.85, 0.26), (0.35, -0.56, 0.25, 0.22), (0.48, -0.56, 0.18, 0.22)]),
        limb([(-0.9, 0.42, 1.5, 0.44), (-0.85, 0.56, 0.9, 0.30), (-1.15, 0.58, 0.25, 0.24), (-1.0, 0.58, 0.2, 0.24)]),
        limb([(-0.9, -0.42, 1.5, 0.44), (-0.6, -0.56, 0.9, 0.30), (-0.55, -0.58, 0.25, 0.24), (-0.4, -0.58, 0.2, 0.24)]),
    ]
    body = SmoothUnion((spine, *legs), blend=0.06)
    return mesh_implicit(body, body.box(), n_vertices, n_base=2000)
