"""What a file holds, and what a format is."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from ..mesh.arrays import FloatArray, IntArray
from .polygons import Polygons

Metadata = Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class RawMesh:
    """What the reader of a format finds: positions of any dtype, polygons, and metadata that the writer can keep."""

    v: NDArray[Any]
    faces: Polygons
    metadata: Metadata = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class LoadedMesh:
    """A triangle mesh from a file. Unpacks to ``v, f``.

    Attributes
    ----------
    v : (n, 3) float64 array
        Vertex positions; whether they are finite is not checked.
    f : (m, 3) int64 array
        0-based faces; whether they form a closed surface is not checked.
    metadata : dict
        What the writers of the format can keep: ``structure`` and ``coordinate_system`` (GIFTI), ``volume``
        (FreeSurfer).
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
    """A row of the table of formats."""

    name: str
    suffixes: tuple[str, ...]  # ends of file names, lower case; the first is the usual one
    read: Callable[[Path], RawMesh]
    write: Callable[[Path, FloatArray, IntArray, Metadata], None]  # positions, faces, what to keep beside them
    magic: tuple[bytes, ...] = ()  # how files begin, for those whose name does not decide
    radius: float = 1.0  # of spheres, by the custom of the format's users
    single: bool = False  # positions are held in float32
    ordered: bool = True  # vertices keep their order
    package: str = ""  # of an extra, without which files are neither read nor written
