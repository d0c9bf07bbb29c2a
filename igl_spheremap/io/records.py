"""What a file holds, and what a format is."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .polygons import Polygons

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Metadata = Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class RawMesh:
    """A file's content as a format's reader gives it, polygons and all.

    Attributes
    ----------
    v : (n, 3) float64 array
        Vertex positions, not checked.
    faces : Polygons
        Faces, not checked.
    metadata : dict
        What the writers of the format can keep.
    """

    v: FloatArray
    faces: Polygons
    metadata: Metadata = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class LoadedMesh:
    """A triangle mesh from a file. Unpacks to ``v, f``.

    Attributes
    ----------
    v : (n, 3) float64 array
        Vertex positions, not checked.
    f : (m, 3) int64 array
        0-based faces, not checked.
    metadata : dict
        What the file says beyond that and the writers keep: ``structure``, ``coordinate_system`` (GIFTI),
        ``volume`` (FreeSurfer).
    triangulated : int
        Number of polygons of the file that were cut into triangles.
    """

    v: FloatArray
    f: IntArray
    metadata: Metadata = field(default_factory=dict)
    triangulated: int = 0

    def __iter__(self) -> Iterator[Any]:
        return iter((self.v, self.f))


@dataclass(frozen=True)
class Format:
    """A file format.

    Attributes
    ----------
    name : str
        What people call it.
    suffixes : tuple of str
        Ends of file names, lower case with the dot; the first is the usual one.
    read : callable
        Takes a path.
    write : callable
        Takes a path, vertices, faces and metadata.
    magic : tuple of bytes
        How files begin, for those whose name does not tell.
    radius : float
        Of spheres, by the custom of the format's users.
    single : bool
        Positions are held in float32.
    """

    name: str
    suffixes: tuple[str, ...]
    read: Callable[[Path], RawMesh]
    write: Callable[[Path, FloatArray, IntArray, Metadata], None]
    magic: tuple[bytes, ...] = ()
    radius: float = 1.0
    single: bool = False
