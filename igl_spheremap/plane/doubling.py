"""Conformal disks by doubling: two copies of the surface, joined at the boundary, are mapped to the sphere."""

from __future__ import annotations

import numpy as np

from ..angles.plan import Large
from ..maps.methods import auto
from ..maps.options import Auto
from ..maps.sphere_map import SphereMap
from ..mesh.arrays import FloatArray, IntArray
from ..mesh.check import check_mesh
from ..mesh.disk import Disk
from ..mesh.edges import edge_keys, marked, shared_edges, sides
from ..result.run import Listener
from ..sphere.moebius import conformal_barycentre, moebius
from ..sphere.rows import unit_rows, weighted_moment


def double_map(
    disk: Disk, listener: Listener | None, large: Large = "laid out"
) -> tuple[FloatArray, SphereMap]:
    """Images (n, 2) of a disk's vertices in the unit disk, the boundary on the circle, and the map of the double.

    On the map of the double the exchange of the copies is nearly a reflection of the sphere. The map is changed so that
    it is exactly one; its plane cuts the sphere in the image of the boundary. If the map was far from symmetric, as an
    embedding is, faces may fold; also if they are many, and `large` leaves them.
    """
    v, f = without_chords(disk.unit, disk.f, disk.rim)
    n, on_rim = len(v), marked(disk.rim, len(v))
    inside = np.flatnonzero(~on_rim)
    copy = np.arange(n)
    copy[inside] = n + np.arange(len(inside))
    mesh = check_mesh(np.concatenate((v, v[inside])), np.concatenate((f, copy[f][:, ::-1])))
    # By the default tolerance the reflection is found too roughly: errors fall by less than 4 when edges are halved
    # (`python -m benchmarks disks exact`).
    result = auto(mesh, Auto(tolerance=1e-5), listener, large=large)
    x, other = result.sphere, np.concatenate((copy, inside))
    y = _symmetric(x, x[other], mesh.A, along_axis=result.gauge == "poles")
    if y[inside, 2].mean() < 0:
        y[:, 1:] *= -1  # a half turn
    y[disk.rim, 2] = 0
    return lower(unit_rows(y)[: len(disk.v)], disk.rim), result


def _symmetric(
    x: FloatArray, other: FloatArray, weights: FloatArray, along_axis: bool
) -> FloatArray:
    """The mean of a map and its reflected exchange, turned so that the reflection negates z.

    The reflection R = 1 - 2 n n^T comes closest to the exchange: n is the eigenvector of the least eigenvalue of the
    symmetric part of sum_i w_i x_i other_i^T. If tips of limbs are at ends of an axis, n is the axis next to it. There,
    and in the middle of the disk, coordinates are finer than float64 elsewhere.
    """
    M = weighted_moment(weights, x, other)
    n = np.linalg.eigh(M + M.T)[1][:, 0]
    if along_axis:
        n = np.eye(3)[np.abs(n).argmax()]
    y = unit_rows(x + other - 2 * np.outer(other @ n, n))
    first = np.cross(n, np.eye(3)[np.abs(n).argmin()])
    first /= np.linalg.norm(first)
    return np.asarray(y @ np.column_stack((first, np.cross(n, first), n)))


def without_chords(v: FloatArray, f: IntArray, rim: IntArray) -> tuple[FloatArray, IntArray]:
    """The mesh with a vertex in the middle of each inner edge whose ends both lie on the boundary.

    The double would have two copies of such an edge between the same vertices.
    """
    n, on_rim = len(v), marked(rim, len(v))
    keys, edge, inner, _ = shared_edges(f, n)
    chords = keys[edge[inner]]
    chords = np.sort(chords[on_rim[chords // n] & on_rim[chords % n]])
    while True:  # each face has one of its up to three chords split at a time
        start, stop = sides(f)
        number = np.where((start < n) & (stop < n), edge_keys(start, stop, n), -1)
        place = np.searchsorted(chords, number)
        left = np.append(chords, -2)[place] == number
        best = 3 * np.arange(len(f)) + np.where(left, place, len(chords)).reshape(-1, 3).argmin(
            axis=1
        )
        half = best[left[best]]
        if not len(half):
            return np.concatenate((v, (v[chords // n] + v[chords % n]) / 2)), f
        a, b, c = start[half], stop[half], f.ravel()[half]
        middle = n + place[half]
        f = np.concatenate(
            (
                np.delete(f, half // 3, axis=0),
                np.column_stack((a, middle, c)),
                np.column_stack((middle, b, c)),
            )
        )


def centred(p: FloatArray, disk: Disk) -> FloatArray:
    """The Moebius image of a map to the unit disk that balances the areas of the doubled surface on the sphere."""
    x = _raised(p)
    mirrored = x * [1, 1, -1]
    centre = conformal_barycentre(np.concatenate((x, mirrored)), np.concatenate((disk.A, disk.A)))
    return lower(moebius(x, centre * [1, 1, 0]), disk.rim)


def _raised(p: FloatArray) -> FloatArray:
    square = np.minimum((p * p).sum(axis=1), 1)[:, None]
    return np.concatenate((2 * p, 1 - square), axis=1) / (1 + square)


def lower(x: FloatArray, rim: IntArray) -> FloatArray:
    """Stereographic images in the unit disk of rows of the upper half of the sphere."""
    p = x[:, :2] / (1 + x[:, 2:])
    p[rim] /= np.hypot(p[rim, 0], p[rim, 1])[:, None]
    return np.asarray(p)
