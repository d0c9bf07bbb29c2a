"""Files: one module per format, registered in the table `FORMATS`."""

from .files import read_mesh, read_sphere, write_mesh
from .formats import FORMATS, format_of
from .records import Format, LoadedMesh
from .replacing import check_writable
from .scalars import write_scalars
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
    "read_map",
    "read_mesh",
    "read_sphere",
    "write_map",
    "write_mesh",
    "write_scalars",
    "write_sphere",
    "write_textured",
]
