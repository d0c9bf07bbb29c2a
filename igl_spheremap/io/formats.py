"""The table of formats. It imports no reader: a format's module is imported when a file is read or written."""

from __future__ import annotations

import os
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, Literal, get_args

from ..errors import FileError

PathLike = str | os.PathLike[str]
#: By whose convention a hemisphere's files are named. FreeSurfer's are written in its formats, the others as GIFTI.
Convention = Literal["bids", "freesurfer", "hcp", "fmriprep"]
CONVENTIONS = get_args(Convention)


@dataclass(frozen=True)
class Format:
    """A row of the table of formats."""

    name: str
    # of this room, with `read` and `write` of meshes, `read_scalars` and `write_scalars` of data
    module: str
    suffixes: tuple[str, ...]  # ends of file names, lower case; the first is the usual one
    magic: tuple[bytes, ...] = ()  # how files begin, for those whose name does not decide
    radius: float = 1.0  # of spheres, by the convention of the format's users
    single: bool = False  # positions are held in float32
    ordered: bool = True  # vertices keep their order
    both: bool = False  # a file can hold the sphere of its surface, too
    package: str = ""  # of an extra, without which files are neither read nor written
    data: bool = False  # a file can hold maps over the vertices

    @property
    def functions(self) -> Any:
        """The module, imported."""
        return import_module(f"{__package__}.{self.module}")


#: FreeSurfer's kinds of surfaces, and two of this package, so that its results take no name of FreeSurfer's files.
_KINDS = (
    "pial",
    "white",
    "sphere",
    "inflated",
    "smoothwm",
    "orig",
    "midthickness",
    "graymid",
    "qsphere",
    "reg",
    "surf",
    "conformal",
    "balanced",
)
#: How names of FreeSurfer's files begin.
HEMISPHERES = ("lh.", "rh.")
#: All formats of meshes. A further one is a module with `read` and `write`, and a row here.
FORMATS = (
    Format("OBJ", "obj", (".obj",)),
    Format("OFF", "off", (".off",), magic=(b"OFF", b"COFF", b"NOFF", b"CNOFF")),
    Format("PLY", "ply", (".ply",), magic=(b"ply\n", b"ply\r"), both=True, data=True),
    Format("STL", "stl", (".stl",), single=True, ordered=False),
    Format("VTK", "vtk", (".vtk",), magic=(b"# vtk DataFile",), data=True),
    Format("shape model", "plates", (".tab", ".ver", ".icq")),
    Format("glTF", "gltf", (".glb", ".gltf"), magic=(b"glTF",), single=True, package="trimesh"),
    Format(
        "GIFTI",
        "gifti",
        (".gii", ".gii.gz"),
        magic=(b"<?xml", b"\x1f\x8b"),
        radius=100.0,
        single=True,
        package="nibabel",
        data=True,
    ),
    Format(
        "FreeSurfer",
        "freesurfer",
        tuple(f".{kind}" for kind in _KINDS),
        magic=(b"\xff\xff\xfe", b"\xff\xff\xff"),
        radius=100.0,
        single=True,
        package="nibabel",
        data=True,
    ),
    Format("NPZ", "npz", (".npz",), magic=(b"PK\x03\x04",), both=True, data=True),
)
#: Ends of names of files that are read only: their tables of plates are laid out in other ways than the one written.
READ_ONLY = (".ver", ".icq")
#: All formats of maps over vertices.
DATA_FORMATS = (
    *(entry for entry in FORMATS if entry.data),
    Format("annotation", "annot", (".annot",), data=True),
    Format("NumPy", "arrays", (".npy",), data=True),
    Format("table", "arrays", (".csv", ".tsv", ".txt", ".1d"), data=True),
)


def format_of(path: PathLike, *, data: bool = False) -> Format:
    """The format of a mesh or of data by its name, or else by its first bytes; other lh.NAME and rh.NAME: FreeSurfer's.

    Examples
    --------
    >>> format_of("bunny.OBJ").name, format_of("sub-01/surf/lh.sphere.v2").name, format_of("lh.pial.surf.gii").name
    ('OBJ', 'FreeSurfer', 'GIFTI')
    """
    path, formats = Path(path), DATA_FORMATS if data else FORMATS
    for entry in formats:
        if path.name.lower().endswith(entry.suffixes):
            return entry
    if path.is_file():
        with path.open("rb") as file:
            head = file.read(16)
        for entry in formats:
            if entry.magic and head.startswith(entry.magic):
                return entry
    if path.name.startswith(HEMISPHERES):
        return next(entry for entry in formats if entry.name == "FreeSurfer")
    known = ", ".join(f"{entry.name} ({', '.join(entry.suffixes)})" for entry in formats)
    what = "unknown format of data" if data else "unknown format"
    raise FileError(f"{path}: {what}; the end of the name decides: {known}")
