"""Gu and Yau's descent: its invariants, its limit, and Algorithm 1 beside it."""

from dataclasses import replace
from itertools import islice

import numpy as np
from triangulations import icosphere, wild

import igl_spheremap as ism
from igl_spheremap.descent.energies import HarmonicEnergy
from igl_spheremap.descent.gu_yau import projected_descent
from igl_spheremap.descent.minimize import minimize
from igl_spheremap.descent.problem import Problem, l2_metric, laplacian_metric
from igl_spheremap.mesh.measure import vertex_normals
from igl_spheremap.paper.algorithm_1 import cayley_bb
from igl_spheremap.paper.hooks import Hooks
from igl_spheremap.result.run import Stage
from igl_spheremap.sphere.rows import unit_rows

X, F = icosphere(3)
MESH = ism.check_mesh(X * [1, 1.2, 1.6], F)
L2 = l2_metric(MESH)
PROBLEM = Problem.of(MESH, HarmonicEnergy.of(MESH), L2)
START = vertex_normals(MESH.unit, MESH.f)


def safe(problem):
    """The problem in the metric that its own Laplacian bounds."""
    return replace(problem, metric=laplacian_metric(problem.energy.L))


def test_a_step_of_one_never_raises_the_energy_but_by_centring():
    """Without the gauge's part, each step lowers the energy, from whatever map."""
    metric = laplacian_metric(PROBLEM.energy.L)
    x = wild(X, noise=0.8)
    energies = []
    for _ in range(200):
        energy, derivative = PROBLEM.energy.evaluate(x)
        energies.append(energy)
        x = unit_rows(x - metric.gradient(x, derivative))
    assert (np.diff(energies) < 0).all()


def test_iterates_stay_on_the_sphere_and_keep_their_mass_centre():
    iterates = projected_descent(safe(PROBLEM), L2, wild(X, noise=0.8))
    for _ in range(30):
        x = next(iterates).x
        assert np.allclose((x**2).sum(axis=1), 1, atol=1e-14)
        assert np.linalg.norm(PROBLEM.A @ x) < 2e-4


def test_a_harmonic_map_is_at_rest():
    """The icosphere's identity is harmonic by symmetry: five solid angles of it do not move."""
    x, f = icosphere(0)
    mesh = ism.check_mesh(x, f)
    problem = Problem.of(mesh, HarmonicEnergy.of(mesh), l2_metric(mesh))
    iterates = projected_descent(safe(problem), l2_metric(mesh), unit_rows(x))
    start = next(iterates)
    assert start.residual < 1e-12
    assert np.allclose(next(iterates).x, start.x, atol=1e-12)


def test_it_needs_more_iterations_than_algorithm_1():
    """The paper's Table 2, in kind."""
    ends = [
        minimize(states, Stage.ALGORITHM_1, tolerance=1e-2, max_iterations=5000)
        for states in (
            projected_descent(safe(PROBLEM), L2, START),
            cayley_bb(PROBLEM, START, Hooks()),
        )
    ]
    assert all(status is ism.Status.CONVERGED for _, status in ends)
    assert ends[0][0].iteration > 3 * ends[1][0].iteration


def test_steps_up_to_2_are_stable_the_longer_the_faster_and_from_there_on_not():
    """Each iterate's step is recorded, none for the start."""

    def energy(step):
        taken = list(islice(projected_descent(safe(PROBLEM), L2, START, step), 60))
        assert [iterate.tau for iterate in taken] == [0.0] + 59 * [step]
        assert [iterate.iteration for iterate in taken] == list(range(60))
        return taken[-1].energy

    own = next(islice(projected_descent(safe(PROBLEM), L2, START), 59, None)).energy
    assert own < energy(1.0) < energy(0.5) < energy(2.5)
