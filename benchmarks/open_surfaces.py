"""Surfaces that are no spheres: the cost of caps in angles, and handles found, with their lengths and CPU seconds.

``--holes`` cuts geodesic discs of 1, 10 and 30 percent of the area from samples and files, and compares the angle
differences of what is left with those of these faces in the map of the closed surface. ``--handles`` plants arches on
a ball. ``--voxels`` adds noise to a voxel body. ``--frames`` makes cubic frames of high genus. ``--folder`` repairs and
maps every mesh file of a folder. What single surfaces have goes to stderr where the table sums it up.
"""

from __future__ import annotations

import sys
from pathlib import Path

import igl
import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components, dijkstra

import igl_spheremap as ism
from igl_spheremap.mesh.measure import face_areas
from igl_spheremap.mesh_repair import surface

from .common import load, parser, timed

SAMPLES = ("sample:dino", "sample:bunny", "sample:brain", "sample:spheroid", "sample:pear")


def pairs(f):
    """Faces i, j that share an edge."""
    edges = np.sort(np.vstack((f[:, [0, 1]], f[:, [1, 2]], f[:, [2, 0]])), axis=1)
    order = np.lexsort(edges.T)
    same = (edges[order][1:] == edges[order][:-1]).all(axis=1)
    return order[:-1][same] % len(f), order[1:][same] % len(f)


def largest(f):
    """The faces of the largest component."""
    i, j = pairs(f)
    label = connected_components(
        coo_matrix((np.ones(len(i)), (i, j)), shape=(len(f), len(f))), directed=False
    )[1]
    return label == np.argmax(np.bincount(label))


def without_disc(v, f, share, rng):
    """Rows of the faces that a geodesic disc about a random vertex leaves."""
    length = np.linalg.norm(v[f] - v[np.roll(f, -1, axis=1)], axis=2).ravel()
    graph = coo_matrix(
        (length, (f.ravel(), np.roll(f, -1, axis=1).ravel())), shape=(len(v), len(v))
    ).tocsr()
    distance = dijkstra(graph, indices=int(rng.integers(len(v))))[f].max(axis=1)
    order, areas = np.argsort(distance, kind="stable"), face_areas(v, f)
    kept = np.sort(order[np.cumsum(areas[order]) > share * areas.sum()])
    return kept[largest(f[kept])]


def near_rim(f, rows, rings=3):
    """Which of these faces are within this many rings of a hole."""
    near = np.zeros(f.max() + 1, dtype=bool)
    near[np.intersect1d(f[rows], np.delete(f, rows, axis=0))] = True
    for ring in range(rings):
        touched = near[f[rows]].any(axis=1)
        if ring < rings - 1:
            near[f[rows][touched]] = True
    return touched


def holes(sources, seeds):
    """The table of holes."""
    excess = {}
    for source in sources:
        v, f = load(source)
        closed = np.abs(ism.spherical_conformal_map(v, f).angle_differences()).mean(axis=1)
        for share in (0.01, 0.1, 0.3):
            for seed in range(seeds):
                rows = without_disc(v, f, share, np.random.default_rng(seed))
                used, g = np.unique(f[rows], return_inverse=True)
                mesh = ism.repair_mesh(v[used], g.reshape(-1, 3), holes="fill")
                result = ism.spherical_conformal_map(mesh.v, mesh.f, caps=mesh.face_source < 0)
                size = np.abs(result.angle_differences()).mean(axis=1) - closed[rows]
                found = size.mean(), size[near_rim(f, rows)].mean(), bool(result.certificate)
                excess.setdefault(share, []).append(found)
                print(source, len(v), share, *found, file=sys.stderr, flush=True)
    print(
        "| hole, % of the area | discs | certified | surface: mean, worst | three rings at the rim: mean, worst |"
    )
    print("|---|---|---|---|---|")
    for share, found in excess.items():
        mean, worst = np.mean(found, axis=0), np.max(found, axis=0)
        print(
            f"| {100 * share:g} | {len(found)} | {sum(one[2] for one in found)} | {mean[0]:.2f}, {worst[0]:.2f} | "
            f"{mean[1]:.2f}, {worst[1]:.2f} |"
        )


def isosurface(field, points, resolution):
    """The largest component of where a field vanishes, turned outward."""
    v, f, _ = igl.marching_cubes(field, points, resolution, resolution, resolution, 0.0)
    f = f[largest(f)]
    used, f = np.unique(f, return_inverse=True)
    v, f = v[used], f.reshape(-1, 3).astype(np.int64)
    outward = np.einsum("ij,ij->", v[f[:, 0]], np.cross(v[f[:, 1]], v[f[:, 2]])) > 0
    return v, f if outward else f[:, ::-1].copy()


def lattice(resolution, reach=1.5):
    """Points of a cube, x fastest."""
    axis = np.linspace(-reach, reach, resolution)
    z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
    return np.column_stack((x.ravel(), y.ravel(), z.ravel()))


def arches(count, resolution, seed):
    """A ball with thin arches: mesh, tops of the arches, and girths of their tubes."""
    rng, p = np.random.default_rng(seed), lattice(resolution)
    inside = 1 - np.linalg.norm(p, axis=1)
    step = np.arange(count) + 0.5
    height = 1 - 2 * step / count
    turn = np.pi * (1 + np.sqrt(5)) * step + rng.uniform(0, 6)
    radius = 0.22 if count > 8 else 0.3
    tops, girths = [], []
    for z, angle in zip(height, turn, strict=True):
        out = np.array([np.sqrt(1 - z * z) * np.cos(angle), np.sqrt(1 - z * z) * np.sin(angle), z])
        along = np.cross(out, rng.normal(size=3))
        along /= np.linalg.norm(along)
        tube = 0.05 * rng.uniform(0.8, 1.4)
        q = p - out
        in_plane = np.hypot(q @ out, q @ along) - radius
        inside = np.maximum(inside, tube - np.hypot(in_plane, q @ np.cross(out, along)))
        tops.append(out * (1 + radius))
        girths.append(2 * np.pi * tube)
    return *isosurface(inside, p, resolution), np.array(tops), np.array(girths)


def cut(v, f, **options):
    """The repaired mesh, the cut loops as positions, and CPU seconds."""
    loops, find = [], surface.cutting_loops

    def watched(scaled, f):
        found, low = find(scaled, f), scaled.min(axis=0)
        # loops are found in a unit of their own
        unit = np.ptp(v, axis=0).max() / np.ptp(scaled, axis=0).max()
        loops.extend((scaled[loop] - low) * unit + v.min(axis=0) for loop in found)
        return found

    surface.cutting_loops = watched
    try:
        mesh, seconds = timed(lambda: ism.repair_mesh(v, f, handles="cut", **options))
    finally:
        surface.cutting_loops = find
    return mesh, loops, seconds


def mapped(mesh):
    """Whether the map is certified, and its CPU seconds."""
    caps = mesh.face_source < 0
    result, seconds = timed(lambda: ism.spherical_conformal_map(mesh.v, mesh.f, caps=caps))
    return "yes" if result.certificate.folding_free else "no", seconds


def handles(cases):
    """The table of planted handles."""
    print(
        "| handles | vertices | found, each its own | loop over girth | CPU s to cut | to map | certified |"
    )
    print("|---|---|---|---|---|---|---|")
    for count, resolution, seed in cases:
        v, f, tops, girths = arches(count, resolution, seed)
        mesh, loops, seconds = cut(v, f)
        near = [np.linalg.norm(tops - loop.mean(axis=0), axis=1).argmin() for loop in loops]
        ratio = [
            np.linalg.norm(p - np.roll(p, 1, axis=0), axis=1).sum() / girths[k]
            for p, k in zip(loops, near, strict=True)
        ]
        certified, more = mapped(mesh)
        print(
            f"| {count} | {len(v)} | {len(set(near))} | {min(ratio):.2f} to {max(ratio):.2f} | {seconds:.2f} | "
            f"{more:.2f} | {certified} |",
            flush=True,
        )


def voxels(cases):
    """The table of voxel bodies: a ball of voxels with noise that makes small handles and holes through it."""
    print(
        "| lattice | vertices | genus | longest loop, voxels | CPU s to cut | to map | certified |"
    )
    print("|---|---|---|---|---|---|---|")
    for resolution, seed in cases:
        rng, p = np.random.default_rng(seed), lattice(resolution)
        shape = (
            1
            - np.linalg.norm(p, axis=1)
            + 0.1 * np.sin(7 * p[:, 0]) * np.cos(6 * p[:, 1]) * np.sin(5 * p[:, 2])
        )
        solid = shape > 0
        shell = np.flatnonzero(np.abs(shape) < 2 * 3 / resolution)
        solid[rng.choice(shell, len(shell) // 12, replace=False)] ^= True
        v, f = isosurface(np.where(solid, 1.0, -1.0) + 1e-3 * rng.random(len(p)), p, resolution)
        genus = (2 - len(v) + len(f) // 2) // 2
        mesh, loops, seconds = cut(v, f)
        longest = (
            max(np.linalg.norm(p - np.roll(p, 1, axis=0), axis=1).sum() for p in loops)
            * (resolution - 1)
            / 3
        )
        certified, more = mapped(mesh)
        print(
            f"| {resolution} | {len(v)} | {genus} | {longest:.1f} | {seconds:.2f} | {more:.2f} | {certified} |",
            flush=True,
        )


def frames(cases):
    """The table of bodies of high genus: cubic frames of cells^3 cells that lack up to a quarter of their struts."""
    print("| cells | vertices | genus | CPU s to cut | to map | certified |")
    print("|---|---|---|---|---|---|")
    for cells, seed in cases:
        rng, k = np.random.default_rng(seed), 2 * cells + 1
        odd = (np.indices((k, k, k)) % 2).sum(axis=0)
        solid = (odd == 0) | ((odd == 1) & (rng.random((k, k, k)) > rng.uniform(0, 0.25)))
        solid = np.pad(np.kron(solid, np.ones((2, 2, 2), dtype=bool)), 1).ravel()
        points = lattice(2 * k + 2)
        v, f = isosurface(
            np.where(solid, 1.0, -1.0) + 0.1 * rng.random(len(points)), points, 2 * k + 2
        )
        genus = (2 - len(v) + len(f) // 2) // 2
        mesh, _, seconds = cut(v, f)
        certified, more = mapped(mesh)
        print(
            f"| {cells} | {len(v)} | {genus} | {seconds:.2f} | {more:.2f} | {certified} |",
            flush=True,
        )


def folder(path):
    """The table of the files of a folder, by what their largest components are."""
    kinds = {}
    for file in sorted(Path(path).iterdir()):
        if file.suffix in (".md", ".csv"):
            continue
        if file.suffix == ".npz":
            with np.load(file) as archive:
                names = ("vertices", "faces") if "vertices" in archive else ("v", "f")
                v, f = (archive[name] for name in names)
        else:
            v, f = ism.read_mesh(file, triangulate=True)
        try:
            mesh, _, seconds = cut(v, f, keep_largest=True, holes="fill")
        except ism.MeshError as error:
            kinds.setdefault("refused", []).append((len(v), 0, 0, 0.0, 0.0, False))
            print(file.name, error, file=sys.stderr, flush=True)
            continue
        part = max(ism.info(v, f).topology.components, key=lambda one: one.faces)
        certified, more = mapped(mesh)
        loops, genus = len(part.boundary_loops), part.handles
        kind = (
            "handles and holes"
            if loops and genus
            else "closed with handles"
            if genus
            else "genus 0 with holes"
        )
        kinds.setdefault(kind, []).append((len(v), genus, loops, seconds, more, certified == "yes"))
        print(file.name, kind, kinds[kind][-1], file=sys.stderr, flush=True)
    print(
        "| surface | files | certified | vertices, handles, holes at most | CPU s to repair, to map at most |"
    )
    print("|---|---|---|---|---|")
    for kind, found in kinds.items():
        vertices, genus, loops, seconds, more, _ = np.max(found, axis=0)
        print(
            f"| {kind} | {len(found)} | {sum(one[-1] for one in found)} | {vertices:,.0f}, {genus:.0f}, {loops:.0f} "
            f"| {seconds:.2f}, {more:.2f} |"
        )


def main(argv: list[str]) -> None:
    """Print the tables that were asked for."""
    arguments = parser(__doc__)
    arguments.add_argument(
        "--holes", nargs="*", metavar="MESH", help=f"samples or files; default: {' '.join(SAMPLES)}"
    )
    arguments.add_argument(
        "--seeds", type=int, default=3, help="discs of each size on each body (default 3)"
    )
    arguments.add_argument(
        "--handles", nargs="*", metavar="COUNT:RESOLUTION", help="default: 1:60 3:80 5:100 20:120"
    )
    arguments.add_argument(
        "--voxels", nargs="*", type=int, metavar="RESOLUTION", help="default: 60 100"
    )
    arguments.add_argument("--frames", nargs="*", type=int, metavar="CELLS", help="default: 2 3 4")
    arguments.add_argument("--folder", help="mesh files, .npz with v and f among them")
    args = arguments.parse_args(argv)
    if args.holes is not None:
        holes(args.holes or SAMPLES, args.seeds)
    if args.handles is not None:
        cases = [
            tuple(map(int, case.split(":")))
            for case in args.handles or ("1:60", "3:80", "5:100", "20:120")
        ]
        handles([(*case, seed) for seed, case in enumerate(cases)])
    if args.voxels is not None:
        voxels([(resolution, seed) for seed, resolution in enumerate(args.voxels or (60, 100))])
    if args.frames is not None:
        frames([(cells, seed) for seed, cells in enumerate(args.frames or (2, 3, 4))])
    if args.folder is not None:
        folder(args.folder)
