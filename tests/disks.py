"""Disks whose maps to the plane are known."""

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import connected_components, dijkstra


def polar(rings):
    """A triangulated unit disk: ring j has 6 j points at distance j / rings."""
    points, starts = [np.zeros((1, 2))], [0, 1]
    for j in range(1, rings + 1):
        turn = 2 * np.pi * np.arange(6 * j) / (6 * j)
        points.append(np.column_stack((np.cos(turn), np.sin(turn))) * j / rings)
        starts.append(starts[-1] + 6 * j)
    faces = []
    for j in range(1, rings + 1):
        for side in range(6):
            outer = [starts[j] + (side * j + i) % (6 * j) for i in range(j + 1)]
            inner = [starts[j - 1] + (side * (j - 1) + i) % max(6 * (j - 1), 1) for i in range(j)]
            faces += [(outer[i], outer[i + 1], inner[i]) for i in range(j)]
            faces += [(outer[i + 1], inner[i + 1], inner[i]) for i in range(j - 1)]
    return np.concatenate(points), np.array(faces)


def cap(rings, angle):
    """The part of the unit sphere within an angle of the pole, with its conformal map to the unit disk."""
    p, f = polar(rings)
    theta = np.hypot(p[:, 0], p[:, 1]) * angle
    unit = p / np.where(theta > 0, theta / angle, 1)[:, None]
    v = np.column_stack((np.sin(theta)[:, None] * unit, np.cos(theta)))
    return v, f, np.tan(theta / 2)[:, None] / np.tan(angle / 2) * unit


def grid(rows, columns):
    """Points (i, j) of a grid as float64 rows, and triangles; x grows with j."""
    y, x = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    i = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = (corner.ravel() for corner in (i[:-1, :-1], i[:-1, 1:], i[1:, 1:], i[1:, :-1]))
    return np.column_stack((x.ravel(), y.ravel())).astype(float), np.vstack(
        (np.column_stack((a, b, c)), np.column_stack((a, c, d)))
    )


def half(v, f, axis=2):
    """The faces of a surface on one side of its centre, as a mesh of their own, and its rows of the surface."""
    part = f[v[f, axis].mean(axis=1) > v[:, axis].mean()]
    rows, part = np.unique(part, return_inverse=True)
    return v[rows], part.reshape(-1, 3), rows


def cut(v, f, centre, share):
    """A disk of a closed surface: faces about a vertex, by paths along edges, up to a share of the area."""
    start, stop = f.ravel(), f[:, [1, 2, 0]].ravel()
    length = np.maximum(np.linalg.norm(v[start] - v[stop], axis=1), 1e-12 * np.ptp(v))
    distance = dijkstra(
        csr_matrix((length, (start, stop)), shape=(len(v), len(v))), indices=centre
    )[f].max(axis=1)
    area = np.linalg.norm(np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]]), axis=1)
    order = np.argsort(distance)
    inside = np.zeros(len(f), dtype=bool)
    inside[order[: max(1, int(np.searchsorted(np.cumsum(area[order]), share * area.sum())))]] = True
    for _ in range(len(f)):
        for side in (True, False):  # one piece each: islands go over to what is around them
            rows = np.flatnonzero(inside == side)
            keys = np.sort(np.stack((f[rows], f[rows][:, [1, 2, 0]]), axis=2), axis=2).reshape(
                -1, 2
            )
            edge = keys[:, 0] * len(v) + keys[:, 1]
            order = np.argsort(edge, kind="stable")
            shared = np.flatnonzero(edge[order][1:] == edge[order][:-1])
            ends = order[shared] // 3, order[shared + 1] // 3
            links = coo_matrix((np.ones(len(shared)), ends), shape=(len(rows), len(rows)))
            label = connected_components(links, directed=False)[1]
            inside[rows[label != np.bincount(label).argmax()]] = not side
        part = f[inside]
        a, b = part.ravel(), part[:, [1, 2, 0]].ravel()
        rim = a[~np.isin(a * len(v) + b, b * len(v) + a)]  # where half-edges without a twin start
        pinched = np.flatnonzero(np.bincount(rim, minlength=1) > 1)
        if not len(pinched):
            break
        inside |= np.isin(f, pinched).any(axis=1)
    rows, part = np.unique(f[inside], return_inverse=True)
    return v[rows], part.reshape(-1, 3)
