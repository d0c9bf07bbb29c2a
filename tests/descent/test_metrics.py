"""Metrics: each gradient is dual to the derivative, and what their eigenvalues are on the sphere."""

from dataclasses import replace

import numpy as np
import pytest
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap.descent.algorithm_1 import CayleyBB
from igl_spheremap.descent.gu_yau import step_metric
from igl_spheremap.descent.metrics import Diagonal, SobolevH1, SobolevH2
from igl_spheremap.descent.minimize import minimize
from igl_spheremap.descent.preconditioned import PreconditionedCayley
from igl_spheremap.descent.problem import harmonic_problem
from igl_spheremap.operators.laplacian import build_operators
from igl_spheremap.sphere.rows import tangent, unit_rows

X, F = icosphere(3)
MESH = ism.check_mesh(X * [1, 1.3, 2], F)
PROBLEM = harmonic_problem(MESH)
START = ism.gauss_map(MESH.vertices, F)


def metrics(mesh, x):
    problem, operators = harmonic_problem(mesh), build_operators(mesh)
    return {
        "L2": Diagonal(problem.A),
        "row bounds": step_metric(problem.energy.L),
        "H1": SobolevH1(operators.factor, operators.L),
        "H2": SobolevH2.of(problem.energy.L, mesh.f, x),
    }


METRICS = metrics(MESH, X)


@pytest.mark.parametrize("name", METRICS)
def test_solve_inverts_the_inner_product(name):
    """inner(solve(covector), field) is the covector's value on any field."""
    covector, field = np.random.default_rng(1).normal(size=(2, *X.shape))
    covector -= covector.mean(axis=0)  # P is all but singular on constants
    metric = METRICS[name]
    assert np.isclose(metric.inner(metric.solve(covector), field), np.vdot(covector, field), rtol=1e-6)
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
    expected = minimize(PreconditionedCayley().iterates(replace(PROBLEM, metric=METRICS["H1"]), START),
                        tolerance=1e-9, max_iterations=50)
    found = minimize(CayleyBB().iterates(replace(PROBLEM, metric=METRICS[name]), START),
                     tolerance=1e-6, max_iterations=2000, plateau=1e-12)
    assert np.isclose(found.last.energy, expected.last.energy, rtol=1e-8)


def test_spherical_harmonics_have_the_eigenvalues_of_h2():
    x, f = icosphere(4)
    metric = metrics(ism.check_mesh(x, f), x)["H2"]
    z = x[:, 2]
    for degree, y in ((0, np.ones(len(x))), (1, z), (2, 3 * z**2 - 1)):
        y = np.column_stack((y, y, y))
        ratio = metric.inner(y, y) / (metric.B @ (y**2).sum(axis=1))
        assert np.isclose(ratio, (degree * (degree + 1) + 1) ** 2, rtol=2e-2)
