"""The balanced energy and its derivatives, against closed forms and differences."""

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.balance.derivatives import PAIRS, derivatives
from igl_spheremap.balance.energy import Energy, project
from igl_spheremap.balance.source import Source, lay_flat
from igl_spheremap.sphere.rows import tangent_axes, unit_rows


def axes_at(x):
    return np.stack(tangent_axes(x)).transpose(0, 2, 1)


@pytest.fixture(scope="module")
def map_of_spheroid():
    v, f = ism.samples.make("spheroid", n_vertices=200)
    return lay_flat(v, f), unit_rows(v - v.mean(axis=0))


@pytest.mark.parametrize("power", [0, 0.9, 1])
def test_gradient_is_that_of_differences(map_of_spheroid, power):
    source, x = map_of_spheroid
    rng = np.random.default_rng(0)
    energy = Energy(source, 0.6, power, rng.normal(size=len(source.f)))
    step = rng.normal(size=(2, source.n))
    move = np.einsum("an,ain->ni", step, axes_at(x))
    h = 1e-6
    ahead, behind = (energy.by_face(unit_rows(x + sign * h * move)).sum() for sign in (1, -1))
    difference = (ahead - behind) / (2 * h)
    assert (derivatives(energy, x, axes_at(x)).gradient * step).sum() == pytest.approx(difference, rel=1e-7)


def cap(size):
    """A fan of six triangles of that size at the north pole, with its source sheared."""
    turn = np.arange(6) * np.pi / 3
    plane = np.vstack((np.zeros(2), np.column_stack((np.cos(turn), 0.7 * np.sin(turn)))))
    f = np.array([[0, 1 + k, 1 + (k + 1) % 6] for k in range(6)])
    a, b, c = plane[f].transpose(1, 0, 2)
    u, w = b - a, c - a
    det = u[:, 0] * w[:, 1] - u[:, 1] * w[:, 0]
    first = (w[:, 1] - 1j * w[:, 0]) / det
    second = (-u[:, 1] + 1j * u[:, 0]) / det
    cot = np.stack([((q - p) * (r - p)).sum(axis=1) / det for p, q, r in ((a, b, c), (b, c, a), (c, a, b))])
    source = Source(f, 7, det / 2, cot, np.stack((-(first + second), first, second)))
    x = unit_rows(np.column_stack((size * (plane @ [[1.3, 0.2], [-0.4, 0.8]]), np.ones(7))))
    return source, x


@pytest.mark.parametrize("power", [0, 0.9, 1])
def test_hessian_is_that_of_differences_of_the_gradient_where_the_sphere_is_flat(power):
    source, x = cap(1e-4)
    rng = np.random.default_rng(1)
    energy = Energy(source, 0.4, power, np.log(1e-8) + rng.normal(size=6))
    step = rng.normal(size=(2, 7))
    axes = np.tile(axes_at(np.array([[0, 0, 1.0]])), (1, 1, 7))  # one frame for all, as in the plane
    h = 1e-9
    move = h * np.einsum("an,ain->ni", step, axes)
    difference = (derivatives(energy, x + move, axes).gradient - derivatives(energy, x - move, axes).gradient) / (2 * h)
    blocks = derivatives(energy, x, axes, convex=False).blocks
    product = np.zeros((7, 2))
    for block, (i, j) in zip(blocks, PAIRS, strict=True):
        np.add.at(product, source.f[:, i], np.einsum("abm,bm->ma", block, step[:, source.f[:, j]]))
        if i != j:
            np.add.at(product, source.f[:, j], np.einsum("abm,am->mb", block, step[:, source.f[:, i]]))
    assert np.allclose(product.T, difference, rtol=0, atol=1e-4 * np.abs(difference).max())


def test_the_projected_hessian_is_positive_definite(map_of_spheroid):
    source, x = map_of_spheroid
    energy = Energy(source, 0.5, 1, np.random.default_rng(2).normal(size=len(source.f)))
    blocks = derivatives(energy, x, axes_at(x)).blocks
    face = np.empty((len(source.f), 3, 2, 3, 2))
    for block, (i, j) in zip(blocks, PAIRS, strict=True):
        face[:, i, :, j] = block.transpose(2, 0, 1)
        face[:, j, :, i] = block.transpose(2, 1, 0)
    values = np.linalg.eigvalsh(face.reshape(-1, 6, 6))
    assert (values > -1e-9 * values.max(axis=1, keepdims=True)).all()
    assert (values[:, 3] > 0).all()  # moves of the plane cost nothing, all others do


def test_the_energy_is_mips_and_the_area_barrier(map_of_spheroid):
    source, x = map_of_spheroid
    image, dirichlet = project(source, x)
    none = np.zeros(len(source.f))
    J = image / source.area
    assert np.allclose(Energy(source, 0.0, 1, none).by_face(x), source.area * 2 * (dirichlet / image - 1))
    assert np.allclose(Energy(source, 1.0, 1, none).by_face(x), source.area * (J + 1 / J - 2))


def test_an_isometry_has_energy_zero_and_a_fold_infinite_energy():
    x, f = ism.samples.sphere(162)
    source = lay_flat(x, f)
    exact = Energy(source, 0.5, 1, np.log(project(source, x)[0] / source.area))
    assert exact.by_face(x).sum() < 1e-4  # what the projection leaves of a sphere's own faces
    folded = x.copy()
    folded[0] = -x[0]
    assert np.isinf(exact.by_face(folded)[(f == 0).any(axis=1)]).all()
