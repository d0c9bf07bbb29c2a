"""The public names by theme, each with the module that defines it: `__init__.py` imports one at its first use."""

# ruff: isort: off

# Maps.
from .maps.spherical_conformal_map import spherical_conformal_map as spherical_conformal_map
from .balance.balanced_spherical_map import balanced_spherical_map as balanced_spherical_map
from .maps.mapper import SphereMapper as SphereMapper

# Results.
from .maps.sphere_map import SphereMap as SphereMap
from .result.run import Status as Status
from .result.run import Iterate as Iterate

# Judge and repair.
from .verify.certificate import certify as certify
from .verify.certificate import Certificate as Certificate
from .maps.given_sphere import sphere_map as sphere_map
from .maps.given_sphere import repair_foldings as repair_foldings
from .verify.distortion import angle_differences as angle_differences
from .verify.distortion import log_area_ratios as log_area_ratios
from .verify.distortion import log_length_ratios as log_length_ratios
from .verify.distortion import conformal_factor as conformal_factor

# Pictures.
from .apps.viewer.show import show as show
from .apps.viewer.show import screenshot as screenshot
from .apps.viewer.scene import add_to_polyscope as add_to_polyscope
from .apps.viewer.player import play as play
from .result.recording import Recording as Recording

# The paper.
from .paper.star_map import gauss_map as gauss_map
from .descent.energies import harmonic_energy as harmonic_energy
from .sphere.cayley import cayley_update as cayley_update
from .maps.algorithms import algorithm_1 as algorithm_1
from .paper.star_map import weighted_eigen_projection as weighted_eigen_projection
from .maps.algorithms import algorithm_2 as algorithm_2
from .maps.variational import p_harmonic_map as p_harmonic_map
from .maps.variational import fidelity_map as fidelity_map
from .maps.variational import landmark_map as landmark_map

# Methods and their options.
from .maps.options import Auto as Auto
from .paper.settings import Lai2014 as Lai2014
from .maps.options import GuYau as GuYau
from .maps.options import Stereographic as Stereographic
from .angles.effort import Effort as Effort

# Moebius maps.
from .sphere.riemann import moebius_map as moebius_map
from .sphere.riemann import recentre as recentre
from .sphere.riemann import moebius_through as moebius_through
from .sphere.riemann import stereographic as stereographic
from .sphere.riemann import inverse_stereographic as inverse_stereographic

# Meshes.
from .mesh.check import Mesh as Mesh
from .mesh.check import check_mesh as check_mesh
from .mesh_repair.repair_mesh import repair_mesh as repair_mesh
from .mesh_repair.repair_disk import repair_disk as repair_disk
from .mesh_repair.info import info as info

# Maps to the plane.
from .plane.disk_map import disk_conformal_map as disk_conformal_map
from .plane.disk_map import balanced_disk_map as balanced_disk_map
from .plane.disk_map import DiskMap as DiskMap
from .plane.flat_map import flatten as flatten
from .plane.flat_map import FlatMap as FlatMap
from .mesh.disk import check_disk as check_disk
from .io.plane_map import write_plane_map as write_plane_map
from .io.plane_map import read_plane_map as read_plane_map

# Through the sphere.
from .resampling.locate import SphereLocator as SphereLocator
from .resampling.locate import Location as Location
from .resampling.transfer import transfer as transfer
from .resampling.transfer import transfer_matrix as transfer_matrix
from .resampling.transfer import resample as resample
from .resampling.texture import texture_atlas as texture_atlas

# Populations.
from .populations.map_many import map_many as map_many
from .populations.engine import Engine as Engine

# Files.
from .io.files import read_mesh as read_mesh
from .io.write_mesh import write_mesh as write_mesh
from .io.label_image import label_surface as label_surface
from .io.written_map import read_map as read_map
from .io.written_map import write_map as write_map
from .io.scalars import read_scalars as read_scalars
from .io.scalars import write_scalars as write_scalars

# Samples.
from . import samples as samples

# Errors.
from .errors import MeshError as MeshError
from .errors import FileError as FileError
from .errors import MapError as MapError
from .errors import FoldingsRemain as FoldingsRemain

# Several surfaces, spherical harmonics and grids.
from . import shapes as shapes

__version__: str
__all__: list[str]
