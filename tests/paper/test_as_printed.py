"""Algorithms 1 and 2 as the paper prints them, without safeguards, and each safeguard alone."""

import re
from pathlib import Path

import igl
import numpy as np
import pytest
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap.errors import FactorisationFailed
from igl_spheremap.paper.star_map import project
from igl_spheremap.result.run import SAFEGUARDS
from igl_spheremap.sphere.moebius import moebius

X, F = icosphere(2)
V = X * [1, 1.2, 1.6] + 0.1 * X**2
BIRD, BIRD_F = ism.samples.make("bird", n_vertices=880)


def printed_algorithm_1(v, f, k):
    """The first k iterates of the paper's six steps, by libigl's matrices and its own formula of Theorem 1."""
    L = -igl.cotmatrix(v, f)
    A = igl.massmatrix(v, f, igl.MASSMATRIX_TYPE_BARYCENTRIC).diagonal()
    A /= A.sum()
    x = igl.per_vertex_normals(v, f, igl.PER_VERTEX_NORMALS_WEIGHTING_TYPE_AREA)

    def energy_and_h(x):
        return (x * (L @ x)).sum() / 2, (L @ x) / A[:, None]

    def tangential(x, h):
        return h - (x * h).sum(axis=1, keepdims=True) * x

    (energy, h), tau = energy_and_h(x), 1.0
    gradient, C, Q = tangential(x, h), energy, 1.0
    for n in range(1, k + 1):
        slope = -A @ (gradient**2).sum(axis=1)
        fh, hh = (x * h).sum(axis=1), (h * h).sum(axis=1)
        while True:
            half = tau / 2
            below = 1 - half**2 * fh**2 + half**2 * hh
            y = (((1 + half * fh) ** 2 - half**2 * hh) / below)[:, None] * x - (tau / below)[
                :, None
            ] * h
            if energy_and_h(y)[0] <= C + 1e-4 * tau * slope:
                break
            tau *= 0.1
        energy, h = energy_and_h(y)
        D, W = y - x, tangential(y, h) - gradient
        x, gradient, taken = y, gradient + W, tau
        C, Q = (0.85 * Q * C + energy) / (0.85 * Q + 1), 0.85 * Q + 1
        DD, DW, WW = (A @ (a * b).sum(axis=1) for a, b in ((D, D), (D, W), (W, W)))
        tau = DD / abs(DW) if n % 2 else abs(DW) / WW
        yield x, energy, np.sqrt(A @ (gradient**2).sum(axis=1)), taken


def test_algorithm_1_as_printed_is_the_papers_six_steps():
    seen = []
    ism.algorithm_1(V, F, method=ism.Lai2014.as_printed(max_iterations=40), listener=seen.append)
    assert np.array_equal(seen[0].x, ism.gauss_map(V, F))  # as it is, not centred
    for iterate, (x, energy, residual, tau) in zip(
        seen[2:], printed_algorithm_1(V, F, 40), strict=True
    ):
        assert np.abs(iterate.x - x).max() < 1e-7
        assert np.allclose(
            (iterate.energy, iterate.residual, iterate.tau), (energy, residual, tau), rtol=1e-5
        )
        assert iterate.safeguards is None


def test_rounds_as_printed_start_at_star_maps_as_they_are():
    seen = []
    method = ism.Lai2014.as_printed(max_iterations=20, rounds=2)
    result = ism.spherical_conformal_map(BIRD, BIRD_F, method=method, listener=seen.append)
    last = {iterate.round: iterate.x for iterate in seen}
    for star in (iterate for iterate in seen if iterate.stage == "star map"):
        assert np.array_equal(
            star.x, ism.weighted_eigen_projection(BIRD, BIRD_F, last[star.round - 1]).star_map
        )
    assert [each.start for each in result.rounds] == ["gauss map", "star map", "star map"]
    assert np.array_equal(result.sphere, last[2])
    assert (result.gauge, result.status) == ("free", ism.Status.MAX_ITERATIONS)
    assert [note.partition(";")[0] for note in result.notes] == ["foldings are left"]
    assert ism.certify(result.sphere, BIRD_F).foldings == result.certificate.foldings
    assert not result.certificate.folding_free


def test_the_parameters_are_those_that_the_paper_prints():
    """After Algorithm 1, and of Table 1."""
    printed = ism.Lai2014.as_printed()
    assert (printed.rho, printed.delta, printed.xi) == (1e-4, 0.1, 0.85)
    assert (printed.gradient_tolerance, printed.plateau) == (1e-10, 0)


def test_where_a_star_map_fails_the_run_ends_with_the_map_before_and_names_the_round(monkeypatch):
    calls, seen = [], []

    def second_fails(*args):
        calls.append(args)
        if len(calls) == 2:
            raise FactorisationFailed("planted")
        return project(*args)

    monkeypatch.setattr("igl_spheremap.paper.hooks.project", second_fails)
    method = ism.Lai2014.as_printed(max_iterations=5, rounds=4)
    result = ism.algorithm_2(BIRD, BIRD_F, method=method, listener=seen.append)
    assert len(result.rounds) == 2
    assert [note for note in result.notes if "there is no star map for round 2" in note]
    assert np.array_equal(result.sphere, seen[-1].x)


def test_areas_that_are_raised_are_counted_in_the_notes():
    v = np.array(V)
    around = np.unique(F[(F == 0).any(axis=1)])
    for hidden, count in (([], 0), (around, 1)):
        v[hidden] = v[0]
        notes = ism.algorithm_1(v, F, method=ism.Lai2014(metric="areas", max_iterations=1)).notes
        assert [note[:2] for note in notes if "of eq. (13) were raised" in note] == count * ["1 "]


def test_a_run_that_is_stopped_makes_no_star_map():
    seen = []

    def stop(iterate):
        seen.append(iterate)
        if iterate.iteration == 3:
            raise StopIteration

    method = ism.Lai2014.as_printed(max_iterations=20, rounds=2)
    result = ism.algorithm_2(BIRD, BIRD_F, method=method, listener=stop)
    assert result.status is ism.Status.STOPPED
    assert len(result.rounds) == 1
    assert {iterate.round for iterate in seen} == {0}


def test_no_more_rounds_are_made_than_asked_for():
    method = ism.Lai2014.as_printed(max_iterations=2, rounds=1)
    seen = []
    ism.algorithm_2(BIRD, BIRD_F, method=method, listener=seen.append)
    assert {iterate.round for iterate in seen} == {0, 1}


def iterates(method, v=BIRD, f=BIRD_F):
    seen = []
    return ism.spherical_conformal_map(v, f, method=method, listener=seen.append), seen


def test_steps_that_would_fold_are_counted_in_the_notes_and_in_the_history():
    safe, seen = iterates(ism.Lai2014(max_iterations=60, rounds=1))
    count = sum((step.safeguards or {}).get("refused", 0) for step in safe.history)
    assert count == sum((iterate.safeguards or {}).get("refused", 0) for iterate in seen) > 0
    assert f"{count:,} steps that would fold were refused" in safe.notes
    assert safe.rounds[1].foldings_before == safe.rounds[1].foldings_after == 0
    free, _ = iterates(ism.Lai2014(max_iterations=60, rounds=1, may_fold=True))
    assert free.rounds[1].foldings_before == 0 < free.rounds[1].foldings_after
    assert not any("would fold" in note for note in free.notes)


def test_few_foldings_are_repaired_at_the_end_and_named():
    noise = np.random.default_rng(1).normal(size=BIRD.shape)
    v = BIRD + 0.5 * igl.edge_lengths(BIRD, BIRD_F).mean() * noise
    options = {"max_iterations": 150, "rounds": 1}
    repaired, seen = iterates(ism.Lai2014(**options), v)
    _, minimiser, repair = repaired.rounds
    assert 0 < minimiser.foldings_after <= minimiser.foldings_before < 0.01 * len(BIRD_F)
    assert (repair.start, repair.foldings_after, seen[-1].stage) == ("repair", 0, "repair")
    note = f"minimiser, {repair.foldings_before} of {len(BIRD_F):,} faces repaired"
    assert note in repaired.notes
    assert repaired.certificate.folding_free
    printed, _ = iterates(ism.Lai2014(**options, may_fold=True), v)
    assert printed.rounds[1].foldings_after > 0


def test_no_step_adds_foldings_to_a_star_map():
    """The caudate's tail in kind: a limb beyond float64, whose star map folds and stays folded."""
    v, f = ism.samples.make("octopus", n_vertices=3000)
    v = v * [1, 1, 4]
    result = ism.spherical_conformal_map(v, f, method=ism.Lai2014(rounds=1))
    free = ism.spherical_conformal_map(v, f, method=ism.Lai2014(rounds=1, may_fold=True))
    assert result.rounds[1].foldings_before == free.rounds[1].foldings_before
    assert (
        result.rounds[1].foldings_after
        <= result.rounds[1].foldings_before
        < free.rounds[1].foldings_after
    )


def test_cotangent_weights_that_are_not_finite_are_refused_and_delaunays_are_mollified():
    v, f = np.array(V), F
    v[f[0, 2]] = v[f[0, 0]]  # faces of no area
    assert np.isfinite(ism.algorithm_1(v, f, method=ism.Lai2014(max_iterations=5)).sphere).all()
    with pytest.raises(
        ism.MapError, match=r"not finite at 2 faces without area, e.g. 0, \d+; .*delaunay"
    ):
        ism.algorithm_1(v, f, method=ism.Lai2014.as_printed())


def test_quotients_without_a_value_are_counted_and_the_map_that_shrinks_to_a_point_has_a_status():
    """The bird as printed: its map becomes a point, and D, W of eq. (12) vanish."""
    method = ism.Lai2014.as_printed(rounds=1)
    result = ism.spherical_conformal_map(BIRD, BIRD_F, method=method)
    collapsed = [each.status is ism.Status.COLLAPSED for each in result.rounds]
    assert any(collapsed)
    assert (
        (result.certificate.degree == 0) == collapsed[-1] == (result.status is ism.Status.COLLAPSED)
    )
    count = sum((step.safeguards or {}).get("undefined", 0) for step in result.history)
    assert (f"{count:,} quotients of eq. (12) had no value" in result.notes) == (count > 1)


def test_what_has_no_value_is_counted():
    """A vertex without normal, and weights of eq. (20) of a map that hides a cap in a point."""
    v, f = np.array(V), F
    around = np.unique(f[(f == 0).any(axis=1)])
    v[around] = v[0]
    seen = []
    ism.algorithm_1(v, f, method=ism.Lai2014(max_iterations=0), listener=seen.append)
    assert seen[0].safeguards == {"undirected": 1}
    x = np.array(X)
    x[around] = X[0]
    projection = ism.weighted_eigen_projection(V, F, x)
    assert (projection.floored, projection.undirected) == (1, 0)


def test_rows_of_the_laplacian_take_a_third_of_the_iterations_where_vertices_are_unevenly_spread():
    """An ellipsoid whose vertices crowd at one end, in both metrics down to one norm of the same gradient."""
    x, f = ism.samples.sphere(642)
    v = moebius(x, np.array([0, 0, 0.5])) * [1, 1, 2]
    areas, rows = (
        ism.spherical_conformal_map(v, f, method=ism.Lai2014(rounds=0, plateau=0, metric=metric))
        for metric in ("areas", "laplacian")
    )
    assert rows.status is areas.status is ism.Status.CONVERGED
    assert rows.iterations < areas.iterations / 3
    assert rows.energy == pytest.approx(areas.energy, rel=1e-4)
    first = [result.history[1].residual for result in (areas, rows)]
    assert first[0] == pytest.approx(first[1], rel=0.1)  # boosts are taken out in different metrics


def test_the_page_names_all_that_stands_where_a_printed_formula_has_no_value():
    """Notes that a run as printed can have are quoted in the table, and it quotes no others."""
    page = Path(ism.__file__).parent.parent / "docs" / "equations.md"
    if not page.exists():
        pytest.skip("the docs are not installed with the package")
    quoted = set(re.findall(r'note: "(.+?)"', page.read_text("utf-8")))
    counted = {
        name
        for path in ("hooks", "setup", "algorithm_2")
        for name in re.findall(r'_count\("(\w+)"|nonzero\((\w+)=|, (\w+)=found', source(path))
        for name in name
        if name
    }
    words = [word for name in counted for word in SAFEGUARDS[name][1:]]
    words += re.findall(r'notes,\s+f"\{raised:,\} (.+?)"', source("setup"))
    words += re.findall(r'notes,\s+f"(there .+?) for round', source("algorithm_2"))
    assert all(any(quote in word for word in words) for quote in quoted)
    assert all(any(quote in word for quote in quoted) for word in words)


def source(name):
    return (Path(ism.__file__).parent / "paper" / f"{name}.py").read_text("utf-8")
