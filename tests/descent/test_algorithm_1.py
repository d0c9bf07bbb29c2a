"""Algorithm 1 as it runs: descent, the rule of the search, steps, and what is kept; and so for Gu and Yau's descent."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from triangulations import icosphere, wild

import igl_spheremap as ism
from igl_spheremap.descent.algorithm_1 import CayleyBB, ProjectedDescent, step_metric
from igl_spheremap.descent.minimize import minimize
from igl_spheremap.descent.problem import harmonic_problem
from igl_spheremap.mesh.measure import vertex_normals
from igl_spheremap.sphere.rows import unit_rows

X, F = icosphere(3)
MESH = ism.check_mesh(X * [1, 1.2, 1.6], F)
PROBLEM = harmonic_problem(MESH)
START = vertex_normals(MESH.unit, MESH.f)


def run(solver=None, problem=PROBLEM, x=START, **options):
    options = {"tolerance": 1e-5, "max_iterations": 3000} | options
    return minimize((solver or CayleyBB()).iterates(problem, x), **options)


@pytest.mark.parametrize("bb", ["alternating", "tau_1", "tau_2"])
def test_every_barzilai_borwein_choice_reaches_the_same_minimum(bb):
    minimum = run(CayleyBB(bb=bb))
    assert minimum.status is ism.Status.CONVERGED
    assert np.isclose(minimum.last.energy, run().last.energy, rtol=1e-9)


def test_iterates_stay_on_the_sphere_and_obey_the_search():
    seen = []
    run(listener=seen.append, max_iterations=60)
    assert [it.iteration for it in seen] == list(range(61))
    C, Q = seen[0].energy, 1.0
    for before, after in pairwise(seen):
        assert np.abs(np.linalg.norm(after.x, axis=1) - 1).max() < 1e-12
        assert after.energy <= C - 1e-4 * after.tau * before.residual**2 + 1e-9  # Algorithm 1, step 3
        Q, last = 0.85 * Q + 1, Q
        C = (0.85 * last * C + after.energy) / Q


def test_steps_are_the_quotients_of_eq_12_times_a_power_of_delta():
    seen = []
    problem = replace(PROBLEM, gauge=False)  # re-centring moves the map between two steps
    run(CayleyBB(bb="tau_1"), problem, listener=seen.append, max_iterations=30)
    for a, b, c in zip(seen[:-2], seen[1:-1], seen[2:], strict=True):
        D = b.x - a.x
        W = problem.evaluate(b.x)[1] - problem.evaluate(a.x)[1]
        tau_1 = problem.metric.inner(D, D) / abs(problem.metric.inner(D, W))
        power = np.log10(c.tau / tau_1)
        assert abs(power - round(power)) < 1e-5
        assert power < 0.5


def test_gradient_vanishes_at_the_minimum():
    minimum = run()
    assert np.sqrt(PROBLEM.metric.inner(*[PROBLEM.evaluate(minimum.last.x)[1]] * 2)) <= 1e-5
    assert minimum.last.residual <= 1e-5


def test_without_the_gauge_the_map_still_minimises_but_drifts():
    pear = harmonic_problem(ism.check_mesh(*ism.samples.make("pear", n_vertices=600)))
    start = unit_rows(ism.gauss_map(*ism.samples.make("pear", n_vertices=600)))
    free = run(problem=replace(pear, gauge=False), x=start, tolerance=1e-2)
    fixed = run(problem=pear, x=start)
    assert np.linalg.norm(pear.A @ fixed.last.x) < 1e-2 < np.linalg.norm(pear.A @ free.last.x)


def test_a_start_without_foldings_is_kept_so():
    crumpled = unit_rows(X + 0.015 * np.random.default_rng(0).normal(size=X.shape))
    assert ism.certify(crumpled, F).folding_free

    def check(iterate):
        assert ism.certify(iterate.x, F).folding_free

    run(CayleyBB(may_fold=False), x=crumpled, listener=check, max_iterations=100)


def safe(problem):
    """The problem in the metric that its own Laplacian bounds."""
    return replace(problem, metric=step_metric(problem.energy.L))


def test_a_step_of_one_never_raises_the_energy_but_by_centring():
    """Without the gauge's part, each step lowers the energy, from whatever map."""
    metric = step_metric(PROBLEM.energy.L)
    x = wild(X, noise=0.8)
    energies = []
    for _ in range(200):
        energy, derivative = PROBLEM.energy.evaluate(x)
        energies.append(energy)
        x = unit_rows(x - metric.gradient(x, derivative))
    assert (np.diff(energies) < 0).all()


def test_iterates_stay_on_the_sphere_and_keep_their_mass_centre():
    iterates = ProjectedDescent().iterates(safe(PROBLEM), wild(X, noise=0.8))
    for _ in range(30):
        x = next(iterates).x
        assert np.allclose((x**2).sum(axis=1), 1, atol=1e-14)
        assert np.linalg.norm(PROBLEM.A @ x) < 2e-4


def test_a_harmonic_map_is_at_rest():
    """The icosphere's identity is harmonic by symmetry: five solid angles of it do not move."""
    x, f = icosphere(0)
    problem = harmonic_problem(ism.check_mesh(x, f))
    iterates = ProjectedDescent().iterates(safe(problem), unit_rows(x))
    start = next(iterates)
    assert start.residual < 1e-12
    assert np.allclose(next(iterates).x, start.x, atol=1e-12)


def test_it_needs_more_iterations_than_algorithm_1():
    """The paper's Table 2, in kind."""
    counts = [
        minimize(iterates, tolerance=1e-2, max_iterations=5000).last.iteration
        for iterates in (
            ProjectedDescent().iterates(safe(PROBLEM), START),
            CayleyBB().iterates(PROBLEM, START),
        )
    ]
    assert counts[0] > 3 * counts[1]
