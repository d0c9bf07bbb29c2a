"""Make the pictures of README and docs into docs/images; a picture's file keeps its captions.

    python docs/pictures.py
    python docs/pictures.py dino curves --to elsewhere

They are made of the package's samples, some by the demos, within two minutes; needs libEGL, matplotlib and pillow, no
display. Not here: benchmarks.png, convergence.png, gradient.png and eq24.png, which `benchmarks/` measure, and
docs/reproduction, which `igl-spheremap reproduce` draws of real surfaces.
"""

from __future__ import annotations

import json
import os
import platform
import re
import runpy
import subprocess
import sys
from argparse import ArgumentParser, Namespace, RawDescriptionHelpFormatter
from collections.abc import Callable, Sequence
from contextlib import redirect_stdout
from dataclasses import replace
from importlib.metadata import version
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from unittest.mock import patch

import igl
import numpy as np
import scipy
from PIL import Image
from PIL.PngImagePlugin import PngInfo
from scipy.spatial.transform import Rotation

import igl_spheremap as ism
from igl_spheremap.apps.cli import main as shell
from igl_spheremap.apps.viewer import app as viewer
from igl_spheremap.apps.viewer.app import App, present, run_app
from igl_spheremap.apps.viewer.carried_view import CarriedView
from igl_spheremap.apps.viewer.choices import ROW_SIZE
from igl_spheremap.apps.viewer.colouring import Colouring, Colours, checkerboard
from igl_spheremap.apps.viewer.compare import PartsView
from igl_spheremap.apps.viewer.grid import Part
from igl_spheremap.apps.viewer.registered_view import registration_view
from igl_spheremap.draw.folds import Clusters
from igl_spheremap.draw.lens import follow, look_at
from igl_spheremap.draw.palette import FACTORS, LINES, SURFACE
from igl_spheremap.draw.plot import fit, new_figure, pose
from igl_spheremap.draw.run import plot_run
from igl_spheremap.errors import DisplayError
from igl_spheremap.verify.signs import folded_faces

ROOT = Path(__file__).resolve().parents[1]
#: Pictures are reduced to this many colours: no difference is seen, and they are a quarter as large.
_COLOURS = 256
_CHECKS = 24  # squares of a checkerboard along a flat map
#: Counts on the way to a folded map depend on rounding. To be the same in every run, one kind of BLAS kernels computes,
#: by one thread, and scipy's SuperLU always solves.
_ROUNDING = {"OPENBLAS_CORETYPE": "Nehalem", "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}


def dino(path: Path) -> list[str]:
    """A surface, its Gauss map with the folded faces, its folding-free map, and the head on that map."""
    mesh, turn = _sample("dino")
    gauss = ism.gauss_map(mesh.v, mesh.f)
    result = ism.spherical_conformal_map(mesh.v, mesh.f)
    angles = np.abs(result.angle_differences()).mean()
    forward = fit(mesh.unit, turn)[mesh.f, 0].mean(axis=1)
    lens = look_at(result.sphere @ turn.T, mesh.f[forward > np.percentile(forward, 92)])
    board = checkerboard(mesh, result.sphere)
    folded = np.flatnonzero(folded_faces(gauss, mesh.f))
    row = [
        Part(f"a surface\n{len(mesh.v):,} vertices", fit(mesh.unit, turn), mesh.f),
        Part(f"its Gauss map\n{len(folded):,} folded faces (red)", gauss @ turn.T, mesh.f,
             replace(board, folded=folded), image=True),
        Part(f"its map by igl_spheremap\nno folding; angles differ by {angles:.1f} degrees",
             result.sphere @ turn.T, mesh.f),
        Part(f"the head on that map,\nmagnified {lens.power:,.0f} times", lens(result.sphere @ turn.T), mesh.f),
    ]  # fmt: skip
    return _draw(
        [[replace(part, colours=part.colours or board) for part in row]], path, (1200, 360)
    )


def eigen_projection(path: Path) -> list[str]:
    """Fig. 9 of the paper: conformal factor, map and eigenfunctions, on the way through Algorithm 2."""
    mesh, turn = _sample("dino", n_vertices=2000)
    recording = ism.Recording(mesh.f)
    result = ism.spherical_conformal_map(mesh.v, mesh.f, method="lai2014", listener=recording)
    first = [frame.iterate for frame in recording.frames if frame.iterate.round == 0]
    early = next(iterate for iterate in first if iterate.energy < 4 * np.pi + 1)
    columns: list[list[Part]] = []
    for name, x in (
        (f"early: Algorithm 1, iteration {early.iteration}", early.x),
        ("Algorithm 1 has ended", first[-1].x),
        ("Algorithm 2 has ended", result.sphere),
    ):
        projection = ism.weighted_eigen_projection(mesh.v, mesh.f, x)
        folds, u = (
            Colours("foldings").of(mesh, x),
            np.log(ism.conformal_factor(mesh.v, mesh.f, x)) / 2,
        )
        u -= np.log(4 * np.pi) / 2
        clusters = Clusters.of(mesh.f, folds.folded)
        (lens,) = follow([x @ turn.T], mesh.f, clusters[0] if clusters else folds.folded)
        power = (
            f"foldings magnified {lens.power:,.0f} times"
            if len(folds.folded)
            else "no folding is left"
        )
        phi = projection.phi @ turn.T * np.sqrt(4 * np.pi / 3)
        reach = np.linalg.norm(phi, axis=1)
        columns.append([
            Part(f"{name}\nthe conformal factor", fit(mesh.unit, turn), mesh.f,
                 Colouring(FACTORS[-1].colours(u[mesh.f].mean(axis=1))),
                 legends=FACTORS[-1:] if len(columns) == 1 else ()),
            Part(f"{len(folds.folded):,} folded faces\n{power}", x @ turn.T, mesh.f, folds, image=True,
                 edges=0.5, lens=lens),
            Part(f"the surface of the eigenfunctions\nhas radii from {reach.min():.2f} to {reach.max():.2f}",
                 phi / max(1.0, reach.max()), mesh.f, Colouring(folds.colours), edges=0.5),
        ])  # fmt: skip
    return _draw(list(zip(*columns, strict=True)), path, (1000, 1000))


def curves(path: Path) -> list[str]:
    """Energy, foldings and angle differences of a run of the paper's algorithms."""
    v, f = ism.samples.make("dino")
    recording = ism.Recording(f)
    result = ism.spherical_conformal_map(v, f, method="lai2014", listener=recording)
    figure = plot_run(
        recording.history,
        recording.foldings,
        result.angle_differences(),
        result.log_area_ratios(),
        title="dino, lai2014",
    )
    figure.savefig(path, dpi=110)
    return []


def harmonics(path: Path) -> list[str]:
    """A surface, and the sums of its spherical harmonics up to three degrees."""
    mesh, turn = _sample("brain")
    result = ism.spherical_conformal_map(mesh.v, mesh.f)
    shape = ism.shapes.spherical_harmonics(result, degree=50)
    error = shape.error()
    row = [Part(f"a surface\n{len(mesh.v):,} vertices", fit(mesh.unit, turn), mesh.f)]
    for degree in (5, 15, 50):
        part = ism.shapes.SphericalHarmonics(shape.coefficients[: (degree + 1) ** 2])
        caption = f"degree {degree}\n{error[degree]:.2f} percent off"
        row.append(Part(caption, fit(part.evaluate(result.sphere), turn), mesh.f))
    return _draw([row], path, (1400, 400))


def registration(path: Path) -> list[str]:
    """A sphere laid on another, both coloured by the depth of their surfaces."""
    target = ism.spherical_conformal_map(*ism.samples.make("brain"))
    other = ism.spherical_conformal_map(*ism.samples.make("brain", n_vertices=8000))
    quarter = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    source = ism.sphere_map(other.vertices, other.faces, other.sphere @ quarter)
    registered = ism.shapes.register(source, target)
    return _present(lambda: registration_view(source, target, registered), path, (1200, 440))


def correspondence(path: Path) -> list[str]:
    """A dino, a rabbit, and the surface half of the way between them, with the checkerboard that the map carries."""
    onto = ism.shapes.match(
        *(ism.samples.make(name, n_vertices=3000) for name in ("dino", "bunny"))
    )
    return _present(lambda: CarriedView(onto, up="z"), path, ROW_SIZE)


def flat_maps(path: Path) -> list[str]:
    """Half of a surface, two maps of it to the unit disk, and its flat map, all with one checkerboard."""
    v, f = ism.samples.make("brain", n_vertices=8000)
    rows, half = np.unique(f[v[f, 0].mean(axis=1) > v[:, 0].mean()], return_inverse=True)
    v, f = v[rows], half.reshape(-1, 3)
    disk, flat = ism.disk_conformal_map(v, f), ism.flatten(v, f)
    even = disk.rebalance(1)
    checks = _CHECKS * flat.plane[f].reshape(-1, 2) / np.ptp(flat.plane, axis=0).max()
    board = Colouring(np.tile(SURFACE, (len(f), 1)), checks=checks)
    row = [
        Part(f"a surface with a boundary\n{len(v):,} vertices", fit(v, pose(v)), f),
        Part(f"conformal disk\nangles differ by {np.abs(disk.angle_differences()).mean():.1f} degrees",
             fit(disk.image, np.eye(3)), f),
        Part(f"area-preserving disk\nareas differ by {np.abs(even.log_area_ratios()).mean():.0%}",
             fit(even.image, np.eye(3)), f),
        Part(f"flat map\nlengths differ by {np.abs(flat.log_length_ratios()).mean():.0%}",
             fit(flat.image, np.eye(3)), f),
    ]  # fmt: skip
    return _draw([[replace(part, colours=board) for part in row]], path, (1200, 360))


def balance_front(path: Path) -> list[str]:
    """Areas against angles of three samples over the balances."""
    figure, ((ax,),) = new_figure(1, 1, "", (6.4, 4.2))
    for colour, name in zip(LINES, ("octopus", "dino", "brain"), strict=False):
        v, f = ism.samples.make(name, n_vertices=4000)
        result, points = ism.spherical_conformal_map(v, f), []
        for balance in np.linspace(0, 1, 9):
            result = result.rebalance(float(balance))
            area, angle = (
                np.abs(result.log_area_ratios()).mean(),
                np.abs(result.angle_differences()).mean(),
            )
            points.append((angle, np.exp(area)))
        x, y = np.transpose(points)
        ax.semilogy(x, y, color=colour, marker="o", markersize=4)
        ax.annotate(name, points[-3], color=colour, fontsize=11, textcoords="offset points",
                    xytext=(10, 4) if name != "dino" else (-40, -8))  # fmt: skip
        ends = zip((0, -1), ("balance 0: angles kept", "balance 1: areas kept"), strict=True)
        for end, word in ends if name == "octopus" else ():
            ax.annotate(
                word, points[end], textcoords="offset points", xytext=(6, 4 - 12 * end), fontsize=9
            )
    ax.set(
        xlim=(0, 50),
        xlabel="angles are off by, degrees (mean)",
        ylabel="areas are off by a factor of (mean)",
    )
    ticks = (1, 2, 5, 10, 20, 50, 100, 200)
    ax.set_yticks(ticks, labels=[str(tick) for tick in ticks], minor=False)
    ax.minorticks_off()
    ax.grid(alpha=0.3)
    figure.savefig(path, dpi=110)
    return []


def throughput(path: Path) -> list[str]:
    """Maps a second, from the table that benchmarks/throughput.py wrote."""
    page = (ROOT / "docs" / "throughput.md").read_text("utf-8")
    rows = re.findall(r"^\| ([\w ]+?) \| (\d+) \| ([\d.]+) \|", page, re.MULTILINE)
    names = list(dict.fromkeys(name for name, _, _ in rows))
    workers = sorted({int(count) for _, count, _ in rows})
    figure, ((ax,),) = new_figure(1, 1, "", (6.4, 2.6))
    height = 0.8 / len(workers)
    for k, (count, colour) in enumerate(zip(workers, LINES, strict=False)):
        rates = [
            next(float(rate) for name, many, rate in rows if (name, int(many)) == (one, count))
            for one in names
        ]
        places = np.arange(len(names)) + (k - (len(workers) - 1) / 2) * height
        ax.barh(places, rates, 0.92 * height, color=colour)
        for place, rate in zip(places, rates, strict=True):
            ax.annotate(f" {rate:.0f} by {count} {'worker' if count == 1 else 'workers'}", (rate, place), va="center",
                        fontsize=9)  # fmt: skip
    ax.set_yticks(range(len(names)), labels=names, fontsize=11)
    ax.invert_yaxis()
    ax.set(xticks=[], xlim=(0, 1.25 * max(float(rate) for _, _, rate in rows)))
    ax.spines["bottom"].set_visible(False)
    ax.set_title(
        "meshes of 2,562 vertices read, mapped, certified and written in a second",
        fontsize=10,
        loc="left",
    )
    figure.savefig(path, dpi=110)
    return [f"{name}, {count}: {rate}" for name, count, rate in rows]


def caps(path: Path) -> list[str]:
    """A surface with a hole, its cap, and both on the sphere; a handle, its cut, and its caps on the sphere."""
    v, f = ism.samples.make("bunny")
    turns = [pose(v, "z")]
    seen = fit(v, turns[0])
    hole = np.linalg.norm(seen - seen[np.argmax(seen @ [-0.3, 0, 1])], axis=1) < 0.28
    used, body = np.unique(f[~hole[f].any(axis=1)], return_inverse=True)
    along, around = (a.ravel() for a in np.meshgrid(np.arange(96), np.arange(48), indexing="ij"))
    a, b = 2 * np.pi * along / 96, 2 * np.pi * around / 48
    thick = 0.42 + 0.12 * np.sin(a)
    far = 1 + thick * np.cos(b)
    ring = np.column_stack((far * np.cos(a), far * np.sin(a), thick * np.sin(b)))
    corner = [
        (along + i) % 96 * 48 + (around + k) % 48 for i, k in ((0, 0), (1, 0), (1, 1), (0, 1))
    ]
    faces = np.vstack((np.column_stack(corner[:3]), np.column_stack([corner[0], *corner[2:]])))
    turns.append(Rotation.from_euler("x", -50, degrees=True).as_matrix())
    rows = []
    for w, g, turn, name in (
        (v[used], body.reshape(-1, 3), turns[0], "with a hole"),
        (ring, faces, turns[1], "of genus 1"),
    ):
        mesh = ism.repair_mesh(w, g, holes="fill", handles="cut")
        made = mesh.face_source < 0
        result = ism.spherical_conformal_map(mesh.v, mesh.f, caps=made)
        shades = Colouring(np.where(made[:, None], LINES[1], SURFACE))
        laid = fit(mesh.v, turn)
        rim = np.intersect1d(mesh.f[made], mesh.f[~made])
        first = mesh.f[np.flatnonzero(made)[0]]  # a cap, which is turned towards the viewer
        view = Rotation.align_vectors([[0.3, 0.3, 0.9]], [result.sphere[first].sum(axis=0)])[
            0
        ].as_matrix()
        turned, angles = result.sphere @ view.T, np.abs(result.angle_differences()).mean()
        done = mesh.actions[0].partition(" near")[0].replace(", a ", ":\na ")
        rows.append(
            [
                Part(f"a surface {name}\n{len(w):,} vertices", fit(w, turn), g),
                Part(
                    done, laid, mesh.f, shades, dots={f"rim {name}": (laid[rim], LINES[1], 0.012)}
                ),
                Part(
                    f"its map with {made.sum():,} faces of caps,\nangles differ by {angles:.1f} degrees",
                    turned,
                    mesh.f,
                    shades,
                    dots={f"image {name}": (turned[rim], LINES[1], 0.012)},
                ),
            ]
        )
    return _draw(rows, path, (1080, 760))


def foldings(path: Path) -> list[str]:
    """The moving picture of README: foldings vanish."""
    with TemporaryDirectory() as folder:
        facts = Path(folder) / "facts.json"
        words = (
            "play sample:dino:n_vertices=1500 --length 60 --fps 12 --size 860 440 --quiet --video"
        )
        shell([*words.split(), str(path), "--json", str(facts)])
        pictures = json.loads(facts.read_text("utf-8"))["frames"]
    return [f"{one['title']}: {one['foldings']} folded faces" for one in pictures]


def _demo(name: str, *arguments: str) -> Callable[[Path], list[str]]:
    """A maker that takes a demo's own picture."""

    def make(path: Path) -> list[str]:
        apps: list[App] = []

        def noting(app: App, args: Namespace) -> list[dict[str, Any]]:
            apps.append(app)
            return run_app(app, args)

        command = [f"{name}.py", *arguments, str(path)]
        with (
            patch.object(viewer, "run_app", noting),
            patch.object(sys, "argv", command),
            patch.object(sys, "path", [str(ROOT / "demos"), *sys.path]),
            redirect_stdout(StringIO()) as said,
        ):
            runpy.run_path(str(ROOT / "demos" / command[0]), run_name="__main__")
        return [*said.getvalue().splitlines(), *(line for app in apps for line in _captions(app))]

    make.__doc__ = f"The demo {name}."
    return make


def align_landmarks(path: Path) -> list[str]:
    """The demo align_landmarks, which starts polyscope itself."""
    command = [sys.executable, str(ROOT / "demos" / "align_landmarks.py"), str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return done.stdout.splitlines()


PICTURES: dict[str, Callable[[Path], list[str]]] = {
    "dino.png": dino,
    "eigen_projection.png": eigen_projection,
    "curves.png": curves,
    "harmonics.png": harmonics,
    "registration.png": registration,
    "correspondence.png": correspondence,
    "flat_maps.png": flat_maps,
    "balance_front.png": balance_front,
    "throughput.png": throughput,
    "folding_removal.png": _demo("folding_removal"),
    "checkerboard.png": _demo("checkerboard"),
    "compare_methods.png": _demo("compare_methods"),
    "angles_or_areas.png": _demo("angles_or_areas"),
    "align_landmarks.png": align_landmarks,
    "caps.png": caps,
    "foldings.gif": foldings,
}


def _sample(name: str, **parameters: int) -> tuple[ism.Mesh, np.ndarray]:
    mesh = ism.check_mesh(*ism.samples.make(name, **parameters))
    return mesh, pose(mesh.unit, "z")


def _draw(rows: Sequence[Sequence[Part]], path: Path, size: tuple[int, int]) -> list[str]:
    return _present(lambda: PartsView(rows), path, size)


def _present(build: Callable[[], App], path: Path, size: tuple[int, int]) -> list[str]:
    apps: list[App] = []

    def keep() -> App:
        apps.append(build())
        return apps[0]

    present(keep, path, size=size)
    return _captions(apps[0])


def _captions(app: App) -> list[str]:
    return [part.caption for part in app.grid.parts.values()]


def made_with() -> str:
    """Versions and kernels that decide the last digits of a caption's numbers."""
    versions = [
        f"{one.__name__} {version(name)}"
        for one, name in ((np, "numpy"), (scipy, "scipy"), (igl, "libigl"))
    ]
    return ", ".join(
        (*versions, platform.machine(), *np.show_config("dicts")["SIMD Extensions"]["found"])
    )


def keep(path: Path, captions: list[str]) -> None:
    """Keep the captions of a picture in its file, with the origin of its numbers; reduce the colours of a PNG."""
    if path.suffix == ".gif":
        data, text = path.read_bytes(), "\n".join((made_with(), *captions)).encode()
        blocks = [text[k : k + 255] for k in range(0, len(text), 255)]
        comment = b"!\xfe" + b"".join(bytes([len(block)]) + block for block in blocks) + b"\0"
        # where the header and the table of colours end
        colours = 13 + 3 * 2 ** ((data[10] & 7) + 1)
        path.write_bytes(data[:colours] + comment + data[colours:])
        return
    kept = PngInfo()
    kept.add_itxt("captions", "\n".join(captions))
    kept.add_itxt("made with", made_with())
    with Image.open(path) as image:
        small = image.convert("RGB").quantize(_COLOURS, kmeans=2, dither=Image.Dither.NONE)
    small.save(path, optimize=True, pnginfo=kept)


def main(arguments: Sequence[str] | None = None) -> int:
    """Make the pictures that are named, or all."""
    parser = ArgumentParser(description=__doc__, formatter_class=RawDescriptionHelpFormatter)
    parser.add_argument(
        "names", nargs="*", metavar="NAME", help=f"default: all of {', '.join(PICTURES)}"
    )
    parser.add_argument(
        "--to",
        type=Path,
        default=ROOT / "docs" / "images",
        metavar="DIR",
        help="default: docs/images",
    )
    args = parser.parse_args(arguments)
    names = [name if "." in name else f"{name}.png" for name in args.names] or list(PICTURES)
    unknown = sorted(set(names) - set(PICTURES))
    if unknown:
        parser.error(f"there is no picture {', '.join(unknown)}")
    if not os.environ.items() >= _ROUNDING.items():  # numpy reads them when it is loaded
        command = [sys.executable, __file__, *names, "--to", str(args.to)]
        return subprocess.run(command, env={**os.environ, **_ROUNDING}).returncode
    sys.modules["cvxopt"] = None  # type: ignore[assignment]
    args.to.mkdir(parents=True, exist_ok=True)
    for name in names:
        path = args.to / name
        try:
            captions = PICTURES[name](path)
        except DisplayError as error:
            print(f"{parser.prog}: {error}", file=sys.stderr)
            return 70
        keep(path, captions)
        print(f"{path}: {path.stat().st_size:,} bytes")
    return 0


if __name__ == "__main__":
    sys.exit(main())
