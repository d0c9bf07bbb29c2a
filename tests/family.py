"""Bodies of one family: two known deformations of one body, each meshed, turned and moved anew."""

import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from igl_spheremap.shapes.groups.group import Group, Member

#: Of bend and bulge in six bodies.
AMOUNTS = np.array([[-1.0, -0.5], [1.0, -1.0], [0.0, 1.5], [-0.5, 1.0], [0.5, -1.0], [1.2, 0.3]])


def spiral(n, rng):
    """Points spread over the sphere in a pose of their own, and their Delaunay triangulation."""
    z = 1 - (2 * np.arange(n) + 1) / n
    turn = np.pi * (1 + 5**0.5) * np.arange(n)
    ring = np.sqrt(1 - z * z)
    x = (
        np.stack((ring * np.cos(turn), ring * np.sin(turn), z), axis=1)
        @ Rotation.random(random_state=rng).as_matrix()
    )
    f = ConvexHull(x).simplices.astype(np.int64)
    inward = np.linalg.det(x[f]) < 0
    f[inward] = f[inward][:, ::-1]
    return x, f


def body(x, bend=0.0, bulge=0.0):
    """Points of the body that points of the sphere go to: unlike axes, a bump, and the two deformations."""
    p = x * [1.0, 0.6, 0.45] + 0.35 * np.exp(-6 * ((x - [0.5, 0.8, 0.3]) ** 2).sum(axis=1))[
        :, None
    ] * [0.4, 1, 0.5]
    p = p + bend * 0.2 * np.outer(p[:, 0] ** 2 - 0.35, [0, 0.3, 1])
    towards = p - [0.6, 0, 0]
    return p + bulge * 0.25 * np.exp(-4 * (towards**2).sum(axis=1))[:, None] * towards


def family(amounts, n=300, seed=0, moved=True):
    """A body for each pair of amounts."""
    rng = np.random.default_rng(seed)
    for bend, bulge in amounts:
        x, f = spiral(int(n * rng.uniform(1, 1.1)), rng)
        v = body(x, bend, bulge)
        yield (
            (
                v @ Rotation.random(random_state=rng).as_matrix() + rng.normal(size=3)
                if moved
                else v
            ),
            f,
        )


def group_of(shapes, faces=()):
    """A group of these shapes, without modes, nothing of which was mapped."""
    mean, none = shapes.mean(axis=0), np.empty((*shapes.shape[:2], 0))
    members = tuple(Member(str(k), None, 1.0, 1.0, 1.0) for k in range(len(shapes)))
    return Group(
        mean,
        np.reshape(faces, (-1, 3)).astype(int),
        mean,
        shapes,
        np.empty((0, *mean.shape)),
        np.empty(0),
        np.empty((len(shapes), 0)),
        members,
        np.ones(len(mean)),
        np.ones(len(mean)),
        none,
        {},
        (),
    )
