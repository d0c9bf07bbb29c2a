"""`--to`: the sphere mesh whose vertices data or a surface is carried to."""

from __future__ import annotations

from argparse import Namespace

from ...io import read_sphere
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.check import check_faces
from ...shapes.transfer import regular_mesh
from .failures import UsageError


def read_target_sphere(args: Namespace) -> tuple[FloatArray, IntArray]:
    """Vertices and faces of the sphere mesh."""
    if not args.to.startswith("ico:"):
        x, f = read_sphere(args.to)
        return x, check_faces(f, len(x))
    try:
        return regular_mesh(args.to)
    except ValueError as error:
        raise UsageError(f"--to {error}") from None
