"""Algorithm 1 by the rules of the authors' published program, against a transcription of these rules."""

import igl
import numpy as np
import pytest
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap.paper.optm import OptMRules
from igl_spheremap.result.run import Iterate, Stage


def programmed_algorithm_1(v, f, k):
    """At most k iterations by the rules of OptManiMulitBallGBB on tr(X^T L X) / 2, and which rules end the run at each.

    X has a row a vertex here; in the program it is its transpose, with 3 rows.
    """
    L = -igl.cotmatrix(v, f)
    x = igl.per_vertex_normals(v, f, igl.PER_VERTEX_NORMALS_WEIGHTING_TYPE_AREA)

    def energy_and_derivative(x):
        return (x * (L @ x)).sum() / 2, L @ x

    def tangential(x, g):
        return g - (x * g).sum(axis=1, keepdims=True) * x

    (energy, g), tau = energy_and_derivative(x), 1e-3
    gradient, C, Q = tangential(x, g), energy, 1.0
    changes = []
    for n in range(1, k + 1):
        xg, gg, xx = (x * g).sum(axis=1), (g * g).sum(axis=1), (x * x).sum(axis=1)
        for trial in range(1, 6):
            half = tau / 2
            below = 1 - half**2 * xg**2 + half**2 * xx * gg
            y = (((1 + half * xg) ** 2 - half**2 * xx * gg) / below)[:, None] * x - (
                tau * xx / below
            )[:, None] * g
            reached, derivative = energy_and_derivative(y)
            if reached <= C - 1e-4 * tau * (gradient**2).sum() or trial == 5:
                break
            tau *= 0.2
        S, Y = y - x, tangential(y, derivative) - gradient
        changes.append((np.linalg.norm(S) / np.sqrt(3), abs(reached - energy) / (1 + abs(energy))))
        x, energy, g, gradient, taken = y, reached, derivative, gradient + Y, tau
        ends = {
            "gradient": np.linalg.norm(gradient) < 1e-6,
            "last change": np.less(changes[-1], (1e-6, 1e-12)).all(),
            "last five": np.less(np.mean(changes[-5:], axis=0), (1e-5, 1e-11)).all(),
        }
        yield (
            x,
            energy,
            np.linalg.norm(gradient),
            taken,
            [rule for rule, met in ends.items() if met],
        )
        if any(ends.values()):
            return
        SS, SY, YY = (S * S).sum(), abs((S * Y).sum()), (Y * Y).sum()
        tau = min(max(SY / YY if n % 2 else SS / SY, 1e-20), 1e20) if SY > 0 else 1e-3
        C, Q = (0.85 * Q * C + energy) / (0.85 * Q + 1), 0.85 * Q + 1


def stretched(level, stretch):
    x, f = icosphere(level)
    return x * [1, 1, stretch], f


#: Surfaces, and the rules that end the program's run on them.
ENDS = [
    (stretched(1, 1.2), ["gradient", "last change"]),
    (stretched(1, 1.5), ["gradient"]),
    (stretched(2, 1.5), ["last change"]),
    (stretched(3, 1.2), ["last five"]),
    (ism.samples.make("spheroid", n_vertices=2000), ["last change"]),
]


@pytest.mark.parametrize(("surface", "rules"), ENDS, ids=range(len(ENDS)))
def test_algorithm_1_as_programmed_takes_the_programs_steps_and_ends_by_its_rules(surface, rules):
    v, f = surface
    seen = []
    method = ism.Lai2014.as_programmed()
    result = ism.algorithm_1(
        v, f, method=method, listener=lambda it: it.stage == "harmonic" and seen.append(it)
    )
    expected = list(programmed_algorithm_1(ism.check_mesh(v, f).unit, f, method.max_iterations))
    assert result.status is ism.Status.CONVERGED
    for iterate, (x, energy, norm, tau, _) in list(zip(seen[1:], expected, strict=True))[:100]:
        assert np.abs(iterate.x - x).max() < 1e-7
        assert np.allclose(
            (iterate.energy, iterate.residual, iterate.tau), (energy, norm, tau), rtol=1e-4
        )
    assert [ends for *_, ends in expected if ends] == [rules]


def test_a_quotient_without_a_value_gives_way_to_the_first_step_and_others_are_bounded():
    rules = OptMRules(1e-3)
    assert [rules.step(tau, 7.0) for tau in (np.nan, np.inf, 0.0, 1e-30, 1e30, 0.5)] == [
        1e-3,
        1e-3,
        1e-3,
        1e-20,
        1e20,
        0.5,
    ]
    assert rules.acted() == {"undefined": 3, "bounded": 2}
    assert rules.acted() is None


def after(*changes):
    """Whether the rules end a run after steps that each change a vertex and the energy of 3 by so much."""
    rules, x, energy = OptMRules(1e-3), np.eye(3), 3.0
    ends = [rules.settled(Iterate(Stage.ALGORITHM_1, 0, 0, x, energy))]
    for k, (moved, gained) in enumerate(changes, 1):
        x, energy = x + np.diag([moved, 0, 0]), energy + gained
        ends.append(rules.settled(Iterate(Stage.ALGORITHM_1, 0, k, x, energy)))
    assert not any(ends[:-1])
    return ends[-1]


#: What the program allows of a change: 1e-6 of the map, in the norm over sqrt(3), and 1e-12 of 1 + energy.
MOST = 1e-6 * np.sqrt(3), 4e-12


@pytest.mark.parametrize("sign", [1, -1])
def test_a_run_ends_where_map_and_energy_change_little(sign):
    large = 20.0, 2e6
    for share, ends in ((0.98, True), (1.02, False)):
        few = [share * each * sign for each in MOST]
        for x, energy in ((few[0], 0.0), (0.0, few[1]), few):
            assert after([large[0] * MOST[0], large[1] * MOST[1]], [x, energy]) == ends


def test_a_run_ends_where_the_last_five_changes_are_on_average_ten_times_as_large():
    for share, ends in ((0.95, True), (1.05, False)):
        ten = [10 * share * each for each in MOST]
        assert after([1e3 * MOST[0], 0], *[ten] * 5) == ends


def test_changes_of_the_run_before_do_not_count():
    rules, x = OptMRules(1e-3), np.eye(3)
    for k in range(3):
        assert not rules.settled(Iterate(Stage.ALGORITHM_1, 0, k, x + 100 * k, 3.0))
    assert not rules.settled(Iterate(Stage.ALGORITHM_1, 1, 0, x, 3.0))
    assert rules.settled(Iterate(Stage.ALGORITHM_1, 1, 1, x, 3.0))


@pytest.mark.parametrize("name", ["rho", "delta", "xi"])
@pytest.mark.parametrize("value", [-0.1, 1.1, np.nan, "x"])
def test_parameters_that_algorithm_1_excludes_are_refused(name, value):
    with pytest.raises((ValueError, TypeError), match=name):
        ism.Lai2014(**{name: value})


def test_the_numbers_are_those_of_the_program():
    """Its gtol, mxitr, eta and tau."""
    programmed = ism.Lai2014.as_programmed()
    assert (programmed.gradient_tolerance, programmed.max_iterations) == (1e-6, 1000)
    assert (programmed.delta, programmed.tau, programmed.rho, programmed.xi) == (
        0.2,
        1e-3,
        1e-4,
        0.85,
    )


def test_the_fifth_trial_of_a_search_is_taken_at_any_finite_energy():
    search = OptMRules(1e-3).search(1.0, 1e-4, 0.2, 0.85)
    taken = [search.accepts(2.0, tau, -1.0) for tau in search.steps(1.0)]
    assert taken == [False] * 4 + [True]


def test_the_programs_rules_go_without_safeguards():
    for options in ({"may_fold": False}, {"gauge": "centred"}):
        with pytest.raises(ValueError, match="have no safeguards"):
            ism.Lai2014.as_programmed(**options)
