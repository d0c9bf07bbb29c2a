"""Flat maps of an individual's hemispheres: its own cuts, those of a template, and how far distances are off.

The template's cuts are those that autoflatten 1.0.7 ships for fsaverage, carried over the registration, as `flatten
--patch --via` does. Distances up to 30 mm are measured along the white surface within each patch, between vertices that
all patches have. Shortest paths follow edges and straight lines across pairs of neighbouring faces. They are 1.67
percent longer than exact geodesics, so this is subtracted (60 vertices of S1's right hemisphere, 98 of 100 pairs within
2 percent).
"""

from __future__ import annotations

import json

import nibabel
import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

import igl_spheremap as ism
from igl_spheremap.plane.cuts import carry_cuts
from igl_spheremap.sphere.rows import unit_rows
from igl_spheremap.verify.rim import plane_signs

from .common import fsaverage5, timed

_REACH = 30.0  # mm
# Means over 600 vertices have a standard error of .1 mm: few of them, at the boundary, are far off.
_CENTRES, _PARTNERS = 5000, 200
_LONGER = 1.0167


def fsaverage(side):
    """Sphere and faces of fsaverage: those of fsaverage5, subdivided twice in FreeSurfer's order."""
    name = {"L": "sphere_left.gii.gz", "R": "sphere_right.gii.gz"}[side]
    x, f = (each.data for each in nibabel.load(fsaverage5() / name).darrays)
    x, f = unit_rows(np.asarray(x, float)), np.asarray(f, np.int64)
    for _ in range(2):
        x, f = _finer(x, f)
    return x, f


def _finer(x, f):
    """Split each face in four; new vertices are numbered by the faces that have them first."""
    a, b, c = f.T
    sides = np.stack((np.stack((c, a), 1), np.stack((b, c), 1), np.stack((a, b), 1)), 1)
    sides = np.sort(sides.reshape(-1, 2), axis=1)
    edges, first, index = np.unique(sides, axis=0, return_index=True, return_inverse=True)
    rank = np.empty(len(edges), np.int64)
    rank[np.argsort(first)] = np.arange(len(edges))
    ca, bc, ab = (len(x) + rank[index.ravel()]).reshape(-1, 3).T
    middles = np.empty((len(edges), 3))
    middles[rank] = x[edges].sum(axis=1)
    corners = np.stack(((ca, bc, c), (ab, bc, ca), (ab, b, bc))).transpose(2, 0, 1)
    faces = np.vstack((np.column_stack((a, ab, ca)), corners.reshape(-1, 3)))
    return np.vstack((x, unit_rows(middles))), faces


def carried(folder, side, v, f, x):
    """A hemisphere on the sphere x, cut as the template is."""
    path = next((folder / "autoflatten").rglob("fsaverage_cuts_template.json"))
    lost = [rows for name, rows in json.loads(path.read_text()).items() if name[0] == side.lower()]
    there, g = fsaverage(side)
    patch = g[~np.isin(g, np.concatenate(lost)).any(axis=1)]
    return ism.repair_disk(v, f, cut=carry_cuts(f, x, patch, there), keep_largest=True)


def _graph(v, f):
    """Lengths of edges, and of straight lines across pairs of neighbouring faces that lie within these."""
    n, start, stop, apex = len(v), f.ravel(), f[:, [1, 2, 0]].ravel(), f[:, [2, 0, 1]].ravel()
    order = np.argsort(start * n + stop)
    keys, back = (start * n + stop)[order], stop * n + start
    at = np.minimum(np.searchsorted(keys, back), len(keys) - 1)
    i = np.flatnonzero((keys[at] == back) & (start < stop))
    j = order[at[i]]
    edge = v[stop[i]] - v[start[i]]
    length = np.linalg.norm(edge, axis=1)
    (p, h), (q, k) = (
        (along, np.sqrt(np.maximum((w**2).sum(axis=1) - along**2, 0)))
        for w in (v[apex[i]] - v[start[i]], v[apex[j]] - v[start[i]])
        for along in [(w * edge).sum(axis=1) / length]
    )
    crossing = (p * k + q * h) / np.maximum(h + k, np.finfo(float).tiny)
    within = (crossing > 0) & (crossing < length)
    ends = np.concatenate(
        (np.column_stack((start[i], stop[i])), np.column_stack((apex[i], apex[j]))[within])
    )
    lengths = np.concatenate((length, np.hypot(p - q, h + k)[within]))
    ends, first = np.unique(np.sort(ends, axis=1), axis=0, return_index=True)
    return coo_array((lengths[first], ends.T), shape=(n, n)).tocsr()


def distances(v, f, centres, common):
    """Pairs of a centre and a common vertex, and how far they are apart along the surface."""
    graph, tree, rng, rows = _graph(v, f), cKDTree(v), np.random.default_rng(0), []
    reach = _LONGER * _REACH
    for centre in centres:
        ball = np.sort(tree.query_ball_point(v[centre], reach))  # no shorter path leaves it
        far = dijkstra(
            graph[ball][:, ball],
            directed=False,
            indices=np.searchsorted(ball, centre),
            limit=reach,
        )
        near = np.flatnonzero((far > 0) & np.isfinite(far) & common[ball])
        near = rng.choice(near, min(len(near), _PARTNERS), replace=False)
        rows.append((np.full(len(near), centre), ball[near], far[near] / _LONGER))
    return (np.concatenate(part) for part in zip(*rows, strict=True))


def _row(name, v, f, p, source, centres, common, cpu):
    """A row of the table: how far distances are off, as the map is and scaled to be off least."""
    first = dict(zip(source[::-1].tolist(), range(len(source) - 1, -1, -1), strict=True))
    known = (source >= 0) & common[source]
    i, j, d = distances(v, f, [first[each] for each in centres.tolist()], known)
    image = np.linalg.norm(p[i] - p[j], axis=1)
    by_centre = np.bincount(i, np.abs(image - d))[np.unique(i)] / np.bincount(i)[np.unique(i)]
    error = by_centre.std() / np.sqrt(len(by_centre))
    least = min((np.abs(s * image - d).mean(), s) for s in np.linspace(0.8, 1.2, 81))
    off = np.abs(image - d)
    signs = plane_signs(p, f)
    folds = min((signs <= 0).sum(), (signs >= 0).sum())  # flat maps may be seen from behind
    return (
        f"| {name} | {off.mean():.2f} ± {error:.2f} | {least[0]:.2f} at {least[1]:.3f} | "
        f"{np.median(off):.2f} | {np.percentile(off, 90):.2f} | {folds} | {cpu} |"
    )


def flat_rows(folder, person, side, v, f, x):
    """Rows of FreeSurfer's flat map, ours of the same patch, and ours with the template's cuts."""
    flat, g = person.surface("flat", side)
    own = ism.repair_disk(v, g, keep_largest=True, holes="fill")
    disks = {"its own cuts, `flatten`": own}
    if (folder / "autoflatten").exists() and fsaverage5() is not None:
        disks["fsaverage's cuts, `flatten`"] = carried(folder, side, v, f, x)
    there = np.bincount(np.unique(g), minlength=len(v))
    for disk in disks.values():
        there += np.bincount(
            np.unique(disk.vertex_source[disk.vertex_source >= 0]), minlength=len(v)
        )
    common = there == 1 + len(disks)
    centres = np.random.default_rng(0).choice(np.flatnonzero(common), _CENTRES, replace=False)
    everywhere = np.arange(len(v))
    yield _row("its own cuts, FreeSurfer", v, g, flat[:, :2], everywhere, centres, common, "-")
    for name, disk in disks.items():
        result, cpu = timed(lambda: ism.flatten(disk.v, disk.f))  # noqa: B023
        given = disk.v, disk.f, result.plane, disk.vertex_source
        yield _row(name, *given, centres, common, f"{cpu:.0f}")
