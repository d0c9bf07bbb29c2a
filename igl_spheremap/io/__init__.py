"""Files: meshes, maps, data, coefficients and pictures; `FORMATS` lists the formats of meshes."""

from .coefficients import read_coefficients, write_coefficients
from .files import FORMATS, format_of, read_mesh, read_sphere, write_mesh
from .records import Format, LoadedMesh
from .replacing import check_writable
from .scalars import read_landmarks, read_scalars, write_scalars
from .textured import read_picture, write_picture, write_textured
from .written_map import (
    SphereCheck,
    certify_radius,
    make_mark,
    read_map,
    read_mark,
    write_map,
    write_sphere,
)

__all__ = [
    "FORMATS",
    "Format",
    "LoadedMesh",
    "SphereCheck",
    "certify_radius",
    "check_writable",
    "format_of",
    "make_mark",
    "read_coefficients",
    "read_landmarks",
    "read_map",
    "read_mark",
    "read_mesh",
    "read_picture",
    "read_scalars",
    "read_sphere",
    "write_coefficients",
    "write_map",
    "write_mesh",
    "write_picture",
    "write_scalars",
    "write_sphere",
    "write_textured",
]
