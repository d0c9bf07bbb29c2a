"""Conformal maps of genus-0 triangle meshes to the unit sphere, proved free of foldings."""

from . import samples
from .certify import Certificate, certify
from .distortion import angle_differences, conformal_factor
from .eigen_projection import EigenProjection, weighted_eigen_projection
from .energy import harmonic_energy
from .errors import FactorisationFailed, FileError, FoldingsRemain, MapError, MeshError, NotConverged
from .iterate import Iterate, Status
from .mesh import Mesh, check_faces, check_mesh
from .pipeline import minimize_harmonic_energy, remove_foldings, spherical_conformal_map
from .sphere import cayley_update
from .sphere_map import Round, SphereMap, Step
from .starts import gauss_map

__all__ = [
    "Certificate",
    "EigenProjection",
    "FactorisationFailed",
    "FileError",
    "FoldingsRemain",
    "Iterate",
    "MapError",
    "Mesh",
    "MeshError",
    "NotConverged",
    "Round",
    "SphereMap",
    "Status",
    "Step",
    "angle_differences",
    "cayley_update",
    "certify",
    "check_faces",
    "check_mesh",
    "conformal_factor",
    "gauss_map",
    "harmonic_energy",
    "minimize_harmonic_energy",
    "remove_foldings",
    "samples",
    "spherical_conformal_map",
    "weighted_eigen_projection",
]

__version__ = "0.1.0"
