"""Maps to the plane: their energies' derivatives, the circle, and crossings that are refused."""

import numpy as np
import pytest
from disks import polar

import igl_spheremap as ism
from igl_spheremap.balance.energy import BalancedEnergy
from igl_spheremap.balance.flat_faces import FlatFaces
from igl_spheremap.plane.problem import CircleProblem, FreeProblem

P, F = polar(4)
RNG = np.random.default_rng(3)
DISK = ism.check_disk(np.column_stack((P, 0.3 * np.sin(3 * P[:, 0]))), F)
SOURCE = FlatFaces.of(DISK.unit, DISK.f)
X = 2 * P + 0.02 * RNG.standard_normal(P.shape)


def energies():
    for power in (0, 0.9):
        yield BalancedEnergy(SOURCE, 0.6, power, np.full(len(F), 0.1))


@pytest.mark.parametrize("energy", list(energies()), ids=lambda energy: str(energy.power))
def test_the_gradient_is_the_first_variation(energy):
    axes = RNG.standard_normal((2, 2, len(P)))
    gradient, _ = energy.derivatives(X, axes)
    for _ in range(3):
        step = RNG.standard_normal((2, len(P)))
        move, h = np.einsum("an,ain->ni", step, axes), 1e-6
        slope = (energy.by_face(X + h * move).sum() - energy.by_face(X - h * move).sum()) / (2 * h)
        assert slope == pytest.approx((gradient * step).sum(), rel=1e-5)


def test_parts_that_a_step_brings_together_have_the_speed_of_their_distance():
    # a square with a narrow slit from above, whose banks a step closes
    d = 1e-4
    p = np.array(
        [[0, 0], [4, 0], [4, 4], [2 + d, 4], [2 + d, 1], [2 - d, 1], [2 - d, 4], [0, 4]], float
    )
    f = np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [0, 4, 5], [0, 5, 7], [5, 6, 7]])
    disk = ism.check_disk(np.column_stack((p, np.zeros(8))), f)
    energy = BalancedEnergy(FlatFaces.of(disk.unit, f), 0.5, 0.9, np.zeros(6))
    problem = FreeProblem(energy, disk)
    move = np.zeros((8, 2))
    move[[3, 6], 0] = -0.3, 0.3
    apart = problem.accept(p, move).apart
    speeds = np.einsum("kan,na->k", apart, move)
    assert (speeds < 0).all()
    assert speeds.min() == pytest.approx(-0.6)  # of the upper corners
    # what moves all alike brings nothing nearer, and what opens the slit meets nothing
    assert np.abs(apart.sum(axis=2)).max() < 1e-12
    assert problem.accept(p, -move).apart is None


def test_boundary_vertices_move_along_the_circle_and_crossings_are_refused():
    energy = BalancedEnergy(SOURCE, 0.0, 0.9, np.zeros(len(F)))
    problem = CircleProblem(energy, DISK)
    x = 2 * P
    model = problem.model(x)
    move = problem.move(x, model, RNG.standard_normal((2, len(P))))
    rim = DISK.rim
    assert np.abs((move[rim] * x[rim]).sum(axis=1)).max() < 1e-12
    assert np.abs(np.hypot(*problem.onto(x + move, slice(None))[rim].T) - 2).max() < 1e-12
    free = FreeProblem(energy, DISK)
    y = x.copy()
    y[rim[0]] = -1.5 * x[rim[0]]  # a spike across the disk
    assert free.folded(y, slice(None)).sum() > problem.folded(y, slice(None)).sum()
    trial = free.accept(x, y - x)
    assert ism.certify(trial.x, F)
