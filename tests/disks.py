"""Disks whose maps to the plane are known."""

import numpy as np


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
    return np.column_stack((x.ravel(), y.ravel())).astype(float), np.vstack((np.column_stack((a, b, c)),
                                                                             np.column_stack((a, c, d))))


def half(v, f, axis=2):
    """The faces of a surface on one side of its centre, as a mesh of their own, and its rows of the surface."""
    part = f[v[f, axis].mean(axis=1) > v[:, axis].mean()]
    rows, part = np.unique(part, return_inverse=True)
    return v[rows], part.reshape(-1, 3), rows
