"""The table of formats, and which of them a file is."""

from __future__ import annotations

from pathlib import Path

from ..errors import FileError
from . import freesurfer, gifti, gltf, npz, obj, off, ply, stl
from .records import Format, PathLike

#: All formats. A further one is a module with a FORMAT, and its name here.
FORMATS: tuple[Format, ...] = tuple(
    module.FORMAT for module in (obj, off, ply, stl, gltf, gifti, freesurfer, npz)
)


def format_of(path: PathLike) -> Format:
    """The format of a file by its name, or else by its first bytes.

    Examples
    --------
    >>> format_of("bunny.OBJ").name, format_of("sub-01/surf/lh.pial").name, format_of("lh.pial.surf.gii").name
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
    known = ", ".join(f"{entry.name} ({entry.suffixes[0]})" for entry in FORMATS)
    raise FileError(f"{path}: unknown format; the end of the name decides: {known}")
