"""Claims of the paper's text as tables: maps through the plane, eigenfunctions without weights, projections needed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import count, islice
from math import ceil, log, sqrt

import numpy as np
from scipy.sparse import csr_matrix

from ...descent.energies import HarmonicEnergy
from ...descent.problem import Problem
from ...errors import FactorisationFailed
from ...maps.options import Plane, Stereographic
from ...mesh.arrays import FloatArray
from ...mesh.check import Mesh, check_mesh
from ...mesh.measure import face_areas, vertex_areas, vertex_normals
from ...paper.star_map import project, stiffness
from ...sphere.moebius import best_rotation, moebius
from ...sphere.rows import row_dots, tangent, unit_rows, weighted_moment
from ...verify.distortion import angle_differences, mean_angle_difference
from ...verify.signs import folded_faces
from .runs import Outcome, PaperRun, Runs
from .surfaces import PaperSurface, all_surfaces
from .tables import TABLE_1, TABLE_3, Table

_TABLE_4 = """\
[11] is method "stereographic", one linear solve (Angenent et al.), and [12] the same through a flat metric (here the
convex Newton iteration of Springborn, Schroeder and Pinkall for the curvature flow). Each is run with 20 punctures,
faces drawn at random; the best and the worst have the least and the largest mean angle difference. Angles are the
sizes of angle differences in degrees, seconds CPU time for one puncture.
"""
_PUNCTURES = 20  # faces of a surface that are cut out in turn
_PLANES: tuple[tuple[str, Plane], ...] = (("[11]", "laplace-beltrami"), ("[12]", "conformal-equivalence"))
_OTHERS_OF_TABLE_4 = ("Algorithm 1 made safe", "Algorithm 2 made safe", "default")


def _punctured(runs: Runs, surface: PaperSurface, name: str, plane: Plane) -> list[PaperRun]:
    """Runs through the plane with punctures that are drawn at random."""
    faces = np.random.default_rng(0).choice(len(surface.f), min(_PUNCTURES, len(surface.f)), replace=False)
    return [runs.plan(surface, f"{name}, face {k}", Stereographic(plane, int(k))) for k in faces]


def runs_of_table_4(runs: Runs) -> Iterator[PaperRun]:
    """All runs of Table 4."""
    for surface in map(runs.surface, (row.surface for row in TABLE_1)):
        for name, plane in _PLANES:
            yield from _punctured(runs, surface, name, plane)
        yield from (runs.plan(surface, name) for name in _OTHERS_OF_TABLE_4)


def table_4(runs: Runs) -> Table:
    """Seven rows for every surface of Table 1."""
    rows = []
    for surface in map(runs.surface, (row.surface for row in TABLE_1)):
        for name, plane in _PLANES:
            tried = [runs.get(one.surface, one.name, one.method) for one in _punctured(runs, surface, name, plane)]
            mapped = sorted((one for one in tried if one.foldings >= 0), key=lambda one: one.mean_angle)
            failed = f", no map for {len(tried) - len(mapped)}" if len(mapped) < len(tried) else ""
            rows += [_compared(surface, f"{name}, {which} of {len(tried)}{failed}", one)
                     for which, one in zip(("best", "worst"), mapped[:: max(len(mapped) - 1, 1)], strict=False)]
        rows += [_compared(surface, name, runs.get(surface, name)) for name in _OTHERS_OF_TABLE_4]
    head = ("surface", "method", "energy", "mean angle", "99 percent below", "folded faces", "seconds")
    return Table("Table 4. The comparison with stereographic methods", _TABLE_4, head, rows)


def _compared(surface: PaperSurface, name: str, outcome: Outcome) -> list[str]:
    """A row of Table 4."""
    if outcome.foldings < 0:
        return [surface.label, name, outcome.status, *["-"] * 4]
    size = np.abs(angle_differences(surface.v, surface.f, outcome.sphere))
    return [surface.label, name, f"{outcome.energy:.5f}", f"{size.mean():.2f}", f"{np.percentile(size, 99):.1f}",
            f"{outcome.foldings:,}", f"{outcome.seconds:.2g}"]


_EIGENFUNCTIONS = """\
Each row has the folded faces of three maps: the star map of the standard eigenfunctions, eq. (16), with the share of
its area that they cover in brackets (0.5: as much of it is flipped as is not); the star map of those weighted by the
conformal factor of the default method's map, eq. (20); and that map.
"""


def eigenfunctions(runs: Runs) -> Table:
    """A row for every sample and every mesh of the folder."""
    rows = []
    for surface in all_surfaces(runs.meshes):
        cells = runs.cells(surface, "star maps with and without weights", None, partial(_stars, runs, surface))
        rows.append([surface.name, f"{len(surface.v):,}", *cells])
    folded, weighted, mapped = (sum(row[k] != "0" for row in rows) for k in (2, 3, 4))
    half = sum(row[2].endswith("(0.5)") for row in rows)
    finding = (f"**Without weights** {folded} of {len(rows)} star maps have folded faces, {half} of them over half of "
               f"their area. With the weights of the default map {weighted} have some, and {mapped} default maps.")
    head = ("surface", "vertices", "standard eigenfunctions", "weighted eigenfunctions", "default map")
    title = "Star maps of eigenfunctions with and without the conformal factor"
    return Table(title, _EIGENFUNCTIONS, head, rows, [finding])


def _stars(runs: Runs, surface: PaperSurface) -> list[str]:
    """Foldings of the star maps without and with weights, and of the default map."""
    x = runs.get(surface, "default").sphere
    mesh = check_mesh(surface.v, surface.f)
    A = stiffness(mesh)
    return [*(_star(mesh, A, x, weight) for weight in (np.ones(len(x)), None)), f"{_foldings(mesh, x):,}"]


def _star(mesh: Mesh, A: csr_matrix, x: FloatArray, weight: FloatArray | None) -> str:
    """Foldings of a star map, and their share of the area."""
    try:
        star = project(mesh, A, x, weight).star_map
    except FactorisationFailed:
        return "none"
    folded = folded_faces(star, mesh.f)
    areas = face_areas(star, mesh.f)
    share = f" ({areas[folded].sum() / areas.sum():.2g})" if folded.any() else ""
    return f"{int(folded.sum()):,}{share}"


_PROJECTIONS = """\
The theorem of [projection](projection.md) predicts the number of projections as soon as one changes the map by less
than 1/6 radian (root mean square): of a deviation that is a gradient of degree 2 each projection leaves 21/25, of all
others at most 2/3. Counted are star maps with Delaunay weights, each centred, until the map is within .01 of where 80
of them lead (root of the integral of the squared distance, after the best rotation). "Corrected" are those that from
there on take 3/4 of the change, and 25/4 of its part of degree 2: at most a quarter of a deviation is left. The start
is the Gauss map, or the map by Algorithm 1 from it.
"""
#: Root mean square change in radians up to which first order holds. With the correction limbs fold again from .4 on.
_NEAR = 1 / 6
_CLOSE = 0.01  # of the limit: no picture shows the difference
_LIMIT = 80  # projections in a row, the last of which counts as their limit
#: What a projection leaves of gradients of degree 2, and of other fields at most, once the map is centred.
_DEGREE_2, _OTHERS = 21 / 25, 2 / 3


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
    problem = Problem.of(mesh, energy)
    for k in count():
        star = problem.centred(project(mesh, energy.L, x).star_map)
        areas, change = vertex_areas(x, mesh.f), tangent(x, star)
        moment = weighted_moment(areas, change, x)
        # Degree 2: the tangent parts of T x, T symmetric without trace, whose square integrates to 4 pi |T|^2 / 5.
        T = 5 / (4 * np.pi) * ((moment + moment.T) / 2 - np.trace(moment) / 3 * np.eye(3))
        gradient = tangent(x, x @ T)
        squares = [float(areas @ row_dots(part, part)) for part in (change, gradient, change - gradient)]
        size = sqrt(squares[0] / areas.sum())
        if corrected and k and size < _NEAR:
            star = problem.centred(unit_rows(x + 3 / 4 * (change - gradient) + 25 / 4 * gradient))
        x = star
        yield Projected(x, size, sqrt(squares[1]), sqrt(squares[2]))


def predict(step: Projected) -> int:
    """How many further projections come within `_CLOSE` of the limit.

    A projection changes an error e into f e, so its change is (1 - f) e, and f / (1 - f) of the change is left.
    """
    left = (step.degree_2 * _DEGREE_2 / (1 - _DEGREE_2), _DEGREE_2), (step.others * _OTHERS / (1 + _OTHERS), _OTHERS)
    return max(0, *(ceil(log(_CLOSE / max(error, _CLOSE)) / log(factor)) for error, factor in left))


def runs_of_projections(runs: Runs) -> Iterator[PaperRun]:
    """The runs whose first maps are projected."""
    return (runs.plan(runs.surface(row.surface), _FIRST) for row in TABLE_3)


_FIRST = "Algorithm 2 made safe, Delaunay weights"


def projections(runs: Runs) -> Table:
    """Two rows for every surface of Table 3."""
    rows = []
    for surface in map(runs.surface, (row.surface for row in TABLE_3)):
        mesh = check_mesh(surface.v, surface.f)
        first = runs.get(surface, _FIRST).maps[0]
        for name, x in (("Gauss map", vertex_normals(mesh.unit, mesh.f)), ("Algorithm 1", first)):
            cells = runs.cells(surface, f"projections in a row from {name}", _LIMIT, partial(_counts, mesh, x))
            rows.append([f"{surface.name}: {surface.source}", name, *cells])
    head = ("surface", "start", "folded faces", "nearly conformal after", "predicted", "counted", "corrected",
            "folded faces left: counted, corrected", "mean angle: counted, corrected")
    return Table("Projections in a row: predicted and counted", _PROJECTIONS, head, rows)


def _counts(mesh: Mesh, x: FloatArray) -> list[str]:
    """Foldings of the start, numbers of projections, and what the two ways lead to."""
    ways = [list(islice(in_a_row(mesh, x, corrected), _LIMIT)) for corrected in (False, True)]
    limit, areas = ways[0][-1].x, vertex_areas(ways[0][-1].x, mesh.f)
    near = next((k for k, step in enumerate(ways[0]) if step.change < _NEAR), None)
    close = [next((k for k, step in enumerate(way) if _distance(step.x, limit, areas) < _CLOSE), -1) for way in ways]
    ends = [way[k].x for way, k in zip(ways, close, strict=True)]
    return [
        f"{_foldings(mesh, x)}",
        "never" if near is None else f"{near + 1}",
        "-" if near is None else f"{near + 1 + predict(ways[0][near])}",
        *("never" if k < 0 else f"{k + 1}" for k in close),
        ", ".join(f"{_foldings(mesh, y)}" for y in ends),
        ", ".join(f"{mean_angle_difference(mesh, y):.2f}" for y in ends),
    ]


def _distance(x: FloatArray, y: FloatArray, areas: FloatArray) -> float:
    """Root of the integral of the squared distance of two maps, turned to agree best."""
    apart = x @ best_rotation(x, y, areas) - y
    return sqrt(float(areas @ row_dots(apart, apart)))


def _foldings(mesh: Mesh, x: FloatArray) -> int:
    return int(folded_faces(x, mesh.f).sum())


_BOOSTS = """\
Each row has the harmonic energy (6) of the default map, and of its images under boosts, the Moebius maps with centre
(c, 0, 0). They are as conformal as the map itself.
"""
#: Centres of the Moebius images, as shares of the radius.
_CENTRES = (0.0, 0.3, 0.6, 0.9, 0.99, 0.999)


def boosts(runs: Runs) -> Table:
    """A row for every surface of Table 1."""
    rows = []
    for surface in map(runs.surface, (row.surface for row in TABLE_1)):
        x, energy = runs.get(surface, "default").sphere, HarmonicEnergy.of(check_mesh(surface.v, surface.f))
        rows.append([surface.label, *(f"{energy.evaluate(moebius(x, np.array([c, 0, 0])))[0]:.4f}" for c in _CENTRES)])
    return Table("Energies of Moebius images", _BOOSTS, ("surface", *(f"c = {c:g}" for c in _CENTRES)), rows)


#: The tables as Markdown pages, by their names.
CLAIMS: dict[str, Callable[[Runs], Table]] = {
    "table4": table_4,
    "eigenfunctions": eigenfunctions,
    "projections": projections,
    "boosts": boosts,
}
