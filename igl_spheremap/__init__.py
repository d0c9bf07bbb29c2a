"""Conformal maps of genus-0 triangle meshes to the unit sphere, proved free of foldings."""

from ._version import __version__ as __version__

TYPE_CHECKING = False  # as type checkers know it; `typing` would take most of the time until Ctrl-C is caught
if TYPE_CHECKING:  # the same names once more, for type checkers and editors
    from . import samples as samples
    from .apps.viewer.player import play as play
    from .apps.viewer.result_view import screenshot as screenshot
    from .apps.viewer.result_view import show as show
    from .descent.energies.harmonic import harmonic_energy as harmonic_energy
    from .descent.energies.p_harmonic import p_harmonic_energy as p_harmonic_energy
    from .errors import DisplayError as DisplayError
    from .errors import FactorisationFailed as FactorisationFailed
    from .errors import FileError as FileError
    from .errors import FoldingsRemain as FoldingsRemain
    from .errors import MapError as MapError
    from .errors import MeshError as MeshError
    from .errors import NotConverged as NotConverged
    from .errors import WorkersUnavailable as WorkersUnavailable
    from .io.coefficients import read_coefficients as read_coefficients
    from .io.coefficients import write_coefficients as write_coefficients
    from .io.files import read_mesh as read_mesh
    from .io.files import write_mesh as write_mesh
    from .io.written_map import read_map as read_map
    from .io.written_map import write_map as write_map
    from .maps.balanced import balanced_spherical_map as balanced_spherical_map
    from .maps.balanced import rebalance as rebalance
    from .maps.given_sphere import repair_foldings as repair_foldings
    from .maps.given_sphere import sphere_map as sphere_map
    from .maps.landmarks import landmark_map as landmark_map
    from .maps.mapper import SphereMapper as SphereMapper
    from .maps.options import Auto as Auto
    from .maps.options import GuYau as GuYau
    from .maps.options import Lai2014 as Lai2014
    from .maps.options import Stereographic as Stereographic
    from .maps.p_harmonic import p_harmonic_map as p_harmonic_map
    from .maps.remove_foldings import minimize_harmonic_energy as minimize_harmonic_energy
    from .maps.remove_foldings import remove_foldings as remove_foldings
    from .maps.spherical_conformal_map import spherical_conformal_map as spherical_conformal_map
    from .mesh.check import Mesh as Mesh
    from .mesh.check import check_faces as check_faces
    from .mesh.check import check_mesh as check_mesh
    from .mesh.clean import RepairedMesh as RepairedMesh
    from .mesh.clean import repair_mesh as repair_mesh
    from .populations.map_many import map_many as map_many
    from .populations.table import Row as Row
    from .result.recording import Recording as Recording
    from .result.run import Iterate as Iterate
    from .result.run import Round as Round
    from .result.run import Run as Run
    from .result.run import Status as Status
    from .result.run import Step as Step
    from .result.sphere_map import SphereMap as SphereMap
    from .shapes.grid import from_grid as from_grid
    from .shapes.grid import to_grid as to_grid
    from .shapes.harmonics import AlignedHarmonics as AlignedHarmonics
    from .shapes.harmonics import Expanded as Expanded
    from .shapes.harmonics import SphericalHarmonics as SphericalHarmonics
    from .shapes.harmonics import spherical_harmonics as spherical_harmonics
    from .shapes.locate import Location as Location
    from .shapes.locate import SphereLocator as SphereLocator
    from .shapes.registration import Registration as Registration
    from .shapes.registration import RegistrationStage as RegistrationStage
    from .shapes.registration import register as register
    from .shapes.rotation import RotationCandidate as RotationCandidate
    from .shapes.texture import Atlas as Atlas
    from .shapes.texture import texture_atlas as texture_atlas
    from .shapes.transfer import Resampled as Resampled
    from .shapes.transfer import resample as resample
    from .shapes.transfer import transfer as transfer
    from .sphere.cayley import cayley_update as cayley_update
    from .start.star_map import EigenProjection as EigenProjection
    from .start.star_map import gauss_map as gauss_map
    from .start.star_map import weighted_eigen_projection as weighted_eigen_projection
    from .untangle.effort import Effort as Effort
    from .verify.certificate import Certificate as Certificate
    from .verify.certificate import certify as certify
    from .verify.distortion import angle_differences as angle_differences
    from .verify.distortion import area_distortion as area_distortion
    from .verify.distortion import conformal_factor as conformal_factor
    from .verify.distortion import edge_distortion as edge_distortion

#: The public names by the modules that define them. Each is imported at its first use, so that a program pays for what
#: it uses.
_NAMES = {
    "apps.viewer.player": "play",
    "apps.viewer.result_view": "screenshot show",
    "descent.energies.harmonic": "harmonic_energy",
    "descent.energies.p_harmonic": "p_harmonic_energy",
    "result.run": "Iterate Round Run Status Step",
    "result.recording": "Recording",
    "errors": "DisplayError FactorisationFailed FileError FoldingsRemain MapError MeshError NotConverged "
              "WorkersUnavailable",
    "io.coefficients": "read_coefficients write_coefficients",
    "io.files": "read_mesh write_mesh",
    "io.written_map": "read_map write_map",
    "maps.balanced": "balanced_spherical_map rebalance",
    "maps.given_sphere": "repair_foldings sphere_map",
    "maps.landmarks": "landmark_map",
    "maps.mapper": "SphereMapper",
    "maps.options": "Auto GuYau Lai2014 Stereographic",
    "maps.p_harmonic": "p_harmonic_map",
    "maps.remove_foldings": "minimize_harmonic_energy remove_foldings",
    "result.sphere_map": "SphereMap",
    "maps.spherical_conformal_map": "spherical_conformal_map",
    "mesh.check": "Mesh check_faces check_mesh",
    "mesh.clean": "RepairedMesh repair_mesh",
    "populations.map_many": "map_many",
    "populations.table": "Row",
    "samples": "samples",
    "shapes.grid": "from_grid to_grid",
    "shapes.harmonics": "AlignedHarmonics Expanded SphericalHarmonics spherical_harmonics",
    "shapes.locate": "Location SphereLocator",
    "shapes.registration": "Registration RegistrationStage register",
    "shapes.rotation": "RotationCandidate",
    "shapes.texture": "Atlas texture_atlas",
    "shapes.transfer": "Resampled resample transfer",
    "sphere.cayley": "cayley_update",
    "untangle.effort": "Effort",
    "start.star_map": "EigenProjection gauss_map weighted_eigen_projection",
    "verify.certificate": "Certificate certify",
    "verify.distortion": "angle_differences area_distortion conformal_factor edge_distortion",
}
_HOME = {name: module for module, names in _NAMES.items() for name in names.split()}

if not TYPE_CHECKING:  # checkers are to believe the imports above
    __all__ = sorted(_HOME)

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
    return sorted(_HOME)
