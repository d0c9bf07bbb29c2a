"""What a map does to areas and lengths."""

from __future__ import annotations

import igl
import numpy as np
from numpy.typing import ArrayLike

from ..errors import own_errstate
from ..mesh.arrays import FloatArray, check_rows
from ..mesh.check import Mesh, check_mesh
from ..mesh.measure import face_areas, surface_area


@own_errstate
def area_distortion(v: ArrayLike, f: ArrayLike, x: ArrayLike) -> FloatArray:
    """Logarithm of image area over source area of every face, each surface having area 1.

    Both areas are those of flat triangles, the image's spanned by its three corners on the sphere.

    Parameters
    ----------
    v : (n, 3) array_like
        Source positions, any units.
    f : (m, 3) array_like
        Faces as 0-based vertex indices.
    x : (n, 3) array_like
        Images of the vertices.

    Returns
    -------
    (m,) float64 array
        Zero for an area-preserving map; infinite where one of the areas is zero, NaN where both are.

    Raises
    ------
    MeshError
        If `v, f` is no closed genus-0 mesh or `x` has not one row per vertex.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("spheroid", n_vertices=1000)
    >>> conformal, preserving = (ism.balanced_spherical_map(v, f, balance) for balance in (0, 1))
    >>> bool(abs(conformal.area_ratios()).mean() > 0.4), bool(abs(preserving.area_ratios()).mean() < 0.02)
    (True, True)
    """
    mesh = check_mesh(v, f)
    return mesh_area_distortion(mesh, check_rows(x, len(mesh.v), "images"))


def mesh_area_distortion(mesh: Mesh, x: FloatArray) -> FloatArray:
    """`area_distortion` for a checked mesh."""
    image, source = (face_areas(p, mesh.f) for p in (x, mesh.v))
    return _log_ratio(image / image.sum(), source / source.sum())


@own_errstate
def edge_distortion(v: ArrayLike, f: ArrayLike, x: ArrayLike) -> FloatArray:
    """Logarithm of image length over source length of every edge, each surface having area 1.

    Parameters
    ----------
    v : (n, 3) array_like
        Source positions, any units.
    f : (m, 3) array_like
        Faces as 0-based vertex indices.
    x : (n, 3) array_like
        Images of the vertices.

    Returns
    -------
    (m, 3) float64 array
        Column k belongs to the edge opposite corner ``f[:, k]``, so that every edge is there twice. Zero for an
        isometry up to scale.

    Raises
    ------
    MeshError
        If `v, f` is no closed genus-0 mesh or `x` has not one row per vertex.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> x, f = ism.samples.sphere(162)
    >>> bool(abs(ism.edge_distortion(3 * x, f, x)).max() < 1e-12)
    True
    """
    mesh = check_mesh(v, f)
    return mesh_edge_distortion(mesh, check_rows(x, len(mesh.v), "images"))


def mesh_edge_distortion(mesh: Mesh, x: FloatArray) -> FloatArray:
    """`edge_distortion` for a checked mesh."""
    image, source = (np.asarray(igl.edge_lengths(p, mesh.f)) / np.sqrt(surface_area(p, mesh.f))
                     for p in (x, mesh.v))
    return _log_ratio(image, source)


def _log_ratio(image: FloatArray, source: FloatArray) -> FloatArray:
    """log(image / source), infinities and NaN without warnings."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.log(image / source)
