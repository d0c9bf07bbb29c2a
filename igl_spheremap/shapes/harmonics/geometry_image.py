"""The octahedral grid: a square image of the sphere, and the mesh of an image of positions."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ...errors import MeshError
from ...gate import gate
from ...mesh.arrays import BoolArray, FloatArray, IntArray, check_values, plain_array
from ...sphere.rows import unit_rows


@gate
def mesh_from_grid(grid: ArrayLike) -> tuple[FloatArray, IntArray]:
    """Make the mesh that a geometry image holds, the way back from ``to_grid(kind="octahedral")``.

    Parameters
    ----------
    grid : (k, k, 3) array_like
        Positions on the octahedral grid, k odd and at least 3. Boundary points that are one point of the sphere have
        equal values; the first is taken.

    Returns
    -------
    v : (k^2 - 2k + 3, 3) float64 array
        Positions.
    f : (2 (k - 1)^2, 3) int64 array
        Triangles: a closed surface of genus 0, oriented outwards.

    Raises
    ------
    MeshError
        If the grid has another shape, or a number is not finite.

    References
    ----------
    Praun and Hoppe 2003, *Spherical parametrization and remeshing*: octahedral geometry images.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> result = ism.spherical_conformal_map(*ism.samples.make("spheroid", n_vertices=500))
    >>> v, f = ism.shapes.mesh_from_grid(ism.shapes.to_grid(result, kind="octahedral", rows=33))
    >>> v.shape, f.shape, ism.check_mesh(v, f)
    ((1026, 3), (2048, 3), Mesh(1026 vertices, 2048 faces))
    """
    values = plain_array(grid, "values of the grid")
    if values.ndim != 3 or values.shape[2] != 3:
        raise MeshError(f"the grid has shape {values.shape}; give positions, rows x columns x 3")
    k = check_square(*values.shape[:2])
    rows = check_values(values.reshape(-1, 3), k * k, "positions of the grid")
    _, first, vertex = np.unique(_lattice(k), axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)  # vertices in the order of the image
    row, column = np.indices((k - 1, k - 1)).reshape(2, -1)
    (northwest, northeast, southwest, southeast), falls = _cells(row, column, k)
    left = northwest, southwest, np.where(falls, southeast, northeast)
    right = np.where(falls, (northwest, southeast, northeast), (northeast, southwest, southeast))
    f = np.concatenate((np.column_stack(left), right.T))
    return rows[first[order]], np.argsort(order)[vertex.ravel()[f]]


def octahedral_points(k: int) -> FloatArray:
    """Unit rows (k * k, 3) of the grid's points, row by row from the top; the middle of the image is +z.

    >>> octahedral_points(3)[4]
    array([0., 0., 1.])
    """
    return unit_rows(_lattice(check_square(k, k)).astype(np.float64))


def octahedral_cells(k: int, x: FloatArray) -> tuple[IntArray, FloatArray]:
    """The three grid points around each row of `x`, by their places in the flattened grid, and linear weights."""
    m = check_square(k, k) // 2
    x = x / np.abs(x).sum(axis=1, keepdims=True)
    flat = np.where(
        x[:, 2:] < 0, np.where(x[:, :2] < 0, -1, 1) * (1 - np.abs(x[:, 1::-1])), x[:, :2]
    )
    at = (flat * [1, -1] + 1) * m  # column and row
    column, row = np.clip(np.floor(at).astype(np.int64), 0, 2 * m - 1).T
    east, south = at[:, 0] - column, at[:, 1] - row
    (northwest, northeast, southwest, southeast), falls = _cells(row, column, k)
    # where the diagonal rises, the cell's mirror image is one where it falls
    begin, beside, below, end = np.where(
        falls,
        (northwest, northeast, southwest, southeast),
        (northeast, northwest, southeast, southwest),
    )
    ahead, behind = np.where(falls, (east, 1 - east), (1 - east, east))
    corners = np.column_stack((begin, np.where(ahead >= south, beside, below), end))
    weights = np.column_stack(
        (np.minimum(behind, 1 - south), np.abs(ahead - south), np.minimum(ahead, south))
    )
    return corners, weights


def check_square(rows: int, columns: int) -> int:
    """The side of an octahedral grid; a MeshError unless it is square, odd and at least 3."""
    if rows != columns or rows < 3 or rows % 2 == 0:
        raise MeshError(
            f"the grid has {rows} rows and {columns} columns; an octahedral one has an odd number of "
            "rows, at least 3, and as many columns"
        )
    return rows


def _lattice(k: int) -> IntArray:
    """Whole coordinates (k * k, 3) of the grid's points on the octahedron |x| + |y| + |z| = (k - 1) / 2."""
    m = k // 2
    row, column = np.indices((k, k)).reshape(2, -1)
    x, y = column - m, m - row
    z = m - np.abs(x) - np.abs(y)
    folded = np.sign(x) * (m - np.abs(y)), np.sign(y) * (m - np.abs(x))
    return np.column_stack((np.where(z < 0, folded[0], x), np.where(z < 0, folded[1], y), z))


def _cells(row: IntArray, column: IntArray, k: int) -> tuple[tuple[IntArray, ...], BoolArray]:
    """Indices of cells' corners in the flattened grid: northwest, northeast, southwest and southeast.

    Also whether the diagonal of each runs from its upper left to its lower right corner, as edges of the octahedron do.
    """
    northwest = row * k + column
    falls = (2 * column + 2 > k) != (2 * row + 2 > k)
    return (northwest, northwest + 1, northwest + k, northwest + k + 1), falls
