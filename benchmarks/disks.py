"""Maps of disks to the plane against harmonic, LSCM and SLIM of libigl: folds, overlaps, angles, areas, lengths, time.

Real surfaces with one boundary loop (``--corpus``), cortex as FreeSurfer cuts it (nilearn), and disks of 15, 50 and 90
percent of the area of closed ones; ``--jsonl`` keeps each result. ``--sliding`` compares sliding alone with doubling.
"""

from __future__ import annotations

import importlib.util
import json
import sys
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import igl
import numpy as np
from corpus import CORPUS
from disks import cut

import igl_spheremap as ism
from igl_spheremap.errors import FactorisationFailed
from igl_spheremap.plane.doubling import double_map
from igl_spheremap.plane.plane_map import in_space
from igl_spheremap.plane.sliding import slid_map
from igl_spheremap.result.run import History
from igl_spheremap.verify.distortion import mean_angle_difference
from igl_spheremap.verify.rim import rim_crossings

from .common import parser, timed

Mesh = tuple[np.ndarray, np.ndarray]
_SHARES = (0.15, 0.5, 0.9)
_STEPS = 20  # of SLIM


def disks(corpus: Path) -> Iterator[tuple[str, Mesh]]:
    """Names and meshes."""
    if importlib.util.find_spec("nilearn") is not None:
        yield from _cortex()
    for path in sorted((corpus / "open").glob("g0_b1_*.npz")):
        yield path.stem, _compact(*ism.read_mesh(_as_archive(path)))
    files = [path for folder in ("public", "hard", "pairs") for path in sorted((corpus / folder).glob("*.*"))]
    closed = {path.stem: path for path in files if path.suffix in (".obj", ".npz")}
    meshes = [(name, f"sample:{name}:n_vertices=2000") for name in ism.samples.names()] + list(closed.items())
    random = np.random.default_rng(0)
    for name, source in meshes:
        try:
            v, f = (ism.samples.from_spec(source.removeprefix("sample:")) if str(source).startswith("sample:")
                    else ism.read_mesh(_as_archive(Path(source))))
            ism.check_mesh(v, f)
        except ValueError:
            continue
        for share in _SHARES:
            yield f"{name}, {share:.0%}", cut(v, f, int(random.integers(len(v))), share)


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
    import nibabel
    import nilearn

    folder = Path(nilearn.__file__).parent / "datasets" / "data" / "fsaverage5"
    for side in ("left", "right"):
        faces = nibabel.load(folder / f"flat_{side}.gii.gz").darrays[1].data
        white = nibabel.load(folder / f"white_{side}.gii.gz").darrays[0].data
        yield f"fsaverage5 {side}", _compact(white.astype(float), faces.astype(np.int64))


def methods() -> dict[str, Callable[[np.ndarray, np.ndarray], np.ndarray]]:
    """Functions of v, f that return images (n, 2)."""
    return {
        "disk_conformal_map": lambda v, f: ism.disk_conformal_map(v, f).plane,
        "balanced_disk_map, balance 1": lambda v, f: ism.balanced_disk_map(v, f, balance=1).plane,
        "flatten": lambda v, f: ism.flatten(v, f).plane,
        "flatten, balance 0": lambda v, f: ism.flatten(v, f, balance=0).plane,
        "igl.harmonic": _harmonic,
        "igl.lscm": _lscm,
        f"igl.slim, {_STEPS} steps": _slim,
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
    energy, free = igl.MappingEnergyType.SYMMETRIC_DIRICHLET, (np.empty(0, np.int32), np.empty((0, 2), order="F"))
    data = igl.slim_precompute(*arrays, energy, *free, 0.0)
    return np.asarray(igl.slim_solve(data, _STEPS))[:, :2]


def figures(v: np.ndarray, f: np.ndarray, p: np.ndarray) -> dict[str, float]:
    """Folded faces, boundary edges that cross others, means of angle differences and logarithms of ratios."""
    mesh = ism.check_disk(v, f)
    image = np.column_stack((p, np.zeros(len(p))))
    certificate = ism.certify(p, f)
    sizes = [np.abs(part) for part in (ism.angle_differences(v, f, image), ism.log_area_ratios(v, f, image),
                                       ism.log_length_ratios(v, f, image))]
    angle, area, edge = (float(size[np.isfinite(size)].mean()) for size in sizes)
    return {"folds": certificate.foldings, "crossings": int(rim_crossings(p, mesh.rim).sum()), "angle": angle,
            "area": area, "edge": edge}


def sliding(disk: ism.Disk) -> tuple[float, float] | None:
    """Mean angle differences of the map by doubling, and of that by sliding alone; None if doubling folds faces."""
    try:
        doubled, _ = double_map(disk, None)
    except (FactorisationFailed, ism.FoldingsRemain):
        return None
    if not ism.certify(doubled, disk.f).folding_free:
        return None
    slid, _ = slid_map(disk, History(None))
    return mean_angle_difference(disk, in_space(doubled)), mean_angle_difference(disk, in_space(slid))


def main(words: list[str] | None = None) -> None:
    """Measure each method on each disk, and print a table."""
    line = parser(__doc__)
    line.add_argument("--corpus", type=Path, default=CORPUS)
    line.add_argument("--jsonl", type=Path)
    line.add_argument("--only", default="", help="names that contain this")
    line.add_argument("--sliding", action="store_true")
    line.add_argument("--largest", type=float, default=np.inf, help="vertices of a disk at most")
    args = line.parse_args(words)
    warnings.simplefilter("ignore")
    rows: dict[str, list[dict[str, float]]] = {name: [] for name in methods()}
    number, ratios = 0, []
    for name, (v, f) in disks(args.corpus):
        if args.only not in name:
            continue
        if len(v) > args.largest:
            continue
        try:
            ism.check_disk(v, f)
        except ism.MeshError as error:
            print(f"{name}: left out, {error}", file=sys.stderr)
            continue
        if args.sliding:
            found = sliding(ism.check_disk(v, f))
            if found and found[0] > 0:
                ratios.append(found[1] / found[0])
                print(f"| {name} | {len(v)} | {found[0]:.2f} | {ratios[-1]:.2f} |", flush=True)
            continue
        number += 1
        for method, call in methods().items():
            try:
                p, cpu = timed(lambda call=call, v=v, f=f: call(v, f))
                row = figures(v, f, p) | {"cpu": cpu}
            except Exception as error:  # whatever a peer raises counts as a failure
                row = {"failure": f"{type(error).__name__}: {error}"}
            rows[method].append(row)
            if args.jsonl:
                with args.jsonl.open("a") as file:
                    print(json.dumps({"disk": name, "vertices": len(v), "method": method} | row), file=file)
    if args.sliding:
        print(f"{len(ratios)} disks: median {np.median(ratios):.3f}, beyond 1.3 {np.sum(np.array(ratios) > 1.3)}")
        return
    print(f"| {number} disks | failed | with folds | with overlaps | angle | area | edge | CPU s |")
    print("|---|---:|---:|---:|---:|---:|---:|---:|")
    for method, found in rows.items():
        done = [row for row in found if "failure" not in row]
        medians = [np.nanmedian([row[key] for row in done]) for key in ("angle", "area", "edge", "cpu")] if done else []
        print(f"| {method} | {len(found) - len(done)} | {sum(row['folds'] > 0 for row in done)} | "
              f"{sum(row['crossings'] > 0 for row in done)} | " + " | ".join(f"{m:.3g}" for m in medians) + " |")
