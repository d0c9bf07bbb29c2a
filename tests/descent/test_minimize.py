"""The one loop of minimisation: each way to end, and the rights of listeners."""

import time
from dataclasses import replace
from itertools import islice

import numpy as np
import pytest
from triangulations import icosphere, wild

import igl_spheremap as ism
from igl_spheremap.descent.energies import HarmonicEnergy
from igl_spheremap.descent.minimize import State, minimize, minimize_round
from igl_spheremap.descent.problem import Problem, l2_metric
from igl_spheremap.mesh.measure import vertex_normals
from igl_spheremap.paper.algorithm_1 import cayley_bb
from igl_spheremap.paper.hooks import Hooks
from igl_spheremap.result.run import Stage

X, F = icosphere(3)
MESH = ism.check_mesh(X * [1, 1.2, 1.6], F)
PROBLEM = Problem.of(MESH, HarmonicEnergy.of(MESH), l2_metric(MESH))


def run(problem=PROBLEM, **options):
    options = {"tolerance": 1e-5, "max_iterations": 3000} | options
    states = cayley_bb(problem, vertex_normals(MESH.unit, MESH.f), Hooks())
    return minimize(states, Stage.ALGORITHM_1, **options)


def test_each_way_to_end_has_its_status():
    assert run(max_iterations=3)[1] is ism.Status.MAX_ITERATIONS
    assert run(max_iterations=0)[0].iteration == run(max_iterations=-1)[0].iteration == 0
    assert run(tolerance=0, plateau=1e-6)[1] is ism.Status.PLATEAU

    class Uphill:  # an energy that rises along its own descent direction
        def evaluate(self, x):
            value, gradient = PROBLEM.energy.evaluate(x)
            return value, -gradient

    assert run(problem=replace(PROBLEM, energy=Uphill()))[1] is ism.Status.STALLED

    def stop(iterate):
        if iterate.iteration == 5:
            raise StopIteration

    last, status = run(listener=stop)
    assert status is ism.Status.STOPPED
    assert last.iteration == 5


def test_iterates_can_not_be_changed_by_a_listener():
    def meddle(iterate):
        iterate.x[0] = 0

    with pytest.raises(ValueError, match="read-only"):
        run(listener=meddle)


def falling(by, steps=100_000):
    """States whose energy falls by the same share in each 100 steps, and oscillates above that with period 10."""
    for k in range(steps):
        energy = (1 - by) ** (k / 100) * (1 + 0.3 * (k % 10))
        yield State(k, X, energy, residual=1.0)


@pytest.mark.parametrize("plateau", [1e-6, 1e-3])
def test_a_plateau_is_a_share_of_the_energy_in_a_hundred_steps(plateau):
    def end(share):
        rules = {"tolerance": 0, "max_iterations": 2000, "plateau": plateau}
        return minimize(falling(share * plateau), Stage.ALGORITHM_1, **rules)

    last, status = end(0.9)
    assert status is ism.Status.PLATEAU
    assert 100 < last.iteration < 300
    assert end(1.1)[1] is ism.Status.MAX_ITERATIONS
    still = minimize(falling(0.0), Stage.ALGORITHM_1, tolerance=0, max_iterations=300)
    assert still[1] is ism.Status.MAX_ITERATIONS


def test_a_plateau_after_a_long_fall_is_one():
    """Only the last steps count; the run goes on while they fall, however far."""

    def fall_and_stay():
        for state in falling(0.5, 1000):
            yield state
        for k in range(1000, 3000):
            yield state._replace(iteration=k)

    rules = {"tolerance": 0, "max_iterations": 5000, "plateau": 1e-3}
    last, status = minimize(fall_and_stay(), Stage.ALGORITHM_1, **rules)
    assert status is ism.Status.PLATEAU
    assert 1000 < last.iteration < 1300


def test_a_run_ends_at_its_tolerance_or_where_its_own_rule_says():
    def residuals(**rules):
        states = (
            state._replace(residual=1 / (k + 1)) for k, state in enumerate(islice(falling(0.1), 10))
        )
        last, status = minimize(states, Stage.ALGORITHM_1, max_iterations=100, round=7, **rules)
        assert last.round == 7
        return last.iteration, status

    assert residuals(tolerance=0.25) == (3, ism.Status.CONVERGED)
    assert residuals(tolerance=0, settled=lambda it: it.iteration == 5) == (
        5,
        ism.Status.CONVERGED,
    )
    assert residuals(tolerance=0) == (9, ism.Status.STALLED)


def test_the_record_of_a_run_tells_its_foldings_angles_and_time():
    began, states = time.perf_counter(), cayley_bb(PROBLEM, wild(X), Hooks())
    rules = {"tolerance": 1e-2, "max_iterations": 3000}
    last, record = minimize_round(
        MESH, "wild", wild(X), states, Stage.ALGORITHM_1, round=2, **rules
    )
    assert 0 < record.seconds <= time.perf_counter() - began
    assert record.foldings_before == ism.certify(wild(X), F).foldings > 0
    assert record.foldings_after == ism.certify(last.x, F).foldings
    assert record.status is ism.Status.CONVERGED
    assert (record.round, record.start, record.iterations) == (2, "wild", last.iteration)
    angles = ism.angle_differences(MESH.v, F, last.x)
    assert record.mean_angle_difference == pytest.approx(np.abs(angles).mean())


@pytest.mark.parametrize("stops", [False, True])
def test_a_map_of_degree_0_has_collapsed_unless_it_was_stopped(stops):
    def listener(iterate):
        if stops:
            raise StopIteration

    flat = X * [1, 1, 0] + [0, 0, 1e-9]
    rules = {"tolerance": 1.0, "max_iterations": 3, "listener": listener}
    states = iter([State(0, flat, 1.0, 0.5)])
    _, record = minimize_round(MESH, "flat", flat, states, Stage.ALGORITHM_1, **rules)
    assert record.status is (ism.Status.STOPPED if stops else ism.Status.COLLAPSED)
