"""Conformal maps of a mesh without one face, by one factorisation: to the plane, and on to the sphere."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from ..mesh.arrays import TINY, ComplexArray, FloatArray, IntArray
from ..mesh.check import Mesh
from ..mesh.measure import spread, surface_area, vertex_normals, weighted_quantile
from ..operators.laplacian import Operators, apply_laplacian
from ..sphere.moebius import center
from ..sphere.rows import INFINITE, from_chart, inner
from ..timings import phase
from ..verify.distortion import mean_angle_difference

#: At most this many faces are sampled for the affine correction, and vertices for a first scale: medians need no more.
_SAMPLE = 1000
#: Starts, and maps after a step, are centred if their weighted mean is farther than this from the origin.
OFF_CENTRE = 1e-4


class Evaluated(NamedTuple):
    """A map, its harmonic energy, and the derivatives of the energy."""

    x: FloatArray
    energy: float
    derivative: FloatArray

    @classmethod
    def of(cls, x: FloatArray, operators: Operators) -> Evaluated:
        """A map, evaluated."""
        derivative = apply_laplacian(operators.L, x)
        return cls(x, 0.5 * inner(x, derivative), derivative)  # eq. (6)


@phase("start")
def punctured_start(
    mesh: Mesh,
    operators: Operators,
    faces: Iterable[int] | None = None,
    largest_nu: float = 0.5,
    largest_energy: float = 6 * np.pi,
) -> Evaluated:
    """Map that is nearly conformal outside one face, by two solves; centred to `OFF_CENTRE` on the vertex areas.

    The faces to puncture, well-shaped ones by default, are tried in turn until a start is good. If none is, the best is
    taken; if no puncture gives finite numbers, the Gauss map. A larger mean Beltrami coefficient nu comes from a badly
    shaped face; the energy of a conformal map is 4 pi.

    The plane map is that of Angenent, Haker, Tannenbaum, Kikinis 1999 (reference [11] of Lai et al.); the correction of
    the puncture's discretisation error is ours.
    """
    tried: list[Evaluated] = []
    if faces is None:
        faces = candidate_faces(mesh)
    for face in faces:
        z = _placed_map(mesh, operators, face)
        z, nu = _corrected(mesh, z, face)
        if not np.isfinite(z).all():
            continue
        x = center(to_sphere(z, mesh.A), mesh.A, OFF_CENTRE)
        if not np.isfinite(x).all():
            continue
        tried.append(Evaluated.of(x, operators))
        coarse = is_coarse(surface_area(x, mesh.f))
        if abs(nu) < largest_nu and tried[-1].energy < largest_energy and not coarse:
            break
    if not tried:
        return Evaluated.of(center(vertex_normals(mesh.unit, mesh.f), mesh.A), operators)
    if coarse:  # large chords have so little energy that it can't rank maps
        return min(tried, key=lambda start: mean_angle_difference(mesh, start.x))
    return min(tried, key=lambda start: start.energy)


def is_coarse(area: float) -> bool:
    """True if the flat faces cover less than 95 percent of the sphere's area: chords cut deep through it then."""
    return area < 0.95 * 4 * np.pi


def candidate_faces(
    mesh: Mesh, compared: int = 4000, tries: int = 4, stride: int = 40
) -> Iterator[int]:
    """Well-shaped faces of middling size, spread over the mesh: good ones to puncture.

    They are every `stride`-th in the order of quality of the faces `compared`; fewer would miss the good ones.
    """
    sample = spread(len(mesh.f), compared)
    side, w = _in_their_planes(mesh, mesh.f[sample])
    area = side * w.imag / 2
    quality = area / np.maximum(side**2 + np.abs(w) ** 2 + np.abs(w - side) ** 2, TINY)
    middling = np.sort(area)[len(area) // 2]
    ratio = np.minimum(area, middling) / np.maximum(np.maximum(area, middling), TINY)
    order = np.arange(len(mesh.f))[sample][np.argsort(-quality * np.sqrt(ratio), kind="stable")]
    yield from order[:: min(len(order) // tries, stride)][:tries].tolist()


def dipole_map(mesh: Mesh, operators: Operators, face: int) -> ComplexArray:
    """Map a mesh to the plane with a pole inside one face, up to a similarity, as seen from outside.

    With a local coordinate w about the puncture, z = 1 / w solves ``Laplace z = 2 pi (d/dx - i d/dy) delta``: the field
    of a dipole. Tested with the hat function of a corner, the right-hand side is that function's gradient in the face.
    Angenent, Haker, Tannenbaum, Kikinis 1999, *On the Laplace-Beltrami operator and brain surface flattening*.
    """
    w = np.append(0, _in_their_planes(mesh, mesh.f[[face]]))
    opposite = np.roll(w, -2) - np.roll(w, -1)
    # of the hat functions: opposite edge, turned inwards
    gradients = 1j * opposite / (w[1].real * w[2].imag)
    load = np.zeros((len(mesh.v), 2))
    load[mesh.f[face]] = np.column_stack((gradients.real, -gradients.imag))
    z = operators.factor.solve(load)
    return np.asarray(z[:, 0] + 1j * z[:, 1])


def _placed_map(mesh: Mesh, operators: Operators, face: int) -> ComplexArray:
    """Harmonic map of the mesh without one face to the plane; its corners are placed in the face's mirrored shape.

    Without the face the Laplacian changes only in the rows of its three corners, whose places are given. So differences
    of the whole mesh's Green functions give the map.
    """
    a, b, c = mesh.f[face]
    loads = np.zeros((len(mesh.v), 2))
    loads[[b, c], [0, 1]] = 1
    loads[a] = -1
    green = operators.factor.solve(loads)  # algorithm (3)
    target = np.conj(np.ravel(_in_their_planes(mesh, mesh.f[[face]])))
    # without area it is placed as an equilateral one: the affine correction finds its shape
    if target[1].imag == 0:
        target = np.array([1, 0.5 - 0.75**0.5 * 1j])
    with np.errstate(all="ignore"):
        try:
            coefficients = np.linalg.solve(green[[b, c]] - green[a], target)  # algorithm (4)
        except np.linalg.LinAlgError:
            return np.full(len(mesh.v), np.nan + 0j)
        return np.einsum("ij,j->i", green, coefficients)


def _corrected(
    mesh: Mesh, z: ComplexArray, face: int, inner: float = 1 / 8, outer: float = 1 / 3
) -> tuple[ComplexArray, complex]:
    """Take out the discretisation error of a puncture, and return its part nu.

    With z about the middle of the body the map is made conformal by z + nu conj(z) + kappa conj(z)^2 / 2, up to terms
    that matter only at the puncture. The first part removes a stretch of the whole plane, which a badly placed face
    causes. The second has the threefold symmetry of a triangle, and is larger for a good face: its Beltrami coefficient
    is about conj(z) over the distance of the corners.

    The second is fitted on the ring inner < |z| < outer, in units of the corners' distance: farther out higher terms
    matter, farther in the mesh's noise. If the geometric mean of that distance and the body's size is nearer, the ring
    begins there.
    """
    z = _about_middle(z, mesh.A)
    body = mesh.f[spread(len(mesh.f), _SAMPLE)]
    nu = _median(_beltrami(mesh, body, z))
    if nu is None:
        return z, 1.0
    if abs(nu) < 0.95:  # more comes from slivers, and would flatten the plane to a line
        z = z + nu * z.conj()  # algorithm (6)
    distance, sample = np.abs(z), spread(len(z), _SAMPLE)
    corner, middle = (
        distance[mesh.f[face]].min(),
        weighted_quantile(distance[sample], mesh.A[sample]),
    )
    # algorithm (7)
    begin, end = min(inner * corner, np.sqrt(middle * corner)), outer * corner
    within = (distance > begin) & (distance < end)
    ring = mesh.f[within.take(mesh.f[:, 0])]
    ring = ring[within[ring].all(axis=1)]
    ring = ring[spread(len(ring), _SAMPLE)]
    kappa = _median(_beltrami(mesh, ring, z) / z[ring].mean(axis=1).conj())
    if kappa is not None:
        z = z + kappa / 2 * z.conj() ** 2  # algorithm (8)
    return z, nu


def _beltrami(mesh: Mesh, f: IntArray, z: ComplexArray, reliable: float = 1e-10) -> ComplexArray:
    """For each face the nu that makes z + nu conj(z) conformal there; NaN if it is rounding, or 1 or more.

    Sides in the plane below the share `reliable` of its extent, deep in limbs, are rounding.
    """
    side, w = _in_their_planes(mesh, f)
    with np.errstate(all="ignore"):
        first, second, third = z[f.T]
        dp, dq = second - first, third - first
        # dp = side (z_w + z_wbar) and dq = w z_w + conj(w) z_wbar, whose common factor is imaginary.
        nu = (dq * side - dp * w) / (dp * w.conj() - dq * side).conj()  # algorithm (5)
        known = np.abs(dp) + np.abs(dq) > reliable * np.abs(z).max()
        return np.where(known & (w.imag > 0) & (np.abs(nu) < 1), nu, np.nan)


def _median(values: ComplexArray) -> complex | None:
    """Median of the real parts and of the imaginary parts of numbers, NaN left out; None if there are none."""
    values = values[np.isfinite(values)]
    if not len(values):
        return None
    middle = len(values) // 2
    return complex(np.sort(values.real)[middle], np.sort(values.imag)[middle])


def _in_their_planes(mesh: Mesh, f: IntArray) -> tuple[FloatArray, ComplexArray]:
    """Faces in their own planes, as seen from outside: corners are 0, a length, and a point above the real line."""
    a, b, c = (np.ascontiguousarray(mesh.unit[corners].T) for corners in f.T)
    p, q = b - a, c - a
    side = np.maximum(np.sqrt((p * p).sum(axis=0)), TINY)
    along = (p * q).sum(axis=0) / side
    return side, along + 1j * np.sqrt(np.maximum((q * q).sum(axis=0) - along**2, 0.0))


def to_sphere(z: ComplexArray, weights: FloatArray) -> FloatArray:
    """Inverse stereographic projection with about half the weight in each hemisphere; infinity is the south pole."""
    z = _about_middle(z, weights)
    radius, sample = np.abs(z), spread(len(z), _SAMPLE)
    middle = weighted_quantile(radius[sample], weights[sample])
    if middle <= 0:
        middle = radius.max()
    z /= np.maximum(middle, radius / INFINITE)
    return from_chart(2 * z, np.array([[0.0, 0.0, 1.0]]))  # algorithm (9)


def _about_middle(z: ComplexArray, weights: FloatArray) -> ComplexArray:
    """Positions relative to an estimate of their weighted median, which is enough: maps are centred later."""
    sample = spread(len(z), _SAMPLE)
    w = weights[sample]
    return z - complex(weighted_quantile(z.real[sample], w), weighted_quantile(z.imag[sample], w))
