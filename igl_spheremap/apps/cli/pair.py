"""SOURCE and SPHERE: a mesh and a map of it."""

from __future__ import annotations

from argparse import Namespace

import numpy as np

from ...errors import MeshError
from ...io import read_sphere
from ...mesh.arrays import FloatArray, IntArray
from .failures import UsageError
from .source import Source, load_source
from .streams import STREAM, read_stream


def load_pair(args: Namespace) -> tuple[Source, str, FloatArray]:
    """The mesh, the name of its map, and the map's positions as stored."""
    if args.source == STREAM and args.sphere in (None, STREAM):
        raise UsageError("stdin is read once: give the mesh or its map as a file")
    source = load_source(args)
    name = args.sphere or source.name
    args.progress.stage(f"reading {name}")
    x, f = read_stream(name, args.format, read_sphere)
    name = "stdin" if name == STREAM else name
    check_fits(source, name, x, f)
    return source, name, x


def check_fits(source: Source, name: str, x: FloatArray, f: IntArray) -> None:
    """Raise a MeshError if a sphere's vertices or faces are not those of the mesh in the same order."""
    if len(x) != len(source.v):
        raise MeshError(
            f"{name} has {len(x)} vertices but {source.name} has {len(source.v)}; give a map of this mesh"
        )
    if len(f) != len(source.f) or not np.array_equal(_face_set(f), _face_set(source.f)):
        raise MeshError(
            f"{name} has other faces than {source.name}: not the same vertex order; give a map of this mesh "
            "in a format that keeps the order (not .stl)"
        )


def _face_set(f: IntArray) -> IntArray:
    """Faces in sorted order, whatever their orientation and first vertex."""
    f = np.sort(f, axis=1)
    return f[np.lexsort(f.T)]
