"""Data over a mapped mesh as an image on a grid of the sphere, and back."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from ...errors import MeshError, check_whole
from ...gate import gate
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import AnyArray, FloatArray, IntArray, check_rows, plain_array
from ...resampling.transfer import check_map, transfer, weighted
from ...sphere.rows import unit_rows
from .basis import gauss_rows, grid_points, longitudes
from .geometry_image import check_square, octahedral_cells, octahedral_points

Kind = Literal["equirectangular", "equiangular", "gauss", "octahedral"]


@gate
def to_grid(
    source: SphereMap,
    values: ArrayLike | None = None,
    *,
    kind: Kind = "equirectangular",
    rows: int | None = None,
    labels: bool = False,
    columns: int | None = None,
) -> AnyArray:
    """Sample a mapped surface, or data over it, on a grid of latitudes and longitudes, or on the octahedral one.

    Parameters
    ----------
    source : SphereMap
        The surface and its map.
    values : (n,) or (n, ...) array_like, optional
        Data at the vertices; by default the positions, which gives a geometry image.
    kind : {"equirectangular", "equiangular", "gauss", "octahedral"}
        "equirectangular": cell centres of a picture whose upper edge is the north pole (+z) and whose left edge has
        longitude -180 degrees, as `texture_atlas` lays it out. The others have rows from north to south and columns
        from longitude 0, as spherical harmonic transforms take them. "equiangular": rows at equal steps from pole to
        pole, both included (torch-harmonics: "equiangular"; s2fft: "mwss", of L + 1 rows and 2 L columns). "gauss":
        Gauss-Legendre latitudes (torch-harmonics: "legendre-gauss"; s2fft: "gl", of L rows and 2 L - 1 columns).
        "octahedral": a square with the north pole in the middle and the south pole in its corners; of positions,
        `mesh_from_grid` makes a mesh again.
    rows : int, optional
        Number of rows: 180 by default, 181 on the octahedral grid, which needs an odd number; "equiangular" needs 2 or
        more.
    labels : bool
        The values are labels: take the nearest corner's; linear by default.
    columns : int, optional
        Number of columns: by default twice the rows, on the octahedral grid as many as rows.

    Returns
    -------
    (rows, columns) or (rows, columns, ...) array
        Values on the grid.

    Raises
    ------
    MeshError
        If there is not one value per vertex.
    FoldingsRemain
        If the map is not certified folding-free.
    ValueError
        If there is no such kind, or there are too few rows.
    TypeError
        If the source is not a map.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> source = ism.spherical_conformal_map(*ism.samples.make("spheroid", n_vertices=1000))
    >>> ism.shapes.to_grid(source, rows=32).shape
    (32, 64, 3)
    """
    square = kind == "octahedral"
    usual, least, across = 180, 1, 2
    if square:
        usual, across = 181, 1
    elif kind == "equiangular":
        least = 2  # both poles
    if rows is None:
        rows = usual
    rows = check_whole(rows, "rows", least)
    if columns is None:
        columns = across * rows
    columns = check_whole(columns, "columns", 1)
    check_map(source)
    if square:
        points = octahedral_points(check_square(rows, columns))
    else:
        theta, phi = _coordinates(kind, rows, columns)
        points = grid_points(np.cos(theta), phi).reshape(-1, 3)
    if values is None:
        values = source.vertices
    sampled = transfer(source, values, points, labels=labels)
    return sampled.reshape(rows, columns, *sampled.shape[1:])


@gate
def from_grid(
    grid: ArrayLike,
    target: SphereMap | ArrayLike,
    *,
    kind: Kind = "equirectangular",
    labels: bool = False,
) -> AnyArray:
    """Read values off a grid, at the vertices of a map or at points of the sphere.

    Parameters
    ----------
    grid : (rows, columns) or (rows, columns, ...) array_like
        Values as `to_grid` lays them out, in an even number of columns, or on the octahedral grid.
    target : SphereMap or (k, 3) array_like
        A map, whose vertices get values, or points of the sphere.
    kind : {"equirectangular", "equiangular", "gauss", "octahedral"}
        As for `to_grid`.
    labels : bool
        Take the nearest grid point's value; by default bilinear, across the poles and the seam, or linear on the
        triangles of the octahedral grid.

    Returns
    -------
    (k,) or (k, ...) array
        Values at the target.

    Raises
    ------
    MeshError
        If the grid is not such an array.
    ValueError
        If there is no such kind.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> result = ism.spherical_conformal_map(*ism.samples.make("spheroid", n_vertices=1000))
    >>> heights = ism.shapes.from_grid(ism.shapes.to_grid(result, result.sphere[:, 2]), result)
    >>> bool(abs(heights - result.sphere[:, 2]).max() < 0.01)
    True
    """
    values = plain_array(grid, "values of the grid")
    if values.ndim < 2 or values.size == 0 or (kind != "octahedral" and values.shape[1] % 2):
        raise MeshError(
            f"the grid has shape {values.shape}; give rows and an even number of columns"
        )
    if isinstance(target, SphereMap):
        points = target.sphere
    else:
        points = unit_rows(check_rows(target, name="points"))
    if kind == "octahedral":
        corners, weights = octahedral_cells(check_square(*values.shape[:2]), points)
    else:
        corners, weights = _cells(kind, values.shape[0], values.shape[1], points)
    return weighted(values.reshape(-1, *values.shape[2:]), corners, weights, labels)


def _coordinates(kind: str, rows: int, columns: int) -> tuple[FloatArray, FloatArray]:
    """Colatitudes and longitudes of a grid."""
    if kind == "gauss":
        return np.arccos(gauss_rows(rows)[0]), longitudes(columns)
    if kind == "equiangular":
        return np.linspace(0, np.pi, rows), longitudes(columns)
    if kind == "equirectangular":
        return np.pi * (np.arange(rows) + 0.5) / rows, longitudes(columns) - np.pi + np.pi / columns
    raise ValueError(f"unknown kind of grid {kind!r}: choose from {', '.join(get_args(Kind))}")


def _cells(kind: str, rows: int, columns: int, x: FloatArray) -> tuple[IntArray, FloatArray]:
    """The four grid points around each point, (k, 4) by their places in the flattened grid, and bilinear weights."""
    theta, phi = _coordinates(kind, rows, columns)
    # and a row beyond each pole
    theta = np.concatenate(([-theta[0]], theta, [2 * np.pi - theta[-1]]))
    # numpy 1.26's arctan2 of columns depends on where they lie in memory
    x, y, z = np.ascontiguousarray(x.T)
    here = np.arctan2(np.hypot(x, y), z)
    i = np.clip(np.searchsorted(theta, here, side="right") - 1, 0, rows)
    step = theta[i + 1] - theta[i]
    down = (here - theta[i]) / np.where(step > 0, step, 1)  # steps are 0 where a row is at a pole
    turn = (np.arctan2(y, x) - phi[0]) * columns / (2 * np.pi)
    j = np.floor(turn).astype(np.int64)
    east = turn - j
    row, column = i[:, None] + [-1, -1, 0, 0], j[:, None] + [0, 1, 0, 1]
    beyond = (row < 0) | (row >= rows)  # beyond a pole lies the opposite longitude
    column = (column + beyond * (columns // 2)) % columns
    weights = np.stack(
        ((1 - down) * (1 - east), (1 - down) * east, down * (1 - east), down * east), axis=1
    )
    return np.clip(row, 0, rows - 1) * columns + column, weights
