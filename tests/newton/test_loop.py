"""The loop of Newton steps, on quadratic functions of maps to the plane, whose minima and steps are known exactly."""

from itertools import islice

import numpy as np
import pytest
from triangulations import icosphere

from igl_spheremap.newton.loop import DAMPED, Levenberg, LineSearch, Model, Trial, newton
from igl_spheremap.newton.system import VertexSystem, gram_blocks

X, F = icosphere(1)
N = len(X)


class Bowl:
    """Half the squares of random linear functions of each face's displacement from a random map; moves are recorded."""

    def __init__(self, seed=0):
        rng = np.random.default_rng(seed)
        self.J, self.least = rng.normal(size=(7, 3, 2, len(F))), rng.normal(size=(N, 2))
        self.blocks, self.moves = gram_blocks(self.J, self.J), []

    def rows(self, x):
        return np.einsum("rkam,mka->rm", self.J, (x - self.least)[F])

    def value(self, x):
        return 0.5 * (self.rows(x) ** 2).sum()

    def model(self, x, **conditions):
        gradient = np.zeros((N, 2))
        np.add.at(gradient, F, np.einsum("rkam,rm->mka", self.J, self.rows(x)))
        axes = np.repeat(np.eye(2)[:, :, None], N, axis=2)
        return Model(self.value(x), axes, gradient.T, self.blocks, **conditions)

    def move(self, x, model, step):
        return step.T

    def accept(self, x, move):
        self.moves.append(move)
        return self.judged(x + move, move)

    def judged(self, y, move):
        return Trial(y, self.value(y), np.zeros(len(F), bool))


class Claims(Bowl):
    """Says of each step that it lowers the value by a given share of the slope along it."""

    def __init__(self, share):
        super().__init__()
        self.share = share

    def model(self, x):
        model = super().model(x)
        self.start, self.slope = model, None
        return model

    def judged(self, y, move):
        slope = (self.start.gradient.T * move).sum()
        return Trial(y, self.start.value + self.share * slope, np.zeros(len(F), bool))


class Short(Bowl):
    """Refuses moves that are longer than a share of the way to the minimum."""

    def __init__(self, share):
        super().__init__()
        self.most = share * np.linalg.norm(self.least)

    def judged(self, y, move):
        trial = super().judged(y, move)
        return trial if np.linalg.norm(move) <= self.most else trial._replace(value=np.inf)


class Folds(Bowl):
    """Some faces fold, and the value stays, until their corners move by less than a share of their way."""

    def __init__(self, faces, share, value=np.inf):
        super().__init__()
        self.faces, self.share, self.risen = np.array(faces, dtype=int), share, value

    def judged(self, y, move):
        corners, folded = F[self.faces], np.zeros(len(F), bool)
        sizes = np.linalg.norm(move[corners], axis=(1, 2))
        whole = np.linalg.norm(self.least[corners], axis=(1, 2))
        folded[self.faces] = sizes > self.share * whole
        return Trial(y, self.risen if folded.any() else self.value(y), folded)


class Parts(Bowl):
    """Refuses moves that bring parts together: rows whose product with a move is their speed apart."""

    def __init__(self, *rows):
        super().__init__()
        self.apart = np.array(rows)

    def judged(self, y, move):
        trial = super().judged(y, move)
        if (speeds(self.apart, move) > -1e-6).all():
            return trial
        return trial._replace(value=np.inf, apart=self.apart)


class Stuck(Short):
    """Refuses long moves, whether or not they bring parts together, and names the parts."""

    def __init__(self, share, *rows):
        super().__init__(share)
        self.apart = np.array(rows)

    def judged(self, y, move):
        return super().judged(y, move)._replace(apart=self.apart)


def speeds(rows, move):
    return np.einsum("kan,na->k", rows, move)


def approaching(count, seed=3):
    """Rows of parts that Newton's step of a `Bowl` brings together."""
    rows = np.random.default_rng(seed).normal(size=(count, 2, N))
    return -np.sign(speeds(rows, Bowl().least))[:, None, None] * rows


def levenberg(damping=0.0, systems=100):
    return Levenberg(VertexSystem(F, N), np.full(N, damping), systems)


ZERO = np.zeros((N, 2))


def test_a_quadratic_function_is_minimised_in_one_step_whose_decrease_is_predicted():
    bowl, search = Bowl(), LineSearch(VertexSystem(F, N))
    trial = search.step(bowl, ZERO, bowl.model(ZERO))
    assert np.allclose(trial.x, bowl.least, atol=1e-5)
    assert search.length == 1
    assert np.isclose(search.predicted, bowl.value(ZERO), rtol=1e-6)


def test_levenbergs_step_without_damping_is_newtons():
    bowl = Bowl()
    trial = levenberg().step(bowl, ZERO, bowl.model(ZERO))
    assert np.allclose(trial.x, bowl.least, atol=1e-5)


def test_a_step_under_conditions_is_that_of_the_whole_system():
    """Stationary where the conditions leave it free, and on them, as a dense solution of all unknowns says."""
    bowl, rng = Bowl(), np.random.default_rng(1)
    C, c = rng.normal(size=(3, 2, N)), rng.normal(size=3)
    trial = levenberg().step(bowl, ZERO, bowl.model(ZERO, border=(C, c)))
    assert np.allclose(np.einsum("ian,na->i", C, trial.x), c, atol=1e-8)
    dense = np.zeros((7 * len(F), 2 * N))
    for k, face in enumerate(F):
        for i, vertex in enumerate(face):
            dense[7 * k : 7 * k + 7, 2 * vertex : 2 * vertex + 2] += bowl.J[:, i, :, k]
    across = C.transpose(0, 2, 1).reshape(3, -1)
    whole = np.block([[dense.T @ dense, across.T], [across, np.zeros((3, 3))]])
    right = np.concatenate((dense.T @ dense @ bowl.least.ravel(), c))
    assert np.allclose(trial.x.ravel(), np.linalg.solve(whole, right)[: 2 * N], atol=1e-6)


@pytest.mark.parametrize("halvings", [0, 1, 3, 9])
def test_steps_are_halved_until_they_are_accepted_and_the_next_is_tried_at_twice_that(halvings):
    problem, search = Short(1.001 / 2**halvings), LineSearch(VertexSystem(F, N))
    trial = search.step(problem, ZERO, problem.model(ZERO))
    assert search.length == 2.0**-halvings
    assert np.allclose(trial.x, problem.least * search.length, atol=1e-5)
    sizes = np.linalg.norm(problem.moves, axis=(1, 2))
    assert np.allclose(sizes[1:] / sizes[:-1], 0.5)
    problem.moves.clear()
    search.step(problem, ZERO, problem.model(ZERO))
    assert np.allclose(problem.moves[0], min(1, 2.0 ** (1 - halvings)) * problem.least, atol=1e-5)


def test_a_search_gives_up_at_a_thousandth_of_newtons_step():
    problem, search = Short(0.0), LineSearch(VertexSystem(F, N))
    assert search.step(problem, ZERO, problem.model(ZERO)) is None
    smallest = np.linalg.norm(problem.moves[-1]) / np.linalg.norm(problem.least)
    assert smallest * (1 + 1e-6) >= 1e-3
    assert smallest / 2 < 1e-3


def test_a_step_must_bring_a_ten_thousandth_of_what_the_slope_promises():
    """Armijo's condition with rho = 1e-4, at every length."""
    for share, accepted in ((1.1e-4, True), (0.9e-4, False), (0.0, False), (-1.0, False)):
        problem = Claims(share)
        found = LineSearch(VertexSystem(F, N)).step(problem, ZERO, problem.model(ZERO))
        assert (found is not None) == accepted
        assert (len(problem.moves) == 1) == accepted


@pytest.mark.parametrize("count", [2, 16])
def test_parts_that_a_step_brings_together_keep_their_distance(count):
    """The step is then the least value's on the condition, at whole length, as the step with this condition says."""
    rows = approaching(count)
    problem, search = Parts(*rows), LineSearch(VertexSystem(F, N))
    trial = search.step(problem, ZERO, problem.model(ZERO))
    conditioned = Bowl().model(ZERO, border=(rows, np.zeros(count)))
    best = LineSearch(VertexSystem(F, N)).step(Bowl(), ZERO, conditioned)
    assert np.allclose(trial.x, best.x, atol=1e-6)
    assert np.allclose(speeds(rows, trial.x), 0, atol=1e-6)
    assert len(problem.moves) == 2
    assert search.length == 1


def test_parts_that_only_the_conditioned_step_brings_together_are_held_beside_the_first():
    first = approaching(1)[0]
    held = Parts(first)
    sliding = LineSearch(VertexSystem(F, N)).step(held, ZERO, held.model(ZERO)).x
    whole = Bowl().least
    # the whole step parts these two by 1, the conditioned one would bring them nearer by 1
    along = np.linalg.lstsq(np.array([whole.T.ravel(), sliding.T.ravel()]), [1.0, -1.0], rcond=None)
    second = along[0].reshape(2, N)
    problem, search = Parts(first, second), LineSearch(VertexSystem(F, N))
    trial = search.step(problem, ZERO, problem.model(ZERO))
    assert np.allclose(speeds(problem.apart, trial.x), 0, atol=1e-6)
    assert len(problem.moves) == 3
    assert search.length == 1


@pytest.mark.parametrize(
    "rows", [-approaching(3), approaching(17)], ids=["moving apart", "more than sixteen"]
)
def test_a_refused_step_is_halved_if_no_part_is_in_its_way_or_too_many_are(rows):
    problem, search = Stuck(0.3, *rows), LineSearch(VertexSystem(F, N))
    trial = search.step(problem, ZERO, problem.model(ZERO))
    assert search.length == 0.25
    assert np.allclose(trial.x, problem.least / 4, atol=1e-5)


def test_iterates_end_where_nothing_is_gained():
    """The value falls at every step, and a step from the minimum gains nothing."""
    trials = list(islice(newton(Short(0.3), LineSearch(VertexSystem(F, N)), ZERO), 50))
    assert 3 < len(trials) < 50
    assert (np.diff([trial.value for trial in trials]) < 0).all()
    assert np.allclose(trials[-1].x, Bowl().least, atol=1e-6)


def test_damping_falls_after_a_step_that_succeeds_at_once_and_else_stays():
    search, bowl = levenberg(0.5), Bowl()
    search.step(bowl, ZERO, bowl.model(ZERO))
    assert search.at_once
    assert (search.damping < 0.5).all()
    search, problem = levenberg(0.01), Folds([0], 0.8)
    search.step(problem, ZERO, problem.model(ZERO))
    assert not search.at_once
    with_it = np.linalg.norm(problem.moves[-1])
    problem.moves.clear()
    problem.share = np.inf  # the next step is tried with the damping of the last
    search.step(problem, ZERO, problem.model(ZERO))
    assert np.isclose(np.linalg.norm(problem.moves[0]), with_it)


def test_damping_grows_around_faces_that_a_step_folds_and_less_elsewhere():
    """The corners of the folded face and their neighbours are damped alike, the others less, none without a bound."""
    search, problem = levenberg(0.01), Folds([5], 0.5)
    trial = search.step(problem, ZERO, problem.model(ZERO))
    assert trial.value < problem.value(ZERO)
    around = np.isin(np.arange(N), F[np.isin(F, F[5]).any(axis=1)])
    near, far = search.damping[around], search.damping[~around]
    assert np.ptp(near) == np.ptp(far) == 0
    assert near[0] > far[0] > 0.01
    assert search.damping.max() <= 10
    assert np.linalg.norm(problem.moves[-1]) < np.linalg.norm(problem.moves[0])


def test_a_search_gives_up_where_no_damping_helps():
    """It does so at the first step that moves with its largest damping, and not before."""
    problem = Folds([], 0.0)
    problem.judged = lambda y, move: Trial(y, np.inf, np.zeros(len(F), bool))
    search = levenberg()
    assert search.step(problem, ZERO, problem.model(ZERO)) is None
    values = search.system.assemble(problem.blocks)

    def move(damping):
        factor = search.system.factorize(search.system.damped(values, damping))
        return np.linalg.norm(search.system.solve(factor, problem.model(ZERO).gradient))

    sizes = np.linalg.norm(problem.moves, axis=(1, 2))
    assert (np.diff(sizes) < 0).all()
    assert np.isclose(sizes[0], move(0.0))
    assert np.isclose(sizes[1], move(DAMPED))
    assert sizes[-1] <= move(10.0) * (1 + 1e-9) < sizes[-2]


@pytest.mark.parametrize("faces", [[3], [3, 9]])
def test_a_search_gives_up_where_more_damping_leaves_as_many_folded_and_no_lower_value(faces):
    for value, steps in ((1e9, 2), (np.inf, None)):
        problem = Folds(faces, 0.0, value)
        assert levenberg(1e-3).step(problem, ZERO, problem.model(ZERO)) is None
        assert (len(problem.moves) == 2) == (steps == 2)


def test_no_more_systems_are_solved_than_allowed():
    for systems in (0, 1, 3):
        problem, search = Folds([3], 0.0), levenberg(systems=systems)
        assert search.step(problem, ZERO, problem.model(ZERO)) is None
        assert len(problem.moves) == systems
        assert search.systems == 0


@pytest.mark.parametrize("search", [LineSearch(VertexSystem(F, N)), levenberg()])
def test_a_model_that_is_not_finite_gives_no_step(search):
    bowl = Bowl()
    bowl.blocks[0, 0, 0, 0] = np.nan
    assert search.step(bowl, ZERO, bowl.model(ZERO)) is None
    assert not bowl.moves


def test_a_singular_model_is_solved_by_levenberg_where_it_has_a_slope():
    """A vertex whose faces have no weight stays where it is."""
    bowl = Bowl()
    bowl.J[:, :, :, (F == 7).any(axis=1)] = 0
    bowl.blocks = gram_blocks(bowl.J, bowl.J)
    trial = levenberg(1e-6).step(bowl, ZERO, bowl.model(ZERO))
    assert np.abs(trial.x[7]).max() == 0
    assert trial.value < 1e-6 * bowl.value(ZERO)
