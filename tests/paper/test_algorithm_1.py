"""Algorithm 1 as it runs: descent, the rule of the search, steps, and invariants."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap.descent.energies import HarmonicEnergy
from igl_spheremap.descent.line_search import NonmonotoneSearch
from igl_spheremap.descent.minimize import minimize
from igl_spheremap.descent.problem import Problem, l2_metric
from igl_spheremap.maps.safeguards import Confined
from igl_spheremap.mesh.measure import vertex_normals
from igl_spheremap.paper.algorithm_1 import cayley_bb
from igl_spheremap.paper.hooks import Hooks
from igl_spheremap.result.run import Stage
from igl_spheremap.sphere.rows import unit_rows

X, F = icosphere(3)
MESH = ism.check_mesh(X * [1, 1.2, 1.6], F)
PROBLEM = Problem.of(MESH, HarmonicEnergy.of(MESH), l2_metric(MESH))
START = vertex_normals(MESH.unit, MESH.f)
METHOD = ism.Lai2014()


def run(problem=PROBLEM, x=START, hooks=None, method=METHOD, **options):
    options = {"tolerance": 1e-5, "max_iterations": 3000} | options
    hooks = Hooks() if hooks is None else hooks
    return minimize(cayley_bb(problem, x, hooks, method), Stage.ALGORITHM_1, **options)


@pytest.mark.parametrize("bb", ["tau_1 first", "tau_2 first", "tau_1", "tau_2"])
def test_every_barzilai_borwein_choice_reaches_the_same_minimum(bb):
    last, status = run(method=ism.Lai2014(bb=bb))
    assert status is ism.Status.CONVERGED
    assert np.isclose(last.energy, run()[0].energy, rtol=1e-9)


def test_iterates_stay_on_the_sphere_and_obey_the_search():
    seen = []
    run(listener=seen.append, max_iterations=60)
    assert [it.iteration for it in seen] == list(range(61))
    C, Q = seen[0].energy, 1.0
    for before, after in pairwise(seen):
        assert np.abs(np.linalg.norm(after.x, axis=1) - 1).max() < 1e-12
        # Algorithm 1, step 3
        assert after.energy <= C - 1e-4 * after.tau * before.residual**2 + 1e-9
        Q, last = 0.85 * Q + 1, Q
        C = (0.85 * last * C + after.energy) / Q


def test_steps_are_the_quotients_of_eq_12_times_a_power_of_delta():
    seen = []
    problem = replace(PROBLEM, fixes_gauge=False)  # re-centring moves the map between two steps
    run(problem, method=ism.Lai2014(bb="tau_1"), listener=seen.append, max_iterations=30)
    for a, b, c in zip(seen[:-2], seen[1:-1], seen[2:], strict=True):
        D = b.x - a.x
        W = problem.evaluate(b.x)[1] - problem.evaluate(a.x)[1]
        tau_1 = problem.metric.inner(D, D) / abs(problem.metric.inner(D, W))
        power = np.log10(c.tau / tau_1)
        assert abs(power - round(power)) < 1e-5
        assert power < 0.5


def test_the_slope_of_the_search_is_the_derivative_along_the_path():
    """E'(Y(0)) of step 3, by differences of the energy along the Cayley path."""
    slopes = []

    class Noted(NonmonotoneSearch):
        def accepts(self, energy, tau, slope):
            slopes.append(slope)
            return True

    class Noting(Hooks):
        def search(self, *options):
            return Noted(*options)

    first = replace(PROBLEM, fixes_gauge=False)
    run(problem=first, hooks=Noting(), max_iterations=1)
    h, gradient = 1e-6, first.evaluate(START)[1]
    ahead, behind = (first.evaluate(ism.cayley_update(START, gradient, s))[0] for s in (h, -h))
    assert slopes[0] == pytest.approx((ahead - behind) / (2 * h), rel=1e-6)
    assert slopes[0] < 0


@pytest.mark.parametrize("faces", [[], [0], [0, 100]], ids=len)
def test_a_star_map_is_made_while_a_single_folding_is_left(faces):
    """A corner that has moved across the side opposite to it folds its face alone."""
    start = X.copy()
    for i, j, k in F[faces]:
        start[i] = X[j] + X[k] - X[i] / 50
    method = ism.Lai2014.as_printed(max_iterations=0, rounds=1)
    result = ism.algorithm_2(MESH.v, F, start=start, method=method)
    assert result.rounds[0].foldings_after == len(faces)
    assert len(result.rounds) == 1 + (len(faces) > 0)


def test_gradient_vanishes_at_the_minimum():
    last, _ = run()
    assert np.sqrt(PROBLEM.metric.inner(*[PROBLEM.evaluate(last.x)[1]] * 2)) <= 1e-5
    assert last.residual <= 1e-5


def test_without_the_gauge_the_map_still_minimises_but_drifts():
    mesh = ism.check_mesh(*ism.samples.make("pear", n_vertices=600))
    pear = Problem.of(mesh, HarmonicEnergy.of(mesh), l2_metric(mesh))
    start = unit_rows(ism.gauss_map(*ism.samples.make("pear", n_vertices=600)))
    free, _ = run(problem=replace(pear, fixes_gauge=False), x=start, tolerance=1e-2)
    fixed, _ = run(problem=pear, x=start, hooks=Confined(mesh, pear, may_fold=False))
    assert np.linalg.norm(pear.A @ fixed.x) < 1e-2 < np.linalg.norm(pear.A @ free.x)


def test_a_start_without_foldings_is_kept_so():
    crumpled = unit_rows(X + 0.015 * np.random.default_rng(0).normal(size=X.shape))
    assert ism.certify(crumpled, F).folding_free

    def check(iterate):
        assert ism.certify(iterate.x, F).folding_free

    run(
        x=crumpled,
        hooks=Confined(MESH, PROBLEM, may_fold=False),
        listener=check,
        max_iterations=100,
    )
