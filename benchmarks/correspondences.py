"""Figures of docs/correspondence.md: maps between surfaces, against the best rotation or Moebius map, and known truth.

    python -m benchmarks correspondences --meshes FOLDER... [--fsaverage FOLDER] [--pairs COUNT]
                                         [--only pairs warps landmarks chance registration functional overlays sizes]

FOLDER of the meshes holds the names of `PAIRS` as .obj or .npz files with `v` and `f`; that of fsaverage5 is
nilearn/datasets/data/fsaverage5 of the package nilearn, if none is named. Distances are root mean squares over A's
area after a similarity, over A's rms radius. Seconds are of the CPU, one thread. "functional" needs pyfmaps; --pairs
takes that many of the pairs, drawn with seed 0.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import igl
import nibabel
import numpy as np
from scipy.spatial.transform import Rotation

import igl_spheremap as ism
from igl_spheremap.mesh.measure import vertex_areas
from igl_spheremap.sphere.rows import unit_rows

from .common import fsaverage5, parser, peak_memory, timed

#: A onto B: sides of a body, one shape meshed twice, unlike shapes. "/n" takes n faces, "~" mirrors, "name:n" is a
#: sample, "fs:" a surface of fsaverage5, "body:s" a random body and "body:s+" the same one turned, on another grid,
#: with noise.
PAIRS = """
~hippocampus_aal_right hippocampus_aal_left | choi_hippocampus hippocampus_aal_left
~putamen_cit168_right paper_putamen_10002/8000 | ~fs:white_right fs:white_left | ~fs:pial_right fs:pial_left
fs:pial_left fs:white_left
choi_maxplanck/8000 choi_maxplanck | spot_oded/6000 spot_oded/14000 | armadillo_oded/8000 armadillo_oded/12000
penguin/3000 penguin | paper_bimba_15002/6000 paper_bimba_15002/10000 | paper_dilo_9731/6000 paper_dilo_9731
lucy_cr_50k/8000 lucy_cr_50k/12000 | koala/6000 koala/10000 | choi_moai/6000 choi_moai/10000
bunny_noise40/6000 bunny_noise40/10000 | fs:white_left/8000 fs:white_left/14000
dino:2500 dino:5000 | bird:2500 bird:4000 | octopus:3000 octopus:5000 | brain:5000 brain:8000
vhacd_cow2/6000 cow_libigl | cow_libigl spot_oded/6000 | dino_1502 paper_dino_5524
paper_dino_5524 dino_isoblend_6013 | paper_dilo_9731/6000 dino_isoblend_6013 | choi_maxplanck/6000 choi_moai/8000
choi_maxplanck/8000 paper_bimba_15002/8000 | paper_brain_15002/10000 fs:pial_left/10000 | penguin koala/6000
armadillo_oded/8000 lucy_cr_50k/8000
body:1 body:1+ | body:2 body:2+ | body:3 body:3+ | body:4 body:4+ | body:5 body:5+ | body:1 body:2 | body:3 body:4
body:5 body:6 | body:7 body:8 | body:9 body:10 | bird:2500 penguin | cow_libigl koala/6000 | spot_oded/6000 koala/6000
"""
#: Pairs of one shape, whose points belong together where they are nearest.
SAME = (
    "spot_oded/6000 spot_oded/14000",
    "armadillo_oded/8000 armadillo_oded/12000",
    "dino:2500 dino:5000",
    "lucy_cr_50k/8000 lucy_cr_50k/12000",
    "koala/6000 koala/10000",
)


class Data:
    """Meshes and their area-preserving maps."""

    def __init__(self, meshes: list[Path], fsaverage: Path) -> None:
        self._meshes, self.fsaverage = meshes, fsaverage

    def mesh(self, name):
        """Vertices and faces by a name as in `PAIRS`."""
        if name.startswith("~"):
            v, f = self.mesh(name[1:])
            return v * [-1, 1, 1], np.ascontiguousarray(f[:, ::-1])
        name, _, faces = name.partition("/")
        if name.startswith("body:"):
            v, f = body(int(name[5:].rstrip("+")), name.endswith("+"))
        elif name.startswith("fs:"):
            v, f = (
                np.asarray(each.data)
                for each in nibabel.load(self.fsaverage / f"{name[3:]}.gii.gz").darrays
            )
        elif ":" in name:
            name, _, n = name.partition(":")
            v, f = ism.samples.make(name, n_vertices=int(n))
        else:
            path = next(
                path
                for folder in self._meshes
                for end in ("obj", "npz")
                if (path := folder / f"{name}.{end}").exists()
            )
            v, f = (
                (np.load(path)[key] for key in "vf")
                if path.suffix == ".npz"
                else ism.read_mesh(path)
            )
        v, f = np.asarray(v, float), np.asarray(f, np.int64)
        return (
            tuple(np.asarray(a) for a in igl.qslim(v, f, int(faces)) if np.ndim(a) == 2)
            if faces
            else (v, f)
        )

    @cache  # noqa: B019
    def map(self, name):
        """The area-preserving map."""
        return ism.balanced_spherical_map(*self.mesh(name), balance=1.0)


def body(seed, again):
    """A random body of four to seven bent limbs; `again` turned, on a finer grid and with noise."""
    rng = np.random.default_rng(seed)
    limbs, n = rng.integers(4, 8), 52 if again else 44
    directions = unit_rows(rng.normal(size=(limbs, 3)))
    lengths, radii = rng.uniform(0.7, 1.6, limbs), rng.uniform(0.16, 0.3, limbs)
    bends = 0.35 * rng.normal(size=(limbs, 3))
    grid = np.linspace(-2.1, 2.1, n)
    points = np.stack(
        [each.ravel(order="F") for each in np.meshgrid(grid, grid, grid, indexing="ij")], axis=1
    )
    turn = Rotation.random(random_state=seed).as_matrix() if again else np.eye(3)
    values = np.exp(-3.6 * (points**2).sum(axis=1))
    for direction, length, radius, bend in zip(directions, lengths, radii, bends, strict=True):
        for t in np.linspace(0.2, 1, 9):
            centre = length * t * direction + t**2 * bend
            values += 0.45 * np.exp(-((points @ turn - centre) ** 2).sum(axis=1) / radius**2)
    v, f = (np.asarray(each) for each in igl.marching_cubes(values - 0.35, points, n, n, n)[:2])
    mesh = ism.repair_mesh(v, f, keep_largest=True)
    return (mesh.v + 0.004 * rng.normal(size=mesh.v.shape) if again else mesh.v), mesh.f


def similar(p, q, w):
    """Rows p after the similarity that brings them nearest to q."""
    w = w / w.sum()
    P, Q = p - w @ p, q - w @ q
    U, s, Vt = np.linalg.svd((P * w[:, None]).T @ Q)
    sign = np.array([1, 1, np.sign(np.linalg.det(U @ Vt))])
    return (s * sign).sum() / (w @ (P**2).sum(axis=1)) * P @ (U * sign) @ Vt + w @ q


def distance(a, b, x):
    """How far B's points are from A's, if A's sphere is x."""
    w = vertex_areas(a.vertices, a.faces)
    off = similar(ism.transfer(b, b.vertices, x), a.vertices, w) - a.vertices
    radius = a.vertices - w @ a.vertices / w.sum()
    return np.sqrt(w @ (off**2).sum(axis=1) / (w @ (radius**2).sum(axis=1)))


def starts(a, b):
    """Maps of A by all rotations of the search, with and without a Moebius map."""
    found = []
    turned = ism.shapes.register(a, b, stages=["rotation"])
    for candidate in turned.candidates:
        x = ism.repair_foldings(a.vertices, a.faces, a.sphere @ candidate.rotation.T)
        found += [x.sphere, ism.shapes.register(x, b, stages=["moebius"]).map.sphere]
    return found


def pairs(data, count=None):
    """The best start and the end of every pair, or of some."""
    every = [pair.split() for pair in PAIRS.replace("\n", "|").split("|") if pair.strip()]
    print("| A | B | vertices | best start | end | folds | CPU s |\n|---|---|---|---|---|---|---|")
    for row in sorted(np.random.default_rng(0).permutation(len(every))[:count]):
        names = every[row]
        a, b = map(data.map, names)
        best = min(distance(a, b, x) for x in starts(a, b))
        onto, seconds = timed(lambda: ism.shapes.match(a, b))  # noqa: B023
        end = distance(a, b, onto.map.sphere)
        print(
            f"| {title(names[0])} | {title(names[1])} | {len(a.sphere):,} onto {len(b.sphere):,} | {best:.3f} | "
            f"{end:.4f} | {onto.map.certificate.foldings} | {seconds:.1f} |",
            flush=True,
        )


def title(name):
    """A name of `PAIRS` as a reader of the table takes it."""
    name, _, faces = name.partition("/")
    if name.startswith("~"):
        name = f"mirrored {name[1:]}"
    if name.startswith("body:"):
        name = f"body {name[5:].rstrip('+')}" + ", again" * name.endswith("+")
    elif "fs:" not in name and ":" in name:
        name = "sample " + name.partition(":")[0]
    return name.replace("fs:", "fsaverage5 ") + (f", faces: {faces}" if faces else "")


def nearest(a, b):
    """The points of B that are nearest to A's vertices, and the vertices next to them."""
    _, faces, points = igl.point_mesh_squared_distance(a.vertices, b.vertices, b.faces)
    corners = b.faces[faces]
    off = np.linalg.norm(b.vertices[corners] - np.asarray(points)[:, None], axis=2)
    return np.asarray(points), corners[np.arange(len(corners)), off.argmin(axis=1)]


def error(a, onto, truth, rows=slice(None)):
    """Mean distance from the true points over the rms radius, of all vertices or of some."""
    w = vertex_areas(a.vertices, a.faces)
    radius = np.sqrt(w @ ((truth - w @ truth / w.sum()) ** 2).sum(axis=1) / w.sum())
    return w[rows] @ np.linalg.norm(onto - truth, axis=1)[rows] / w[rows].sum() / radius


def warps(data):
    """Copies of fewer faces, whose spheres are warped smoothly: back to the true points."""
    from .shapes import warped

    print("| body | vertices | warp, degrees | Moebius | end |\n|---|---|---|---|---|")
    for name in (
        "choi_maxplanck/8000 choi_maxplanck",
        "spot_oded/6000 spot_oded/14000",
        "fs:white_left/8000 fs:white_left",
        "koala/6000 koala/10000",
    ):
        a, b = map(data.map, name.split())
        truth = nearest(a, b)[0]
        for size in (0.12, 0.25):
            x = ism.repair_foldings(a.vertices, a.faces, warped(a.sphere, size))
            start = ism.shapes.register(x, b, stages=["rotation", "moebius"]).map.sphere
            onto = ism.shapes.match(x, b)
            cells = " | ".join(
                f"{error(a, p, truth):.4f}"
                for p in (ism.transfer(b, b.vertices, start), onto.positions)
            )
            print(
                f"| {title(name.split()[1])} | {len(a.sphere):,} onto {len(b.sphere):,} | {np.degrees(size):.0f} | "
                f"{cells} |",
                flush=True,
            )


def landmarks(data):
    """Landmarks of one shape meshed twice: how far the other points and landmarks that were left out are off."""
    from igl_spheremap.maps.variational import check_landmarks, match_landmarks

    rng = np.random.default_rng(1)
    print(
        "| body | vertices | landmarks | all met, no folds | Moebius: all, left out | end: all, left out | CPU s |"
    )
    print("|---|---|---|---|---|---|---|")
    for name in SAME:
        a, b = map(data.map, name.split())
        truth, vertices = nearest(a, b)
        order = rng.permutation(np.unique(vertices, return_index=True)[1])
        for k in (5, 10, 20):
            chosen, rest = order[:k], order[k:50]
            onto, seconds = timed(
                lambda: ism.shapes.match(a, b, landmarks=(chosen, vertices[chosen]))  # noqa: B023
            )
            targets = check_landmarks(len(a.sphere), chosen, b.sphere[vertices[chosen]], 1.0)
            start = ism.transfer(b, b.vertices, match_landmarks(a.sphere, targets, 1e-2))
            cells = " | ".join(
                f"{error(a, p, truth):.4f}, {error(a, p, truth, rest):.4f}"
                for p in (start, onto.positions)
            )
            met = (
                onto.map.sphere[chosen] == b.sphere[vertices[chosen]]
            ).all() and onto.map.certificate.folding_free
            print(
                f"| {title(name.split()[1])} | {len(a.sphere):,} onto {len(b.sphere):,} | {k} | "
                f"{'yes' if met else 'no'} | {cells} | {seconds:.1f} |",
                flush=True,
            )


def chance(data):
    """How often vertices by chance are met on unlike bodies."""
    rng = np.random.default_rng(1)
    for name in ("cow_libigl spot_oded/6000", "choi_hippocampus hippocampus_aal_left"):
        a, b = map(data.map, name.split())
        for k in (3, 5, 10):
            met = 0
            for _ in range(4):
                try:
                    chosen = tuple(rng.permutation(len(each.sphere))[:k] for each in (a, b))
                    ism.shapes.match(a, b, landmarks=chosen)
                    met += 1
                except ism.MapError:
                    pass
            print(f"{name}, {k} landmarks by chance: {met} of 4 met", flush=True)


def registration(data):
    """`register` on fsaverage5 and a pair of hippocampi, by stiffness; curvature was not used on the first."""
    from .shapes import correlation, degrees

    def over(name):
        return np.asarray(nibabel.load(data.fsaverage / f"{name}.gii.gz").darrays[0].data, float)

    for stiffness in (0.5, 0.2, 0.1, 0.05):
        source, target = data.map("~fs:white_right"), data.map("fs:white_left")
        sulc = over("sulc_right"), over("sulc_left")
        found = ism.shapes.register(source, target, features=sulc, stiffness=stiffness)
        w, end = vertex_areas(source.vertices, source.faces), found.stages[-1]
        curvature = correlation(
            over("curv_right"), ism.transfer(target, over("curv_left"), found.map), w
        )
        print(
            f"right on left by sulc, stiffness {stiffness}: sulc {end.correlation[0]:.4f}, curvature {curvature:.4f},"
            f" |log J| {end.strain:.4f}, {found.map.certificate.foldings} folded",
            flush=True,
        )
    for stiffness in (0.5, 0.2, 1.0):
        off = []
        for side in ("left", "right"):
            source, target = data.map(f"fs:pial_{side}"), data.map(f"fs:white_{side}")
            x = ism.shapes.register(source, target, stiffness=stiffness).map.sphere
            off.append(
                np.average(
                    degrees(x, target.sphere), weights=vertex_areas(source.vertices, source.faces)
                )
            )
        source, target = data.map("~hippocampus_aal_right"), data.map("hippocampus_aal_left")
        x = ism.shapes.register(source, target, stiffness=stiffness).map.sphere
        print(
            f"stiffness {stiffness}: pial on white, left {off[0]:.3f}, right {off[1]:.3f} degrees; hippocampi "
            f"{distance(source, target, x):.4f}",
            flush=True,
        )


def functional(data):
    """Functional maps of pyfmaps, as it ships and after ZoomOut, where the truth is known."""
    from pyFM.functional import FunctionalMapping
    from pyFM.mesh import TriMesh

    def found(a, b):
        model = FunctionalMapping(TriMesh(b.vertices, b.faces), TriMesh(a.vertices, a.faces))
        model.preprocess()
        model.fit()
        first = model.get_p2p()
        return first, model.get_p2p(model.zoomout_refine(nit=30, step=5))

    for name in SAME:
        a, b = map(data.map, name.split())
        truth, own = nearest(a, b)
        images, seconds = timed(lambda: found(a, b))  # noqa: B023
        onto, ours = timed(lambda: ism.shapes.match(a, b))  # noqa: B023
        off = [
            f"{error(a, b.vertices[p], truth):.4f} ({1 - len(np.unique(p)) / len(p):.0%} of A's vertices share "
            "their image)"
            for p in images
        ]
        print(
            f"{name}: functional map {off[0]}, refined {off[1]}, {seconds:.1f} s; nearest vertices "
            f"{error(a, b.vertices[own], truth):.4f}; match {error(a, onto.positions, truth):.4f}, {ours:.1f} s",
            flush=True,
        )


def overlays(data):
    """Time, memory and exactness of the common refinement, by size."""
    from igl_spheremap.shapes.correspondence.overlay import overlay

    print(
        "| vertices of A, B | of the overlay: vertices, faces | Euler characteristic | faces without area | "
        "areas of A, B off by | CPU s | peak of the process, GB |\n|---|---|---|---|---|---|---|"
    )
    for n in (10_000, 40_000):
        a, b = (
            ism.spherical_conformal_map(*ism.samples.make(name, n_vertices=n))
            for name in ("brain", "pear")
        )
        b = ism.sphere_map(
            b.vertices, b.faces, b.sphere @ Rotation.from_rotvec([1.0, 2.0, 0.5]).as_matrix()
        )
        both, seconds = timed(lambda: overlay(a, b))  # noqa: B023
        areas = [igl.doublearea(p, both.faces) for p in (both.on_source, both.on_target)]
        whole = [
            abs(each.sum() / igl.doublearea(m.vertices, m.faces).sum() - 1)
            for each, m in zip(areas, (a, b), strict=True)
        ]
        print(
            f"| {len(a.sphere):,}, {len(b.sphere):,} | {len(both.on_source):,}, {len(both.faces):,} | "
            f"{len(both.on_source) - len(both.faces) // 2} | {sum(int((each <= 0).sum()) for each in areas)} | "
            f"{whole[0]:.0e}, {whole[1]:.0e} | {seconds:.2f} | {peak_memory() / 1e3:.2f} |",
            flush=True,
        )


def sizes(data):
    """Time and memory by size."""
    print(
        "| vertices of A, B | landmarks | folds | CPU s | peak of the process, GB |\n|---|---|---|---|---|"
    )
    for n, k in ((10_000, 0), (40_000, 20)):
        a, b = (
            ism.balanced_spherical_map(*ism.samples.make("brain", n_vertices=m), balance=1.0)
            for m in (n, n + n // 10)
        )
        rows = nearest(a, b)[1]
        chosen = np.random.default_rng(0).permutation(np.unique(rows, return_index=True)[1])[:k]
        onto, seconds = timed(
            lambda: ism.shapes.match(a, b, landmarks=(chosen, rows[chosen]) if k else None)  # noqa: B023
        )
        print(
            f"| {len(a.sphere):,}, {len(b.sphere):,} | {k} | {onto.map.certificate.foldings} | {seconds:.1f} | "
            f"{peak_memory() / 1e3:.2f} |",
            flush=True,
        )


def main(argv: list[str]) -> None:
    """Print the figures."""
    parts = {
        part.__name__: part
        for part in (pairs, warps, landmarks, chance, registration, functional, overlays, sizes)
    }
    arguments = parser(__doc__)
    arguments.add_argument("--meshes", type=Path, nargs="+", required=True)
    arguments.add_argument("--fsaverage", type=Path)
    arguments.add_argument("--only", nargs="+", choices=parts, default=list(parts))
    arguments.add_argument("--pairs", type=int, metavar="COUNT")
    args = arguments.parse_args(argv)
    data = Data(args.meshes, args.fsaverage or fsaverage5())
    for name in args.only:
        parts[name](data, *([args.pairs] if name == "pairs" else []))
