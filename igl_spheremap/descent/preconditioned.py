"""Preconditioned Cayley steps of length one: the paper's update with H replaced by P^-1 H."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import count

import numpy as np

from ..mesh.arrays import FloatArray
from ..mesh.check import Mesh
from ..mesh.measure import surface_area
from ..operators.laplacian import Operators
from ..result.run import Iterate, Listener, Stage, Status
from ..sphere.cayley import cayley_step
from ..sphere.rows import along, column_crosses, inner, row_dots, weighted_moment, weighted_sum
from ..start.punctured import OFF_CENTRE, Evaluated, is_coarse, punctured_start
from ..timings import phase
from ..verify.certificate import Certificate
from ..verify.distortion import mean_angle_difference
from .energies import HarmonicEnergy
from .line_search import NonmonotoneSearch, line_search
from .minimize import State, minimize
from .problem import Problem, SobolevH1

#: A rise of the energy by this share of it is rounding.
_ROUNDING = 1e-13
#: At most this many halvings of a step. Only bodies with limbs beyond float64, whose maps fold anyway, took shorter
#: steps: these gained less than 1e-4 of the energy, again and again, until rounding stopped them.
_HALVINGS = 10
#: Least gap between energy and area, for meshes that are conformal to rounding (a tetrahedron).
_LEAST_GAP = 1e-9
#: If a start has more foldings than the end, but angle differences below this share of the end's, it is preferred.
_FAR_LESS = 0.5


def preconditioned_cayley(problem: Problem, start: Evaluated) -> Iterator[State]:
    """Yield a centred start and every state after it; end when no step lowers the energy.

    The steps are Cayley steps along P^-1 H: near a conformal map, of any surface, they are almost Newton's.

    Near a conformal map a tangent field is a sum of gradients of spherical harmonics and of such gradients turned by a
    right angle. The energy has the Hessian l (l + 1) - 2 on those of degree l; those of degree 1 are the Moebius maps,
    which the gauge fixes. With P = L + tiny M, factorised, P^-1 times the Hessian is 1 + 2 / (l (l + 1)) on gradients
    and 1 - 2 / (l (l + 1)) on turned ones. The reason: coordinates of these fields are harmonics of degrees l - 1 and l
    + 1, and of degree l. So a step along P^-1 H, which replaces H in eq. (11), is Newton's for fine fields, but leaves
    a third of a field of degree 2. The ten fields of degree 2 are divided by their own Hessian instead. Then a step
    leaves a sixth of degree 3, and less of all others. If bad triangles make the energy rise, the search of Algorithm 1
    shortens the step.

    A state's residual estimates the energy above its minimum, in units of the gap between energy and flat image area,
    which is the mesh's own discretisation error; infinite for the start.
    """
    x, energy, H = start
    yield State(0, x, energy, np.inf)
    for k in count(1):
        # lambda of eq. (9), algorithm (10): twice the image area around each vertex
        density = row_dots(x, H)
        e = _boost(x, H, density)
        # eq. (9), less the boost: algorithm (12)
        g = H - (density * (1 - along(x, e)))[:, None] * x
        g -= (e[:, None] * density).T
        D = problem.metric.solve(g)  # algorithm (13)
        quadrupoles = _correct_quadrupoles(D, x, g)
        D -= weighted_sum(problem.A, D)
        # After a step at most a fifth of its square is left, and a twentieth of the part of degree 2 if that part's
        # Hessian is within a sixth of the round sphere's.
        square = 0.5 * float(np.einsum("i,i->", density, row_dots(D, D)))
        left = (abs(square - quadrupoles) + quadrupoles / 4) / 5  # algorithm (16)
        slope = -inner(g, D)
        search = NonmonotoneSearch(energy * (1 + _ROUNDING), delta=0.5, trials=_HALVINGS)
        path = partial(_path, problem, x, D)
        step = line_search(search, problem.energy, path, 1.0, slope)  # Algorithm 1, step 3
        if step is None:
            return
        tau, x, energy, H = step
        area = surface_area(x, problem.f)
        residual = left / max(energy - area, _LEAST_GAP)  # algorithm (17)
        yield State(k, x, energy, residual, tau, details={"area": area})


def _path(problem: Problem, x: FloatArray, D: FloatArray, tau: float) -> FloatArray:
    """The map to which a step along D leads, in the gauge: Theorem 1, with D for H."""
    return problem.centred(cayley_step(x, D, tau), OFF_CENTRE)  # algorithm (15)


def _boost(x: FloatArray, H: FloatArray, density: FloatArray) -> FloatArray:
    """Boost to remove from the tangent part of `H` in proportion to the density, so that it sums to zero.

    A uniform shift would load the vertices of limbs, whose image is tiny, like all others, and distort them.
    """
    gram = density.sum() * np.eye(3) - weighted_moment(density, x, x)
    return np.linalg.solve(gram, H.sum(axis=0) - weighted_sum(density, x))  # algorithm (11)


def _correct_quadrupoles(D: FloatArray, x: FloatArray, g: FloatArray) -> float:
    """Make the fields of degree 2 in P^-1 g those of a Newton step; return their square, integrated over the sphere.

    They are the tangent part of Q x, and x cross Q x, for symmetric Q without trace. The square of either integrates to
    4 pi |Q|^2 / 5, the Hessian is 4 times that, and P^-1 g has 4/3 and 2/3 of the Newton step.
    """
    x_columns, g_columns = np.ascontiguousarray(x.T), np.ascontiguousarray(g.T)
    moments = (
        np.einsum("ji,ki->jk", x_columns, y)
        for y in (g_columns, column_crosses(g_columns, x_columns))
    )
    # g is tangent, so that neither moment has a trace
    Q, turned = (5 / (32 * np.pi) * (M + M.T) for M in moments)
    y = np.einsum("jk,ki->ji", turned, x_columns)
    y += column_crosses(x_columns, np.einsum("jk,ki->ji", Q, x_columns))
    D += column_crosses(x_columns, y).T / 3  # algorithm (14)
    return 4 * np.pi / 5 * float((Q**2).sum() + (turned**2).sum())


@phase("steps")
def harmonic_map(
    mesh: Mesh,
    operators: Operators,
    x: FloatArray | None = None,
    *,
    tolerance: float = 1e-3,
    max_iterations: int = 30,
    listener: Listener | None = None,
) -> tuple[Iterate, Status]:
    """Harmonic map of a mesh whose Laplacian is factorised, from the punctured harmonic map by default.

    The steps end when the energy is above the minimum by at most the share `tolerance` of the mesh's own discretisation
    error, energy minus image area; on most meshes one or two reach it.

    On a mesh so coarse that its faces cut deep through the sphere, the chord energy has no useful minimiser. If the
    start keeps angles better there, it is returned in place of the last iterate.
    """
    problem = Problem.of(
        mesh, HarmonicEnergy(operators.L), SobolevH1(operators.factor, operators.L)
    )
    if x is None:
        start = punctured_start(mesh, operators)
    else:
        start = Evaluated.of(problem.centred(x, OFF_CENTRE), operators)
    last, status = minimize(
        preconditioned_cayley(problem, start),
        Stage.PRECONDITIONED,
        tolerance=tolerance,
        max_iterations=max_iterations,
        listener=listener,
    )
    if status is Status.STOPPED or last.details is None or not is_coarse(last.details["area"]):
        return last, status
    if _start_is_better(mesh, start.x, last.x):
        last = Iterate(Stage.PRECONDITIONED, 0, 0, start.x, start.energy, np.inf)
    return last, status


def _start_is_better(mesh: Mesh, start: FloatArray, end: FloatArray) -> bool:
    """True if the start's angle differences are smaller, without more foldings, or less than half of the end's."""
    before, after = (mean_angle_difference(mesh, x) for x in (start, end))
    if Certificate.of(start, mesh.f).foldings <= Certificate.of(end, mesh.f).foldings:
        return before < after
    return before < _FAR_LESS * after
