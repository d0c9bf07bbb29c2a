"""The check of a disk: a surface with one boundary loop and no handle, which has maps to the plane."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .. import wings
from ..errors import Remedy
from ..gate import takes_mesh
from ..timings import phase
from .arrays import (
    BoolArray,
    FloatArray,
    IntArray,
    check_rows,
    check_triangles,
    listed_words,
    mean_position,
    plural,
)
from .check import (
    CheckedFaces,
    area_weights,
    check_caps,
    check_indices,
    normalised,
    not_finite,
)
from .edges import components, pinched_vertices, rims, shared_edges, sides


@dataclass(frozen=True, eq=False)
class Disk(CheckedFaces):
    """An oriented, connected triangle mesh with one boundary loop and no handle, which `check_disk` has passed.

    Attributes
    ----------
    v, unit, f
        As of `Mesh`.
    rim : (k,) int64 array
        Vertices of the boundary loop, from the smallest on, in the direction in which faces run along it: in the plane
        counterclockwise.
    A : (n,) float64 array
        Vertex areas with sum 1, none below a billionth of their mean.
    caps : (m,) bool array or None
        Faces that only fill holes; None if there are none.
    """

    v: FloatArray
    unit: FloatArray
    f: IntArray
    rim: IntArray
    A: FloatArray
    caps: BoolArray | None = None

    def __repr__(self) -> str:
        return f"Disk({len(self.v)} vertices, {len(self.f)} faces, {len(self.rim)} on the rim)"


@takes_mesh
@phase("check")
def check_disk(v: ArrayLike, f: ArrayLike, *, caps: ArrayLike | None = None) -> Disk:
    """Check that `v, f` is an oriented, connected mesh with one boundary loop and no handle, and normalise it.

    Parameters
    ----------
    v, f
        As of `check_mesh`.
    caps : (m,) array_like of bool, optional
        Faces that only fill holes, of a mesh that `repair_disk` made: they stay out of all figures. By default there
        are none.

    Returns
    -------
    Disk
        The checked mesh; it shares no memory with the input.

    Raises
    ------
    MeshError
        One line that names the fault, its place and the remedy.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    >>> ism.check_disk(v, [[0, 1, 2], [0, 2, 3]]).rim
    array([0, 1, 2, 3])
    >>> ism.check_disk(v, [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    Traceback (most recent call last):
        ...
    igl_spheremap.errors.MeshError: closed surface: it has no boundary; map it to the sphere (spherical_conformal_map...
    """
    vertices, faces = np.array(check_rows(v, name="vertices")), check_triangles(f)
    rim = disk_rim(faces, vertices)
    unit, areas = normalised(vertices, faces)
    closing = None
    if caps is not None:
        closing = check_caps(caps, len(faces))
    return Disk(vertices, unit, faces, rim, area_weights(areas, faces, len(vertices)), closing)


def disk_rim(f: IntArray, v: FloatArray, refuse: Callable[..., Any] | None = None) -> IntArray:
    """The boundary loop of a disk; a MeshError, which `refuse` makes as of `check.py`, if the faces form no disk."""
    n, m = len(v), len(f)
    check_indices(f, n)
    if refuse is None:
        refuse = partial(wings.refusal, asked=Remedy("repair_disk"))
    refusal = partial(refuse, f, n, v)
    if len(bad := not_finite(v)):
        refusal().not_finite(bad)
    start, stop = sides(f)
    _, edge, one, other = shared_edges(f, n)
    faces_at = np.bincount(edge)
    if (start == stop).any() or (faces_at > 2).any() or (start[one] == start[other]).any():
        refusal().half_edges()
    unused = np.flatnonzero(np.bincount(start, minlength=n) == 0)
    if len(unused):
        refusal().unreferenced(unused)
    parts, label = components(one // 3, other // 3, m)
    if parts > 1:
        refusal().components(label)
    order = np.argsort(edge, kind="stable")
    open_edges = order[faces_at[edge[order]] == 1]
    if not len(open_edges):
        refusal().refuse(
            "closed surface: it has no boundary",
            "map it to the sphere "
            f"({Remedy('spherical_conformal_map')} does), or cut it open along a seam",
        )
    pinched = pinched_vertices(f, one, other)
    if len(pinched):
        refusal().pinched(pinched)
    loops = sorted(
        (np.array(rim) for rim in rims(start[open_edges], stop[open_edges])), key=len, reverse=True
    )
    places = (
        f"{listed_words([len(loop) for loop in loops])} edges, near {mean_position(v[loops[0]], v)}"
    )
    if len(loops) > 1:
        refusal().several_loops(loops)
    handles = (1 - (n - len(faces_at) + m)) // 2
    if handles:
        refusal().refuse(
            f"{plural(handles, 'handle')} and a boundary loop of {places}: no map to the plane is "
            "free of foldings",
            "fill the hole, cut the handles, and cut it open along a seam",
        )
    return np.roll(loops[0], -int(np.argmin(loops[0])))
