"""Animals: smooth bodies with limbs, whose Gauss maps fold badly. Their knots and radii are chosen by eye."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..errors import check_number
from ..gate import gate
from ..mesh.arrays import FloatArray, IntArray
from .implicit import Limb, SmoothUnion, limb, mesh_implicit

_DINO_SPINE = (  # x (forward), y (left), z (up), radius; from the tail to the snout
    (-5.0, 0.95, 0.85, 0.10),
    (-4.0, 0.55, 0.78, 0.15),
    (-3.0, 0.20, 1.02, 0.24),
    (-2.0, 0.02, 1.45, 0.42),
    (-1.0, 0.00, 1.75, 0.68),
    (0.0, 0.00, 1.80, 0.80),
    (0.9, 0.00, 1.88, 0.64),
    (1.6, 0.00, 2.25, 0.42),
    (2.1, -0.02, 2.92, 0.31),
    (2.4, -0.08, 3.65, 0.25),
    (2.7, -0.18, 4.22, 0.22),
    (3.1, -0.30, 4.42, 0.28),
    (3.5, -0.42, 4.34, 0.25),
    (3.85, -0.52, 4.18, 0.18),
)
_DINO_LEGS = (
    (
        (0.65, 0.45, 1.5, 0.36),
        (0.85, 0.55, 0.85, 0.27),
        (0.85, 0.56, 0.28, 0.23),
        (0.97, 0.56, 0.20, 0.23),
    ),
    (
        (0.65, -0.45, 1.5, 0.36),
        (0.55, -0.55, 0.85, 0.27),
        (0.35, -0.56, 0.28, 0.23),
        (0.47, -0.56, 0.20, 0.23),
    ),
    (
        (-0.9, 0.42, 1.5, 0.48),
        (-0.9, 0.56, 0.9, 0.33),
        (-1.2, 0.58, 0.28, 0.25),
        (-1.08, 0.58, 0.21, 0.25),
    ),
    (
        (-0.9, -0.42, 1.5, 0.48),
        (-0.6, -0.56, 0.9, 0.33),
        (-0.6, -0.58, 0.28, 0.25),
        (-0.48, -0.58, 0.21, 0.25),
    ),
)
_BIRD_SPINE = (
    (-1.5, 0.0, 0.0, 0.20),
    (-0.9, 0.0, 0.0, 0.38),
    (0.0, 0.0, 0.0, 0.55),
    (0.8, 0.0, 0.2, 0.42),
    (1.35, 0.0, 0.5, 0.28),
    (1.75, 0.0, 0.62, 0.30),
)
_BIRD_BEAK = ((1.85, 0.0, 0.6, 0.17), (2.15, 0.0, 0.54, 0.13), (2.45, 0.0, 0.46, 0.08))
_BIRD_WING = (  # the left one
    (0.35, 0.2, 0.1, 0.45),
    (0.45, 1.0, 0.45, 0.50),
    (0.60, 1.8, 0.75, 0.45),
    (0.25, 2.7, 0.95, 0.36),
    (-0.45, 3.5, 1.0, 0.18),
)
_BUNNY_BODY = (  # x (forward), y (left), z (up), radius; from the rump to the neck
    (-1.05, 0.0, 0.98, 0.82),
    (-0.55, 0.0, 1.12, 0.95),
    (0.15, 0.0, 1.22, 0.84),
    (0.7, 0.0, 1.45, 0.64),
    (0.95, 0.0, 1.85, 0.50),
)
_BUNNY_HEAD = (
    (0.95, 0.0, 2.2, 0.42),
    (1.25, 0.0, 2.42, 0.56),
    (1.6, 0.0, 2.34, 0.48),
    (1.88, 0.0, 2.22, 0.34),
)
_BUNNY_TAIL = ((-1.75, 0.0, 0.75, 0.26), (-1.98, 0.0, 0.86, 0.31))
_BUNNY_EAR = (  # ear, haunch, legs and eye: the left ones
    (1.02, 0.22, 2.8, 0.17),
    (0.88, 0.32, 3.15, 0.25),
    (0.68, 0.44, 3.6, 0.29),
    (0.46, 0.53, 4.02, 0.22),
    (0.33, 0.57, 4.28, 0.11),
)
_BUNNY_HAUNCH = ((-1.0, 0.62, 0.95, 0.56), (-0.4, 0.82, 0.70, 0.52), (-0.15, 0.84, 0.55, 0.40))
_BUNNY_LEGS = (
    ((-0.75, 0.84, 0.24, 0.22), (0.15, 0.88, 0.20, 0.23), (0.45, 0.88, 0.18, 0.19)),
    (
        (0.72, 0.36, 1.1, 0.38),
        (0.92, 0.38, 0.55, 0.24),
        (1.0, 0.38, 0.2, 0.19),
        (1.28, 0.38, 0.16, 0.18),
    ),
)
_BUNNY_EYE = ((1.52, 0.40, 2.55, 0.13), (1.55, 0.44, 2.56, 0.11))
_OCTOPUS_MANTLE = (
    (0.0, 0.0, 0.6, 0.55),
    (-0.05, 0.0, 1.1, 0.50),
    (-0.20, 0.0, 1.7, 0.75),
    (-0.45, 0.0, 2.4, 0.70),
    (-0.65, 0.0, 2.8, 0.50),
)


@gate
def dino(n_vertices: int = 5000) -> tuple[FloatArray, IntArray]:
    """Four-legged dinosaur with a long neck and tail, walking along x.

    `n_vertices` and the result are those of every sample, see `igl_spheremap.samples`.
    """
    body = SmoothUnion((limb(_DINO_SPINE), *map(limb, _DINO_LEGS)), blend=0.06)
    return mesh_implicit(body, body.box(), n_vertices, detail=0.12)


@gate
def bird(n_vertices: int = 5000) -> tuple[FloatArray, IntArray]:
    """Bird in flight along x, with spread wings and tail.

    `n_vertices` and the result are those of every sample, see `igl_spheremap.samples`.
    """
    parts = [limb(_BIRD_SPINE), limb(_BIRD_BEAK)]
    for side in (1.0, -1.0):
        parts.append(limb(_on_side(_BIRD_WING, side), squash=(1, 1, 0.3)))
    for angle in (-0.45, 0.0, 0.45):
        x, y = -np.cos(angle), np.sin(angle)
        feather = [(-1.3 + s * x, s * y, 0.02 * s, 0.16 + 0.06 * s) for s in (0.0, 0.5, 1.0, 1.4)]
        parts.append(limb(feather, squash=(1, 1, 0.45)))
    body = SmoothUnion(tuple(parts), blend=0.05)
    return mesh_implicit(body, body.box(), n_vertices, detail=0.12)


@gate
def bunny(n_vertices: int = 11000) -> tuple[FloatArray, IntArray]:
    """Rabbit that sits and pricks up its ears, looking along x.

    `n_vertices` and the result are those of every sample, see `igl_spheremap.samples`.
    """
    parts = [limb(_BUNNY_BODY), limb(_BUNNY_HEAD), limb(_BUNNY_TAIL)]
    for side in (1.0, -1.0):
        parts += [limb(_on_side(part, side)) for part in (_BUNNY_HAUNCH, *_BUNNY_LEGS, _BUNNY_EYE)]
        parts.append(limb(_on_side(_BUNNY_EAR, side), squash=(0.45, 1, 1)))
    body = SmoothUnion(tuple(parts), blend=0.07)
    return mesh_implicit(body, body.box(), n_vertices, detail=0.14)


@gate
def octopus(n_vertices: int = 6000, arm_length: float = 2.0) -> tuple[FloatArray, IntArray]:
    """Octopus with eight arms.

    `n_vertices` and the result are those of every sample, see `igl_spheremap.samples`.

    A conformal map shrinks the end of an arm to about ``exp(-2 pi arm_length)``.

    Parameters
    ----------
    arm_length : float
        Length of each arm, in mean circumferences of the arm; 0.5 to 20.
    """
    check_number(arm_length, "arm_length", 0.5, 20)
    eyes = [limb([(0.42, y, 1.15, 0.17), (0.5, 1.1 * y, 1.2, 0.17)]) for y in (0.3, -0.3)]
    body = SmoothUnion(
        (limb(_OCTOPUS_MANTLE), *eyes, *(_arm(k, arm_length) for k in range(8))), blend=0.08
    )
    return mesh_implicit(body, body.box(), n_vertices, detail=0.11)


def _on_side(
    knots: Sequence[Sequence[float]], side: float
) -> list[tuple[float, float, float, float]]:
    """The knots of a left part for side 1, of its mirror image for -1."""
    return [(x, side * y, z, r) for x, y, z, r in knots]


def _arm(k: int, circumferences: float) -> Limb:
    """The k-th of eight arms: down from the body, outwards in waves, and up at its end."""
    root, tip = 0.25, 0.12
    length = circumferences * np.pi * (root + tip)
    t = np.linspace(0.0, 1.0, 16 + int(12 * circumferences))
    s = length * t
    rise = -0.9 * np.exp(-s / 0.6) + 1.1 * t**4
    swing = 0.6 * np.sin(2.6 * s + 2.4 * k) * np.clip(s - 0.3, 0.0, 1.0) + 0.25 * np.pi * (k + 0.5)
    out = np.cos(rise)
    direction = np.stack([out * np.cos(swing), out * np.sin(swing), np.sin(rise)], axis=1)
    steps = 0.5 * (direction[1:] + direction[:-1]) * (length / (len(t) - 1))
    start = np.array([0.4 * np.cos(swing[0]), 0.4 * np.sin(swing[0]), 0.55])
    return Limb(
        np.concatenate([start[None], start + np.cumsum(steps, axis=0)]), root + (tip - root) * t
    )
