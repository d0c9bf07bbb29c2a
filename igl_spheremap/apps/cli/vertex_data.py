"""`--data FILE[:NAME]`, data over the vertices, and `--to MESH`, the sphere whose vertices they are carried to."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

import numpy as np

from ...errors import MeshError
from ...io import read_scalars, read_sphere
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.check import check_faces
from ...shapes.transfer import regular_mesh
from .failures import UsageError


def read_data(path: str, n_vertices: int, mesh: str) -> FloatArray:
    """The maps of a file as columns (n, k)."""
    return np.stack(list(read_maps(path, n_vertices, mesh).values()), axis=1)


def read_maps(path: str, n_vertices: int, mesh: str) -> dict[str, FloatArray]:
    """The maps of a file by name, (n,) each; the mesh is named in errors."""
    file, colon, name = path.rpartition(":")
    if colon and not Path(path).exists():
        maps = read_scalars(file)
        if name not in maps:
            raise MeshError(f"{file} holds no map {name!r}; it has {', '.join(maps)}")
        maps = {name: maps[name]}
    else:
        maps = read_scalars(path)
    for key, values in maps.items():
        if len(values) != n_vertices:
            raise MeshError(f"{path}: {key} has {len(values)} values but {mesh} has {n_vertices} vertices; "
                            "give data of this mesh")
    return maps


def read_target_sphere(args: Namespace) -> tuple[FloatArray, IntArray]:
    """Vertices and faces of the sphere mesh."""
    if not args.to.startswith("ico:"):
        x, f = read_sphere(args.to)
        return x, check_faces(f, len(x))
    try:
        return regular_mesh(args.to)
    except ValueError as error:
        raise UsageError(f"--to {error}") from None
