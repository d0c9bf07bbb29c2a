"""Scalar maps over the vertices of a mapped surface, and colours for them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .distortion import mesh_angle_differences, mesh_conformal_factor
from .mesh import check_mesh, check_rows

FloatArray = NDArray[np.float64]

# Dark blue to yellow through green, nearly even in lightness: five colours of matplotlib's viridis.
_COLOURS = np.array([[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]], dtype=float)


def vertex_maps(v: ArrayLike, f: ArrayLike, x: ArrayLike) -> dict[str, FloatArray]:
    """What a map does to areas and angles around each vertex.

    Parameters
    ----------
    v : (n, 3) array_like
        Source positions.
    f : (m, 3) array_like
        Faces as 0-based vertex indices.
    x : (n, 3) array_like
        Images of the vertices on the unit sphere.

    Returns
    -------
    dict of (n,) float64 arrays
        ``factor``: half the logarithm of the conformal factor, u of eq. (14), the source being scaled to the
        area of the sphere; 0 for an isometry. ``angles``: mean size of the angle differences at the vertex,
        in degrees.

    Raises
    ------
    MeshError
        If `v, f` is no closed genus-0 mesh or `x` has not one row per vertex.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> from igl_spheremap.vertex_maps import vertex_maps
    >>> x, f = ism.samples.sphere(162)
    >>> maps = vertex_maps(5 * x, f, x)
    >>> bool(abs(maps["angles"]).max() < 1e-9), bool(abs(maps["factor"]).max() < 0.02)
    (True, True)
    """
    mesh = check_mesh(v, f)
    images = check_rows(x, len(mesh.v), "images")
    tiny = np.finfo(float).tiny
    factor = np.log(np.maximum(mesh_conformal_factor(mesh, images), tiny) / (4 * np.pi)) / 2
    size = np.abs(mesh_angle_differences(mesh, images)).ravel()
    corners = mesh.f.ravel()
    angles = np.bincount(corners, size) / np.bincount(corners)
    return {"factor": factor, "angles": angles}


def colours(values: FloatArray) -> dict[str, NDArray[np.uint8]]:
    """Colours for a scalar map, from its 1st to its 99th percentile.

    Parameters
    ----------
    values : (n,) float64 array
        The map; what is not finite is shown as an end of the scale.

    Returns
    -------
    dict of (n,) uint8 arrays
        ``red``, ``green`` and ``blue``, as PLY files name them.

    Examples
    --------
    >>> colours(np.array([0.0, 1.0]))["red"].tolist()
    [68, 253]
    """
    finite = values[np.isfinite(values)]
    low, high = np.percentile(finite, [1, 99]) if len(finite) else (0.0, 1.0)
    place = np.nan_to_num((values - low) / (high - low if high > low else 1.0), posinf=1.0, neginf=0.0)
    knots = np.linspace(0, 1, len(_COLOURS))
    return {
        name: np.interp(place, knots, _COLOURS[:, k]).astype(np.uint8)
        for k, name in enumerate(("red", "green", "blue"))
    }
