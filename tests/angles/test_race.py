"""The race and its plan: the best candidate wins, and the plan can be read before."""

from __future__ import annotations

from dataclasses import replace

import igl
import numpy as np
import pytest
from bodies import random_body
from triangulations import unit

import igl_spheremap as ism
from igl_spheremap.angles.plan import plan_repair
from igl_spheremap.angles.race import Candidate, race
from igl_spheremap.descent.energies import HarmonicEnergy
from igl_spheremap.verify.certificate import Certificate


def candidates(*means):
    return [Candidate(np.full((1, 3), float(k)), mean) for k, mean in enumerate(means)]


def towards(limit, share):
    """Steps that bring a candidate nearer to a limit of its own."""

    def steps(candidate):
        end = limit[int(candidate.x[0, 0])]
        return Candidate(candidate.x, end + share * (candidate.mean - end))

    return steps


@pytest.mark.parametrize("order", [[0, 1, 2, 3], [3, 1, 0, 2]])
def test_of_candidates_that_gain_nothing_the_best_wins_in_any_order(order):
    field = candidates(4.0, 2.0, 3.0, 5.0)
    best = race([field[k] for k in order], lambda candidate: candidate, 0.1)
    assert best.x is field[1].x


def test_steps_go_on_until_a_round_gains_no_more_than_its_price():
    [start] = candidates(9.0)
    ends = [race([start], towards([1.0], 0.5), price).mean for price in (0.4, 0.1, 1e-3)]
    assert ends == sorted(ends, reverse=True)
    assert ends[0] < 9
    assert ends[-1] == pytest.approx(1, abs=0.01)


@pytest.mark.parametrize("mean", [0.0, 1e-15])
def test_a_race_of_an_exact_map_ends(mean):
    [start] = candidates(mean)
    assert race([start], lambda candidate: candidate, 0.01).mean == mean


def test_a_candidate_that_is_predicted_to_gain_less_than_the_price_takes_no_steps():
    [start] = candidates(9.0)
    settled = replace(start, further=0.01)
    assert race([settled], towards([1.0], 0.5), 0.02) is settled
    assert race([settled], towards([1.0], 0.5), 1e-3).mean < 2


def test_a_candidate_that_falls_behind_does_not_win_by_where_it_would_end():
    """Halving costs that: the worse half takes no more steps."""
    limit = [3.0, 3.0, 0.0, 0.0]
    assert race(candidates(4.0, 5.0, 8.0, 9.0), towards(limit, 0.5), 0.01).mean == pytest.approx(
        3, rel=0.05
    )


def test_prices_rise_and_layouts_fall_with_the_size_of_a_mesh():
    sizes = [50, 200, 600, 1000, 2000, 5000, 10**6]
    prices, layouts = (
        [count(n) for n in sizes] for count in (ism.Effort().price, ism.Effort().layouts)
    )
    assert prices == sorted(prices)
    assert ism.Effort().least_gain <= prices[0] < prices[-1] <= 8 * ism.Effort().least_gain
    assert layouts == sorted(layouts, reverse=True)
    assert (layouts[0], layouts[-1]) == (5, 1)
    assert ism.Effort(holes=0).layouts(100) == 0


def plan_of(result, x, polish, large="embedded"):
    energy = HarmonicEnergy.of(result.mesh).evaluate(x)[0]
    certificate = Certificate.of(x, result.faces)
    return plan_repair(result.mesh, x, energy, certificate, polish, ism.Effort(), large)


@pytest.fixture(scope="module")
def bodies():
    """A mesh on which one layout may start, and one on which five may, each with its map and one that half folds."""
    made = {}
    for name, n in (("large", 4000), ("small", 500)):
        result = ism.spherical_conformal_map(*ism.samples.make("sphere", n_vertices=n), polish=None)
        made[name] = (
            result,
            unit(np.where(result.mesh.unit[:, :1] > 0, result.sphere[::-1], result.sphere)),
        )
    return made


@pytest.mark.parametrize("name", ["large", "small"])
def test_what_mostly_folds_is_laid_out_and_embedded_as_the_caller_says(bodies, name):
    result, folded = bodies[name]
    plans = {
        large: plan_of(result, folded, "auto", large) for large in ("embedded", "laid out", "left")
    }
    assert [plan.use_map for plan in plans.values()] == [False] * 3
    assert plans["left"].starts == 0
    assert (
        plans["embedded"].layouts == plans["laid out"].layouts == ism.Effort().layouts(len(folded))
    )
    assert [plan.embeds for plan in plans.values()][:2] == [True, name == "small"]


@pytest.mark.parametrize("polish", ["auto", "angles", None])
@pytest.mark.parametrize("large", ["embedded", "laid out", "left"])
def test_a_map_with_few_foldings_starts_itself_whatever_is_done_with_many(bodies, polish, large):
    result, _ = bodies["large"]
    x, (i, j) = result.sphere.copy(), result.faces[7, :2]
    x[[i, j]] = x[[j, i]]
    assert 0 < Certificate.of(x, result.faces).foldings < 20
    plan = plan_of(result, x, polish, large)
    assert (plan.use_map, plan.layouts) == (True, 0)
    assert (plan.price < np.inf) == (polish == "angles")
    assert plan_of(result, result.sphere, polish, large).starts == (polish == "angles")


def test_layouts_start_beside_a_poor_map_only_if_its_energy_is_far_above_its_area(bodies):
    """Smooth bodies reach the area within a few percent: there angles are not even measured."""
    result, _ = bodies["small"]
    x = unit(result.sphere * [1.0, 1.0, 3.0])  # no face folds, and angles are far off
    certificate = Certificate.of(x, result.faces)
    area = igl.doublearea(x, result.faces).sum() / 2
    below, above = (
        plan_repair(result.mesh, x, share * area, certificate, None, ism.Effort())
        for share in (1.049, 1.051)
    )
    assert certificate.folding_free
    assert below.starts == 0
    assert above.use_map
    assert above.layouts == ism.Effort().layouts(len(x))


def test_a_plan_says_what_starts_and_why():
    v, f = ism.samples.make("sphere", n_vertices=500)
    good = ism.spherical_conformal_map(v, f, method=ism.Auto(polish=None))
    stays = plan_of(good, good.sphere, None)
    assert (stays.starts, stays.price) == (0, np.inf)
    asked = plan_of(good, good.sphere, "angles")
    assert (asked.use_map, asked.layouts, asked.price) == (True, 0, ism.Effort().polish_gain)
    x = unit(np.where(good.mesh.unit[:, :1] > 0, good.sphere[::-1], good.sphere))
    plan = plan_of(good, x, "auto")
    assert not plan.use_map
    assert plan.layouts > 1
    assert "faces fold" in str(plan)
    assert f"up to {plan.layouts} layouts" in str(plan)


def test_a_result_explains_what_was_decided():
    result = ism.spherical_conformal_map(*random_body(3, depth=12.0, limbs=2))
    lines = result.explain().splitlines()
    assert lines[0] == f"auto: {result.run.plan}"
    assert [line.split(":")[0] for line in lines[1 : 1 + len(result.rounds)]] == [
        each.start for each in result.rounds
    ]
    assert (
        ism.spherical_conformal_map(*ism.samples.sphere(42), method="gu-yau")
        .explain()
        .startswith("gu-yau: ")
    )
