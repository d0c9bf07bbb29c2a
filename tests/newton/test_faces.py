"""Sums over faces: steps keep every exact sign, gradients are first variations."""

from itertools import islice

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.balance.energy import BalancedEnergy
from igl_spheremap.balance.flat_faces import FlatFaces
from igl_spheremap.newton.faces import FaceProblem
from igl_spheremap.newton.loop import LineSearch, newton
from igl_spheremap.newton.system import VertexSystem
from igl_spheremap.sphere.rows import tangent_axes, unit_rows
from igl_spheremap.verify.certificate import Certificate
from igl_spheremap.verify.signs import orientation_signs


def sphere_energy(n=642, weight=0.5, spread=0.0):
    x, f = ism.samples.sphere(n)
    source = FlatFaces.of(x, f)
    target = spread * np.random.default_rng(0).normal(size=len(f))
    return BalancedEnergy(source, weight, 1, target), x


def test_one_vertex_that_would_fold_is_held_and_all_others_stay():
    energy, x = sphere_energy(spread=0.5)
    move = np.zeros_like(x)
    move[300] = 0.5 * tangent_axes(x[[300]])[0][0]  # through several faces
    problem = FaceProblem(energy)
    y, value, folded, _ = problem.accept(x, move)
    assert (orientation_signs(y, energy.source.f) > 0).all()
    assert value == energy.by_face(y).sum()
    assert (energy.source.f[folded] == 300).any(axis=1).all()
    assert folded.any()
    assert 0 < np.abs(y[300] - x[300]).max() < 0.1
    assert np.abs(np.delete(y - x, 300, axis=0)).max() < 1e-15


class Bumps:
    """One a face, and the sum of its corners' distances from where they were, each times a number."""

    def __init__(self, f, x, rise):
        self.f, self.area, self.origin, self.rise = f, np.ones(len(f)), x, rise

    def by_face(self, x, faces=slice(None)):
        off = np.linalg.norm(x - self.origin, axis=1) * self.rise
        return 1 + off[self.f[faces]].sum(axis=1)


def test_a_face_whose_energy_grows_a_little_moves_as_asked_and_one_whose_grows_much_by_less():
    """Whatever moves besides: each face is judged by itself."""
    x, f = ism.samples.sphere(642)
    everywhere = 1e-3 * np.random.default_rng(0).normal(size=x.shape)
    there = (f == 300).any(axis=1)
    for rise, most in ((1e3, 40.0), (1e4, 40.0), (1.0, np.inf)):
        rises = np.ones(len(x))
        rises[300] = rise
        energy, move = Bumps(f, x, rises), everywhere.copy()
        move[300] = 0.05 * tangent_axes(x[[300]])[0][0]
        y, value, folded, _ = FaceProblem(energy).accept(x, move)
        whole = unit_rows(x + move)
        far = np.setdiff1d(np.arange(len(x)), f[there])
        assert np.array_equal(y[far], whole[far])
        assert not folded.any()
        assert value == energy.by_face(y).sum()
        assert np.array_equal(y[300], whole[300]) == (rise == 1.0)
        assert 1 < energy.by_face(y)[there].max() <= most
        halvings = np.log2(0.05 / np.tan(np.arccos(y[300] @ x[300])))
        assert halvings == pytest.approx(round(halvings), abs=1e-6)
        assert np.allclose(y[300], unit_rows(x[[300]] + move[[300]] / 2 ** round(halvings))[0])
        slack = np.where(there, 1e5, 0.0)
        assert np.array_equal(FaceProblem(energy, slack=slack).accept(x, move).x, whole)


def test_a_step_that_most_faces_refuse_is_given_up_at_its_length():
    """A map of no face that could move has an infinite value, and says which faces the step itself would fold."""
    x, f = ism.samples.sphere(642)
    energy = Bumps(f, x, np.full(len(x), 1e9))
    move = 0.01 * np.random.default_rng(0).normal(size=x.shape)
    y, value, folded, _ = FaceProblem(energy).accept(x, move)
    assert y is x
    assert value == np.inf
    assert not folded.any()
    wild = FaceProblem(energy).accept(x, 100 * move)
    assert np.array_equal(wild.folded, orientation_signs(unit_rows(x + 100 * move), f) <= 0)


def test_vertices_that_are_held_stay_bit_for_bit():
    energy, x = sphere_energy(spread=1.5)
    held = x[:, 2] > 0.3
    search = LineSearch(VertexSystem(energy.f, len(x)))
    trials = list(islice(newton(FaceProblem(energy, held=held), search, x), 3))
    assert all(np.array_equal(trial.x[held], x[held]) for trial in trials)
    assert np.abs(trials[-1].x - x)[~held].max() > 1e-3
    assert trials[-1].value < energy.by_face(x).sum()


def test_no_random_step_folds_a_face():
    energy, x = sphere_energy(spread=0.5)
    found = [
        FaceProblem(energy).accept(x, size * np.random.default_rng(3).normal(size=x.shape))
        for size in (0.01, 0.1, 1.0, 10.0)
    ]
    accepted = [trial.x for trial in found if np.isfinite(trial.value)]
    assert len(accepted) >= 2
    assert all((orientation_signs(y, energy.source.f) > 0).all() for y in accepted)


def search(energy, x, backend="auto"):
    return newton(
        FaceProblem(energy, turns=False), LineSearch(VertexSystem(energy.f, len(x), backend)), x
    )


def test_every_iterate_towards_random_areas_is_a_bijection_of_less_energy():
    energy, x = sphere_energy(spread=1.5)
    trials = list(islice(search(energy, x), 8))
    assert len(trials) > 3
    assert all(Certificate.of(trial.x, energy.f).folding_free for trial in trials)
    assert (np.diff([energy.by_face(x).sum(), *(trial.value for trial in trials)]) < 0).all()


def test_a_start_a_few_ulps_from_folding_comes_back_through_bijections():
    """Vertex 300 is pushed to the opposite side of its star; at the last ulp rounding decides if a step is found."""
    energy, x = sphere_energy()
    f = energy.f
    star = f[(f == 300).any(axis=1)]
    towards, lowest, highest = x[star[star != 300]][0] - x[300], 0.0, 1.0
    for _ in range(60):
        middle = (lowest + highest) / 2
        y = x.copy()
        y[300] = unit_rows((x[300] + middle * towards)[None])[0]
        lowest, highest = (
            (middle, highest) if (orientation_signs(y, star) > 0).all() else (lowest, middle)
        )
    y[300] = unit_rows((x[300] + (1 - 1e-15) * lowest * towards)[None])[0]
    assert energy.by_face(y).max() > 1e10
    trials = list(islice(search(energy, y), 60))
    assert all((orientation_signs(trial.x, f) > 0).all() for trial in trials)
    assert trials[-1].value < 1e-3 * energy.by_face(y).sum()


def test_no_step_turns_the_sphere():
    energy, x = sphere_energy(spread=0.5)
    moved = next(search(energy, x)).x
    assert np.abs(moved - x).max() > 0.01
    assert (
        np.abs(np.cross(x, moved - x).sum(axis=0)).max()
        < 0.01 * np.abs(np.cross(x, moved - x)).sum()
    )


def test_backends_agree():
    energy, x = sphere_energy(spread=0.5)
    ends = [list(islice(search(energy, x, backend), 3))[-1].x for backend in ("auto", "scipy")]
    assert np.abs(ends[0] - ends[1]).max() < 1e-7


class Pull:
    """Squares of the distances to given points, a term of each vertex alone."""

    def __init__(self, points):
        self.points = points

    def value(self, x):
        return 0.5 * ((x - self.points) ** 2).sum()

    def derivatives(self, x, axes):
        slope = np.einsum("ain,ni->an", axes, x - self.points)
        return slope, np.einsum("ain,bin->abn", axes, axes)


def test_the_gradient_of_a_sum_is_its_first_variation():
    energy, x = sphere_energy(spread=0.5)
    problem = FaceProblem(energy, (Pull(np.roll(x, 1, axis=0)),))
    model = problem.model(x)
    step, h = np.random.default_rng(2).normal(size=(2, len(x))), 1e-6
    move = np.einsum("an,ain->ni", step, model.axes)
    ahead, behind = (problem.value(unit_rows(x + sign * h * move)) for sign in (1, -1))
    assert model.value == problem.value(x)
    assert np.isclose((model.gradient * step).sum(), (ahead - behind) / (2 * h), rtol=1e-6)


def test_a_term_at_the_vertices_pulls_the_map_as_far_as_the_energy_lets_it():
    energy, x = sphere_energy()
    a = 0.1
    R = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
    problem = FaceProblem(energy, (Pull(x @ R.T),), slack=energy.area)
    *_, last = newton(problem, LineSearch(VertexSystem(energy.f, len(x))), x)
    assert np.abs(last.x - x @ R.T).max() < 1e-3  # a rotation costs no strain
