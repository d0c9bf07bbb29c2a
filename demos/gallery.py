"""Make the pictures of README, of the gallery, and of the guides to playing and shape analysis, into docs/images.

    python demos/gallery.py
    python demos/gallery.py dino curves --to elsewhere
"""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace, RawDescriptionHelpFormatter
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import polyscope as ps
from checkerboard import deepest_tips, mercator_corners, show_squares
from PIL import Image

import igl_spheremap as ism
from igl_spheremap.apps.cli.exits import Exit
from igl_spheremap.apps.viewer import window
from igl_spheremap.apps.viewer.body import Body, follow, look_at
from igl_spheremap.apps.viewer.colouring import colouring, places
from igl_spheremap.apps.viewer.compare import registration_view
from igl_spheremap.apps.viewer.stage import Stage
from igl_spheremap.draw.plot import fit, pose
from igl_spheremap.errors import DisplayError
from igl_spheremap.result.recording import Recording, plot_run
from igl_spheremap.verify.signs import folded_faces

#: Pictures are reduced to so many colours: no difference is seen, and they are a quarter as large.
_COLOURS = 256
#: Squares around the sphere.
_SQUARES = 24
_NONE = np.empty(0, dtype=np.int64)
IMAGES = Path(__file__).parents[1] / "docs" / "images"


def dino(path: Path) -> None:
    """A surface, its Gauss map with the folded faces, its folding-free map, and the head on that map."""
    mesh, turn = _sample("dino")
    gauss = ism.gauss_map(mesh.vertices, mesh.f)
    result = ism.spherical_conformal_map(mesh.vertices, mesh.f)
    angles = np.abs(result.angle_differences()).mean()
    forward = fit(mesh.v, turn)[mesh.f, 0].mean(axis=1)
    lens = look_at(result.sphere @ turn.T, mesh.f[forward > np.percentile(forward, 92)])
    checks = mercator_corners(result.sphere, mesh.f, deepest_tips(mesh, result.sphere)) * _SQUARES
    stage = _row(4, (1200, 440))
    for k, (x, caption) in enumerate(
        (
            (fit(mesh.v, turn), f"a surface\n{len(mesh.v):,} vertices"),
            (gauss @ turn.T, f"its Gauss map\n{folded_faces(gauss, mesh.f).sum():,} folded faces (red)"),
            (result.sphere @ turn.T, f"its map by igl_spheremap\nno folding; angles differ by {angles:.1f} degrees"),
            (lens(result.sphere @ turn.T), f"the head on that map,\nmagnified {lens.power:,.0f} times"),
        )
    ):
        body = stage.place(0, k, Body(f"part {k}", x, mesh.f, lift=k == 1))
        body.raised = False
        body.paint(places(mesh), np.flatnonzero(folded_faces(gauss, mesh.f)) if k == 1 else None)
        show_squares(body, checks)
        body.caption = caption
    _save(stage, path)


def eigen_projection(path: Path) -> None:
    """Fig. 9 of the paper: conformal factor, map and eigenfunctions, on the way through Algorithm 2."""
    mesh, turn = _sample("dino")
    recording = Recording(mesh.f)
    result = ism.spherical_conformal_map(mesh.vertices, mesh.f, "lai2014", listener=recording)
    first = [frame.iterate for frame in recording.frames if frame.iterate.round == 0]
    early = next(iterate for iterate in first if iterate.energy < 4 * np.pi + 1)
    rows = (
        (f"Algorithm 1, iteration {early.iteration}", early.x),
        ("Algorithm 1, end", first[-1].x),
        ("Algorithm 2, end", result.sphere),
    )
    stage = _grid(3, 3, (900, 960))
    for row, (name, x) in enumerate(rows):
        projection = ism.weighted_eigen_projection(mesh.vertices, mesh.f, x)
        folds = replace(colouring(mesh, x, "foldings"), legend=None)
        source = _body(f"source {row}", mesh, turn, None)
        replace(colouring(mesh, x, "conformal factor", reach=2.0), folded=_NONE).apply(stage.place(row, 0, source))
        lens = follow(x @ turn.T, mesh.f, folds.folded)
        image = _body(f"image {row}", mesh, np.eye(3), lens(x @ turn.T))
        folds.apply(stage.place(row, 1, image))
        phi = _body(f"phi {row}", mesh, turn, projection.phi * np.sqrt(4 * np.pi / 3))
        folds.apply(stage.place(row, 2, phi))
        source.caption = f"{name}:\nconformal factor"
        power = f", magnified {lens.power:,.0f} times" if len(folds.folded) else ""
        image.caption = f"image{power}\n{len(folds.folded):,} folded faces"
        values = ", ".join(f"{value:.2f}" for value in projection.eigenvalues)
        phi.caption = f"eigenfunctions under that factor\neigenvalues {values}"
    _save(stage, path)


def curves(path: Path) -> None:
    """Energy, foldings and angle differences of a run of the paper's algorithms."""
    v, f = ism.samples.make("dino")
    recording = Recording(f)
    result = ism.spherical_conformal_map(v, f, "lai2014", listener=recording)
    figure = plot_run(recording.history, recording.foldings, result.angle_differences(), title="dino, lai2014")
    figure.savefig(path, dpi=110)
    _shrink(path)


def harmonics(path: Path) -> None:
    """A surface, and the sums of its spherical harmonics up to three degrees."""
    mesh, turn = _sample("brain")
    result = ism.spherical_conformal_map(mesh.vertices, mesh.f)
    shape = ism.spherical_harmonics(result, degree=50)
    error = shape.error()
    stage = _row(4, (1400, 400))
    stage.place(0, 0, _body("source", mesh, turn, None)).caption = f"a surface\n{len(mesh.v):,} vertices"
    for column, degree in enumerate((5, 15, 50), 1):
        part = ism.SphericalHarmonics(shape.coefficients[: (degree + 1) ** 2])
        body = Body(f"degree {degree}", fit(part.evaluate(result.sphere), turn), mesh.f)
        stage.place(0, column, body).caption = f"degree {degree}\n{error[degree]:.2f} percent off"
    _save(stage, path)


def registration(path: Path) -> None:
    """A sphere laid on another, both coloured by the depth of their surfaces."""
    fixed = ism.spherical_conformal_map(*ism.samples.make("brain"))
    other = ism.spherical_conformal_map(*ism.samples.make("brain", n_vertices=8000))
    quarter = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    moving = ism.sphere_map(other.vertices, other.faces, other.sphere @ quarter)
    registered = ism.register(moving, fixed)
    window.open_window(size=(1200, 440), offscreen=True)
    _save(registration_view(moving, fixed, registered).stage, path)


def _demo(name: str, *arguments: str) -> Callable[[Path], None]:
    """A maker that takes a demo's own picture, in a process of its own as demos are run."""

    def make(path: Path) -> None:
        import subprocess

        script = Path(__file__).parent / f"{name}.py"
        subprocess.run([sys.executable, str(script), *arguments, "--screenshot", str(path)], check=True)
        _shrink(path)

    make.__doc__ = f"The demo {name}."
    return make


PICTURES: dict[str, Callable[[Path], None]] = {
    "dino": dino,
    "eigen_projection": eigen_projection,
    "curves": curves,
    "align_landmarks": _demo("align_landmarks"),
    "folding_removal": _demo("folding_removal", "sample:dino", "--size", "1200", "480"),
    "compare_methods": _demo("compare_methods", "sample:dino"),
    "conformal_texture": _demo("conformal_texture", "sample:dino"),
    "harmonics": harmonics,
    "registration": registration,
}


def _sample(name: str) -> tuple[ism.Mesh, np.ndarray]:
    mesh = ism.check_mesh(*ism.samples.make(name))
    return mesh, pose(mesh.v)


def _row(columns: int, size: tuple[int, int]) -> Stage:
    return _grid(1, columns, size)


def _grid(rows: int, columns: int, size: tuple[int, int]) -> Stage:
    window.open_window(size=size, offscreen=True)
    return Stage(rows, columns, panel=0)


def _body(name: str, mesh: ism.Mesh, turn: np.ndarray, x: np.ndarray | None) -> Body:
    """The source, or an image of it with its edges."""
    if x is None:
        return Body(name, fit(mesh.v, turn), mesh.f)
    body = Body(name, x @ turn.T, mesh.f, lift=True)
    body.show_edges(0.5)
    return body


def _save(stage: Stage, path: Path) -> None:
    ps.set_user_callback(stage.draw)
    window.save(path)
    _shrink(path)


def _shrink(path: Path) -> None:
    with Image.open(path) as image:
        image.convert("RGB").quantize(_COLOURS, kmeans=2, dither=Image.Dither.NONE).save(path, optimize=True)


def main(arguments: Sequence[str] | None = None) -> int:
    """Make the pictures that are named, or all."""
    parser = ArgumentParser(description=__doc__, formatter_class=RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(PICTURES)}; default: all")
    parser.add_argument("--to", type=Path, default=IMAGES, metavar="DIR", help="default: docs/images")
    args: Namespace = parser.parse_args(arguments)
    unknown = sorted(set(args.names) - set(PICTURES))
    if unknown:
        parser.error(f"there is no picture {', '.join(unknown)}")
    args.to.mkdir(parents=True, exist_ok=True)
    for name in args.names or PICTURES:
        try:
            PICTURES[name](args.to / f"{name}.png")
        except DisplayError as error:
            print(f"{parser.prog}: {error}", file=sys.stderr)
            return int(Exit.FAILED)
        print(args.to / f"{name}.png")
    return int(Exit.OK)


if __name__ == "__main__":
    sys.exit(main())
