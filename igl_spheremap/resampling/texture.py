"""Texture coordinates from the sphere, of faces that are cut at the seam or of the mesh as it is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.ndimage import distance_transform_edt, map_coordinates
from scipy.sparse import csr_matrix, identity, vstack

from ..gate import gate
from ..mesh.arrays import BoolArray, FloatArray, IntArray, PixelArray, check_directions, plain_array
from ..mesh.check import MapLike, Mesh, check_faces, rows_and_faces
from ..mesh.edges import edge_keys
from ..sphere.rows import plane_crosses, unit_rows

#: Side of a picture in texels: 64 for each of a checkerboard's 16 squares.
SIDE = 1024

Projection = Literal["equirectangular", "octahedral"]


@dataclass(frozen=True, eq=False)
class Atlas:
    """Texture coordinates of a mapped surface.

    Attributes
    ----------
    uv : (k, 2) float64 array
        Between 0 and 1, v upwards; one row per vertex of the atlas. Uncut faces across the date line go beyond.
    f : (m, 3) int64 array
        Faces of the atlas: those of the mesh, cut at the seam.
    weights : (k, n) sparse matrix
        Takes values at the mesh's vertices (positions, normals, data) to values at those of the atlas.
    vertex : (k,) int64 array
        The vertex of each row: below n one of the mesh, from n on one that a cut made. Copies of a vertex along the
        seam have the same number.
    face : (m,) int64 array
        The face of the mesh that each face is a part of.
    """

    uv: FloatArray
    f: IntArray
    weights: csr_matrix
    vertex: IntArray
    face: IntArray

    def __repr__(self) -> str:
        return f"Atlas({len(self.uv)} vertices, {len(self.f)} faces)"

    @gate
    def carry(self, values: ArrayLike) -> FloatArray:
        """Values at the atlas' vertices.

        Parameters
        ----------
        values : (n,) or (n, d) array_like
            At the mesh's vertices.

        Returns
        -------
        (k,) or (k, d) float64 array
            Linear along cut edges.
        """
        return self.weights @ plain_array(values, "values").astype(np.float64)


@gate
def texture_atlas(
    x: ArrayLike | MapLike,
    f: ArrayLike | Mesh | None = None,
    *,
    projection: Projection = "equirectangular",
    cut: bool = True,
) -> Atlas:
    """Texture coordinates of a surface from its map to the sphere.

    Faces across the seam are cut there, which adds vertices on edges and changes no geometry. The poles become
    vertices, with one copy for each face around them. Without cuts the mesh stays as it is. Then faces across the date
    line have coordinates beyond 1, where pictures repeat, and faces that hold a pole show the picture wrongly.

    Parameters
    ----------
    x : (n, 3) array_like or SphereMap
        Images of the vertices on the unit sphere, or a map, which needs no `f`.
    f : (m, 3) array_like or Mesh
        Faces as 0-based vertex indices.
    projection : {"equirectangular", "octahedral"}
        Longitude and latitude, poles up and down; or the octahedron ``|x| + |y| + |z| = 1`` unfolded onto the
        square, which has no poles and leaves no part of the picture unused.
    cut : bool
        Cut faces at the seam, the default; the octahedral projection always does.

    Returns
    -------
    Atlas
        Coordinates, faces, and the way from the mesh's vertices to them.

    Raises
    ------
    MeshError
        If a point is not finite or at the origin, or `f` is not a closed genus-0 mesh on the rows of `x`.
    ValueError
        If the projection is unknown, or has no form without cuts.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> x, f = ism.samples.sphere(642)
    >>> atlas = ism.texture_atlas(x, f)
    >>> atlas.carry(x).shape[1], float(atlas.uv.min()) >= 0, float(atlas.uv.max()) <= 1
    (3, True, True)
    """
    if projection not in _CHARTS:
        raise ValueError(f"unknown projection {projection!r}: choose one of {', '.join(_CHARTS)}")
    x, f = rows_and_faces(x, f)
    points = check_directions(x, name="images")
    faces = check_faces(f, len(points))
    if not cut and projection == "octahedral":
        raise ValueError(
            "the octahedral projection cuts faces; choose equirectangular, or cut=True"
        )
    planes: tuple[int, ...] = 0, 1
    chart = _CHARTS[projection]
    if projection == "octahedral":
        planes = (0, 1, 2)
    elif not cut:
        planes, chart = (), _unwrapped
    pieces = cut_along_planes(unit_rows(points), faces, planes)
    uv = chart(pieces)
    # Away from the seam a vertex has the same coordinates in all its faces.
    corners = np.column_stack([pieces.f.ravel(), uv.reshape(-1, 2)])
    values, index = np.unique(corners, axis=0, return_inverse=True)
    vertex = values[:, 0].astype(np.int64)
    return Atlas(
        np.ascontiguousarray(values[:, 1:]),
        index.reshape(-1, 3).astype(np.int64),
        pieces.weights[vertex],
        vertex,
        pieces.face,
    )


def plane_atlas(uv: FloatArray, f: IntArray, vertex: IntArray, n: int) -> Atlas:
    """The atlas of a map to the plane, whose rows are those `vertex` of the n vertices of the surface.

    >>> plane_atlas(np.array([[0.0, 0], [1, 0], [0, 1]]), np.array([[0, 1, 2]]), np.array([5, 6, 7]), 8).face
    array([0])
    """
    return Atlas(uv, f, identity(n, format="csr")[vertex], vertex, np.arange(len(f)))


def bake(
    atlas: Atlas,
    f: IntArray,
    uv: FloatArray,
    image: PixelArray,
    size: int = SIDE,
    texels: int = 1 << 22,
) -> PixelArray:
    """Draw the texture of a surface anew, for the coordinates of an atlas.

    Parameters
    ----------
    atlas : Atlas
        The new coordinates.
    f : (m, 3) int64 array
        Faces of the mesh.
    uv : (m, 3, 2) float64 array
        Coordinates of their corners in the surface's own texture, which repeats; NaN for faces without any.
    image : (height, width, 3) uint8 array
        That texture, rows from above.
    size : int
        Of the new one, in texels.
    texels : int
        Texels of bounding boxes of faces that are drawn at a time; the default takes some 1 GB.

    Returns
    -------
    (size, size, 3) uint8 array
        Each texel within a face has the colour of its place, interpolated between four texels; the others have that
        of the nearest one.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> from igl_spheremap.resampling.texture import bake, checker_image, texture_atlas
    >>> x, f = ism.samples.sphere(642)
    >>> atlas = texture_atlas(x, f, projection="octahedral")
    >>> bake(atlas, f, np.zeros((len(f), 3, 2)), checker_image(64), size=32).shape
    (32, 32, 3)
    """
    corners = atlas.f.ravel().repeat(3)
    parents = f[atlas.face].repeat(3, axis=0).ravel()
    share = np.asarray(atlas.weights[corners, parents]).reshape(-1, 3, 3)
    there = share @ uv[atlas.face]  # of the atlas' corners
    place = np.full((size, size, 2), np.nan)
    here = atlas.uv[atlas.f] * size - 0.5
    low = np.clip(np.ceil(here.min(axis=1)), 0, size).astype(np.int64)
    high = np.clip(np.floor(here.max(axis=1)), -1, size - 1).astype(np.int64)
    sides = np.maximum(high - low + 1, 0)
    total = np.cumsum(sides.prod(axis=1))
    ends = np.searchsorted(total, np.arange(texels, total[-1], texels))
    for part in np.split(np.arange(len(here)), ends):
        count = sides[part].prod(axis=1)
        face = np.repeat(part, count)
        k = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
        row, column = np.divmod(k, sides[face, 0])
        texel = low[face] + np.column_stack((column, row))
        a, b, c = here[face].transpose(1, 0, 2)
        whole = plane_crosses(b - a, c - a)
        a, b, c = a - texel, b - texel, c - texel
        share = np.column_stack([plane_crosses(b, c), plane_crosses(c, a), plane_crosses(a, b)])
        inside = (share * np.sign(whole)[:, None] >= 0).all(axis=1) & (whole != 0)
        t = share[inside] / whole[inside, None]
        column, row = texel[inside].T
        place[size - 1 - row, column] = (t[:, :, None] * there[face[inside]]).sum(axis=1)
    empty = np.isnan(place[..., 0])
    nearest = distance_transform_edt(empty, return_distances=False, return_indices=True)
    place = place[tuple(nearest)]
    height, width = image.shape[:2]
    at = [(1 - place[..., 1]) * height - 0.5, place[..., 0] * width - 0.5]
    found = [
        map_coordinates(image[..., k].astype(np.float64), at, order=1, mode="grid-wrap")
        for k in range(3)
    ]
    return np.rint(np.stack(found, axis=-1)).astype(np.uint8)


def _equirectangular(cut: CutMesh) -> FloatArray:
    """(m, 3, 2) coordinates of the corners: longitude from -pi to pi, latitude."""
    corners = cut.x[cut.f]
    # A corner on the seam is at longitude pi or -pi, as its face is: give its y, which is 0, the face's sign.
    y = np.copysign(corners[..., 1], _sides(corners)[:, None, 1])
    return _longitude_latitude(corners, _angle(y, corners[..., 0]) / (2 * np.pi))


def _unwrapped(mesh: CutMesh) -> FloatArray:
    """(m, 3, 2) coordinates of the corners of uncut faces: longitudes of a face within half a turn of its first one."""
    corners = mesh.x[mesh.f]
    turns = _angle(corners[..., 1], corners[..., 0]) / (2 * np.pi)
    at_pole = _is_pole(corners[:, 0])
    first = np.where(at_pole, turns[:, 1], turns[:, 0])[:, None]
    return _longitude_latitude(corners, turns - np.rint(turns - first))


def _longitude_latitude(corners: FloatArray, turns: FloatArray) -> FloatArray:
    """Coordinates from longitudes (m, 3) in turns; a corner at a pole takes the mean of the others in its face."""
    pole = _is_pole(corners)
    beside = np.where(pole, 0, turns).sum(axis=1) / np.maximum((~pole).sum(axis=1), 1)
    latitude = _angle(corners[..., 2], np.hypot(corners[..., 0], corners[..., 1]))
    return np.stack([0.5 + np.where(pole, beside[:, None], turns), 0.5 + latitude / np.pi], axis=-1)


def _angle(y: FloatArray, x: FloatArray) -> FloatArray:
    """Compute arctan2 of copies: by numpy 1.26 the last bit of columns depends on where they lie in memory."""
    return np.arctan2(np.ascontiguousarray(y), np.ascontiguousarray(x))


def _is_pole(x: FloatArray) -> BoolArray:
    return (x[..., 0] == 0) & (x[..., 1] == 0)


def _octahedral(cut: CutMesh) -> FloatArray:
    """(m, 3, 2) coordinates of the corners: upper half within the diamond, lower half folded out."""
    corners = cut.x[cut.f]
    side = _sides(corners)
    flat = np.abs(corners) / np.abs(corners).sum(axis=-1, keepdims=True)
    inner = flat[..., :2]
    outer = 1 - flat[..., 1::-1]
    uv = side[:, None, :2] * np.where(side[:, None, 2:] > 0, inner, outer)
    return (1 + uv) / 2


def _sides(corners: FloatArray) -> FloatArray:
    """Return the side, 1 or -1, of each coordinate plane on which a face lies; some corners may lie in the plane."""
    furthest = np.abs(corners).argmax(axis=1)
    return np.where(np.take_along_axis(corners, furthest[:, None], axis=1)[:, 0] < 0, -1.0, 1.0)


_CHARTS: dict[str, Callable[[CutMesh], FloatArray]] = {
    "equirectangular": _equirectangular,
    "octahedral": _octahedral,
}


@dataclass(frozen=True, eq=False)
class CutMesh:
    """A mesh with the crossings of its edges and some planes as further vertices."""

    # the old vertices, then new ones on old edges, exactly 0 in the coordinate that cut
    x: FloatArray
    f: IntArray  # each face on one side of every plane
    # takes values at the old vertices to values at all vertices, along the edges
    weights: csr_matrix
    face: IntArray  # the old face that each face is a part of


def cut_along_planes(x: FloatArray, f: IntArray, axes: tuple[int, ...]) -> CutMesh:
    """Cut a mesh along the planes through the origin where one of the `axes` (0 to 2) vanishes, one after the other.

    After two planes have cut, their common axis is a vertex. Interpolated positions lie on the flat faces.

    >>> x = np.array([[1.0, 0, 1], [-1, 1, 1], [-1, -1, 1]])
    >>> cut = cut_along_planes(x, np.array([[0, 1, 2]]), (0, 1))
    >>> len(cut.x), len(cut.f), cut.x[-1].tolist()
    (8, 8, [0.0, 0.0, 1.0])
    """
    cut = CutMesh(x, f, identity(len(x), format="csr"), np.arange(len(f)))
    for axis in axes:
        cut = _cut(cut, axis)
    return cut


def _cut(mesh: CutMesh, axis: int) -> CutMesh:
    s, f = mesh.x[:, axis], mesh.f
    n = len(s)
    side = np.sign(s).astype(np.int64)
    crossing = side[f] * side[f[:, [1, 2, 0]]] < 0  # of edge k, from corner k to the next
    count = crossing.sum(axis=1)
    # Renumber the corners: two crossed edges become the first and the last of their face, a single one the second.
    one, two = count == 1, count == 2
    first = np.where(two, np.argmin(crossing, axis=1), np.argmax(crossing, axis=1)) + 2
    a, b, c = np.take_along_axis(f, (first[:, None] + np.arange(3)) % 3, axis=1).T
    starts = np.concatenate([a[two], c[two], b[one]])
    stops = np.concatenate([b[two], a[two], c[one]])
    edges, index = np.unique(edge_keys(starts, stops, n), return_inverse=True)
    p, q, r = np.split(n + index, [two.sum(), 2 * two.sum()])
    pieces = [f[count == 0]]
    for piece in (
        (a[two], p, q),
        (p, b[two], c[two]),
        (p, c[two], q),
        (a[one], b[one], r),
        (a[one], r, c[one]),
    ):
        pieces.append(np.column_stack(piece))
    i, j = edges // n, edges % n
    t = s[i] / (s[i] - s[j])
    k = np.arange(len(edges))
    along = csr_matrix(
        (np.concatenate([1 - t, t]), (np.concatenate([k, k]), np.concatenate([i, j]))), (len(k), n)
    )
    points = along @ mesh.x
    points[:, axis] = 0
    return CutMesh(
        np.concatenate([mesh.x, points]),
        np.concatenate(pieces),
        vstack([mesh.weights, along @ mesh.weights], format="csr"),
        np.concatenate([mesh.face[count == k] for k in (0, 2, 2, 2, 1, 1)]),
    )


def checker_image(size: int = SIDE, squares: int = 16) -> PixelArray:
    """(size, size, 3) uint8 checkerboard whose colours show the place: red grows with u, green with v.

    >>> checker_image(64, 4).shape
    (64, 64, 3)
    """
    place = (np.arange(size) + 0.5) / size
    u, v = np.meshgrid(place, 1 - place)
    dark = ((u * squares).astype(int) + (v * squares).astype(int)) % 2
    # No square is black or white; dark ones have less than half of the light.
    red, green = (60 + (255 - 60) * share for share in (u, v))
    colour = np.stack([red, green, np.full_like(u, 160)], axis=-1)
    return np.asarray(colour * np.where(dark, 0.45, 1.0)[..., None], dtype=np.uint8)
