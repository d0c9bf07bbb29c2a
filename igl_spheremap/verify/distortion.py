"""What a map does to angles, and its conformal factor."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..errors import own_errstate
from ..mesh.arrays import FloatArray, IntArray, check_rows
from ..mesh.check import Mesh, check_mesh
from ..mesh.measure import corner_angles, vertex_areas


@own_errstate
def angle_differences(v: ArrayLike, f: ArrayLike, x: ArrayLike) -> FloatArray:
    """Change of every corner angle, image minus source, in degrees.

    Both angles are those of flat triangles, the image's spanned by its three corners on the sphere.

    Parameters
    ----------
    v : (n, 3) array_like
        Source positions.
    f : (m, 3) array_like
        Faces as 0-based vertex indices.
    x : (n, 3) array_like
        Images of the vertices.

    Returns
    -------
    (m, 3) float64 array
        Degrees; column k belongs to corner ``f[:, k]``. Zero for a conformal map.

    Raises
    ------
    MeshError
        If `v, f` is no closed genus-0 mesh or `x` has not one row per vertex.

    References
    ----------
    Lai et al., section 3.3 and the histograms of Figs. 4 and 10.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]
    >>> f = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]
    >>> bool(abs(ism.angle_differences(v, f, v)).max() < 1e-9)
    True
    """
    mesh = check_mesh(v, f)
    return mesh_angle_differences(mesh, check_rows(x, len(mesh.v), "images"))


def mesh_angle_differences(mesh: Mesh, x: FloatArray) -> FloatArray:
    """`angle_differences` of a checked mesh."""
    return np.degrees(corner_angles(x, mesh.f) - corner_angles(mesh.v, mesh.f))


def mean_angle_difference(mesh: Mesh, x: FloatArray) -> float:
    """Mean size of the angle differences, in degrees, of a checked mesh."""
    return mean_difference(corner_angles(mesh.v, mesh.f), x, mesh.f)


def mean_difference(source: FloatArray, x: FloatArray, f: IntArray) -> float:
    """The same from the source's corner angles in radians, for programs that compare many maps of one mesh."""
    return float(np.degrees(np.abs(corner_angles(x, f) - source).mean()))


@own_errstate
def conformal_factor(v: ArrayLike, f: ArrayLike, x: ArrayLike) -> FloatArray:
    """Conformal factor e^{2u} at the vertices: image area over source area of the faces around, equation (14).

    Parameters
    ----------
    v : (n, 3) array_like
        Source positions; their scale does not matter, the source counts as having unit area.
    f : (m, 3) array_like
        Faces as 0-based vertex indices.
    x : (n, 3) array_like
        Images of the vertices.

    Returns
    -------
    (n,) float64 array
        e^{2u}, non-negative; its mean over the source is the flat image area, nearly 4 pi.

    Raises
    ------
    MeshError
        If `v, f` is no closed genus-0 mesh or `x` has not one row per vertex.

    References
    ----------
    Lai et al., eq. (14).

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]
    >>> f = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]
    >>> ism.conformal_factor(v, f, v).round(6)
    array([13.856406, 13.856406, 13.856406, 13.856406])
    """
    mesh = check_mesh(v, f)
    return mesh_conformal_factor(mesh, check_rows(x, len(mesh.v), "images"))


def mesh_conformal_factor(mesh: Mesh, x: FloatArray) -> FloatArray:
    """`conformal_factor` of a checked mesh; infinite where only the source's faces have no area."""
    n = len(mesh.v)
    image, source = vertex_areas(x, mesh.f), vertex_areas(mesh.v, mesh.f)
    ratio = np.full(n, np.inf)
    ratio[image == 0] = 0.0
    return np.divide(image, source, out=ratio, where=source > 0)  # eq. (14)
