"""Problems: the gradient along the sphere, the gauge, the areas that it balances, and the metrics."""

from dataclasses import replace

import igl
import numpy as np
import pytest
from triangulations import icosphere, wild

import igl_spheremap as ism
from igl_spheremap.descent.energies import HarmonicEnergy
from igl_spheremap.descent.minimize import minimize
from igl_spheremap.descent.preconditioned import harmonic_map
from igl_spheremap.descent.problem import (
    Diagonal,
    Problem,
    SobolevH1,
    SobolevH2,
    l2_metric,
    laplacian_metric,
    remove_boosts,
)
from igl_spheremap.mesh.measure import vertex_areas
from igl_spheremap.operators.laplacian import build_operators
from igl_spheremap.paper.algorithm_1 import cayley_bb
from igl_spheremap.paper.hooks import Hooks
from igl_spheremap.result.run import Stage
from igl_spheremap.sphere.moebius import center
from igl_spheremap.sphere.rows import tangent, unit_rows

X, F = icosphere(3)
V = X * [1, 1.3, 2]
MESH = ism.check_mesh(V, F)
PROBLEM = Problem.of(MESH, HarmonicEnergy.of(MESH), l2_metric(MESH))


@pytest.mark.parametrize("gauge", [True, False])
def test_gradient_is_the_derivative_along_the_sphere(gauge):
    x = wild(X)
    problem = replace(PROBLEM, fixes_gauge=gauge)
    direction = tangent(x, np.random.default_rng(1).normal(size=x.shape))
    if gauge:
        direction = remove_boosts(x, direction, PROBLEM.A)
    _, gradient = problem.evaluate(x)
    h = 1e-6
    values = [problem.evaluate(ism.cayley_update(x, -direction, s))[0] for s in (h, -h)]
    assert np.isclose(
        (values[0] - values[1]) / (2 * h), problem.metric.inner(gradient, direction), rtol=1e-6
    )


def test_gradient_has_neither_radial_part_nor_boost_nor_rotation():
    x = center(wild(X), PROBLEM.A)
    _, gradient = PROBLEM.evaluate(x)
    assert np.abs((gradient * x).sum(axis=1)).max() < 1e-9 * np.abs(gradient).max()
    for e in np.eye(3):
        assert abs(PROBLEM.metric.inner(gradient, tangent(x, np.tile(e, (len(x), 1))))) < 1e-9
        assert abs(PROBLEM.metric.inner(gradient, np.cross(e, x))) < 1e-9


def test_areas_are_libigls_mass_and_never_vanish():
    mass = igl.massmatrix(MESH.unit, F, igl.MASSMATRIX_TYPE_BARYCENTRIC).diagonal()
    assert np.allclose(PROBLEM.A, mass)  # eq. (13)
    flat = V.copy()
    flat[F[0]] = flat[F[0, 0]]
    assert ism.check_mesh(flat, F).A.min() > 0


START = ism.gauss_map(MESH.v, F)


def metrics(mesh, x):
    energy, operators = HarmonicEnergy.of(mesh), build_operators(mesh)
    return {
        "L2": l2_metric(mesh),
        "row bounds": laplacian_metric(energy.L),
        "H1": SobolevH1(operators.factor, operators.L),
        "H2": SobolevH2.of(energy.L, mesh.f, x),
    }


METRICS = metrics(MESH, X)


@pytest.mark.parametrize("name", METRICS)
def test_solve_inverts_the_inner_product(name):
    """inner(solve(covector), field) is the covector's value on any field."""
    covector, field = np.random.default_rng(1).normal(size=(2, *X.shape))
    covector -= covector.mean(axis=0)  # P is all but singular on constants
    metric = METRICS[name]
    assert np.isclose(
        metric.inner(metric.solve(covector), field), np.vdot(covector, field), rtol=1e-6
    )
    assert np.isclose(metric.inner(covector, field), metric.inner(field, covector))
    assert metric.inner(field, field) > 0


@pytest.mark.parametrize("name", METRICS)
def test_gradients_are_tangent_and_point_uphill(name):
    x = unit_rows(X + 0.3 * np.random.default_rng(0).normal(size=X.shape))
    _, derivative = PROBLEM.energy.evaluate(x)
    gradient = METRICS[name].gradient(x, derivative)
    assert np.abs((gradient * x).sum(axis=1)).max() < 1e-12 * np.abs(gradient).max()
    assert np.vdot(tangent(x, derivative), gradient) > 0


@pytest.mark.parametrize("name", METRICS)
def test_algorithm_1_finds_one_minimum_in_every_metric(name):
    expected, _ = harmonic_map(
        MESH, build_operators(MESH), START, tolerance=1e-9, max_iterations=50
    )
    problem = replace(PROBLEM, metric=METRICS[name])
    rules = {"tolerance": 1e-6, "max_iterations": 2000, "plateau": 1e-12}
    found, _ = minimize(cayley_bb(problem, START, Hooks()), Stage.ALGORITHM_1, **rules)
    assert np.isclose(found.energy, expected.energy, rtol=1e-8)


def test_spherical_harmonics_have_the_eigenvalues_of_h2():
    x, f = icosphere(4)
    metric = metrics(ism.check_mesh(x, f), x)["H2"]
    z = x[:, 2]
    for degree, y in ((0, np.ones(len(x))), (1, z), (2, 3 * z**2 - 1)):
        y = np.column_stack((y, y, y))
        ratio = metric.inner(y, y) / (metric.B @ (y**2).sum(axis=1))
        assert np.isclose(ratio, (degree * (degree + 1) + 1) ** 2, rtol=2e-2)


@pytest.mark.parametrize("share", [None, np.random.default_rng(3).uniform(0.1, 9, len(X))])
def test_what_boosts_take_out_is_a_boost_and_what_is_left_moves_no_mean(share):
    """In a diagonal metric boosts are multiplied by its share of the L2 metric; they are taken out whole."""
    x, A = wild(X), PROBLEM.A
    t = tangent(x, np.random.default_rng(1).normal(size=x.shape))
    left = remove_boosts(x, t, A, share)
    assert np.abs(A @ left).max() < 1e-9 * np.abs(A @ t).max()
    times = np.ones(len(x)) if share is None else share
    boosts = [times[:, None] * tangent(x, np.tile(e, (len(x), 1))) for e in np.eye(3)]
    basis = np.stack(boosts).reshape(3, -1).T
    taken = (t - left).ravel()
    assert np.abs(basis @ np.linalg.lstsq(basis, taken, rcond=None)[0] - taken).max() < 1e-9
    assert np.abs(remove_boosts(x, boosts[1], A, share)).max() < 1e-9


def test_the_gauge_centres_a_map_that_is_off_by_more_than_allowed():
    x, A = wild(X), PROBLEM.A
    off = float(np.linalg.norm(A @ x))
    assert off > 1e-4
    assert np.linalg.norm(A @ PROBLEM.centred(x)) < 1e-9
    assert np.linalg.norm(A @ PROBLEM.centred(x, 0.99 * off)) < 1e-9
    assert PROBLEM.centred(x, 1.01 * off) is x
    assert replace(PROBLEM, fixes_gauge=False).centred(x) is x


def test_runs_in_all_diagonal_metrics_of_areas_end_by_one_norm():
    """That of A F in the L2 metric, of whatever map and derivatives."""
    x, rng = wild(X), np.random.default_rng(0)
    derivative, A = rng.normal(size=x.shape), vertex_areas(MESH.unit, F)
    L2, other = Diagonal(A), Diagonal(rng.uniform(0.1, 9, len(x)), A)
    expected = L2.residual(L2.gradient(x, derivative))
    assert expected == pytest.approx(np.sqrt((tangent(x, derivative) ** 2).sum(axis=1) @ (1 / A)))
    assert other.residual(other.gradient(x, derivative)) == pytest.approx(expected)
