"""Data and surfaces carried between meshes through the sphere."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..draw.markup import table
from ..draw.shown import Drawing, Shown, place_drawing
from ..errors import MeshError, check_list
from ..gate import gate
from ..maps.sphere_map import SphereMap
from ..mesh.arrays import AnyArray, FloatArray, IntArray, check_rows, plain_array
from ..mesh.check import check_faces
from ..samples import sphere as regular_sphere
from .locate import Location, SphereLocator, locator_of
from .weights import (
    Resampling,
    TransferMatrix,
    adaptive_area,
    apply_matrix,
    check_resampling,
    largest,
    linear_matrix,
)


@dataclass(frozen=True, eq=False)
class Resampled(Shown):
    """A surface with the connectivity of another mesh of the sphere. Unpacks to ``v, f``.

    Attributes
    ----------
    v : (n, 3) float64 array
        Points of the surface.
    f : (m, 3) int64 array
        Faces of the other mesh.
    x : (n, 3) float64 array
        Images of the points on the sphere.
    location : Location
        The points on the surface that was resampled.
    """

    v: FloatArray
    f: IntArray
    x: FloatArray
    location: Location

    def __iter__(self) -> Iterator[Any]:
        return iter((self.v, self.f))

    def _drawing(self) -> Drawing:
        return place_drawing(
            (self.v, self.x),
            self.f,
            "Left: the surface; right: its points on the sphere. The same "
            "colour is the same point.",
        )

    def _figures(self) -> str:
        return table([("mesh", f"{len(self.v):,} vertices, {len(self.f):,} faces")])

    def __repr__(self) -> str:
        return f"Resampled({len(self.v)} vertices, {len(self.f)} faces)"


def interpolate(
    values: ArrayLike, f: IntArray, location: Location, labels: bool = False
) -> AnyArray:
    """Values at points of a mesh, from those at its vertices.

    With `labels` each point takes that of the corner with the largest weight; by default values are linear.
    Raises MeshError if there is not one value per vertex.

    >>> location = Location(np.array([0]), np.array([[0.5, 0.3, 0.2]]))
    >>> f = np.array([[0, 1, 2]])
    >>> interpolate([10.0, 20.0, 30.0], f, location), interpolate([10, 20, 30], f, location, labels=True)
    (array([17.]), array([10]))
    """
    values = plain_array(values, "values")
    n = int(f.max()) + 1
    given = len(np.atleast_1d(values))
    if not values.ndim or given != n:
        raise MeshError(f"{given} values for {n} vertices; give one for each")
    return weighted(values, f[location.face], location.weights, labels)


def weighted(values: AnyArray, corners: IntArray, weights: FloatArray, labels: bool) -> AnyArray:
    """For each row of `corners`, the weighted sum of their values, or the value of the largest weight."""
    if labels:
        return values[corners[np.arange(len(corners)), weights.argmax(axis=1)]]
    return np.einsum("ij,ij...->i...", weights, values[corners])


@gate
def transfer(
    source: SphereMap | SphereLocator,
    values: ArrayLike,
    target: str | SphereMap | ArrayLike | tuple[ArrayLike, ArrayLike],
    *,
    labels: bool = False,
    method: Resampling = "linear",
) -> AnyArray:
    """Carry data from one mesh to another through the sphere.

    Both maps should be rotated to agree; if the surfaces are aligned, the gauge of their maps does that.

    Parameters
    ----------
    source : SphereMap or SphereLocator
        Surface of the data.
    values : (n,) or (n, ...) array_like
        At the vertices of the source.
    target : str, SphereMap, (k, 3) array_like, or (x, f)
        Their target: the vertices of ``ico:K``, of another map or of any mesh of the sphere, or points.
    labels : bool
        The values are labels: take that of the vertex with the largest weight; by default weighted sums are taken.
    method : {"linear", "adaptive-area"}
        "linear" interpolates in the face of the source that holds the point. "adaptive-area" keeps integrals, as
        `transfer_matrix` describes; it needs a map, and faces at the target.

    Returns
    -------
    (k,) or (k, ...) array
        At the target; of several data at once see `transfer_matrix`.

    Raises
    ------
    MeshError
        If there is not one value per vertex, or the target is neither rows of three nor a closed genus-0 mesh.
    FoldingsRemain
        If a map is not certified folding-free.
    TypeError
        If the source is not a map, for instance because the arguments are in another order, or if the target has no
        faces and the method needs them.
    ValueError
        If there is no such method, or no regular sphere of that name.

    See Also
    --------
    transfer_matrix : the weights, for several data.
    resample : the surface itself on a regular sphere.
    shapes.match : a map from one surface to another.

    Examples
    --------
    >>> import numpy as np
    >>> import igl_spheremap as ism
    >>> source = ism.spherical_conformal_map(*ism.samples.make("spheroid", n_vertices=1000))
    >>> height = ism.transfer(source, source.sphere[:, 2], [[0, 0, 1], [0, 0, -1]])
    >>> np.allclose(height, [1, -1], atol=0.01)
    True
    """
    check_resampling(method)
    if method == "adaptive-area":
        return apply_matrix(transfer_matrix(source, target, method=method).matrix, values, labels)
    locator = _locator(source)
    return interpolate(values, locator.f, locator.locate(_points(target)), labels)


@gate
def transfer_matrix(
    source: SphereMap | SphereLocator,
    target: str | SphereMap | ArrayLike | tuple[ArrayLike, ArrayLike],
    *,
    labels: bool = False,
    method: Resampling = "linear",
) -> TransferMatrix:
    """Weights by which data go from one mesh to another, to be applied to several data, or elsewhere.

    "adaptive-area" is the method that HCP calls ADAP_BARY_AREA. Each target lies in a face of the source and takes that
    face's corners. But if other vertices of the source lie in the faces around the target, it takes all of these, each
    with its barycentric weight in the face that holds it. So no vertex is left out, whichever mesh is finer. Weights
    count by the target's areas, and each vertex of the source divides its area among the targets that take it.

    Parameters
    ----------
    source, target, method
        As for `transfer`.
    labels : bool
        Keep a single 1 in each row, at its largest weight.

    Returns
    -------
    TransferMatrix
        The matrix, targets by sources, so that `transfer` of values is ``weights.matrix @ values``; by "adaptive-area"
        with the areas that keep integrals. Those of a target (x, f) are areas of the source's surface resampled there.

    Raises
    ------
    MeshError
        If the target is neither rows of three nor a closed genus-0 mesh.
    FoldingsRemain
        If a map is not certified folding-free.
    TypeError
        If the source is not a map, or if the target has no faces and the method needs them.
    ValueError
        If there is no such method, or no regular sphere of that name.

    See Also
    --------
    transfer : one set of data.

    References
    ----------
    Glasser et al. 2013, *The minimal preprocessing pipelines for the Human Connectome Project*.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> source = ism.spherical_conformal_map(*ism.samples.make("spheroid", n_vertices=1000))
    >>> weights = ism.transfer_matrix(source, "ico:2", method="adaptive-area")
    >>> weights.matrix.shape, bool(abs(weights.received.sum() / weights.source_areas.sum() - 1) < 1e-12)
    ((162, 1001), True)
    """
    check_resampling(method)
    if method == "adaptive-area":
        if not isinstance(target, str | SphereMap | tuple):
            raise TypeError(
                'method="adaptive-area" needs the faces of the target: give a SphereMap, (x, f) or ico:K'
            )
        own: FloatArray | None = None
        if isinstance(target, SphereMap):
            own = target.vertices
        found = adaptive_area(check_map(source), *sphere_mesh(target), own)
    else:
        locator = _locator(source)
        location = locator.locate(_points(target))
        found = TransferMatrix(linear_matrix(locator.f, location, len(locator.x)))
    if labels:
        return TransferMatrix(largest(found.matrix))
    return found


def _points(target: Any) -> FloatArray:
    """Return points of the sphere, or the vertices of a mesh of it."""
    pair = isinstance(target, tuple) and np.ndim(target[0]) == 2
    if pair or isinstance(target, str | SphereMap):
        return sphere_mesh(target)[0]
    return check_rows(target, name="points")


def sphere_mesh(target: str | SphereMap | tuple[Any, Any]) -> tuple[FloatArray, IntArray]:
    """Return points and faces of a regular mesh by its name, of a map's image, or of any closed mesh of the sphere."""
    if isinstance(target, str):
        target = regular_mesh(target)
    if isinstance(target, SphereMap):
        x, f = target.sphere, target.mesh
    else:
        x, f = check_list(target, "target", 2, "ico:K, a map, or points and faces of a sphere")
    x = check_rows(x, name="points")
    return x, check_faces(f, len(x))


def regular_mesh(name: str) -> tuple[FloatArray, IntArray]:
    """The icosphere of that name: "ico:K" has edges cut into 2^K parts, and 10 * 4^K + 2 vertices, nested.

    >>> regular_mesh("ico:5")[0].shape
    (10242, 3)
    """
    if not re.fullmatch("ico:[0-9]", name):  # ico:9 has 2.6 million vertices
        raise ValueError(f"{name!r} is not a regular sphere: give ico:0 to ico:9")
    depth = name[-1]
    return regular_sphere(10 * 4 ** int(depth) + 2)


@gate
def resample(
    source: SphereMap, target: str | SphereMap | tuple[ArrayLike, ArrayLike] = "ico:5"
) -> Resampled:
    """Give a surface the connectivity of another mesh of the sphere.

    Parameters
    ----------
    source : SphereMap
        The surface and its map.
    target : str, SphereMap or (x, f)
        ``ico:K``, a regular icosphere (default: ``ico:5``), whose first ``10 * 4^J + 2`` vertices are those of
        ``ico:J`` (the order is this package's own, not FreeSurfer's); a map, whose image is taken; or any mesh of the
        sphere.

    Returns
    -------
    Resampled
        Unpacks to ``v, f``.

    Raises
    ------
    ValueError
        If there is no regular sphere of that name.
    MeshError
        If `target` is not a closed genus-0 mesh.
    FoldingsRemain
        If the map is not certified folding-free.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.resample(ism.spherical_conformal_map(*ism.samples.make("spheroid", n_vertices=1000)), "ico:3")
    >>> v.shape, f.shape
    ((642, 3), (1280, 3))
    """
    x, faces = sphere_mesh(target)
    locator = _locator(source)
    location = locator.locate(x)
    return Resampled(interpolate(source.vertices, locator.f, location), faces, x, location)


def _locator(source: SphereMap | SphereLocator) -> SphereLocator:
    if isinstance(source, SphereLocator):
        return source
    return locator_of(check_map(source))


def check_map(result: object, name: str = "source") -> SphereMap:
    """Return a map; anything else, such as data given before the map, is a TypeError."""
    if not isinstance(result, SphereMap):
        raise TypeError(
            f"{name} is of type {type(result).__name__}; give a SphereMap first, then the values over it"
        )
    return result
