"""Maps of disks to the plane: beside other programs and exact maps, by sliding alone, and of long shapes.

    python -m benchmarks disks programs [--corpus FOLDER] [--only NAME] [--largest VERTICES] [--jsonl FILE]
    python -m benchmarks disks exact
    python -m benchmarks disks sliding [--corpus FOLDER] [--largest VERTICES]
    python -m benchmarks disks long [--sizes VERTICES ...]

`programs` counts folds and overlaps, and has medians of means of angles, areas, lengths and CPU seconds: of real
surfaces with one boundary loop, cortex as FreeSurfer cuts it (nilearn), and disks of 15, 50 and 90 percent of the area
of closed ones. `exact` has errors on surfaces of revolution, `sliding` angle differences over those of doubling.
`long` times fans, strips and stars. ``--only`` takes names that contain its word.
"""

from __future__ import annotations

import json
import sys
import warnings
from argparse import Namespace
from collections.abc import Callable, Iterator
from pathlib import Path

import igl
import numpy as np
from corpus import CORPUS
from disks import cut, half, polar

import igl_spheremap as ism
from igl_spheremap.errors import FactorisationFailed
from igl_spheremap.mesh.disk import Disk
from igl_spheremap.plane.doubling import centred, double_map
from igl_spheremap.plane.plane_map import in_space
from igl_spheremap.plane.sliding import slid_map
from igl_spheremap.plane.tutte import by_harmonic_measure, tutte_map
from igl_spheremap.result.run import History
from igl_spheremap.samples import SurfaceOfRevolution
from igl_spheremap.verify.distortion import mean_angle_difference
from igl_spheremap.verify.rim import rim_crossings

from .common import fsaverage5, parser, timed

Mesh = tuple[np.ndarray, np.ndarray]
_SHARES = (0.15, 0.5, 0.9)
#: Surfaces of revolution, cut this many degrees from the pole.
_EXACT = {
    "spherical cap, 75 degrees": (SurfaceOfRevolution(), 75),
    "half spheroid 1 : 1 : 2": (SurfaceOfRevolution(2.0), 90),
    "half pear": (SurfaceOfRevolution(1.4, (1.0, -0.4, 0.1, 0.2)), 90),
    "cup, 150 degrees": (SurfaceOfRevolution(), 150),
}
_RINGS = (10, 20, 40, 80, 160)
_STEPS = 20  # of SLIM


def disks(corpus: Path, only: str) -> Iterator[tuple[str, Mesh]]:
    """Names that contain a word, and meshes."""
    if fsaverage5():
        yield from _cortex()
    for path in sorted((corpus / "open").glob("g0_b1_*.npz")):
        yield path.stem, _compact(*ism.read_mesh(_as_archive(path)))
    files = [
        path
        for folder in ("public", "hard", "pairs")
        for path in sorted((corpus / folder).glob("*.*"))
    ]
    closed = {path.stem: path for path in files if path.suffix in (".obj", ".npz")}
    meshes = [(name, f"sample:{name}:n_vertices=2000") for name in ism.samples.names()] + list(
        closed.items()
    )
    random = np.random.default_rng(0)
    for name, source in meshes:
        try:
            v, f = (
                ism.samples.from_spec(source.removeprefix("sample:"))
                if str(source).startswith("sample:")
                else ism.read_mesh(_as_archive(Path(source)))
            )
            ism.check_mesh(v, f)
        except ValueError:
            continue
        for share in _SHARES:
            centre = int(random.integers(len(v)))
            if only in (title := f"{name}, {share:.0%}"):
                yield title, cut(v, f, centre, share)


def _as_archive(path: Path) -> Path | str:
    """The corpus keeps some meshes as arrays `v` and `f`; these are written under the names that are read."""
    if path.suffix != ".npz":
        return path
    with np.load(path) as arrays:
        target = Path("/tmp") / f"igl_spheremap_{path.name}"
        np.savez(target, vertices=arrays["v"], faces=arrays["f"])
    return target


def _compact(v: np.ndarray, f: np.ndarray) -> Mesh:
    rows, f = np.unique(f, return_inverse=True)
    return v[rows], f.reshape(-1, 3)


def _cortex() -> Iterator[tuple[str, Mesh]]:
    for side in ("left", "right"):
        faces, white = _fsaverage5(f"flat_{side}", 1), _fsaverage5(f"white_{side}", 0)
        yield f"cortex {side}", _compact(white.astype(float), faces.astype(np.int64))


def _fsaverage5(name: str, array: int) -> np.ndarray:
    """An array of a file that nilearn brings."""
    import nibabel

    return np.asarray(nibabel.load(fsaverage5() / f"{name}.gii.gz").darrays[array].data)  # type: ignore[operator]


def freesurfer(v: np.ndarray, f: np.ndarray) -> np.ndarray:
    """FreeSurfer's flat map of a hemisphere of fsaverage5, known by its number of vertices."""
    for side in ("left", "right"):
        rows = np.unique(_fsaverage5(f"flat_{side}", 1))
        if len(rows) == len(v):
            return _fsaverage5(f"flat_{side}", 0)[rows, :2].astype(float)
    raise ValueError("FreeSurfer's map of it is not at hand")


def methods() -> dict[str, Callable[[np.ndarray, np.ndarray], np.ndarray]]:
    """Functions of v, f that return images (n, 2)."""
    return {
        "`disk_conformal_map`": lambda v, f: ism.disk_conformal_map(v, f).plane,
        "`balanced_disk_map`, balance 1": lambda v, f: ism.balanced_disk_map(v, f, balance=1).plane,
        "`flatten`": lambda v, f: ism.flatten(v, f).plane,
        "`flatten`, balance 0": lambda v, f: ism.flatten(v, f, balance=0).plane,
        "FreeSurfer's flat maps (in nilearn; hours)": freesurfer,
        "`igl.harmonic`, circle": _harmonic,
        "`igl.lscm`": _lscm,
        f"SLIM of libigl, {_STEPS} steps": _slim,
    }


def _harmonic(v: np.ndarray, f: np.ndarray) -> np.ndarray:
    rim = ism.check_disk(v, f).rim
    return np.asarray(igl.harmonic(v, f, rim, igl.map_vertices_to_circle(v, rim), 1))


def _lscm(v: np.ndarray, f: np.ndarray) -> np.ndarray:
    rim = ism.check_disk(v, f).rim
    ends = rim[[0, len(rim) // 2]]
    return np.asarray(igl.lscm(v, f, ends, np.array([[0.0, 0.0], [1.0, 0.0]]))[0])


def _slim(v: np.ndarray, f: np.ndarray) -> np.ndarray:
    start = _harmonic(v, f)
    if not ism.certify(start, f).folding_free:
        raise ValueError("its start, the harmonic map, folds")
    arrays = [np.asfortranarray(each) for each in (v, f.astype(np.int32), start)]
    energy, free = (
        igl.MappingEnergyType.SYMMETRIC_DIRICHLET,
        (np.empty(0, np.int32), np.empty((0, 2), order="F")),
    )
    data = igl.slim_precompute(*arrays, energy, *free, 0.0)
    return np.asarray(igl.slim_solve(data, _STEPS))[:, :2]


def figures(v: np.ndarray, f: np.ndarray, p: np.ndarray) -> dict[str, float]:
    """Folded faces, boundary edges that cross others, means of angle differences and logarithms of ratios."""
    mesh = ism.check_disk(v, f)
    image = np.column_stack((p, np.zeros(len(p))))
    certificate = ism.certify(p, f)
    sizes = [
        np.abs(part)
        for part in (
            ism.angle_differences(v, f, image),
            ism.log_area_ratios(v, f, image),
            ism.log_length_ratios(v, f, image),
        )
    ]
    angle, area, edge = (float(size[np.isfinite(size)].mean()) for size in sizes)
    return {
        "folds": certificate.foldings,
        "crossings": int(rim_crossings(p, mesh.rim).sum()),
        "angle": angle,
        "area": area,
        "edge": edge,
    }


def slid_over_doubled(disk: Disk) -> tuple[float, float] | None:
    """Mean angle differences of the map by doubling, and of that by sliding alone; None if doubling folds faces."""
    try:
        doubled, _ = double_map(disk, None)
    except (FactorisationFailed, ism.FoldingsRemain, ism.MeshError):  # a triangle has no double
        return None
    if not ism.certify(doubled, disk.f).folding_free:
        return None
    slid, _ = slid_map(disk, History(None))
    return mean_angle_difference(disk, in_space(doubled)), mean_angle_difference(
        disk, in_space(slid)
    )


def given(args: Namespace) -> Iterator[tuple[str, Disk]]:
    """The disks that were asked for; those that are refused are named."""
    for name, (v, f) in disks(args.corpus, args.only):
        if args.only in name and len(v) <= args.largest:
            try:
                yield name, ism.check_disk(v, f)
            except ism.MeshError as error:
                print(f"{name}: left out, {error}", file=sys.stderr)


def programs(args: Namespace) -> None:
    """Each method on each disk."""
    rows: dict[str, list[dict[str, float]]] = {name: [] for name in methods()}
    for name, disk in given(args):
        for method, call in methods().items():
            v, f = disk.v, disk.f
            try:
                p, cpu = timed(lambda call=call, v=v, f=f: call(v, f))  # type: ignore[misc]
                row = figures(v, f, p) | {"cpu": cpu}
            except Exception as error:  # whatever a peer raises counts as a failure
                row = {"failure": f"{type(error).__name__}: {error}"}
            rows[method].append(row)
            if args.jsonl:
                with args.jsonl.open("a") as file:
                    print(
                        json.dumps({"disk": name, "vertices": len(v), "method": method} | row),
                        file=file,
                    )
    print(
        "| method | disks | failed | with folds | with overlaps | angle | area | length | CPU s |"
    )
    print("|---|---:|---:|---:|---:|---:|---:|---:|---:|")
    for method, found in rows.items():
        if done := [row for row in found if "failure" not in row]:
            angle, area, edge, cpu = (
                np.nanmedian([row[key] for row in done]) for key in ("angle", "area", "edge", "cpu")
            )
            print(
                f"| {method} | {len(found)} | {len(found) - len(done)} | {sum(row['folds'] > 0 for row in done)} | "
                f"{sum(row['crossings'] > 0 for row in done)} | {angle:.3g} | {area:.3g} | {edge:.3g} | {cpu:.2g} |"
            )


def exact(_: Namespace) -> None:
    """Root mean square errors by doubling, and of the map that sliding starts from."""
    sizes = " | ".join(f"{1 + 3 * n * (n + 1):,}" for n in _RINGS)
    print(
        f"| rms error | {sizes} vertices | mean order | CPU s of the last |\n|---|"
        + "---:|" * (len(_RINGS) + 2)
    )
    for by, make in (
        ("doubling", lambda disk: ism.disk_conformal_map(disk.v, disk.f).plane),
        ("harmonic measure, before sliding", _unslid),
    ):
        for name, (surface, degrees) in _EXACT.items():
            errors = []
            for rings in _RINGS:
                disk, true = revolved(surface, degrees, rings)
                p, cpu = timed(lambda make=make, disk=disk: make(disk))
                z, w = p @ [1, 1j], true @ [1, 1j]
                turn = np.exp(1j * np.angle((disk.A * z.conj() * w).sum()))
                errors.append(np.sqrt((disk.A * np.abs(turn * z - w) ** 2).sum()))
            order = np.log2(errors[0] / errors[-1]) / (len(_RINGS) - 1)
            cells = " | ".join(f"{error:.1e}" for error in errors)
            print(f"| {by}: {name} | {cells} | {order:.1f} | {cpu:.2g} |", flush=True)


def _unslid(disk: Disk) -> np.ndarray:
    """The first start of sliding."""
    return tutte_map(disk, centred(tutte_map(disk, by_harmonic_measure(disk)), disk)[disk.rim])


def revolved(surface: SurfaceOfRevolution, degrees: float, rings: int) -> tuple[Disk, np.ndarray]:
    """The part of a surface of revolution around its pole, and its conformal map to the unit disk."""
    p, f = polar(rings)
    theta = np.hypot(p[:, 0], p[:, 1]) * np.radians(degrees)
    around = p / np.where(theta > 0, np.hypot(p[:, 0], p[:, 1]), 1)[:, None]
    v = surface.embed(np.column_stack((np.sin(theta)[:, None] * around, np.cos(theta))))
    x = surface.conformal_map(v)
    image = x[:, :2] / (1 + x[:, 2:])
    return ism.check_disk(v, f), image / np.hypot(image[:, 0], image[:, 1]).max()


def sliding(args: Namespace) -> None:
    """Sliding alone where doubling folds nothing."""
    ratios = []
    for name, disk in given(args):
        found = slid_over_doubled(disk)
        if found and found[0] > 0:
            ratios.append(found[1] / found[0])
            print(
                f"{name}, {len(disk.v)} vertices: {found[0]:.2f} degrees, times {ratios[-1]:.2f}",
                file=sys.stderr,
            )
    print("| disks | median | mean | beyond 1.3 |\n|---|---|---|---|")
    print(
        f"| {len(ratios)} | {np.median(ratios):.3f} | {np.mean(ratios):.3f} | {np.sum(np.array(ratios) > 1.3)} |"
    )


def fan(n: int) -> Mesh:
    """A jagged, bent fan of three quarters of a turn."""
    rng, turn = np.random.default_rng(0), np.linspace(0, 1.5 * np.pi, n)
    radius, i = rng.uniform(0.7, 1, n), np.arange(1, n)
    rim = np.column_stack((radius * np.cos(turn), radius * np.sin(turn), 0.1 * rng.normal(size=n)))
    return np.vstack((np.zeros(3), rim)), np.column_stack((0 * i, i, i + 1))


def strip(n: int) -> Mesh:
    """A jagged, bent strip, two vertices wide."""
    rng, half_n = np.random.default_rng(1), n // 2
    x, i = np.arange(half_n) / 10, np.arange(half_n - 1)
    side = np.column_stack((x, 0 * x, 0.01 * rng.normal(size=half_n)))
    v = np.vstack((side, side + [0, 1, 0] + 0.01 * rng.normal(size=side.shape)))
    return v, np.vstack(
        (
            np.column_stack((i, i + 1, i + half_n)),
            np.column_stack((i + 1, i + half_n + 1, i + half_n)),
        )
    )


def star(n: int) -> Mesh:
    """A star whose every second vertex lies at a fifth of the radius, bent."""
    rng, i = np.random.default_rng(2), np.arange(n)
    radius, turn = np.where(i % 2, 1, 0.2), 2 * np.pi * i / n
    rim = np.column_stack((radius * np.cos(turn), radius * np.sin(turn), 0.05 * rng.normal(size=n)))
    return np.vstack((np.zeros(3), rim)), np.column_stack((0 * i, 1 + i, 1 + (i + 1) % n))


def half_spheroid(n: int) -> Mesh:
    """Upper half of a spheroid."""
    return half(*ism.samples.make("spheroid", n_vertices=2 * n))[:2]


def long(args: Namespace) -> None:
    """CPU seconds beside those of half a spheroid."""
    calls = {"`disk_conformal_map`": ism.disk_conformal_map, "`flatten`": ism.flatten}
    print("| vertices | map | half a spheroid, CPU s | fan | strip | star | certified |")
    print("|---:|---|---:|---:|---:|---:|---|")
    ism.flatten(*half_spheroid(500))
    for n in args.sizes:
        for name, call in calls.items():
            found = [
                timed(lambda call=call, make=make, n=n: call(*make(n)))
                for make in (half_spheroid, fan, strip, star)
            ]
            certified = "all" if all(result.certificate for result, _ in found) else "not all"
            first, *others = [seconds for _, seconds in found]
            cells = " | ".join(f"{seconds:.2g}, {seconds / first:.2g} times" for seconds in others)
            print(f"| {n:,} | {name} | {first:.2g} | {cells} | {certified} |", flush=True)


def main(words: list[str]) -> None:
    """Print one of the tables."""
    line = parser(__doc__)
    tables = {"programs": programs, "exact": exact, "sliding": sliding, "long": long}
    line.add_argument("table", choices=tables)
    line.add_argument("--corpus", type=Path, default=CORPUS)
    line.add_argument("--jsonl", type=Path)
    line.add_argument("--only", default="")
    line.add_argument("--largest", type=float, default=np.inf, help="vertices of a disk at most")
    line.add_argument("--sizes", type=int, nargs="+", default=[1000, 4000, 16000])
    args = line.parse_args(words)
    warnings.simplefilter("ignore")
    tables[args.table](args)
