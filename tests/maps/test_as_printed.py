"""Algorithms 1 and 2 as the paper prints them, without safeguards, and each safeguard alone."""

from dataclasses import replace

import igl
import numpy as np
import pytest
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap.descent.algorithm_1 import CayleyBB
from igl_spheremap.descent.energies import HarmonicEnergy
from igl_spheremap.descent.problem import harmonic_problem
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
            y = (((1 + half * fh) ** 2 - half**2 * hh) / below)[:, None] * x - (tau / below)[:, None] * h
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
    for iterate, (x, energy, residual, tau) in zip(seen[2:], printed_algorithm_1(V, F, 40), strict=True):
        assert np.abs(iterate.x - x).max() < 1e-7
        assert np.allclose((iterate.energy, iterate.residual, iterate.tau), (energy, residual, tau), rtol=1e-5)
        assert iterate.safeguards is None


def test_rounds_as_printed_start_at_star_maps_as_they_are():
    seen = []
    method = ism.Lai2014.as_printed(max_iterations=20, rounds=2)
    result = ism.spherical_conformal_map(BIRD, BIRD_F, method=method, listener=seen.append)
    last = {iterate.round: iterate.x for iterate in seen}
    for star in (iterate for iterate in seen if iterate.stage == "star map"):
        assert np.array_equal(star.x, ism.weighted_eigen_projection(BIRD, BIRD_F, last[star.round - 1]).star_map)
    assert [each.start for each in result.rounds] == ["gauss map", "star map", "star map"]
    assert np.array_equal(result.sphere, last[2])
    assert (result.gauge, result.notes, result.status) == ("free", (), ism.Status.MAX_ITERATIONS)
    assert ism.certify(result.sphere, BIRD_F).foldings == result.certificate.foldings
    assert not result.certificate.folding_free


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


def noisy_bird():
    noise = np.random.default_rng(1).normal(size=BIRD.shape)
    return BIRD + 0.5 * igl.edge_lengths(BIRD, BIRD_F).mean() * noise, BIRD_F


def test_few_foldings_of_a_star_map_are_repaired_and_counted_so_that_none_are_left():
    """By weights that are never negative on obtuse triangles; by the paper's, foldings remain there."""
    options = {"max_iterations": 150, "rounds": 2}
    repaired, seen = iterates(ism.Lai2014(**options, edge_weights="delaunay"), *noisy_bird())
    folds = repaired.rounds[1].foldings_before
    assert 0 < folds < 0.01 * len(BIRD_F)
    assert [iterate.safeguards["repaired"] for iterate in seen if "repaired" in (iterate.safeguards or {})] == [folds]
    assert any(note.startswith(f"{folds} fold") and "repaired" in note for note in repaired.notes)
    assert repaired.rounds[1].foldings_after == repaired.certificate.foldings == 0
    left, _ = iterates(ism.Lai2014(**options, edge_weights="delaunay", repair_star_maps=False), *noisy_bird())
    assert left.rounds[1].foldings_before == folds
    assert left.rounds[1].foldings_after > 0
    assert iterates(ism.Lai2014(**options), *noisy_bird())[0].certificate.foldings > 50


def test_the_map_of_the_best_round_is_kept_or_that_of_the_last():
    options = {"max_iterations": 200, "rounds": 2, "may_fold": True, "gauge": "free"}
    best, _ = iterates(ism.Lai2014(**options))
    last, seen = iterates(ism.Lai2014(**options, keep_best=False))
    after = [each.foldings_after for each in best.rounds]
    assert best.certificate.foldings == min(after)  # which round that is depends on rounding
    note = f"the map is that of round {after.index(min(after))}: later rounds left more foldings"
    assert (note in best.notes) == (after[-1] > min(after))
    assert np.array_equal(last.sphere, seen[-1].x)


def test_weights_are_mollified_unless_that_is_refused():
    v, f = np.array(V), F
    v[f[0, 2]] = v[f[0, 0]]  # faces of no area
    mollified = ism.algorithm_1(v, f, method=ism.Lai2014(max_iterations=5))
    assert "cotangent weights are not usable: slivers or faces of zero area" in mollified.notes
    with pytest.raises(ism.MapError, match=r"not finite at 2 faces without area, e.g. 0, \d+; remove such faces"):
        ism.algorithm_1(v, f, method=ism.Lai2014.as_printed())


@pytest.mark.parametrize("bound", [True, False])
def test_quotients_are_bounded_or_not(bound):
    """In units of 1e-14 times the energy all quotients of eq. (12) are 1e14 times as large."""
    mesh = ism.check_mesh(V, F)
    weak = replace(harmonic_problem(mesh), energy=HarmonicEnergy(1e-14 * HarmonicEnergy.of(mesh).L), gauge=False)
    steps = CayleyBB(bound_tau=bound).iterates(weak, X)
    seen = [next(steps) for _ in range(10)]
    assert (max(iterate.tau for iterate in seen) <= 1e12) == bound
    assert any(iterate.safeguards == {"bounded": 1} for iterate in seen) == bound


def test_wen_yins_rule_ends_where_map_and_energy_hardly_change():
    seen = []
    method = ism.Lai2014.as_printed(stop="wen-yin")
    result = ism.algorithm_1(V, F, method=method, listener=seen.append)
    assert result.status is ism.Status.CONVERGED
    assert seen[-1].residual > method.gradient_tolerance
    before, after = seen[1:-1], seen[2:]
    x = np.array([np.sqrt(((b.x - a.x) ** 2).sum() / len(V)) for a, b in zip(before, after, strict=True)])
    energy = np.array([abs(b.energy - a.energy) / (1 + a.energy) for a, b in zip(before, after, strict=True)])
    small = (x < 1e-6) & (energy < 1e-12)
    means = [(x[max(0, k - 4): k + 1].mean(), energy[max(0, k - 4): k + 1].mean()) for k in range(len(x))]
    met = small | [mean_x < 1e-5 and mean_energy < 1e-11 for mean_x, mean_energy in means]
    assert met.tolist() == [False] * (len(x) - 1) + [True]


def test_in_wen_yins_search_the_fifth_trial_is_taken():
    class Rising:
        """An energy that is higher at each evaluation."""

        value = 0.0

        def evaluate(self, x):
            self.value += 1
            return self.value, problem.energy.evaluate(x)[1]

    problem = harmonic_problem(ism.check_mesh(V, F))
    assert len(list(CayleyBB().iterates(replace(problem, energy=Rising()), X))) == 1
    steps = CayleyBB(stop="wen-yin").iterates(replace(problem, energy=Rising()), X)
    assert [next(steps).tau for _ in range(2)] == [0, pytest.approx(1e-4)]


def test_rows_of_the_laplacian_take_a_third_of_the_iterations_where_vertices_are_unevenly_spread():
    """An ellipsoid whose vertices crowd at one end, in both metrics down to one norm of the same gradient."""
    x, f = ism.samples.sphere(642)
    v = moebius(x, np.array([0, 0, 0.5])) * [1, 1, 2]
    areas, rows = (ism.spherical_conformal_map(v, f, method=ism.Lai2014(rounds=0, plateau=0, metric=metric))
                   for metric in ("areas", "laplacian"))
    assert rows.status is areas.status is ism.Status.CONVERGED
    assert rows.iterations < areas.iterations / 3
    assert rows.energy == pytest.approx(areas.energy, rel=1e-6)
    first = [result.history[1].residual for result in (areas, rows)]
    assert first[0] == pytest.approx(first[1], rel=0.1)  # boosts are taken out in different metrics
