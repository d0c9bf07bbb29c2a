"""Harmonics of bodies that are not star-shaped, beside programs that take cells and molecules.

    python -m benchmarks harmonics [--cells FILE] [--degree 15]

The first body is star-shaped. Molecules are unions of balls about chains of atoms, by marching cubes; FILE holds cells,
a component each. Two variables name Pythons, FLOWSHAPE_PYTHON one with flowshape and AICS_PYTHON one with aicsshparam;
ktch is imported. *Hidden* is the share of the area that faces the centroid. Errors are root mean squares of distances
from the surface to the sum up to a degree, and back, in percent of the diagonal of the bounding box.
"""

from __future__ import annotations

import os
import subprocess
import tempfile
import warnings
from pathlib import Path

import igl
import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

import igl_spheremap as ism
from igl_spheremap.shapes.harmonics.basis import synthesis

from .common import parser

HEADER = (
    "body",
    "vertices",
    "hidden",
    "FlowShape: folds",
    "FlowShape",
    "aics-shparam",
    "ktch on our sphere",
    "here, conformal",
    "here, balance 1",
)
#: Radius of a carbon with its hydrogens, and the spacing of the grid of marching cubes, in angstroms.
RADIUS, SPACING = 2.0, 0.4
#: Voxels along the longest side of an image.
VOXELS = 96


def elsewhere(variable: str, name: str, **data: object) -> dict[str, np.ndarray]:
    """Run a function of `harmonics_programs.py` in the Python that a variable names."""
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "in.npz", Path(folder) / "out.npz"
        np.savez(source, **data)
        subprocess.run(
            [
                os.environ[variable],
                Path(__file__).with_name("harmonics_programs.py"),
                name,
                source,
                target,
            ],
            check=True,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        with np.load(target) as found:
            return dict(found)


def chain(count: int, turn: float, rise: float, radius: float) -> np.ndarray:
    """Atoms on a helix: `turn` degrees and `rise` from one to the next."""
    angle = np.radians(turn) * np.arange(count)
    return np.column_stack(
        (radius * np.cos(angle), radius * np.sin(angle), rise * np.arange(count))
    )


#: An arch of 14 atoms, a helix of two turns, and a rod with a hook.
MOLECULES = {
    "arch of 14 atoms": chain(14, 18.0, 0.0, 5.0),
    "helix of 24 atoms": chain(24, 30.0, 0.55, 4.0),
    "hook of 16 atoms": np.vstack(
        (chain(10, 0.0, 1.5, 3.0)[::-1] - [0, 0, 1.5], chain(6, 32.0, 0.3, 3.0))
    ),
}


def union_of_balls(centres: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The surface of balls about some centres."""
    sides = zip(centres.min(axis=0) - 3, centres.max(axis=0) + 3, strict=True)
    grid = np.meshgrid(*(np.arange(low, high, SPACING) for low, high in sides), indexing="ij")
    points = np.column_stack([each.ravel(order="F") for each in grid])
    depth = RADIUS - np.min([np.linalg.norm(points - centre, axis=1) for centre in centres], axis=0)
    return igl.marching_cubes(depth, points, *grid[0].shape, 0.0)[:2]


def bodies(cells: Path | None):
    """Names and meshes."""
    yield "sample pear", ism.check_mesh(*ism.samples.make("pear", n_vertices=3000))
    for name, centres in MOLECULES.items():
        yield name, ism.repair_mesh(*union_of_balls(centres))
    if cells:
        v, f = ism.read_mesh(cells)
        joined = csr_matrix(
            (np.ones(f.size), (f.ravel(), np.roll(f, -1, 1).ravel())), shape=(len(v),) * 2
        )
        label = connected_components(joined, directed=False)[1]
        for k in range(label.max() + 1):
            yield f"cell {k + 1}", ism.repair_mesh(v, f[label[f[:, 0]] == k])


def hidden(v: np.ndarray, f: np.ndarray) -> float:
    """Share of the area that faces the centroid of the surface."""
    normals, area, middle = (
        igl.per_face_normals(v, f, np.zeros(3)),
        igl.doublearea(v, f),
        v[f].mean(axis=1),
    )
    return float(
        area[((middle - area @ middle / area.sum()) * normals).sum(axis=1) < 0].sum() / area.sum()
    )


def error(v: np.ndarray, f: np.ndarray, w: np.ndarray, g: np.ndarray) -> float:
    """Root mean square distance of two surfaces, both ways, in percent of the first one's diagonal."""
    squares = []
    for (p, q), (a, b) in (((v, f), (w, g)), ((w, g), (v, f))):
        area = igl.doublearea(p, q)
        to_there = igl.point_mesh_squared_distance(p[q].mean(axis=1), a, b)[0]
        squares.append(area @ np.ravel(to_there) / area.sum())
    return float(100 * np.sqrt(np.mean(squares)) / np.linalg.norm(np.ptp(v, axis=0)))


def solid(v: np.ndarray, f: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """An image (z, y, x) of the inside, the place of its first voxel, and the voxels' size."""
    size = float(np.ptp(v, axis=0).max() / VOXELS)
    low, count = v.min(axis=0) - 4 * size, np.ceil(np.ptp(v, axis=0) / size).astype(int) + 8
    grid = np.stack(np.meshgrid(*(np.arange(n) for n in count), indexing="ij"), axis=-1)
    inside = igl.fast_winding_number(v, f, low + size * grid.reshape(-1, 3)) > 0.5
    return inside.reshape(count).transpose(2, 1, 0).astype(np.uint8), low, size


def row(name: str, mesh: object, degree: int) -> list[str]:
    """One line of the table."""
    from ktch.harmonic import SphericalHarmonicAnalysis

    v, f = mesh.v, mesh.f
    flow = elsewhere("FLOWSHAPE_PYTHON", "flowshape", v=v, f=f, degree=degree)
    image, low, size = solid(v, f)
    star = elsewhere("AICS_PYTHON", "aics", image=image, degree=degree)
    maps = ism.spherical_conformal_map(mesh), ism.balanced_spherical_map(mesh, balance=1)
    target = ism.samples.sphere(10_242)
    ours = [
        ism.shapes.spherical_harmonics(result, degree=degree).surface(target) for result in maps
    ]
    x, y, z = maps[1].sphere.T
    places = np.column_stack((np.arccos(np.clip(z, -1, 1)), np.arctan2(y, x) % (2 * np.pi)))
    analysis = SphericalHarmonicAnalysis(n_harmonics=degree, registration=None)
    flat = analysis.fit_transform([v], theta_phi=[places])
    fitted = synthesis(flat.reshape(3, -1).T, target[0]), target[1]
    # a mirror image does not fold
    folds = min(ism.certify(sign * flow["x"], f).foldings for sign in (1, -1))
    return [
        name,
        f"{len(v):,}",
        f"{hidden(v, f):.0%}",
        f"{folds:,}",
        *(
            f"{error(v, f, *body):.2f}"
            for body in ((flow["v"], flow["f"]), (low + size * star["v"], star["f"]), fitted, *ours)
        ),
    ]


def main(argv: list[str]) -> None:
    """Print the table."""
    arguments = parser(__doc__)
    arguments.add_argument("--cells", type=Path, help="a mesh file of cells")
    arguments.add_argument("--degree", type=int, default=15)
    options = arguments.parse_args(argv)
    warnings.simplefilter("ignore")
    print("| " + " | ".join(HEADER) + " |\n|---|" + "---:|" * (len(HEADER) - 1))
    for name, mesh in bodies(options.cells):
        print("| " + " | ".join(row(name, mesh, options.degree)) + " |", flush=True)
