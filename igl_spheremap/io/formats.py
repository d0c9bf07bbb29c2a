"""The table of formats. It imports no reader: a format's module is imported when a file is read or written."""

from __future__ import annotations

import os
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

from ..errors import FileError

if TYPE_CHECKING:
    from ..mesh.arrays import FloatArray, IntArray
    from .records import Metadata, RawMesh

PathLike = str | os.PathLike[str]
#: By whose convention a hemisphere's files are named. FreeSurfer's are written in its formats, the others as GIFTI.
Convention = Literal["bids", "freesurfer", "hcp"]
CONVENTIONS = get_args(Convention)


@dataclass(frozen=True)
class Format:
    """A row of the table of formats."""

    name: str
    module: str  # of this room, with the functions `read` and `write`
    suffixes: tuple[str, ...]  # ends of file names, lower case; the first is the usual one
    magic: tuple[bytes, ...] = ()  # how files begin, for those whose name does not decide
    radius: float = 1.0  # of spheres, by the convention of the format's users
    single: bool = False  # positions are held in float32
    ordered: bool = True  # vertices keep their order
    both: bool = False  # a file can hold the sphere of its surface, too
    package: str = ""  # of an extra, without which files are neither read nor written

    @property
    def _module(self) -> Any:
        return import_module(f"{__package__}.{self.module}")

    def read(self, path: Path) -> RawMesh:
        """What a file holds."""
        raw: RawMesh = self._module.read(path)
        return raw

    def write(self, path: Path, v: FloatArray, f: IntArray, metadata: Metadata) -> None:
        """Write positions and faces, and what to keep beside them."""
        self._module.write(path, v, f, metadata)


#: FreeSurfer's kinds of surfaces, and two of this package, so that its results take no name of FreeSurfer's files.
_KINDS = ("pial", "white", "sphere", "inflated", "smoothwm", "orig", "midthickness", "graymid", "qsphere", "reg",
          "surf", "conformal", "balanced")
#: How names of FreeSurfer's files begin.
HEMISPHERES = ("lh.", "rh.")
#: All formats. A further one is a module with `read` and `write`, and a row here.
FORMATS = (
    Format("OBJ", "obj", (".obj",)),
    Format("OFF", "off", (".off",), magic=(b"OFF", b"COFF", b"NOFF", b"CNOFF")),
    Format("PLY", "ply", (".ply",), magic=(b"ply\n", b"ply\r"), both=True),
    Format("STL", "stl", (".stl",), single=True, ordered=False),
    Format("VTK", "vtk", (".vtk",), magic=(b"# vtk DataFile",)),
    Format("VTP", "vtp", (".vtp",), magic=(b"<VTKFile",)),
    Format("glTF", "gltf", (".glb", ".gltf"), magic=(b"glTF",), single=True, package="trimesh"),
    Format("GIFTI", "gifti", (".gii", ".gii.gz"), magic=(b"<?xml", b"\x1f\x8b"), radius=100.0, single=True,
           package="nibabel"),
    Format("FreeSurfer", "freesurfer", tuple(f".{kind}" for kind in _KINDS),
           magic=(b"\xff\xff\xfe", b"\xff\xff\xff"), radius=100.0, single=True, package="nibabel"),
    Format("NPZ", "npz", (".npz",), magic=(b"PK\x03\x04",), both=True),
)


def format_of(path: PathLike) -> Format:
    """The format of a file by its name, or else by its first bytes; other names with lh. or rh. are FreeSurfer's.

    Examples
    --------
    >>> format_of("bunny.OBJ").name, format_of("sub-01/surf/lh.sphere.v2").name, format_of("lh.pial.surf.gii").name
    ('OBJ', 'FreeSurfer', 'GIFTI')
    """
    path = Path(path)
    for entry in FORMATS:
        if path.name.lower().endswith(entry.suffixes):
            return entry
    if path.is_file():
        with path.open("rb") as file:
            head = file.read(16)
        for entry in FORMATS:
            if entry.magic and head.startswith(entry.magic):
                return entry
    if path.name.startswith(HEMISPHERES):
        return next(entry for entry in FORMATS if entry.name == "FreeSurfer")
    known = ", ".join(f"{entry.name} ({', '.join(entry.suffixes)})" for entry in FORMATS)
    raise FileError(f"{path}: unknown format; the end of the name decides: {known}")
