"""Conformal maps of genus-0 triangle meshes to the unit sphere, proved free of foldings."""

from . import samples
from .certify import Certificate, certify
from .distortion import angle_differences, conformal_factor
from .eigen_projection import EigenProjection, weighted_eigen_projection
from .energy import harmonic_energy
from .errors import DisplayError, FactorisationFailed, FileError, FoldingsRemain, MapError, MeshError, NotConverged
from .io import read_map, read_mesh, write_map, write_mesh
from .iterate import Iterate, Status
from .locate import Location, SphereLocator
from .mapper import SphereMapper
from .mesh import Mesh, check_faces, check_mesh
from .mesh_repair import RepairedMesh, repair_mesh
from .p_harmonic import p_harmonic_energy
from .pipeline import minimize_harmonic_energy, remove_foldings, spherical_conformal_map
from .recording import Recording
from .repair import repair_foldings
from .sphere import cayley_update
from .sphere_map import Round, SphereMap, Step
from .starts import gauss_map
from .texture import Atlas, texture_atlas
from .transfer import resample, transfer
from .variational import landmark_map, p_harmonic_map
from .viewer import screenshot, show

__all__ = [
    "Atlas",
    "Certificate",
    "DisplayError",
    "EigenProjection",
    "FactorisationFailed",
    "FileError",
    "FoldingsRemain",
    "Iterate",
    "Location",
    "MapError",
    "Mesh",
    "MeshError",
    "NotConverged",
    "Recording",
    "RepairedMesh",
    "Round",
    "SphereLocator",
    "SphereMap",
    "SphereMapper",
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
    "landmark_map",
    "minimize_harmonic_energy",
    "p_harmonic_energy",
    "p_harmonic_map",
    "read_map",
    "read_mesh",
    "remove_foldings",
    "repair_foldings",
    "repair_mesh",
    "resample",
    "samples",
    "screenshot",
    "show",
    "spherical_conformal_map",
    "texture_atlas",
    "transfer",
    "weighted_eigen_projection",
    "write_map",
    "write_mesh",
]

__version__ = "0.1.0"
