"""Disks made of other surfaces: repaired, all holes but one filled, or cut open along a seam; on request only."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from ..errors import MeshError, check_whole, shown
from ..gate import takes_mesh
from ..mesh.arrays import FloatArray, IntArray, check_rows, own_unit, plain_array
from ..mesh.disk import disk_rim
from .repair_mesh import RepairedMesh, asked_for, repaired
from .surface import Surface


@takes_mesh
def repair_disk(
    v: ArrayLike,
    f: ArrayLike,
    *,
    weld: float = 0.0,
    keep_largest: bool = False,
    holes: Literal["refuse", "fill"] = "refuse",
    handles: Literal["refuse", "cut"] = "refuse",
    rim: ArrayLike | None = None,
    cut: ArrayLike | None = None,
) -> RepairedMesh:
    """Make a disk of a surface: repair it as `repair_mesh` does, fill its holes but one, or cut it open.

    Parameters
    ----------
    v, f, weld, keep_largest
        As of `repair_mesh`.
    holes : {"refuse", "fill"}
        "fill" closes each hole by a cap except the one of `rim`; with `cut` all of them. By default they are refused.
    handles : {"refuse", "cut"}
        With `cut`: "cut" first cuts each handle and fills both sides. By default handles are refused.
    rim : int or (3,) array_like, optional
        Keep the boundary loop nearest to this vertex, or to this point; by default the longest.
    cut : int or (k,) or (k, 2) array_like of int, optional
        Cut the surface along a tree of shortest paths that joins its boundary loops and these vertices, two or more, or
        a number of loops and tips. Each tip is the vertex farthest from the tree so far. So 2 cuts a tube lengthways.
        Two columns are edges to cut along; if they divide the surface, `keep_largest` keeps the largest part. The cut's
        vertices are doubled.

    Returns
    -------
    RepairedMesh
        The disk; ``vertex_source`` has the row of the input that each vertex comes from, -1 in caps.

    Raises
    ------
    MeshError
        If the repair does not suffice.
    ValueError
        If `holes` or `handles` is another word, `weld` is out of range, or `rim` or `cut` names no vertex.

    References
    ----------
    X. Gu, S. J. Gortler, H. Hoppe, Geometry images, 2002: a cut through the extremes of the surface.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.sphere(42)
    >>> disk = ism.repair_disk(v, f, cut=2)
    >>> disk.actions, ism.flatten(disk).certificate.folding_free
    (('cut along 6 edges between 2 tips',), True)
    >>> len(disk.v) - len(v)
    5
    """
    given = {
        name: np.asarray(value).tolist()
        for name, value in (("rim", rim), ("cut", cut))
        if value is not None and np.ndim(value) < 2
    }
    asked = asked_for(
        "repair_disk", weld=weld, keep_largest=keep_largest, holes=holes, handles=handles, **given
    )
    if handles == "cut" and cut is None:
        raise ValueError("handles='cut' goes with cut: give the number of points to cut through")
    vertices = check_rows(v, name="vertices")
    near, points = _point(rim, vertices), _points(cut, len(vertices))

    def steps(work: Surface) -> None:
        if holes == "fill" and points is not None:
            work.fill_holes()
        elif holes == "fill" and len(work.rims) > 1:
            work.fill_holes(_kept(work, near))
        if handles == "cut" and not work.rims:
            work.cut_handles()
        if isinstance(points, int):
            work.cut_open(points, keep_largest)
        elif points is not None:
            work.cut_open(_images(work, points), keep_largest)

    return repaired(vertices, f, asked, steps, disk_rim)


def _points(cut: ArrayLike | None, n: int) -> IntArray | int | None:
    """The vertices to cut through, or the number of tips."""
    if cut is None:
        return None
    if np.ndim(cut) == 0:
        tips = check_whole(cut, "cut", least=2)
        if tips > n:
            raise ValueError(f"cut is {tips}; give at most the number of vertices, {n}")
        return tips
    points = plain_array(cut, "cut")
    if points.ndim != 2 or points.shape[1] != 2:
        points = np.unique(points)
    whole = points.dtype.kind in "iu" and points.size >= 2
    if not whole or points.min() < 0 or points.max() >= n:
        raise ValueError(
            f"cut is {shown(cut)}; give two or more of the vertices 0 to {n - 1}, edges of two, or a number of tips"
        )
    return points.astype(np.int64)


def _point(rim: ArrayLike | None, v: FloatArray) -> FloatArray | None:
    """The point that chooses the loop to keep: a vertex's position, or the point itself."""
    if rim is None:
        return None
    if np.ndim(rim) == 0:
        vertex = check_whole(rim, "rim")
        if vertex >= len(v):
            raise ValueError(
                f"rim is {vertex}; give one of the vertices 0 to {len(v) - 1}, or a point"
            )
        return v[vertex]
    point = plain_array(rim, "rim").astype(np.float64)
    if point.shape != (3,) or not np.isfinite(point).all():
        raise ValueError(f"rim is {shown(rim)}; give a vertex, or a point of three coordinates")
    return point


def _kept(work: Surface, near: FloatArray | None) -> int:
    """The boundary loop that stays: the longest, or the one nearest to a point."""
    own, power = own_unit(work.v)
    loops = [own[rim] for rim in work.rims]
    if near is None:
        sides = [np.linalg.norm(loop - np.roll(loop, 1, axis=0), axis=1) for loop in loops]
        return int(np.argmax([side.sum() for side in sides]))
    gaps = [np.linalg.norm(loop - np.ldexp(near, -power), axis=1).min() for loop in loops]
    return int(np.argmin(gaps))


def _images(work: Surface, points: IntArray) -> IntArray:
    """Images of vertices of the input; a MeshError if one was dropped."""
    images = work.image[points]
    if (images < 0).any():
        raise MeshError(
            f"vertex {points[images < 0][0]} of the cut was dropped; give one of the surface that is kept"
        )
    return images
