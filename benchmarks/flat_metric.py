"""A map through a flat metric that is discretely conformally equivalent to the mesh's, reference [12] of Lai et al.

For the curvature flow of the paper's reference stands a convex Newton iteration (Springborn, Schroeder, Pinkall 2008).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import count

import numpy as np
import scipy.sparse as sp

from igl_spheremap.errors import FactorisationFailed, MapError
from igl_spheremap.mesh.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from igl_spheremap.mesh.check import Mesh
from igl_spheremap.mesh.measure import angle_defects
from igl_spheremap.operators.factor.factorize import factorize
from igl_spheremap.operators.laplacian import (
    build_operators,
    mollified_edge_lengths,
    summed_laplacian,
)
from igl_spheremap.sphere.moebius import center
from igl_spheremap.start.punctured import dipole_map, to_sphere

#: Halvings of a Newton step at most: to 1e-12 of it.
_HALVINGS = 40
#: Numbers added to the Hessian's diagonal, in turn until it can be factorised: a vertex whose faces are all broken has
#: a row of zeros.
_SHIFTS = (1e-10, 1e-6, 1e-3)


@dataclass(frozen=True, eq=False)
class FlatMetric:
    """Edge lengths ``exp((u_i + u_j) / 2) l_ij`` that make a mesh without one vertex and its star flat."""

    #: The vertex that was taken out; it lies at infinity.
    vertex: int
    #: (n,) logarithmic scale factors; all edges to the vertex at infinity are scaled to length 1.
    u: FloatArray
    #: (k, 3) faces that are left.
    faces: IntArray
    #: (k, 3) angles in radians, which sum to 2 pi around each inner vertex.
    angles: FloatArray
    #: (k, 3) logarithms of the sides, each opposite its corner.
    log_lengths: FloatArray
    #: Faces of the mesh that violate the triangle inequality: the metric is flat apart from them. By the theory their
    #: edges would have to be flipped, which makes another mesh.
    broken: IntArray
    #: Newton steps.
    iterations: int


def through_flat_metric(mesh: Mesh, face: int) -> FloatArray:
    """The centred sphere map of the flat metric with the first corner of a face at infinity."""
    vertex = int(mesh.f[face, 0])
    first = to_sphere(dipole_map(mesh, build_operators(mesh), face), mesh.A)
    z = lay_out(flat_metric(mesh, vertex, first))
    x = np.tile([0.0, 0.0, -1.0], (len(z), 1))
    near = np.arange(len(z)) != vertex
    if not np.isfinite(z[near]).all():
        raise MapError("the plane map is not finite; puncture another face")
    x[near] = to_sphere(z[near], mesh.A[near])
    return center(x, mesh.A)


def flat_metric(
    mesh: Mesh, vertex: int, x: FloatArray, *, tolerance: float = 1e-8, max_iterations: int = 100
) -> FlatMetric:
    """Flatten a mesh with one vertex at infinity; edges to it get length 1, which makes the metric unique.

    `x`, a nearly conformal map to the unit sphere, gives the first guess. The tolerance is the largest deviation of an
    inner vertex's angle sum from 2 pi, in radians; a MapError if more is left after `max_iterations` Newton steps.

    Springborn, Schroeder, Pinkall 2008, *Conformal Equivalence of Triangle Meshes*: the angle defects are the gradient
    of a convex energy of u, whose Hessian is the cotangent Laplacian of the current metric; where the triangle
    inequality fails, the angles pi, 0, 0 continue the energy.
    """
    rest = (mesh.f != vertex).all(axis=1)
    f, log_l = mesh.f[rest], np.log(mollified_edge_lengths(mesh.unit, mesh.f))
    u = _first_guess(mesh, vertex, x)
    star, corner = np.nonzero(mesh.f == vertex)
    link = mesh.f[star, (corner + 1) % 3]
    at_infinity = -2 * log_l[star, (corner + 2) % 3]  # scales all edges to the vertex to length 1
    u += (at_infinity - u[link]).mean()
    u[link], u[vertex] = at_infinity, 0.0
    free = np.setdiff1d(np.arange(len(u)), [*link, vertex])
    u, angles, worst, k = _newton(u, f, log_l[rest], free, tolerance, max_iterations)
    if worst > tolerance:
        raise MapError(
            f"angle defects of up to {worst:.1e} are left after {k} Newton steps; allow more"
        )
    broken = np.flatnonzero(rest)[_broken(angles)]
    return FlatMetric(vertex, u, f, angles, log_l[rest] + edge_log_scale(u, f), broken, k)


def lay_out(metric: FlatMetric) -> ComplexArray:
    """Positions in the plane that have a flat metric's lengths, up to a similarity, oriented as seen from outside.

    Found as the least-squares conformal map of the flat metric, which is an isometry up to scale: one solve places all
    vertices, no error travels along a chain of faces, and a broken face, which has no weight, spoils its surroundings
    only. The vertex that was taken out lies at infinity. MapError if broken faces cut parts off from the rest.

    Levy, Petitjean, Ray, Maillot 2002, *Least squares conformal maps*: Dirichlet energy minus area.
    """
    f, n = metric.faces, len(metric.u)
    sound = ~_broken(metric.angles)
    L = angle_laplacian(metric.angles, f, n)
    start, stop = f[sound].ravel(), f[sound][:, [1, 2, 0]].ravel()
    S = sp.csr_matrix((np.ones(len(start)), (start, stop)), shape=(n, n))
    half = (S - S.T) / 2  # x . half y is the area: inner edges cancel
    system = sp.bmat([[L, -half], [half.copy(), L]], format="csr")
    rim = np.unique(start[~np.isin(start * n + stop, stop * n + start)])
    pins = rim[[0, -1]]
    free = np.setdiff1d(np.arange(n), [*pins, metric.vertex])
    rows, fixed = np.r_[free, free + n], np.r_[pins, pins + n]
    values = np.array([0.0, 1.0, 0.0, 0.0])  # the pins lie at 0 and 1
    z = np.zeros(2 * n)
    z[fixed] = values
    try:
        z[rows] = factorize(system[rows][:, rows]).solve(-(system[rows][:, fixed] @ values))
    except FactorisationFailed:
        raise MapError(
            f"the flat metric can't be laid out: {len(metric.broken)} broken faces, e.g. "
            f"{metric.broken[:3].tolist()}, cut parts off from the rest; remesh there, or take the "
            "Laplace-Beltrami map"
        ) from None
    return np.asarray(np.where(np.arange(n) == metric.vertex, np.inf, z[:n] + 1j * z[n:]))


def _first_guess(mesh: Mesh, vertex: int, x: FloatArray) -> FloatArray:
    """Scale factors of the map `x` followed by the stereographic projection from the vertex."""
    # each edge both ways
    edges = np.vstack((mesh.f[:, [0, 1]], mesh.f[:, [1, 2]], mesh.f[:, [2, 0]]))
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.log(
            [np.linalg.norm(p[edges[:, 0]] - p[edges[:, 1]], axis=1) for p in (x, mesh.unit)]
        )
        scale = np.bincount(edges[:, 0], ratio[0] - ratio[1]) / np.bincount(edges[:, 0])
        # Lengths in the plane are 2 |x - y| / (|x - pole| |y - pole|).
        u = scale - np.log(((x - x[vertex]) ** 2).sum(axis=1))
    return np.asarray(np.where(np.isfinite(u), u, 0.0))


def edge_log_scale(u: FloatArray, f: IntArray) -> FloatArray:
    """Logarithm of the factor of the edge opposite each corner."""
    return np.asarray((u[np.roll(f, -1, axis=1)] + u[np.roll(f, -2, axis=1)]) / 2)


def triangle_angles(log_lengths: FloatArray) -> FloatArray:
    """Corner angles from the sides opposite; pi, 0, 0 where the triangle inequality fails."""
    # In units of each face's longest side: limbs shrink below any common unit.
    side = np.exp(log_lengths - log_lengths.max(axis=1, keepdims=True))
    perimeter = side.sum(axis=1, keepdims=True)
    excess = np.maximum(perimeter - 2 * side, 0.0)  # b + c - a
    others = np.roll(excess, -1, axis=1) * np.roll(excess, -2, axis=1)
    return np.asarray(2 * np.arctan2(np.sqrt(others), np.sqrt(excess * perimeter)))


def _broken(angles: FloatArray) -> BoolArray:
    return ~((angles.min(axis=1) > 0) & (angles.max(axis=1) < np.pi))


def angle_laplacian(angles: FloatArray, f: IntArray, n: int) -> sp.csr_matrix:
    """Cotangent Laplacian of a mesh with a boundary, from its angles; broken triangles have no weight."""
    broken = _broken(angles)[:, None]
    half = np.where(broken, 0.0, 0.5 / np.tan(np.where(broken, 1.0, angles)))
    return summed_laplacian(half, f, n)


def _newton(
    u: FloatArray,
    f: IntArray,
    log_l: FloatArray,
    free: IntArray,
    tolerance: float,
    max_iterations: int,
) -> tuple[FloatArray, FloatArray, float, int]:
    """Minimise the convex energy over the free vertices; its gradient are the angle defects."""
    angles = triangle_angles(log_l + edge_log_scale(u, f))
    for k in count():
        K = angle_defects(angles, f, len(u))[free]
        worst = float(np.abs(K).max(initial=0.0))
        if worst <= tolerance or k == max_iterations:
            break
        step = np.zeros(len(u))
        step[free] = _newton_step(angles, f, len(u), free, K)
        tau = 1.0
        for _ in range(_HALVINGS):  # a convex energy fell if the slope is small at the trial
            trial = u + tau * step
            angles = triangle_angles(log_l + edge_log_scale(trial, f))
            if angle_defects(angles, f, len(u))[free] @ step[free] <= 0.5 * abs(K @ step[free]):
                break
            tau /= 2
        u = trial
    return u, angles, worst, k


def _newton_step(
    angles: FloatArray, f: IntArray, n: int, free: IntArray, K: FloatArray
) -> FloatArray:
    H = angle_laplacian(angles, f, n)[free][:, free]
    for shift in _SHIFTS:
        try:
            return -factorize(H + shift * sp.identity(len(free))).solve(K)
        except FactorisationFailed:  # faces broken or so thin that rounding made it indefinite
            continue
    return -K
