"""The nonmonotone search: its acceptance rule, its average, and how it gives up."""

import numpy as np
import pytest

from igl_spheremap.descent.line_search import NonmonotoneSearch


def test_step_is_the_first_power_of_delta_that_the_rule_accepts():
    def energy(tau):
        return (1 - tau) ** 2

    search = NonmonotoneSearch(1.0)
    taken = next(tau for tau in search.steps(300.0) if search.accepts(energy(tau), tau, -2.0))
    sizes = 300.0 * 0.1 ** np.arange(6)
    accepted = [energy(t) <= 1 + 1e-4 * t * -2 for t in sizes]
    assert np.isclose(taken, sizes[accepted.index(True)])


def test_average_is_the_weighted_mean_of_all_energies():
    """C_k unrolled: weights xi^(k - j) over their sum."""
    energies = [5.0, 7.0, 3.0, 4.0, 2.0]
    search = NonmonotoneSearch(energies[0], xi=0.85)
    for energy in energies[1:]:
        search.record(energy)
    weights = 0.85 ** np.arange(len(energies))[::-1]
    mean = weights @ energies / weights.sum()
    assert search.accepts(mean - 1e-9, 1.0, -1e-12)
    assert not search.accepts(mean + 1e-9, 1.0, -1e-12)


def test_xi_zero_is_the_monotone_rule():
    search = NonmonotoneSearch(5.0, xi=0.0)
    search.record(1.0)
    assert not search.accepts(2.0, 1.0, -1e-9)


def test_numbers_that_are_none_are_refused():
    assert not NonmonotoneSearch(1.0).accepts(np.nan, 1.0, -1.0)


def test_the_last_trial_is_taken_if_asked_at_any_finite_energy():
    search = NonmonotoneSearch(1.0, delta=0.2, trials=5, takes_last=True)
    energies = [np.inf, 9.0, np.nan, 7.0, 8.0]
    accepted = [
        search.accepts(energy, tau, -1.0)
        for energy, tau in zip(energies, search.steps(1.0), strict=True)
    ]
    assert accepted == [False] * 4 + [True]
    assert not any(search.accepts(np.inf, tau, -1.0) for tau in search.steps(1.0))


@pytest.mark.parametrize("rho", [1e-4, 0.3, 0.9])
@pytest.mark.parametrize("tau", [1e-6, 1.0, 300.0])
def test_a_step_must_gain_the_share_rho_of_what_the_slope_predicts(rho, tau):
    search = NonmonotoneSearch(1.0, rho=rho)
    for share in (1.01 * rho, 1.0):
        assert search.accepts(1 - share * 2 * tau, tau, -2.0)
    for share in (0.99 * rho, 0.0, -1.0):
        assert not search.accepts(1 - share * 2 * tau, tau, -2.0)
