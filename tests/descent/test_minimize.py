"""The one loop of minimisation: each way to end, and what listeners may do."""

from dataclasses import replace

import pytest
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap.descent.energies import HarmonicEnergy
from igl_spheremap.descent.minimize import State, minimize
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
