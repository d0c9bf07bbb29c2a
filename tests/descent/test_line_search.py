"""The nonmonotone search: its acceptance rule, its average, and how it gives up."""

import numpy as np

from igl_spheremap.descent.line_search import NonmonotoneSearch


def test_step_is_the_first_power_of_delta_that_the_rule_accepts():
    def energy(tau):
        return (1 - tau) ** 2

    search = NonmonotoneSearch(1.0)
    step = search.search(lambda tau: (energy(tau), "extra"), 300.0, -2.0)
    sizes = 300.0 * 0.1 ** np.arange(6)
    accepted = [energy(t) <= 1 + 1e-4 * t * -2 for t in sizes]
    assert np.isclose(step.tau, sizes[accepted.index(True)])
    assert step.energy == energy(step.tau)
    assert step.trial == "extra"


def test_average_is_the_weighted_mean_of_all_energies():
    """C_k unrolled: weights xi^(k - j) over their sum."""
    energies = [5.0, 7.0, 3.0, 4.0, 2.0]
    search = NonmonotoneSearch(energies[0], xi=0.85)
    for energy in energies[1:]:
        search.record(energy)
    weights = 0.85 ** np.arange(len(energies))[::-1]
    mean = weights @ energies / weights.sum()
    assert search.search(lambda tau: (mean - 1e-9, None), 1.0, -1e-12).tau == 1.0
    assert search.search(lambda tau: (mean + 1e-9, None), 1.0, -1e-12) is None


def test_xi_zero_is_the_monotone_rule():
    search = NonmonotoneSearch(5.0, xi=0.0)
    search.record(1.0)
    assert search.search(lambda tau: (2.0, None), 1.0, -1e-9) is None


def test_numbers_that_are_none_are_refused():
    assert NonmonotoneSearch(1.0).search(lambda tau: (np.nan, None), 1.0, -1.0) is None
