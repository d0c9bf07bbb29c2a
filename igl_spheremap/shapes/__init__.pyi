"""The public names of several surfaces and of bases, by theme, each with the module that defines it."""

# ruff: isort: off

# Maps between surfaces, registration.
from .correspondence.matching import match as match
from .correspondence.surface_map import SurfaceMap as SurfaceMap
from .correspondence.files import write_surface_map as write_surface_map
from .correspondence.files import read_surface_map as read_surface_map
from .correspondence.registration import register as register
from .correspondence.registration import Registration as Registration

# Groups.
from .groups.template import template as template
from .groups.group import Group as Group
from .groups.permutation import permutation_test as permutation_test
from .groups.series import series as series
from .groups.files import write_group as write_group
from .groups.files import read_group as read_group

# Harmonics and grids.
from .harmonics.harmonics import spherical_harmonics as spherical_harmonics
from .harmonics.harmonics import SphericalHarmonics as SphericalHarmonics
from .harmonics.harmonics import coefficients_from_mesh as coefficients_from_mesh
from .harmonics.files import write_coefficients as write_coefficients
from .harmonics.files import read_coefficients as read_coefficients
from .harmonics.grid import to_grid as to_grid
from .harmonics.geometry_image import mesh_from_grid as mesh_from_grid
from .harmonics.grid import from_grid as from_grid

__all__: list[str]
