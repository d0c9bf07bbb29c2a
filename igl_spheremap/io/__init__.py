"""Files: one module per format, registered in the table `FORMATS`."""

from .coefficients import read_coefficients, write_coefficients
from .files import read_mesh, read_sphere, write_mesh
from .formats import FORMATS, format_of
from .marks import make_mark, read_mark
from .picture import read_picture, write_picture
from .records import Format, LoadedMesh
from .replacing import check_writable
from .scalars import read_scalars, write_scalars
from .textured import write_textured
from .written_map import SphereCheck, certify_radius, read_map, write_map, write_sphere

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
