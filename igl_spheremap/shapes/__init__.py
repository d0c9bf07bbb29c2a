"""Several surfaces in correspondence, and surfaces in spherical harmonics: matches, registrations, groups."""

from ..lazy import attach

#: The module that defines each public name; the stub beside this file tells type checkers the same.
_MODULES = {
    "Group": "groups.group",
    "Registration": "correspondence.registration",
    "SphericalHarmonics": "harmonics.harmonics",
    "SurfaceMap": "correspondence.surface_map",
    "coefficients_from_mesh": "harmonics.harmonics",
    "from_grid": "harmonics.grid",
    "match": "correspondence.matching",
    "mesh_from_grid": "harmonics.geometry_image",
    "permutation_test": "groups.permutation",
    "read_coefficients": "harmonics.files",
    "read_group": "groups.files",
    "read_surface_map": "correspondence.files",
    "register": "correspondence.registration",
    "series": "groups.series",
    "spherical_harmonics": "harmonics.harmonics",
    "template": "groups.template",
    "to_grid": "harmonics.grid",
    "write_coefficients": "harmonics.files",
    "write_group": "groups.files",
    "write_surface_map": "correspondence.files",
}
__getattr__, __dir__, __all__ = attach(__name__, _MODULES)
del attach
