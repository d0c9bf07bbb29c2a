"""Conformal maps of genus-0 triangle meshes to the unit sphere, proved free of foldings."""

from .certify import Certificate, certify
from .distortion import angle_differences, conformal_factor
from .errors import FileError, FoldingsRemain, MapError, MeshError, NotConverged
from .mesh import Mesh, check_faces, check_mesh
from .sphere import cayley_update

__all__ = [
    "Certificate",
    "FileError",
    "FoldingsRemain",
    "MapError",
    "Mesh",
    "MeshError",
    "NotConverged",
    "angle_differences",
    "cayley_update",
    "certify",
    "check_faces",
    "check_mesh",
    "conformal_factor",
]

__version__ = "0.1.0"
