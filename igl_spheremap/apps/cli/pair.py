"""SOURCE and SPHERE: a mesh and a map of it."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...errors import FoldingsRemain, MeshError
from ...io import read_sphere
from ...maps.given_sphere import sphere_map
from ...mesh.arrays import FloatArray, IntArray, check_directions
from ...result.sphere_map import SphereMap
from ...sphere.rows import row_lengths
from .failures import UsageError
from .source import Source, load_source
from .streams import STREAM, read_stream


@dataclass(frozen=True, eq=False)
class Pair:
    """A mesh and a map of it: positions (n, 3) as they are stored, and the name of their file."""

    source: Source
    name: str
    x: FloatArray

    @property
    def unit(self) -> FloatArray:
        """The positions on about the unit sphere."""
        x = check_directions(self.x, name=f"{self.name}: images")
        return np.asarray(x / np.median(row_lengths(x)))

    def map(self) -> SphereMap:
        """The map as a certified result; errors name its file."""
        try:
            return sphere_map(self.source.v, self.source.f, self.x)
        except (MeshError, FoldingsRemain) as error:
            error.args = (f"{self.name}: {error}",)
            raise


def load_pair(args: Namespace) -> Pair:
    """The mesh and the map that the command line names."""
    if args.source == STREAM and args.sphere in (None, STREAM):
        raise UsageError("stdin is read once: give the mesh or its map as a file")
    if args.sphere is None and not args.source.lower().endswith(".npz"):
        raise UsageError(f"{args.source} holds no map: give SPHERE, or an .npz with both")
    source = load_source(args)
    return read_pair(source, args.sphere or source.name, args.format, args.progress.stage)


def read_pair(source: Source, name: str, kind: str = "obj", stage: Callable[[str], None] = lambda name: None) -> Pair:
    """A mesh and a map of it from a file or stdin; a MeshError if its vertices or faces are not those of the mesh."""
    stage(f"reading {name}")
    x, f = read_stream(name, kind, read_sphere)
    name = "stdin" if name == STREAM else name
    if len(x) != len(source.v):
        raise MeshError(
            f"{name} has {len(x)} vertices but {source.name} has {len(source.v)}; give a map of this mesh"
        )
    if len(f) != len(source.f) or not np.array_equal(_face_set(f), _face_set(source.f)):
        raise MeshError(
            f"{name} has other faces than {source.name}: not the same vertex order; give a map of this mesh "
            "in a format that keeps the order (not .stl)"
        )
    return Pair(source, name, x)


def _face_set(f: IntArray) -> IntArray:
    """Faces in sorted order, whatever their orientation and first vertex."""
    f = np.sort(f, axis=1)
    return f[np.lexsort(f.T)]
