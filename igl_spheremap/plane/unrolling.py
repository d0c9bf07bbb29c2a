"""The isometric layout of a surface that can be unrolled: flat ones are projected, others laid out face by face."""

from __future__ import annotations

from operator import itemgetter

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree

from ..mesh.arrays import HALF_DIGITS, TINY, FloatArray, own_unit
from ..mesh.disk import Disk
from ..mesh.edges import marked, shared_edges, sides
from ..mesh.measure import angle_defects, corner_angles
from ..sphere.rows import row_crosses, row_dots, row_lengths
from ..verify.certificate import Certificate

#: A surface is unrolled if no edge changes its length by more than this share, and angles around its vertices sum to
#: 2 pi up to as many radians: a surface that was stored in float32 is off by some 1e-7.
ISOMETRIC = 1e-6
#: A surface is flat if its projection changes none by more than this: rounding in float64, of thin faces too, is less.
FLAT = 1e-9


def unrolled(disk: Disk) -> FloatArray | None:
    """Images (n, 2) of a surface that can be unrolled, every edge as long as before; None for others.

    A flat surface is projected to its plane, which rounds least. Any other is laid out along a tree of faces, each
    beside its parent across long common edges, if the angles around each inner vertex sum to 2 pi. Images may overlap.
    """
    v = own_unit(disk.v)[0]  # as given: a move to the origin rounds
    p = _projected(disk, v)
    change = stretch(disk, p)
    if change < ISOMETRIC and not Certificate.of_plane(p, disk.f, disk.rim).folding_free:
        change = np.inf
    if change > FLAT and _closes(disk):
        q = _laid_out(disk, v)
        p, change = min((p, change), (q, stretch(disk, q)), key=itemgetter(1))
    if change < ISOMETRIC:
        return p
    return None


def stretch(disk: Disk, p: FloatArray) -> float:
    """The largest relative change of the length of an edge."""
    i, j = disk.f.ravel(), disk.f[:, [1, 2, 0]].ravel()
    v = own_unit(disk.v)[0]
    before, after = row_lengths(v[i] - v[j]), np.hypot(*(p[i] - p[j]).T)
    return float((np.abs(after - before) / np.maximum(before, TINY)).max())


def _projected(disk: Disk, v: FloatArray) -> FloatArray:
    """The projection to the plane of the two largest principal axes, oriented as the faces are.

    The width of a strip of aspect 1e8 has half of the digits of its length: longer numbers keep them in the products.
    """
    a, b, c = disk.f.T
    if not np.ptp(v, axis=0).all():  # in a plane of coordinates: they are kept to the last digit
        axes = np.eye(3)[np.argsort(np.ptp(v, axis=0) == 0, kind="stable")]
    else:
        axes = np.linalg.svd(v - v.mean(axis=0), full_matrices=False)[2]
    far = v.astype(np.longdouble)
    p = ((far - far.mean(axis=0)) @ axes[:2].T.astype(np.longdouble)).astype(np.float64)
    area = float(np.cross(axes[0], axes[1]) @ row_crosses(v[b] - v[a], v[c] - v[a]).sum(axis=0))
    if not area > 0:
        p[:, 1] *= -1
    return p


def _closes(disk: Disk) -> bool:
    """Whether the angles around each inner vertex sum to 2 pi, up to rounding of those of thin faces."""
    defects = angle_defects(corner_angles(disk.unit, disk.f), disk.f, len(disk.v))
    return bool((np.abs(defects)[~marked(disk.rim, len(disk.v))] < ISOMETRIC).all())


def _laid_out(disk: Disk, v: FloatArray) -> FloatArray:
    """Faces laid out along a tree, each one's new vertex by its place relative to the edge that it shares."""
    f, m = disk.f, len(disk.f)
    first, second = shared_edges(f, len(disk.v))[2:]
    (start, stop), apex = sides(f), f.ravel()
    side, other = v[stop] - v[start], v[apex] - v[start]
    length = row_lengths(side)
    square = np.maximum(length * length, TINY)
    # The apex of each half-edge, in units of the half-edge, from its start.
    place = (row_dots(other, side) + 1j * row_lengths(row_crosses(side, other))) / square
    weights = length.max() / np.maximum(length[first], HALF_DIGITS * length.max())
    dual = csr_matrix((weights, (first // 3, second // 3)), shape=(m, m))
    order, parent = breadth_first_order(minimum_spanning_tree(dual), 0, directed=False)
    beside = {
        (int(i), int(j)): h
        for i, j, h in zip(
            np.r_[first, second] // 3,
            np.r_[second, first] // 3,
            np.r_[first, second].tolist(),
            strict=True,
        )
    }
    z: list[complex | None] = [None] * len(disk.v)
    root = 2  # the side of face 0 that starts at its first corner
    z[int(start[root])], z[int(stop[root])] = 0j, complex(length[root])
    starts, stops, apexes, places = start.tolist(), stop.tolist(), apex.tolist(), place.tolist()
    for i in order.tolist():
        h = root
        if i != 0:
            h = beside[i, int(parent[i])]
        a, b = z[starts[h]], z[stops[h]]
        if z[apexes[h]] is None and a is not None and b is not None:
            z[apexes[h]] = a + (b - a) * places[h]
    found = np.array(z, dtype=complex)
    return np.column_stack((found.real, found.imag))
