"""Steps keep every exact sign."""

import numpy as np

import igl_spheremap as ism
from igl_spheremap.balance.energy import Energy
from igl_spheremap.balance.newton import newton
from igl_spheremap.balance.newton_system import NewtonSystem
from igl_spheremap.balance.source import lay_flat
from igl_spheremap.balance.step import certified_step
from igl_spheremap.verify.certificate import Certificate, orientation_signs


def sphere_energy(n=642, weight=0.5, spread=0.0):
    x, f = ism.samples.sphere(n)
    source = lay_flat(x, f)
    target = spread * np.random.default_rng(0).normal(size=len(f))
    return Energy(source, weight, 1, target), x


def test_one_vertex_that_would_fold_is_held_and_all_others_stay():
    energy, x = sphere_energy(spread=0.5)
    move = np.zeros_like(x)
    move[300] = 0.5 * x[100]  # through several faces
    y, after = certified_step(energy, x, move, energy.by_face(x))
    assert (orientation_signs(y, energy.source.f) > 0).all()
    assert np.array_equal(after, energy.by_face(y))
    assert 0 < np.abs(y[300] - x[300]).max() < 0.1
    assert np.abs(np.delete(y - x, 300, axis=0)).max() < 1e-15


def test_no_random_step_folds_a_face():
    energy, x = sphere_energy(spread=0.5)
    before = energy.by_face(x)
    found = [certified_step(energy, x, size * np.random.default_rng(3).normal(size=x.shape), before)
             for size in (0.01, 0.1, 1.0, 10.0)]
    accepted = [step[0] for step in found if step is not None]
    assert len(accepted) >= 2
    assert all((orientation_signs(y, energy.source.f) > 0).all() for y in accepted)


def test_every_iterate_towards_random_areas_is_a_bijection_of_less_energy():
    energy, x = sphere_energy(spread=1.5)
    iterates = []
    for iterate in newton(energy, NewtonSystem(energy.source.f, len(x)), x, "balance"):
        iterates.append(iterate)
        if len(iterates) == 8:
            break
    assert len(iterates) > 3
    assert all(Certificate.of(i.x, energy.source.f).folding_free for i in iterates)
    assert (np.diff([i.energy for i in iterates]) < 0).all()


def test_no_step_turns_the_sphere():
    energy, x = sphere_energy(spread=0.5)
    steps = newton(energy, NewtonSystem(energy.source.f, len(x)), x, "balance")
    moved = [next(steps) for _ in range(2)][-1].x
    assert np.abs(moved - x).max() > 0.01
    assert np.abs(np.cross(x, moved - x).sum(axis=0)).max() < 0.01 * np.abs(np.cross(x, moved - x)).sum()


def test_backends_agree():
    energy, x = sphere_energy(spread=0.5)
    ends = []
    for backend in ("auto", "scipy"):
        steps = newton(energy, NewtonSystem(energy.source.f, len(x), backend), x, "balance")
        ends.append([next(steps) for _ in range(4)][-1].x)
    assert np.abs(ends[0] - ends[1]).max() < 1e-7
