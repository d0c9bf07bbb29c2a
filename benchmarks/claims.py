"""Claims of the paper's text that its tables and figures do not show, measured.

    python -m benchmarks claims NAME [--meshes FOLDER] [--image FILE]

Tables: boosts, eigenfunctions, planes, projections, rounding, speeds. Pictures, written to docs/images: gradient, eq24.
The folder is the corpus (docs/corpus.md); samples replace what it lacks.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import count, islice
from math import ceil, log, sqrt
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix

import igl_spheremap as ism
from igl_spheremap.apps.reproduce.canvas import TEXT, page_figure, show_function
from igl_spheremap.apps.reproduce.figures import SETTINGS, named, relative_u
from igl_spheremap.apps.reproduce.runs import METHODS, PaperRun, run
from igl_spheremap.apps.reproduce.surfaces import PaperSurface, load_surface
from igl_spheremap.apps.reproduce.tables import TABLE_1, TABLE_2, TABLE_3, WAYS
from igl_spheremap.descent.energies import HarmonicEnergy
from igl_spheremap.descent.problem import Problem, l2_metric
from igl_spheremap.draw.palette import FACTORS, GUIDE, LINES
from igl_spheremap.errors import FactorisationFailed, FileError, MapError, MeshError
from igl_spheremap.maps.methods import in_gauge
from igl_spheremap.maps.options import Stereographic
from igl_spheremap.mesh.arrays import FloatArray
from igl_spheremap.mesh.check import Mesh, check_mesh
from igl_spheremap.mesh.measure import angle_defects, face_areas, vertex_areas, vertex_normals
from igl_spheremap.operators.laplacian import build_operators
from igl_spheremap.paper.star_map import project, stiffness, weighted_mass
from igl_spheremap.result.run import Run, Status
from igl_spheremap.sphere.moebius import best_rotation, moebius
from igl_spheremap.sphere.rows import row_dots, tangent, unit_rows, weighted_moment
from igl_spheremap.verify.distortion import mean_angle_difference
from igl_spheremap.verify.signs import folded_faces

from .common import IMAGES, parser
from .convergence import course
from .flat_metric import through_flat_metric
from .pages import reduce

Rows = Iterable[Sequence[object]]

PUNCTURES = 20  # faces of a surface that are cut out in turn


def planes(meshes: Path | None) -> Rows:
    """Through the plane: the best and the worst of 20 punctures, faces drawn at random, by the mean angle difference.

    [11] is one linear solve (Angenent et al.), [12] the same through a flat metric, here by the convex Newton iteration
    of Springborn, Schroeder and Pinkall for the curvature flow.
    """
    yield "surface", "method", "energy", "mean angle", "99 percent below", "folded faces", "CPU s"
    for surface in surfaces(TABLE_1, meshes):
        faces = np.random.default_rng(0).choice(len(surface.f), PUNCTURES, replace=False)
        for name, way in (("[11]", by_one_solve), ("[12]", by_flat_metric)):
            tried = [made for k in faces if (made := attempt(way, surface, int(k))) is not None]
            tried.sort(key=lambda one: mean_angle_difference(one.result.mesh, one.result.sphere))
            failed = f", no map for {len(faces) - len(tried)}" if len(tried) < len(faces) else ""
            for which, one in (("best", tried[0]), ("worst", tried[-1])):
                yield compared(surface, f"{name}, {which} of {len(faces)}{failed}", one)
        for name in ("Algorithm 1", "Algorithm 2", "auto"):
            yield compared(surface, name, run(surface, METHODS[name]))


def by_one_solve(surface: PaperSurface, face: int) -> PaperRun:
    """The map by the Laplace-Beltrami operator, a face being punctured."""
    return run(surface, Stereographic(puncture=face))


def by_flat_metric(surface: PaperSurface, face: int) -> PaperRun:
    """The map by a flat metric, the first corner of a face being at infinity."""
    began, mesh = time.process_time(), check_mesh(surface.v, surface.f)
    x = through_flat_metric(mesh, face)
    result = in_gauge(mesh, x, Run(Status.CONVERGED, HarmonicEnergy.of(mesh).evaluate(x)[0]))
    return PaperRun(result, time.process_time() - began, x[None], x[None])


def attempt(
    way: Callable[[PaperSurface, int], PaperRun], surface: PaperSurface, face: int
) -> PaperRun | None:
    """A run, or None if there is no map."""
    try:
        return way(surface, face)
    except (MapError, FactorisationFailed):
        return None


def compared(surface: PaperSurface, name: str, one: PaperRun) -> list[str]:
    """Figures of a map."""
    size = np.abs(one.result.angle_differences())
    return [
        surface.name,
        name,
        f"{one.result.energy:.5f}",
        f"{size.mean():.2f}",
        f"{np.percentile(size, 99):.1f}",
        f"{one.result.certificate.foldings:,}",
        f"{one.seconds:.2g}",
    ]


def eigenfunctions(meshes: Path | None) -> Rows:
    """Folded faces of star maps of standard and of weighted eigenfunctions, and the share of the area they cover."""
    yield "surface", "vertices", "standard eigenfunctions", "weighted eigenfunctions", "default map"
    rows = []
    for name, v, f in bodies(meshes):
        mesh, x = check_mesh(v, f), ism.spherical_conformal_map(v, f).sphere
        A = stiffness(mesh)
        rows.append(
            [
                name,
                f"{len(v):,}",
                *(star(mesh, A, x, B) for B in (weighted_mass(mesh, np.ones(len(x))), None)),
                f"{foldings(mesh, x):,}",
            ]
        )
        yield rows[-1]
    folded = [sum(row[k] != "0" for row in rows) for k in (2, 3, 4)]
    half = sum(row[2].endswith("(0.5)") for row in rows)
    yield (
        f"some of {len(rows)}",
        "",
        f"{folded[0]}, {half} of them over half of the area",
        folded[1],
        folded[2],
    )


def bodies(meshes: Path | None) -> Iterator[tuple[str, FloatArray, Any]]:
    """All samples, and all closed meshes of genus 0 of a folder and its subfolders."""
    for name in ism.samples.names():
        yield (name, *ism.samples.make(name))
    for path in sorted(meshes.rglob("*.obj")) if meshes else ():
        try:
            v, f = ism.read_mesh(path)
            check_mesh(v, f)
        except (FileError, MeshError):
            continue
        yield path.stem, v, f


def star(mesh: Mesh, A: csr_matrix, x: FloatArray, B: csr_matrix | None) -> str:
    """Foldings of a star map, and their share of the area."""
    try:
        found = project(mesh, A, x, B).star_map
    except FactorisationFailed:
        return "none"
    folded = folded_faces(found, mesh.f)
    areas = face_areas(found, mesh.f)
    share = f" ({areas[folded].sum() / areas.sum():.2g})" if folded.any() else ""
    return f"{int(folded.sum()):,}{share}"


#: Root mean square change in radians up to which first order holds. With the correction limbs fold again from .4 on.
NEAR = 1 / 6
CLOSE = 0.01  # of the limit: no picture shows the difference
LIMIT = 80  # projections in a row, the last of which counts as their limit
#: What a projection leaves of gradients of degree 2, and of other fields at most, once the map is centred.
DEGREE_2, OTHERS = 21 / 25, 2 / 3


@dataclass(frozen=True, eq=False)
class Projected:
    """A map, the root mean square of the change that led there, and the norms of its degree 2 and of the rest."""

    x: FloatArray
    change: float
    degree_2: float
    others: float


def in_a_row(mesh: Mesh, x: FloatArray, corrected: bool = False) -> Iterator[Projected]:
    """Star maps of star maps, with Delaunay weights, without end; corrected where the map is nearly conformal.

    The first map may be folded: a correction, which keeps a quarter of it, begins with the second projection.
    """
    energy = HarmonicEnergy.of(mesh, "delaunay")
    problem = Problem.of(mesh, energy, l2_metric(mesh))
    for k in count():
        star = problem.centred(project(mesh, energy.L, x).star_map)
        areas, change = vertex_areas(x, mesh.f), tangent(x, star)
        moment = weighted_moment(areas, change, x)
        # Degree 2: the tangent parts of T x, T symmetric without trace, whose square integrates to 4 pi |T|^2 / 5.
        T = 5 / (4 * np.pi) * ((moment + moment.T) / 2 - np.trace(moment) / 3 * np.eye(3))
        gradient = tangent(x, x @ T)
        squares = [
            float(areas @ row_dots(part, part)) for part in (change, gradient, change - gradient)
        ]
        size = sqrt(squares[0] / areas.sum())
        if corrected and k and size < NEAR:
            star = problem.centred(unit_rows(x + 3 / 4 * (change - gradient) + 25 / 4 * gradient))
        x = star
        yield Projected(x, size, sqrt(squares[1]), sqrt(squares[2]))


def predict(step: Projected) -> int:
    """How many further projections come within `CLOSE` of the limit.

    A projection changes an error e into f e, so its change is (1 - f) e, and f / (1 - f) of the change is left.
    """
    left = (
        (step.degree_2 * DEGREE_2 / (1 - DEGREE_2), DEGREE_2),
        (step.others * OTHERS / (1 + OTHERS), OTHERS),
    )
    return max(0, *(ceil(log(CLOSE / max(error, CLOSE)) / log(factor)) for error, factor in left))


def projections(meshes: Path | None) -> Rows:
    """How many projections in a row are needed, predicted by the theorem of docs/projection.md and counted."""
    yield (
        "surface",
        "start",
        "folded faces",
        "nearly conformal after",
        "predicted",
        "counted",
        "corrected",
        "folded faces left: counted, corrected",
        "mean angle: counted, corrected",
    )
    for surface in surfaces(TABLE_3, meshes):
        mesh = check_mesh(surface.v, surface.f)
        first = run(surface, METHODS["Algorithm 1"]).ends[0]
        for name, x in (("Gauss map", vertex_normals(mesh.unit, mesh.f)), ("Algorithm 1", first)):
            yield surface.name, name, *counts(mesh, x)


def counts(mesh: Mesh, x: FloatArray) -> list[str]:
    """Foldings of the start, numbers of projections, and what the two ways lead to."""
    ways = [list(islice(in_a_row(mesh, x, corrected), LIMIT)) for corrected in (False, True)]
    limit, areas = ways[0][-1].x, vertex_areas(ways[0][-1].x, mesh.f)
    near = next((k for k, step in enumerate(ways[0]) if step.change < NEAR), None)
    close = [
        next((k for k, step in enumerate(way) if distance(step.x, limit, areas) < CLOSE), -1)
        for way in ways
    ]
    ends = [way[k].x for way, k in zip(ways, close, strict=True)]
    return [
        f"{foldings(mesh, x)}",
        "never" if near is None else f"{near + 1}",
        "-" if near is None else f"{near + 1 + predict(ways[0][near])}",
        *("never" if k < 0 else f"{k + 1}" for k in close),
        ", ".join(f"{foldings(mesh, y)}" for y in ends),
        ", ".join(f"{mean_angle_difference(mesh, y):.2f}" for y in ends),
    ]


def distance(x: FloatArray, y: FloatArray, areas: FloatArray) -> float:
    """Root of the integral of the squared distance of two maps, turned to agree best."""
    apart = x @ best_rotation(x, y, areas) - y
    return sqrt(float(areas @ row_dots(apart, apart)))


def foldings(mesh: Mesh, x: FloatArray) -> int:
    return int(folded_faces(x, mesh.f).sum())


#: Centres of the Moebius images, as shares of the radius.
CENTRES = (0.0, 0.3, 0.6, 0.9, 0.99, 0.999)


def boosts(meshes: Path | None) -> Rows:
    """Harmonic energy (6) of the default map, and of its images under boosts, Moebius maps with centre (c, 0, 0)."""
    yield "surface", *(f"c = {c:g}" for c in CENTRES)
    for surface in surfaces(TABLE_1, meshes):
        x = ism.spherical_conformal_map(surface.v, surface.f).sphere
        energy = HarmonicEnergy.of(check_mesh(surface.v, surface.f))
        yield (
            surface.name,
            *(f"{energy.evaluate(moebius(x, np.array([c, 0, 0])))[0]:.4f}" for c in CENTRES),
        )


COPIES = 3  # renumbered ones of each surface


def rounding(meshes: Path | None) -> Rows:
    """Least and largest counts over a surface and renumbered copies of it, which only rounding changes."""
    yield "surface", "algorithm", "iterations", "folded faces left", "mean angle"
    for rows, algorithm in ((TABLE_2, "Algorithm 1"), (TABLE_3, "Algorithm 2")):
        for surface in surfaces(rows, meshes):
            for name in (WAYS[way].format(algorithm) for way in SETTINGS):
                made = [
                    run(renumbered(surface, seed), METHODS[name]).result
                    for seed in range(COPIES + 1)
                ]
                yield (
                    surface.name,
                    name,
                    bounds([one.iterations for one in made], ","),
                    bounds([one.certificate.foldings for one in made], ","),
                    bounds([float(np.abs(one.angle_differences()).mean()) for one in made], ".2f"),
                )


def renumbered(surface: PaperSurface, seed: int) -> PaperSurface:
    """The same surface with its vertices and faces in another order; in its own for seed 0."""
    if not seed:
        return surface
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(surface.v))
    return replace(
        surface, v=surface.v[order], f=np.argsort(order)[surface.f[rng.permutation(len(surface.f))]]
    )


def bounds(values: Sequence[float], form: str) -> str:
    """The first value, and the least and the largest of all, if these differ."""
    least, most = f"{min(values):{form}}", f"{max(values):{form}}"
    return f"{values[0]:{form}}" + (f" ({least} to {most})" if least != most else "")


# share by which an energy may miss the common one and still count as having reached it
REACHED = 1e-6


def speeds(meshes: Path | None) -> Rows:
    """Iterations and CPU seconds of Algorithm 1 and of Gu and Yau's down to the lowest energy that both reach.

    Their own stopping rules end them at different places: only this compares work for work.
    """
    yield (
        "surface",
        "algorithm",
        "iterations",
        "Gu-Yau's iterations",
        "ratio",
        "ratio of CPU seconds",
    )
    for surface in surfaces(TABLE_2, meshes):
        *theirs, _ = course(surface.v, surface.f, METHODS["Gu-Yau"])
        # Those that minimise the same energy: other weights have another minimum.
        for name in (name for name in METHODS if name.startswith("Algorithm 1 as")):
            *ours, _ = course(surface.v, surface.f, METHODS[name])
            (a, s), (b, t) = to_common_energy(ours, theirs)
            yield (
                surface.name,
                name,
                f"{a:,}",
                f"{b:,}",
                f"{b / max(a, 1):.1f}",
                f"{t / max(s, 1e-3):.1f}",
            )


def to_common_energy(*courses: Sequence[FloatArray]) -> list[tuple[int, float]]:
    """Iterations and seconds of each course, of seconds and energies, down to the lowest energy that all reach.

    >>> first, second = np.array([9, 5, 4, 3.0]), np.array([9, 8, 7, 6, 5, 4.5])
    >>> to_common_energy((np.arange(4) / 10, first), (np.arange(6) / 10, second))
    [(2, 0.2), (5, 0.5)]
    """
    target = max(energies.min() for _, energies in courses) * (1 + REACHED)
    firsts = [int(np.argmax(energies <= target)) for _, energies in courses]
    return [(k, float(seconds[k])) for k, (seconds, _) in zip(firsts, courses, strict=True)]


#: Surfaces on which Algorithm 1 runs until rounding ends it.
TO_THE_FLOOR = ("Hippocampus 2", "Maxplanck", "Brain")


def gradient(meshes: Path | None) -> Any:
    """The norm of the gradient A F by iteration of Algorithm 1, until rounding ends its fall."""
    figure, ((ax,),) = page_figure(
        1, 1, "Algorithm 1 without a stopping rule: gradient by iteration", 3.5
    )
    curves = []
    for colour, name in zip(LINES, TO_THE_FLOOR, strict=False):
        surface = load_surface(name, meshes)
        method = replace(METHODS["Algorithm 1"], gradient_tolerance=0.0, plateau=0.0)
        norms = np.array(
            [
                step.residual
                for step in run(surface, method).result.history
                if step.stage == "harmonic"
            ]
        )
        ax.loglog(1 + np.arange(len(norms)), norms, color=colour, alpha=0.25, linewidth=0.5)
        curves += ax.loglog(
            1 + np.arange(len(norms)),
            np.minimum.accumulate(norms),
            color=colour,
            label=f"{named(surface)},\nleast {norms.min():.1e}",
        )
    ax.axhline(ism.Lai2014().gradient_tolerance, color=GUIDE, linestyle=":")
    ax.annotate(
        "tolerance of this package",
        (1, ism.Lai2014().gradient_tolerance),
        (0, 3),
        textcoords="offset points",
        fontsize=TEXT,
    )
    ax.set_xlabel("iteration + 1", fontsize=TEXT)
    ax.set_ylabel("L2 norm of A F (bold: the least so far)", fontsize=TEXT)
    ax.tick_params(labelsize=TEXT)
    curves.sort(key=lambda curve: -curve.get_ydata()[-1])  # in the order in which they end
    ax.legend(
        handles=curves,
        fontsize=TEXT,
        loc="lower left",
        bbox_to_anchor=(1, 0),
        frameon=False,
        labelspacing=1.2,
    )
    return figure


def eq24(meshes: Path | None) -> Any:
    """u of eq. (14), u that solves eq. (24) with its right-hand side, and the difference of the two."""
    figure, axes = page_figure(
        3, len(TABLE_1), "Eq. (24): u of the map by (14), u that solves (24), difference", 2.5
    )
    ramp, fine = FACTORS[1], replace(FACTORS[0], label="difference of u")
    for column, surface in zip(axes.T, surfaces(TABLE_1, meshes), strict=True):
        mesh = check_mesh(surface.v, surface.f)
        x = ism.spherical_conformal_map(surface.v, surface.f).sphere
        u = np.log(ism.conformal_factor(surface.v, surface.f, x)) / 2
        error = curvature_error(mesh, u)
        shown = relative_u(surface, x)
        show_function(column[0], surface, shown, ramp, title=f"{named(surface)}\nu of (14)")
        show_function(column[1], surface, shown - error, ramp, title="u that solves (24)")
        show_function(
            column[2],
            surface,
            error,
            fine,
            title=f"difference: mean size {mesh.A @ np.abs(error):.2g}",
        )
    return figure


def curvature_error(mesh: Mesh, u: FloatArray) -> FloatArray:
    """u less the solution w of L w = A e^{2u} - K of the same mean: eq. (24) with K the angle defects."""
    operators = build_operators(mesh, "auto")
    K = angle_defects(mesh.angles, mesh.f, len(mesh.v))
    residual = operators.L @ u + K - mesh.A * np.exp(2 * u)  # eq. (24)
    error = operators.factor.solve(residual - mesh.A * residual.sum())
    return np.asarray(error - mesh.A @ error)


def surfaces(rows: Sequence[Any], meshes: Path | None) -> list[PaperSurface]:
    """Substitutes of the surfaces of one of the paper's tables."""
    return [load_surface(row.surface, meshes) for row in rows]


TABLES: dict[str, Callable[[Path | None], Rows]] = {
    one.__name__: one for one in (boosts, eigenfunctions, planes, projections, rounding, speeds)
}
PICTURES: dict[str, Callable[[Path | None], Any]] = {one.__name__: one for one in (gradient, eq24)}


def main(argv: list[str]) -> None:
    """Print a table, row by row, or write a picture."""
    arguments = parser(__doc__)
    arguments.add_argument("name", choices=(*TABLES, *PICTURES), metavar="NAME")
    arguments.add_argument("--meshes", type=Path)
    arguments.add_argument("--image", type=Path)
    options = arguments.parse_args(argv)
    if options.name in PICTURES:
        path = options.image or IMAGES / f"{options.name}.png"
        figure = PICTURES[options.name](options.meshes)
        figure.savefig(path, dpi=1080 / figure.get_figwidth())
        reduce(path)
        return
    for k, row in enumerate(TABLES[options.name](options.meshes)):
        print(f"| {' | '.join(map(str, row))} |", flush=True)
        if k == 0:
            print("|---" * len(row) + "|")
