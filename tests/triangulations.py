"""Random points, rotations, triangulated spheres and bad positions for them."""

from __future__ import annotations

import igl
import numpy as np
from scipy.spatial import ConvexHull

from igl_spheremap.sphere.rows import unit_rows


def unit(p):
    """Rows of unit length."""
    return p / np.linalg.norm(p, axis=1)[:, None]


def drawn_to_pole(x, size):
    """The map after the linear map that draws directions to the poles of the z axis; no face changes its sign."""
    return unit_rows(x * [size, size, 1])


def random_points(n=200, seed=0):
    """Points on the sphere."""
    return unit(np.random.default_rng(seed).normal(size=(n, 3)))


def random_rotation(seed=0):
    """A rotation matrix."""
    turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return turn * np.sign(np.linalg.det(turn))


def wild(x, seed=0, noise=0.5):
    """The map `x` with noise, which folds it."""
    return unit(x + noise * np.random.default_rng(seed).normal(size=x.shape))


def icosphere(level):
    """Icosahedron, subdivided `level` times onto the unit sphere."""
    p, f = igl.icosahedron()
    p, f = unit(np.asarray(p, dtype=float)), np.asarray(f, dtype=np.int64)
    for _ in range(level):
        p, f = igl.upsample(p, f)[:2]
        p = unit(p)
    return p, f


def delaunay_sphere(n, rng):
    """Convex hull of random points on the sphere."""
    p = unit(rng.normal(size=(n, 3)))
    f = ConvexHull(p).simplices.astype(np.int64)
    q = p - p.mean(axis=0)
    inward = np.linalg.det(q[f]) < 0
    f[inward] = f[inward][:, ::-1]
    return p, f


def flip_edges(f, tries, rng):
    """Flip random edges, as long as the result is a simplicial complex."""
    f = f.tolist()
    left = {(t[k], t[(k + 1) % 3]): i for i, t in enumerate(f) for k in range(3)}
    for _ in range(tries):
        i, k = int(rng.integers(len(f))), int(rng.integers(3))
        a, b, c = (f[i][(k + j) % 3] for j in range(3))
        g = left[b, a]
        d = sum(f[g]) - a - b
        if (c, d) in left or (d, c) in left:
            continue
        del left[a, b], left[b, a]
        f[i], f[g] = [a, d, c], [d, b, c]
        left.update({(a, d): i, (d, c): i, (c, a): i, (d, b): g, (b, c): g, (c, d): g})
    return np.array(f, dtype=np.int64)


def stacked_sphere(n, rng):
    """Tetrahedron into whose faces vertices are put one by one, often into the newest."""
    f = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]
    for v in range(4, n):
        i = len(f) - 1 if rng.random() < 0.5 else int(rng.integers(len(f)))
        a, b, c = f[i]
        f[i] = [a, b, v]
        f += [[b, c, v], [c, a, v]]
    return np.array(f, dtype=np.int64)


def bipyramid(n):
    """Two hubs of valence n - 2."""
    i = np.arange(n - 2)
    j = (i + 1) % (n - 2)
    hub = np.full(n - 2, n - 2)
    return np.vstack((np.column_stack((i, j, hub)), np.column_stack((j, i, hub + 1))))


def nested_triangles(levels):
    """Triangles within triangles, between two caps: a long, thin tube."""
    f = [[0, 2, 1]]
    for a in range(0, 3 * levels, 3):
        for i in range(3):
            j = (i + 1) % 3
            f += [[a + i, a + j, a + 3 + i], [a + j, a + 3 + j, a + 3 + i]]
    return np.array([*f, [3 * levels, 3 * levels + 1, 3 * levels + 2]], dtype=np.int64)


def random_triangulation(rng):
    """One of the families above, renumbered at random."""
    n = int(rng.choice([6, 12, 60, 300]))
    family = int(rng.integers(6))
    if family == 0:
        f = flip_edges(icosphere(2)[1], int(rng.choice([10, 3000])), rng)
    elif family == 1:
        f = delaunay_sphere(n, rng)[1]
    elif family == 2:
        f = flip_edges(delaunay_sphere(n, rng)[1], 3000, rng)
    elif family == 3:
        f = stacked_sphere(n, rng)
    elif family == 4:
        f = bipyramid(n)
    else:
        f = nested_triangles(n // 3)
    return rng.permutation(int(f.max()) + 1)[f]


def bad_positions(n, rng):
    """Nonzero positions that no program should be asked to repair."""
    p = rng.normal(size=(n, 3))
    kind = int(rng.integers(6))
    if kind == 1:
        return np.outer(rng.uniform(-1, 1, n), [1.0, 2.0, 3.0]) + 1e-9  # a line
    if kind == 2:
        return np.column_stack((p[:, :2], np.zeros(n)))  # a plane
    if kind == 3:
        return np.ones((n, 3))  # a point
    if kind == 4:
        return np.where(rng.random((n, 1)) < 0.5, p, 1 + 1e-9 * p)  # half of them in a speck
    if kind == 5:
        # a few points
        return np.round(unit(p)) + (np.abs(np.round(unit(p))).sum(axis=1) == 0)[:, None]
    return p
