"""A factor that serves twice: for maps that turned and grew it is Newton's; where it may not serve, it does not."""

import numpy as np
import pytest
from triangulations import icosphere

from igl_spheremap.balance.kept_factor import KeptFactor
from igl_spheremap.newton.loop import Model, Trial
from igl_spheremap.newton.system import VertexSystem, gram_blocks

F = icosphere(1)[1]
N = F.max() + 1
RNG = np.random.default_rng(0)
START = RNG.normal(size=(N, 2))


class Bowl:
    """A constant plus half the squares of random linear functions of each face's way from the least map."""

    def __init__(self, least, constant, seed=1):
        self.J = np.random.default_rng(seed).normal(size=(7, 3, 2, len(F)))
        self.least, self.constant = least, constant

    def rows(self, x):
        return np.einsum("rkam,mka->rm", self.J, (x - self.least)[F])

    def value(self, x):
        return self.constant + 0.5 * (self.rows(x) ** 2).sum()

    def model(self, x):
        gradient = np.zeros((N, 2))
        np.add.at(gradient, F, np.einsum("rkam,rm->mka", self.J, self.rows(x)))
        axes = np.repeat(np.eye(2)[:, :, None], N, axis=2)
        return Model(self.value(x), axes, gradient.T, gram_blocks(self.J, self.J))

    def move(self, x, model, step):
        return step.T

    def accept(self, x, move):
        return Trial(x + move, self.value(x + move), np.zeros(len(F), bool))


def dense(bowl):
    H = np.zeros((2 * N, 2 * N))
    for k, face in enumerate(F):
        unknowns = (2 * face[:, None] + [0, 1]).ravel()
        rows = bowl.J[..., k].reshape(7, 6)
        H[np.ix_(unknowns, unknowns)] += rows.T @ rows
    return H


class Search(KeptFactor):
    """Counts its factors."""

    factors = 0

    def __init__(self, tolerance):
        super().__init__(VertexSystem(F, N), tolerance)
        factorize = self.system.factorize

        def counted(values):
            self.factors += 1
            return factorize(values)

        self.system.factorize = counted


def after_a_whole_step(c, constant=1e4, tolerance=1.0):
    """A search whose first step moved, turned and enlarged the plane by a complex number, and its bowl."""
    z = c * (START @ [1, 1j]) + 0.3
    first = Bowl(np.column_stack((z.real, z.imag)), constant)
    search = Search(tolerance)
    trial = search.step(first, START, first.model(START))
    assert np.allclose(trial.x, first.least, atol=1e-5)
    assert search.ahead == np.inf
    assert search.factors == 1
    return search, first, trial.x


@pytest.mark.parametrize("c", [1, np.exp(0.4j), 1.1, 0.95 * np.exp(-1j)])
def test_the_old_factors_step_turns_and_grows_with_the_map(c):
    """Its Hessian is that of the map before, in axes that turned by c, over |c|^2."""
    search, first, x = after_a_whole_step(c)
    then = Bowl(x + 1e-3 * RNG.normal(size=x.shape), 1e4, seed=1)
    model = then.model(x)
    trial = search.step(then, x, model)
    assert search.factors == 1
    gradient = model.gradient.T @ [1, 1j] * np.conj(c)
    way = np.linalg.solve(dense(first), np.column_stack((gradient.real, gradient.imag)).ravel())
    z = -c * (way.reshape(-1, 2) @ [1, 1j])
    assert np.allclose((trial.x - x) @ [1, 1j], z, rtol=1e-4, atol=1e-8)
    slope = -(model.gradient.T * (trial.x - x)).sum() / 2
    assert search.ahead == pytest.approx(slope / model.value)


def test_a_step_with_an_old_factor_is_taken_only_where_little_is_left_to_gain():
    for far, factors in ((1e-3, 1), (30.0, 2)):
        search, _, x = after_a_whole_step(1.0, tolerance=1e-2)
        then = Bowl(x + far * RNG.normal(size=x.shape), 1e4)
        trial = search.step(then, x, then.model(x))
        assert search.factors == factors
        assert (search.ahead < 1e-2) == (factors == 1)
        assert np.allclose(trial.x, then.least, atol=1e-3 * far)


def test_a_factor_is_not_kept_whose_step_gained_less_or_more_than_it_predicted():
    class Steeper(Bowl):
        def accept(self, x, move):
            trial = super().accept(x, move)
            return trial._replace(value=trial.value - self.more * (super().value(x) - trial.value))

    for more, factors in ((0.0, 1), (0.5, 2), (-0.5, 2)):
        first, search = Steeper(START + 0.1, 1e4), Search(1.0)
        first.more = more
        x = search.step(first, START, first.model(START)).x
        then = Bowl(x + 1e-3, 1e4)
        search.step(then, x, then.model(x))
        assert search.factors == factors


def test_an_old_factors_step_that_raises_the_value_is_not_taken():
    class Wall(Bowl):
        tried = 0

        def accept(self, x, move):
            self.tried += 1
            trial = super().accept(x, move)
            return trial._replace(value=np.inf) if self.tried == 1 else trial

    search, _, x = after_a_whole_step(1.0)
    then = Wall(x + 1e-3, 1e4)
    trial = search.step(then, x, then.model(x))
    assert then.tried == 2
    assert search.factors == 2
    assert search.ahead == np.inf
    assert trial.value < then.value(x)


def test_a_factor_does_not_serve_after_a_long_fall():
    """The square of the last gain is above ten times the tolerance."""
    search, _, x = after_a_whole_step(1.0 + 0.5j, constant=1.0, tolerance=0.05)
    then = Bowl(x + 1e-9, 1.0)
    search.step(then, x, then.model(x))
    assert search.factors == 2
