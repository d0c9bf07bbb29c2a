"""Conformal maps of a mesh without one face, by one factorisation: to the plane, and on to the sphere."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from ..mesh.arrays import ComplexArray, FloatArray
from ..mesh.check import Mesh
from ..mesh.measure import face_areas
from ..mesh.normals import mesh_gauss_map
from ..mesh.timings import stage
from ..operators.laplacian import apply
from ..operators.operators import Operators
from ..sphere.charts import INFINITE, from_chart
from ..sphere.moebius import center
from ..sphere.rows import inner, row_dots
from ..verify.distortion import mean_angle_difference

#: Number of faces sampled for the affine correction, and for a face to puncture.
_SAMPLE = 4000
#: A larger mean Beltrami coefficient comes from a badly shaped punctured face: the next face is tried.
_LARGEST_STRETCH = 0.5
#: One larger than this comes from slivers; correcting it would flatten the plane.
_LARGEST_CORRECTION = 0.95
#: A start with more energy than this is rejected: 4 pi is that of a conformal map.
_LARGEST_ENERGY = 6 * np.pi
#: Share of the sphere's area below which the flat faces of a map are coarse.
_COARSE = 0.95
#: Faces whose sides in the plane are below this share of its extent, deep in limbs, do not count for the stretch.
_RELIABLE = 1e-10
#: Accuracy of the solves for a start, and for a map that is final, where the factor is only approximate. The energy of
#: a plane map is that of the faces beside the puncture: with 1e-6 the rest costs a step more at 2.6 million vertices.
_ACCURACY = 1e-7
_FINAL_ACCURACY = 1e-8
#: Faces tried before the best of the poor starts is taken.
_TRIES = 4


@stage("start")
def punctured_start(mesh: Mesh, operators: Operators, faces: Iterable[int] | None = None) -> FloatArray:
    """Conformal map but for one face, as good as two solves can make it, Moebius-centred on the vertex areas.

    The faces to puncture, well-shaped ones by default, are tried in turn until a start is good; the Gauss map stands in
    where no puncture gives finite numbers. The plane map is that of Angenent, Haker, Tannenbaum, Kikinis 1999
    (reference [11] of Lai et al.); its affine correction is ours, for the discretisation error of the puncture is
    mostly one global stretch of the plane.
    """
    tried = []
    for face in candidate_faces(mesh) if faces is None else faces:
        z = _placed_map(mesh, operators, face)
        z, stretch = _without_stretch(mesh, z)
        x = center(to_sphere(z, mesh.A), mesh.A) if np.isfinite(z).all() else None
        if x is None or not np.isfinite(x).all():
            continue
        tried.append((0.5 * inner(x, apply(operators.L, x)), x))
        coarse = is_coarse(mesh, x)
        if abs(stretch) < _LARGEST_STRETCH and tried[-1][0] < _LARGEST_ENERGY and not coarse:
            break
    if not tried:
        return center(mesh_gauss_map(mesh), mesh.A)
    if coarse:  # large chords have so little energy that it can't rank maps
        return min((x for _, x in tried), key=lambda x: mean_angle_difference(mesh, x))
    return min(tried, key=lambda pair: pair[0])[1]


def is_coarse(mesh: Mesh, x: FloatArray) -> bool:
    """True if faces cut so deep through the sphere that 5 percent of its area are lost."""
    return float(face_areas(x, mesh.f).sum()) < _COARSE * 4 * np.pi


def candidate_faces(mesh: Mesh) -> Iterator[int]:
    """Four well-shaped faces of middling size, spread over the mesh: good ones to puncture."""
    m = len(mesh.f)
    sample = np.linspace(0, m - 1, num=min(m, _SAMPLE)).astype(np.int64)
    a, b, c = (np.ascontiguousarray(mesh.v[mesh.f[sample, k]].T) for k in range(3))
    lengths = np.sqrt([((b - c) ** 2).sum(0), ((c - a) ** 2).sum(0), ((a - b) ** 2).sum(0)])
    s = lengths.sum(axis=0) / 2
    area = np.sqrt(np.maximum(s * (s - lengths[0]) * (s - lengths[1]) * (s - lengths[2]), 0))
    square = (lengths**2).sum(axis=0)
    quality = np.divide(4 * np.sqrt(3) * area, square, out=np.zeros_like(area), where=square > 0)
    middling = np.median(area)
    ratio = np.minimum(area, middling) / np.maximum(np.maximum(area, middling), 1e-300)
    order = sample[np.argsort(-quality * np.sqrt(ratio), kind="stable")]
    yield from order[:: max(1, min(len(order) // _TRIES, 40))][:_TRIES].tolist()  # of the best 160 on large meshes


def dipole_map(mesh: Mesh, operators: Operators, face: int) -> ComplexArray:
    """Map a mesh to the plane with a pole inside one face, up to a similarity, as seen from outside.

    With a local coordinate w about the puncture, z = 1 / w solves ``Laplace z = 2 pi (d/dx - i d/dy) delta``: the field
    of a dipole. Tested with the hat function of a corner, the right-hand side is that function's gradient in the face.
    Angenent, Haker, Tannenbaum, Kikinis 1999, *On the Laplace-Beltrami operator and brain surface flattening*.
    """
    w = np.array([0, *_in_its_plane(mesh, face)])
    opposite = np.roll(w, -2) - np.roll(w, -1)
    gradients = 1j * opposite / (w[1].real * w[2].imag)  # of the hat functions: opposite edge, turned inwards
    load = np.zeros((len(mesh.v), 2))
    load[mesh.f[face]] = np.column_stack((gradients.real, -gradients.imag))
    z = operators.factor.solve(load, _FINAL_ACCURACY)
    return np.asarray(z[:, 0] + 1j * z[:, 1])


def _placed_map(mesh: Mesh, operators: Operators, face: int) -> ComplexArray:
    """Harmonic map of the mesh without one face to the plane, the corners placed like that face, mirrored.

    The Laplacian of the punctured mesh differs in the rows of the three corners only, which are placed: so the whole
    mesh's Green functions between them give the map.
    """
    a, b, c = mesh.f[face]
    loads = np.zeros((len(mesh.v), 2))
    loads[[b, c], [0, 1]] = 1
    loads[a] = -1
    green = operators.factor.solve(loads, _ACCURACY)
    side, third = _in_its_plane(mesh, face)
    # A face without area is placed as an equilateral one: the affine correction finds its shape.
    target = np.array([side, third.conjugate()]) if third.imag > 0 else np.array([1, 0.5 - 0.75**0.5 * 1j])
    with np.errstate(all="ignore"):
        try:
            coefficients = np.linalg.solve(green[[b, c]] - green[a], target)
        except np.linalg.LinAlgError:
            return np.full(len(mesh.v), np.nan + 0j)
        return np.einsum("ij,j->i", green, coefficients)


def _without_stretch(mesh: Mesh, z: ComplexArray) -> tuple[ComplexArray, complex]:
    """Take out the mean Beltrami coefficient, z + nu conj(z), estimated from a sample of faces by medians."""
    f = mesh.f[:: max(1, len(mesh.f) // _SAMPLE)]
    a, b, c = (mesh.v[f[:, k]] for k in range(3))
    p, q = b - a, c - a
    side = np.sqrt(row_dots(p, p))
    with np.errstate(all="ignore"):
        along = row_dots(p, q) / side
        w = along + 1j * np.sqrt(row_dots(q, q) - along**2)  # `_in_its_plane`, NaN for faces without area
        dp, dq = z[f[:, 1]] - z[f[:, 0]], z[f[:, 2]] - z[f[:, 0]]
        # dp = side (z_w + z_wbar) and dq = w z_w + conj(w) z_wbar, whose common factor is imaginary.
        nu = (dq * side - dp * w) / (dp * w.conj() - dq * side).conj()  # -z_wbar / conj(z_w)
        known = np.abs(dp) + np.abs(dq) > _RELIABLE * np.abs(z[f] - z[f[0, 0]]).max()
    nu = nu[known & np.isfinite(nu) & (np.abs(nu) < 1)]
    if not len(nu):
        return z, 1.0
    mean = complex(np.median(nu.real), np.median(nu.imag))
    return (z + mean * z.conj() if abs(mean) < _LARGEST_CORRECTION else z), mean


def _in_its_plane(mesh: Mesh, face: int) -> tuple[float, complex]:
    """A face in its own plane, as seen from outside: its corners are 0, a length, and a point above the real line."""
    a, b, c = mesh.v[mesh.f[face]]
    p, q = b - a, c - a
    side = max(float(np.linalg.norm(p)), 1e-300)
    along = float(p @ q) / side
    return side, complex(along, np.sqrt(max(q @ q - along**2, 0.0)))


def to_sphere(z: ComplexArray, weights: FloatArray) -> FloatArray:
    """Inverse stereographic projection with about half the weight in each hemisphere; infinity is the south pole."""
    sample = slice(None, None, max(1, len(z) // _SAMPLE))  # an estimate is enough: centring comes later
    w = weights[sample]
    z = z - complex(_middle(z.real[sample], w), _middle(z.imag[sample], w))
    radius = np.abs(z)
    middle = _middle(radius[sample], w)
    z /= np.maximum(middle if middle > 0 else radius.max(), radius / INFINITE)
    return from_chart(2 * z, np.array([[0.0, 0.0, 1.0]]))


def _middle(values: FloatArray, weights: FloatArray) -> float:
    """Weighted median."""
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return float(values[order[np.searchsorted(total, total[-1] / 2)]])
