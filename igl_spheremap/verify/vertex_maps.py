"""Scalar maps over the vertices of a mapped surface."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..errors import own_errstate
from ..mesh.arrays import FloatArray, check_rows
from ..mesh.check import check_mesh
from .distortion import mesh_angle_differences, mesh_conformal_factor


@own_errstate
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
    >>> from igl_spheremap.verify.vertex_maps import vertex_maps
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


