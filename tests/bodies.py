"""Random closed bodies of genus 0 with deep limbs: tubes that grow out of a ball, and out of each other."""

from __future__ import annotations

import igl
import numpy as np
from triangulations import icosphere


def random_body(seed, depth=40.0, limbs=3, around=(8, 20), noise=0.05):
    """Vertices and faces of a ball with limbs up to `depth` nepers deep, their length over their radius.

    Half of the limbs branch, some are coils. Surfaces may cross themselves: a conformal map does not see that.
    """
    return body_and_rings(seed, depth, limbs, around, noise)[:2]


def body_and_rings(seed, depth, limbs, around, noise):
    """A random body, and the vertices of the rings that its tubes consist of."""
    rng = np.random.default_rng(seed)
    (v, f), rings = icosphere(3), []
    for root in rng.choice(len(v), limbs, replace=False):
        deep = depth * rng.uniform(0.35, 1)
        v, f, path, own = grow(rng, v, f, v[root], deep, int(rng.integers(*around)), noise)
        rings += own
        if rng.random() < 0.5:
            at = path[int(len(path) * rng.uniform(0.2, 0.8))]
            v, f, _, own = grow(
                rng, v, f, at, deep * rng.uniform(0.2, 0.6), int(rng.integers(*around)), noise
            )
            rings += own
    used, f = np.unique(f, return_inverse=True)
    whole = [np.searchsorted(used, ring) for ring in rings if np.isin(ring, used).all()]
    return v[used], f.reshape(-1, 3).astype(np.int64), whole


def grow(rng, v, f, at, depth, around, noise):
    """A tube of this many nepers and vertices around, in place of the star next to `at`; points along it; its rings."""
    used = np.unique(f)
    centre = int(used[np.argmin(np.linalg.norm(v[used] - at, axis=1))])
    star = (f == centre).any(axis=1)
    follow = {
        int(np.roll(g, -k)[1]): int(np.roll(g, -k)[2])
        for g in f[star]
        for k in [int(np.argmax(g == centre))]
    }
    loop = [next(iter(follow))]
    while follow[loop[-1]] != loop[0]:
        loop.append(follow[loop[-1]])
    p = v[loop].mean(axis=0)
    d = v[loop] - p
    t = np.cross(d, np.roll(d, -1, axis=0)).sum(axis=0)
    t /= np.linalg.norm(t)
    r = 0.9 * np.linalg.norm(d, axis=1).mean()
    e = across(rng.normal(size=3), t)
    angle = np.arctan2(d @ np.cross(t, e), d @ e) / (2 * np.pi)
    vertices, faces, path, rings = [v], [f[~star]], [], []
    last, turns, n, gone, bend = (
        np.array(loop),
        np.unwrap(angle, period=1),
        len(v),
        0.0,
        0.1 * rng.normal(size=2),
    )
    k, coil = 0, rng.random() < 0.4
    while gone < depth:
        step = 0.87 * 2 * np.pi * r / around
        gone, k = gone + step / r, k + 1
        bend = bend if coil else 0.95 * bend + 0.02 * rng.normal(size=2)
        t = t + (bend[0] * e + bend[1] * np.cross(t, e)) * step / r
        t /= np.linalg.norm(t)
        e, p = across(e, t), p + step * t
        at_turns = (np.arange(around) + 0.5 * (k % 2)) / around
        circle = np.exp(2j * np.pi * at_turns)[:, None]
        ring = p + r * (circle.real * e + circle.imag * np.cross(t, e))
        ids = n + np.arange(around)
        faces.append(stitch(last, turns, ids, at_turns))
        vertices.append(ring + noise * step * rng.normal(size=ring.shape))
        last, turns, n = ids, at_turns, n + around
        path.append(ring[0])
        rings.append(ids)
    vertices.append((p + 0.6 * r * t)[None])
    faces.append(np.column_stack((last, np.roll(last, -1), np.full(len(last), n))))
    return np.vstack(vertices), np.vstack(faces), path, rings


def ring_floor(v, f, rings):
    """Degrees of mean angle difference that no map to a plane can go below, given closed paths that share no vertex.

    The image of a ring of n edges is a closed polygon: the corners inside sum to (n - 2) pi, those outside to
    (n + 2) pi. On a straight tube both sum to n pi. On the sphere only rings near to a great circle do with less.
    """
    angles = igl.internal_angles(v, f)
    ahead = {
        (g[k], g[(k + 1) % 3]): (g[(k + 2) % 3], a[k])
        for g, a in zip(f.tolist(), angles, strict=True)
        for k in range(3)
    }
    change = 0.0
    for ring in (np.asarray(ring).tolist() for ring in rings):
        if any(edge not in ahead for edge in zip(ring, ring[1:] + ring[:1], strict=True)):
            continue  # a limb branches off there
        sides = np.zeros(2)
        for before, at, after in zip(ring[-1:] + ring[:-1], ring, ring[1:] + ring[:1], strict=True):
            for side, (u, end) in enumerate(((after, before), (before, after))):
                while u != end:
                    u, angle = ahead[at, u]
                    sides[side] += angle
        flat = (len(ring) + np.array([-2, 2])) * np.pi
        change += min(np.abs(sides - flat).sum(), np.abs(sides - flat[::-1]).sum())
    return np.degrees(change) / angles.size


def across(e, t):
    """Unit vector along the part of e that is orthogonal to t."""
    e = e - (e @ t) * t
    return e / np.linalg.norm(e)


def stitch(a, at, b, bt):
    """Triangles between two rings whose vertices lie at increasing turns."""
    first = int(np.argmin(np.abs((bt - at[0] + 0.5) % 1 - 0.5)))
    b, bt = np.roll(b, -first), np.roll(bt, -first)
    bt = bt[0] - np.round(bt[0] - at[0]) + (bt - bt[0]) % 1
    at, bt = np.append(at, at[0] + 1), np.append(bt, bt[0] + 1)
    i = j = 0
    faces = []
    while i < len(a) or j < len(b):
        if j == len(b) or (i < len(a) and at[i + 1] <= bt[j + 1]):
            faces.append((a[i], a[(i + 1) % len(a)], b[j % len(b)]))
            i += 1
        else:
            faces.append((a[i % len(a)], b[(j + 1) % len(b)], b[j]))
            j += 1
    return np.array(faces)


def worm(circumferences, around=20):
    """A tube this many circumferences long, of this many vertices around, bent a bit so that nothing is symmetric."""
    length = 2 * np.pi * circumferences
    s = np.linspace(-length / 2, length / 2, int(length / (2 * np.pi / around)))
    r = np.sqrt(np.maximum(1 - np.maximum(np.abs(s) - (length / 2 - 1), 0) ** 2, 0))[1:-1, None]
    t = np.arange(around) * 2 * np.pi / around
    axis = np.column_stack((np.sin(s / 9), np.cos(s / 7), s))
    rings = axis[1:-1, None] + r[..., None] * np.column_stack((np.cos(t), np.sin(t), 0 * t))
    v = np.vstack((axis[:1], rings.reshape(-1, 3), axis[-1:]))
    a, b, last = np.arange(around), (np.arange(around) + 1) % around, len(v) - 1
    f = [
        np.column_stack((0 * a, 1 + b, 1 + a)),
        np.column_stack((last - around + a, last - around + b, 0 * a + last)),
    ]
    for k in range(1, last - around, around):
        f += [
            np.column_stack((k + a, k + b, k + b + around)),
            np.column_stack((k + a, k + b + around, k + a + around)),
        ]
    return v, np.vstack(f)
