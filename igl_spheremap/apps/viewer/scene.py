"""A map in a polyscope scene of the caller's own, beside whatever is there."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...draw import palette
from ...errors import DisplayError
from ...gate import gate
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray, check_rows
from ...verify.signs import folded_faces
from .colouring import checkerboard, measured
from .window import linear, ps

QUANTITIES = ("foldings", "angle difference", "log area ratio", "checkerboard")
#: Polyscope's choice of the range of their colours.
_RANGES = {"angle difference": "magnitude", "log area ratio": "symmetric"}
#: Side of polyscope's squares, if nobody sets it. Its setter may raise if handles of replaced structures are held.
_SQUARE = 0.02


@gate
def add_to_polyscope(
    result: SphereMap,
    name: str = "surface",
    *,
    x: ArrayLike | None = None,
    shown: str = "foldings",
) -> tuple[Any, Any]:
    """Add a surface and its sphere to the present polyscope scene, with the map's measures as quantities.

    Nothing is opened and no setting of the scene is changed. Both structures have the quantities "foldings" (folded
    faces in red), "angle difference" (degrees, the mean of a face's corners), "log area ratio" (natural logarithm of
    image over source area) and "checkerboard" (a texture of the sphere, the same on both).

    Parameters
    ----------
    result : SphereMap
        A map.
    name : str, default "surface"
        The name of the surface in polyscope; the sphere is called "<name> on the sphere". Structures of these names
        are replaced.
    x : (n, 3) array_like, optional
        Another map of the same surface in its place, folded or not, such as `gauss_map(v, f)` or an iterate's.
    shown : str, default "foldings"
        The quantity that is enabled.

    Returns
    -------
    (polyscope.SurfaceMesh, polyscope.SurfaceMesh)
        The surface with the given vertices, and the sphere, whose vertices are those of the map. Its transform puts it
        beside the surface, to the right in polyscope's home view, and as large.

    Raises
    ------
    DisplayError
        If polyscope was not initialised.
    ValueError
        If `shown` is no such quantity.
    MeshError
        If `x` does not have one row for each vertex.

    See Also
    --------
    show : a window of its own, with a lens.

    Examples
    --------
    >>> import polyscope as ps
    >>> import igl_spheremap as ism
    >>> ps.init()  # doctest: +SKIP
    >>> result = ism.spherical_conformal_map(*ism.samples.make("dino"))
    >>> surface, sphere = ism.add_to_polyscope(result, "dino")  # doctest: +SKIP
    >>> ps.show()  # doctest: +SKIP
    """
    if shown not in QUANTITIES:
        raise ValueError(f"unknown quantity {shown!r}: choose one of {', '.join(QUANTITIES)}")
    if not ps.is_initialized():
        raise DisplayError("polyscope has no scene yet; call polyscope.init() first")
    mesh, f = result.mesh, result.faces
    if x is None:
        x = result.sphere
    x = check_rows(x, len(mesh.v), "positions of the map")
    folded = np.flatnonzero(folded_faces(x, f))
    colours = np.tile(linear(np.array(palette.SURFACE)), (len(f), 1))
    colours[folded] = linear(np.array(palette.FOLDED))
    angles, areas = (
        measured(mesh, x, subject) for subject in ("angle differences", "area distortion")
    )
    checks = _SQUARE * np.asarray(checkerboard(mesh, x, folded=folded).checks)
    surface = ps.register_surface_mesh(name, result.vertices, f)
    sphere = ps.register_surface_mesh(f"{name} on the sphere", x, f)
    sphere.set_transform(_beside(result.vertices))
    for structure in (surface, sphere):
        for quantity, values in (("angle difference", angles), ("log area ratio", areas)):
            structure.add_scalar_quantity(
                quantity,
                values,
                defined_on="faces",
                datatype=_RANGES[quantity],
                enabled=shown == quantity,
            )
        structure.add_color_quantity(
            "foldings", colours, defined_on="faces", enabled=shown == "foldings"
        )
        structure.add_parameterization_quantity(
            "checkerboard", checks, defined_on="corners", enabled=shown == "checkerboard"
        )
    return surface, sphere


def _beside(v: FloatArray) -> FloatArray:
    """The transform of a unit sphere that puts it beside a surface, to the right of the home view, as large."""
    right = np.cross(_axis(ps.get_up_dir()), _axis(ps.get_front_dir()))
    low, high = v.min(axis=0), v.max(axis=0)
    radius = float((high - low).max()) / 2
    matrix = np.diag([radius, radius, radius, 1.0])
    across = float(np.abs(right) @ (high - low)) / 2
    matrix[:3, 3] = (low + high) / 2 + (across + 1.3 * radius) * right
    return matrix


def _axis(name: str) -> FloatArray:
    """The direction that polyscope calls "z_up" or "neg_x_front"."""
    axis = np.eye(3)["xyz".index(name.removeprefix("neg_")[0])]
    if name.startswith("neg_"):
        return -axis
    return axis
