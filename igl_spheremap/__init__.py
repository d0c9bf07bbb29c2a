"""Conformal maps of genus-0 triangle meshes to the unit sphere, proved free of foldings."""

from ._version import __version__ as __version__

TYPE_CHECKING = False  # as type checkers know it; `typing` would take most of the time until Ctrl-C is caught
if TYPE_CHECKING:  # the same names once more, for type checkers and editors
    from . import samples
    from .apps.viewer.result_view import screenshot, show
    from .descent.energies.harmonic import harmonic_energy
    from .descent.energies.p_harmonic import p_harmonic_energy
    from .descent.iterate import Iterate, Round, Status, Step
    from .descent.recording import Recording
    from .errors import (
        DisplayError,
        FactorisationFailed,
        FileError,
        FoldingsRemain,
        MapError,
        MeshError,
        NotConverged,
        WorkersUnavailable,
    )
    from .io.coefficients import read_coefficients, write_coefficients
    from .io.files import read_mesh, write_mesh
    from .io.written_map import read_map, write_map
    from .maps.balanced import balanced_spherical_map, rebalance
    from .maps.given_sphere import sphere_map
    from .maps.landmarks import landmark_map
    from .maps.mapper import SphereMapper
    from .maps.options import Auto, GuYau, Lai2014, Stereographic
    from .maps.p_harmonic import p_harmonic_map
    from .maps.remove_foldings import minimize_harmonic_energy, remove_foldings
    from .maps.repair_foldings import repair_foldings
    from .maps.sphere_map import SphereMap
    from .maps.spherical_conformal_map import spherical_conformal_map
    from .mesh.check import Mesh, check_faces, check_mesh
    from .mesh.clean import RepairedMesh, repair_mesh
    from .mesh.normals import gauss_map
    from .populations.map_many import map_many
    from .populations.table import Row
    from .shapes.grid import from_grid, to_grid
    from .shapes.harmonics.spherical_harmonics import AlignedHarmonics, SphericalHarmonics, spherical_harmonics
    from .shapes.locate import Location, SphereLocator
    from .shapes.registration.register import Registration, RegistrationStage, register
    from .shapes.texture import Atlas, texture_atlas
    from .shapes.transfer import resample, transfer
    from .sphere.cayley import cayley_update
    from .start.star_map import EigenProjection, weighted_eigen_projection
    from .verify.atlas import ChartAtlas, atlas_angle_differences
    from .verify.certificate import Certificate, certify
    from .verify.distortion import angle_differences, conformal_factor
    from .verify.stretch import area_distortion, edge_distortion

#: Where each public name is defined. It is imported at its first use, so that a program pays for what it uses.
_HOME = {
    "screenshot": "apps.viewer.result_view",
    "show": "apps.viewer.result_view",
    "harmonic_energy": "descent.energies.harmonic",
    "p_harmonic_energy": "descent.energies.p_harmonic",
    "Iterate": "descent.iterate",
    "Round": "descent.iterate",
    "Status": "descent.iterate",
    "Step": "descent.iterate",
    "Recording": "descent.recording",
    "DisplayError": "errors",
    "FactorisationFailed": "errors",
    "FileError": "errors",
    "FoldingsRemain": "errors",
    "MapError": "errors",
    "MeshError": "errors",
    "NotConverged": "errors",
    "WorkersUnavailable": "errors",
    "read_coefficients": "io.coefficients",
    "write_coefficients": "io.coefficients",
    "read_mesh": "io.files",
    "write_mesh": "io.files",
    "read_map": "io.written_map",
    "write_map": "io.written_map",
    "sphere_map": "maps.given_sphere",
    "landmark_map": "maps.landmarks",
    "balanced_spherical_map": "maps.balanced",
    "rebalance": "maps.balanced",
    "SphereMapper": "maps.mapper",
    "Auto": "maps.options",
    "GuYau": "maps.options",
    "Lai2014": "maps.options",
    "Stereographic": "maps.options",
    "p_harmonic_map": "maps.p_harmonic",
    "repair_foldings": "maps.repair_foldings",
    "SphereMap": "maps.sphere_map",
    "minimize_harmonic_energy": "maps.remove_foldings",
    "remove_foldings": "maps.remove_foldings",
    "spherical_conformal_map": "maps.spherical_conformal_map",
    "Mesh": "mesh.check",
    "check_faces": "mesh.check",
    "check_mesh": "mesh.check",
    "RepairedMesh": "mesh.clean",
    "repair_mesh": "mesh.clean",
    "gauss_map": "mesh.normals",
    "map_many": "populations.map_many",
    "Row": "populations.table",
    "from_grid": "shapes.grid",
    "to_grid": "shapes.grid",
    "AlignedHarmonics": "shapes.harmonics.spherical_harmonics",
    "SphericalHarmonics": "shapes.harmonics.spherical_harmonics",
    "spherical_harmonics": "shapes.harmonics.spherical_harmonics",
    "Location": "shapes.locate",
    "SphereLocator": "shapes.locate",
    "Registration": "shapes.registration.register",
    "RegistrationStage": "shapes.registration.register",
    "register": "shapes.registration.register",
    "Atlas": "shapes.texture",
    "texture_atlas": "shapes.texture",
    "resample": "shapes.transfer",
    "transfer": "shapes.transfer",
    "cayley_update": "sphere.cayley",
    "EigenProjection": "start.star_map",
    "weighted_eigen_projection": "start.star_map",
    "ChartAtlas": "verify.atlas",
    "atlas_angle_differences": "verify.atlas",
    "Certificate": "verify.certificate",
    "certify": "verify.certificate",
    "angle_differences": "verify.distortion",
    "conformal_factor": "verify.distortion",
    "area_distortion": "verify.stretch",
    "edge_distortion": "verify.stretch",
    "samples": "samples",
}

__all__ = [
    "AlignedHarmonics",
    "Atlas",
    "Auto",
    "Certificate",
    "ChartAtlas",
    "DisplayError",
    "EigenProjection",
    "FactorisationFailed",
    "FileError",
    "FoldingsRemain",
    "GuYau",
    "Iterate",
    "Lai2014",
    "Location",
    "MapError",
    "Mesh",
    "MeshError",
    "NotConverged",
    "Recording",
    "Registration",
    "RegistrationStage",
    "RepairedMesh",
    "Round",
    "Row",
    "SphereLocator",
    "SphereMap",
    "SphereMapper",
    "SphericalHarmonics",
    "Status",
    "Step",
    "Stereographic",
    "WorkersUnavailable",
    "angle_differences",
    "area_distortion",
    "atlas_angle_differences",
    "balanced_spherical_map",
    "cayley_update",
    "certify",
    "check_faces",
    "check_mesh",
    "conformal_factor",
    "edge_distortion",
    "from_grid",
    "gauss_map",
    "harmonic_energy",
    "landmark_map",
    "map_many",
    "minimize_harmonic_energy",
    "p_harmonic_energy",
    "p_harmonic_map",
    "read_coefficients",
    "read_map",
    "read_mesh",
    "rebalance",
    "register",
    "remove_foldings",
    "repair_foldings",
    "repair_mesh",
    "resample",
    "samples",
    "screenshot",
    "show",
    "sphere_map",
    "spherical_conformal_map",
    "spherical_harmonics",
    "texture_atlas",
    "to_grid",
    "transfer",
    "weighted_eigen_projection",
    "write_coefficients",
    "write_map",
    "write_mesh",
]


def __getattr__(name: str) -> object:
    """Import a public name from its room at first use."""
    from importlib import import_module

    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = import_module(f"{__name__}.{_HOME[name]}")
    value = module if name == "samples" else getattr(module, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
