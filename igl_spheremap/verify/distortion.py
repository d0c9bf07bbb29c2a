"""Changes of angles, areas and lengths by a map, and their statistics."""

from __future__ import annotations

import igl
import numpy as np
from numpy.typing import ArrayLike

from ..gate import takes_mesh
from ..mesh.arrays import FloatArray, IntArray, check_rows, check_triangles, own_unit
from ..mesh.check import Mesh, check_indices, check_positions
from ..mesh.disk import Disk
from ..mesh.measure import corner_angles, log_face_areas, log_vertex_areas, surface_area


@takes_mesh
def angle_differences(v: ArrayLike, f: ArrayLike, x: ArrayLike) -> FloatArray:
    """Change of every corner angle, image minus source, in degrees.

    Both angles are those of flat triangles, the image's spanned by its three corners on the sphere.

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
        Degrees; column k belongs to corner ``f[:, k]``. Zero for a conformal map.

    Raises
    ------
    MeshError
        If `v, f` is not a triangle mesh or `x` has not one row per vertex.

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
    v, f, x = _checked(v, f, x)
    return np.degrees(corner_angles(x, f) - corner_angles(v, f))


def mean_angle_difference(mesh: Mesh | Disk, x: FloatArray) -> float:
    """Mean size of the angle differences, in degrees, of a checked mesh without its caps."""
    return mean_difference(mesh.angles[mesh.surface], x, mesh.f[mesh.surface])


def mean_difference(source: FloatArray, x: FloatArray, f: IntArray) -> float:
    """Mean size of the angle differences, in degrees, from the source's corner angles in radians."""
    return float(np.degrees(np.abs(corner_angles(x, f) - source).mean()))


@takes_mesh
def conformal_factor(v: ArrayLike, f: ArrayLike, x: ArrayLike) -> FloatArray:
    """Conformal factor e^{2u} at the vertices: image area over source area of the faces around, equation (14).

    It takes the arrays that `angle_differences` takes.

    Returns
    -------
    (n,) float64 array
        e^{2u}, non-negative; its mean over the source is the flat image area, nearly 4 pi. It is infinite if only the
        source's faces have no area, and 0 if the image's have none or one below the least float.

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
    return np.exp(_log_conformal_factor(*_checked(v, f, x)))


@takes_mesh
def log_area_ratios(v: ArrayLike, f: ArrayLike, x: ArrayLike) -> FloatArray:
    """Natural logarithm of image area over source area of every face, each surface having area 1.

    Both areas are those of flat triangles, the image's spanned by its three corners on the sphere.

    It takes the arrays that `angle_differences` takes.

    Returns
    -------
    (m,) float64 array
        Zero for an area-preserving map; infinite if one of the areas is zero, NaN if both are. Areas below the least
        float have their true logarithms.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("spheroid", n_vertices=1000)
    >>> conformal, preserving = (ism.balanced_spherical_map(v, f, balance=balance) for balance in (0, 1))
    >>> bool(abs(conformal.log_area_ratios()).mean() > 0.4), bool(abs(preserving.log_area_ratios()).mean() < 0.02)
    (True, True)
    """
    v, f, x = _checked(v, f, x)
    image, source = (log_face_areas(p, f) - np.log(surface_area(p, f)) for p in (x, v))
    return _log_ratio(image, source)


@takes_mesh
def log_length_ratios(v: ArrayLike, f: ArrayLike, x: ArrayLike) -> FloatArray:
    """Natural logarithm of image length over source length of every edge, each surface having area 1.

    It takes the arrays that `angle_differences` takes.

    Returns
    -------
    (m, 3) float64 array
        Natural logarithms. Column k belongs to the edge opposite corner ``f[:, k]``, so every edge appears twice. Zero
        for an isometry up to scale.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> x, f = ism.samples.sphere(162)
    >>> bool(abs(ism.log_length_ratios(3 * x, f, x)).max() < 1e-12)
    True
    """
    v, f, x = _checked(v, f, x)
    with np.errstate(divide="ignore"):
        image, source = (
            np.log(igl.edge_lengths(p, f)) - np.log(surface_area(p, f)) / 2 for p in (x, v)
        )
    return _log_ratio(image, source)


def _checked(v: ArrayLike, f: ArrayLike, x: ArrayLike) -> tuple[FloatArray, IntArray, FloatArray]:
    """Checked positions, in the mesh's own unit, faces and images; the surface need not be closed."""
    vertices = check_positions(v)
    faces = check_triangles(f)
    check_indices(faces, len(vertices))
    return own_unit(vertices)[0], faces, check_rows(x, len(vertices), "images")


def _log_conformal_factor(v: FloatArray, f: IntArray, x: FloatArray) -> FloatArray:
    """2 u of eq. (14), the source being scaled to unit area."""
    # eq. (14)
    return _log_ratio(log_vertex_areas(x, f), log_vertex_areas(v, f) - np.log(surface_area(v, f)))


def _log_ratio(image: FloatArray, source: FloatArray) -> FloatArray:
    """Difference of logarithms; NaN if both are -inf, that is, of 0."""
    with np.errstate(invalid="ignore"):
        return image - source


def vertex_maps(v: ArrayLike, f: ArrayLike, x: ArrayLike) -> dict[str, FloatArray]:
    """Change of areas and angles around each vertex.

    It takes the arrays that `angle_differences` takes.

    Returns
    -------
    dict of (n,) float64 arrays
        ``factor``: half the natural logarithm of the conformal factor, u of eq. (14), the source being scaled to the
        area of the sphere; 0 for an isometry. ``angles``: mean size of the angle differences at the vertex,
        in degrees.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> from igl_spheremap.verify.distortion import vertex_maps
    >>> x, f = ism.samples.sphere(162)
    >>> maps = vertex_maps(5 * x, f, x)
    >>> bool(abs(maps["angles"]).max() < 1e-9), bool(abs(maps["factor"]).max() < 0.02)
    (True, True)
    """
    vertices, faces, images = _checked(v, f, x)
    factor = (_log_conformal_factor(vertices, faces, images) - np.log(4 * np.pi)) / 2
    corners = faces.ravel()
    size = np.abs(np.degrees(corner_angles(images, faces) - corner_angles(vertices, faces))).ravel()
    angles = np.bincount(corners, size) / np.bincount(corners)
    return {"factor": factor, "angles": angles}


def log_figures(ratios: FloatArray) -> dict[str, float]:
    """Mean, 99th percentile and maximum of the sizes of logarithms of ratios, without those of zero areas.

    NaN if all are left out.

    >>> log_figures(np.array([0.5, -1.5, np.inf]))["mean"]
    1.0
    """
    finite = ratios[np.isfinite(ratios)]
    size = np.full(1, np.nan)
    if len(finite):
        size = np.abs(finite)
    return {
        "mean": float(size.mean()),
        "p99": float(np.percentile(size, 99)),
        "max": float(size.max()),
    }


def angle_figures(differences: FloatArray) -> dict[str, float]:
    """Mean, median, 95th and 99th percentile and maximum of the sizes of angle differences, in their units.

    >>> angle_figures(np.array([[1.0, -2.0, 3.0]]))["median"]
    2.0
    """
    size = np.abs(differences).ravel()
    median, p95, p99 = np.percentile(size, [50, 95, 99]).tolist()
    return {
        "mean": float(size.mean()),
        "median": median,
        "p95": p95,
        "p99": p99,
        "max": float(size.max()),
    }
