"""The balanced energy and its derivatives, against closed forms and differences."""

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.balance.energy import BalancedEnergy
from igl_spheremap.balance.flat_faces import FlatFaces, log_areas
from igl_spheremap.newton.system import PAIRS
from igl_spheremap.sphere.rows import tangent_axes, unit_rows


def axes_at(x):
    return np.stack(tangent_axes(x)).transpose(0, 2, 1)


@pytest.fixture(scope="module")
def map_of_spheroid():
    v, f = ism.samples.make("spheroid", n_vertices=200)
    return FlatFaces.of(v, f), unit_rows(v - v.mean(axis=0))


@pytest.mark.parametrize("power", [0, 0.9, 1])
def test_gradient_is_that_of_differences(map_of_spheroid, power):
    source, x = map_of_spheroid
    rng = np.random.default_rng(0)
    energy = BalancedEnergy(source, 0.6, power, rng.normal(size=len(source.f)))
    step = rng.normal(size=(2, source.n))
    move = np.einsum("an,ain->ni", step, axes_at(x))
    h = 1e-6
    ahead, behind = (energy.by_face(unit_rows(x + sign * h * move)).sum() for sign in (1, -1))
    difference = (ahead - behind) / (2 * h)
    assert (energy.derivatives(x, axes_at(x))[0] * step).sum() == pytest.approx(
        difference, rel=1e-7
    )


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
    hats = np.stack((first, second))
    source = FlatFaces(f, 7, det / 2, np.stack((hats.real, hats.imag)))
    x = unit_rows(np.column_stack((size * (plane @ [[1.3, 0.2], [-0.4, 0.8]]), np.ones(7))))
    return source, x


@pytest.mark.parametrize("power", [0, 0.9, 1])
def test_hessian_is_that_of_differences_of_the_gradient_where_the_sphere_is_flat(power):
    source, x = cap(1e-4)
    rng = np.random.default_rng(1)
    energy = BalancedEnergy(source, 0.4, power, np.log(1e-8) + rng.normal(size=6))
    step = rng.normal(size=(2, 7))
    # one frame for all, as in the plane
    axes = np.tile(axes_at(np.array([[0, 0, 1.0]])), (1, 1, 7))
    h = 1e-9
    move = h * np.einsum("an,ain->ni", step, axes)
    difference = (energy.derivatives(x + move, axes)[0] - energy.derivatives(x - move, axes)[0]) / (
        2 * h
    )
    blocks = energy.derivatives(x, axes, convex=False)[1]
    product = np.zeros((7, 2))
    for block, (i, j) in zip(blocks, PAIRS, strict=True):
        np.add.at(product, source.f[:, i], np.einsum("abm,bm->ma", block, step[:, source.f[:, j]]))
        if i != j:
            np.add.at(
                product, source.f[:, j], np.einsum("abm,am->mb", block, step[:, source.f[:, i]])
            )
    assert np.allclose(product.T, difference, rtol=0, atol=1e-4 * np.abs(difference).max())


def test_the_projected_hessian_is_positive_definite(map_of_spheroid):
    source, x = map_of_spheroid
    energy = BalancedEnergy(source, 0.5, 1, np.random.default_rng(2).normal(size=len(source.f)))
    blocks = energy.derivatives(x, axes_at(x))[1]
    face = np.empty((len(source.f), 3, 2, 3, 2))
    for block, (i, j) in zip(blocks, PAIRS, strict=True):
        face[:, i, :, j] = block.transpose(2, 0, 1)
        face[:, j, :, i] = block.transpose(2, 1, 0)
    values = np.linalg.eigvalsh(face.reshape(-1, 6, 6))
    assert (values > -1e-9 * values.max(axis=1, keepdims=True)).all()
    assert (values[:, 3] > 0).all()  # moves of the plane cost nothing, all others do


def projected(v, f, x):
    """Areas of image over source, and Dirichlet energies over image areas, by flat triangles in other coordinates."""
    ratios, stretch = [], []
    for corners in f:
        p, q = v[corners], x[corners]
        outward = q.sum(axis=0) / np.linalg.norm(q.sum(axis=0))
        flat = np.eye(3) - np.outer(outward, outward)
        source, image = (
            np.stack((p[1] - p[0], p[2] - p[0])),
            np.stack((q[1] - q[0], q[2] - q[0])) @ flat,
        )
        gram = np.linalg.solve(source @ source.T, image @ image.T)
        ratios.append(np.sqrt(np.linalg.det(gram)))
        stretch.append(np.trace(gram) / 2 / ratios[-1])
    return np.array(ratios), np.array(stretch)


def test_the_energy_is_mips_and_the_area_barrier(map_of_spheroid):
    source, x = map_of_spheroid
    v, f = ism.samples.make("spheroid", n_vertices=200)
    J, conformal = projected(v, f, x)
    J *= (
        np.linalg.norm(np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]]), axis=1).sum()
        / 2
        / (4 * np.pi)
    )
    none = np.zeros(len(source.f))
    assert np.allclose(np.exp(log_areas(source, x)), J)
    assert np.allclose(
        BalancedEnergy(source, 0.0, 1, none).by_face(x), source.area * 2 * (conformal - 1)
    )
    assert np.allclose(
        BalancedEnergy(source, 1.0, 1, none).by_face(x), source.area * (J + 1 / J - 2)
    )


def test_it_is_an_energy_of_maps_whose_derivatives_by_the_coordinates_are_those_of_differences(
    map_of_spheroid,
):
    source, x = map_of_spheroid
    energy = BalancedEnergy(source, 0.6, 1, np.random.default_rng(0).normal(size=len(source.f)))
    value, gradient = energy.evaluate(x)
    move = np.random.default_rng(5).normal(size=x.shape)
    h = 1e-6
    ahead, behind = (energy.evaluate(x + sign * h * move)[0] for sign in (1, -1))
    assert value == energy.by_face(x).sum()
    assert (gradient * move).sum() == pytest.approx((ahead - behind) / (2 * h), rel=1e-7)


def test_an_isometry_has_energy_zero_and_a_fold_infinite_energy():
    x, f = ism.samples.sphere(162)
    source = FlatFaces.of(x, f)
    exact = BalancedEnergy(source, 0.5, 1, log_areas(source, x))
    assert exact.by_face(x).sum() < 1e-4  # what the projection leaves of a sphere's own faces
    folded = x.copy()
    folded[0] = -x[0]
    assert np.isinf(exact.by_face(folded)[(f == 0).any(axis=1)]).all()
