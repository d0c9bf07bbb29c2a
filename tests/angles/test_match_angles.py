"""Newton steps on angle differences: the right derivatives, the right system, and the gauge held; polishing."""

from __future__ import annotations

from itertools import islice, pairwise

import numpy as np
import pytest
from triangulations import drawn_to_pole, icosphere, unit

from igl_spheremap import samples, spherical_conformal_map
from igl_spheremap.angles.match_angles import Aitken, AngleProblem
from igl_spheremap.mesh.check import check_mesh
from igl_spheremap.mesh.measure import corner_angles
from igl_spheremap.newton.loop import Levenberg, bordered_step, newton
from igl_spheremap.newton.system import PAIRS, VertexSystem
from igl_spheremap.sphere.rows import tangent_axes
from igl_spheremap.verify.signs import orientation_signs

X, F = icosphere(3)
A = np.full(len(X), 1 / len(X))
NOISY = unit(X + 0.02 * np.random.default_rng(0).normal(size=X.shape))
OFF_CENTRE = unit(NOISY + np.array([0.0, 0.0, 0.05]))


def problem(smoothing=None):
    """The angles of a sphere."""
    return AngleProblem(F, corner_angles(X, F).T, A, A @ X, smoothing)


def steps(x, smoothing):
    """Maps of undamped steps from `x`."""
    damping = Levenberg(VertexSystem(F, len(X)), np.full(len(X), 1e-8), systems=100)
    return newton(problem(smoothing), damping, x)


def axes_at(x):
    return np.stack(tangent_axes(x)).transpose(0, 2, 1)


def test_derivatives_agree_with_differences():
    h, t = 1e-6, np.random.default_rng(1).normal(size=(2, len(X)))
    step = h * np.einsum("an,ain->ni", t, axes_at(NOISY))
    slope = (corner_angles(NOISY + step, F) - corner_angles(NOISY - step, F)) / (2 * h)
    difference, J = problem().linearised(NOISY, axes_at(NOISY))
    assert np.allclose(difference, corner_angles(NOISY, F).T - problem().source, atol=1e-9)
    assert np.allclose(np.einsum("ijam,ajm->mi", J, t[:, F.T]), slope, rtol=1e-5, atol=1e-5)


def test_the_gradient_is_the_first_variation_of_the_reweighted_squares():
    """With a smoothing far above all differences the loss is half of their squares, over the smoothing."""
    p, h = problem(smoothing=1e6), 1e-6
    model = p.model(NOISY)
    t = np.random.default_rng(1).normal(size=model.gradient.shape)
    move = h * p.move(NOISY, model, t)
    loss = [
        ((corner_angles(NOISY + sign * move, F).T - p.source) ** 2).sum() / 2e6 for sign in (1, -1)
    ]
    assert np.isclose((model.gradient * t).sum(), (loss[0] - loss[1]) / (2 * h), rtol=1e-5)


def test_the_model_in_units_of_edges_is_alike_at_every_scale_beside_an_end_of_an_axis():
    at = np.flatnonzero((X[F][..., 2] > 0.3).all(axis=1))
    coarse, fine = (
        problem(0.1).model(drawn_to_pole(NOISY, size)) for size in (2.0**-40, 2.0**-700)
    )
    assert np.abs(coarse.blocks[..., at]).max() > 1
    assert fine.blocks[..., at] == pytest.approx(coarse.blocks[..., at], rel=1e-9, abs=1e-9)
    inside = np.setdiff1d(F[at], F[np.setdiff1d(np.arange(len(F)), at)])
    assert fine.gradient[:, inside] == pytest.approx(coarse.gradient[:, inside], rel=1e-9, abs=1e-9)


def test_a_step_is_that_of_the_dense_system_with_its_border():
    x, f = icosphere(1)
    n = len(x)
    y = unit(x + 0.02 * np.random.default_rng(0).normal(size=x.shape))
    p = AngleProblem(f, corner_angles(x, f).T, np.full(n, 1 / n), np.array([0.0, 0.0, 0.01]))
    model, system = p.model(y), VertexSystem(f, n)
    dense = np.zeros((2 * n, 2 * n))
    for block, (i, j) in zip(model.blocks, PAIRS, strict=True):
        for a in range(2):
            for b in range(2):
                np.add.at(dense, (2 * f[:, i] + a, 2 * f[:, j] + b), block[a, b])
                if i != j:
                    np.add.at(dense, (2 * f[:, j] + b, 2 * f[:, i] + a), block[a, b])
    dense[np.diag_indices(2 * n)] *= 1 + 1e-3
    C, c = model.border
    border = C.transpose(0, 2, 1).reshape(3, -1)
    whole = np.block([[dense, border.T], [border, np.zeros((3, 3))]])
    expected = (
        np.linalg.solve(whole, np.append(-model.gradient.T.ravel(), c))[: 2 * n].reshape(n, 2).T
    )
    step = bordered_step(
        system, system.factorize(system.damped(system.assemble(model.blocks), 1e-3)), model
    )
    assert np.allclose(step, expected, atol=1e-9 * np.abs(expected).max())


def test_steps_lead_back_to_the_sphere_quadratically_at_the_end():
    """Plain least squares: the residual vanishes at the solution."""
    trials = list(islice(steps(NOISY, smoothing=1.0), 6))
    assert all((orientation_signs(trial.x, F) > 0).all() for trial in trials)
    differences = [problem().value(NOISY), *(trial.value for trial in trials)]
    assert differences[-1] < 1e-6
    steep = [b / a**2 for a, b in pairwise(differences) if 1e-4 < a < 1]
    assert max(steep) < 10


def test_the_centroid_goes_where_it_is_to_be():
    *_, last = islice(steps(OFF_CENTRE, smoothing=1.0), 4)
    assert np.linalg.norm(A @ last.x - A @ X) < 1e-4 * np.linalg.norm(A @ OFF_CENTRE - A @ X)


def test_a_map_that_has_the_angles_stays():
    assert all(np.abs(trial.x - X).max() < 1e-9 for trial in islice(steps(X, smoothing=0.01), 2))


def test_systems_that_are_used_up_end_the_steps():
    damping = Levenberg(VertexSystem(F, len(X)), np.full(len(X), 1e-8), systems=2)
    assert len(list(newton(problem(), damping, NOISY))) <= 2
    assert damping.systems == 0


def test_damping_grows_where_a_step_folds():
    """One vertex is pushed next to another's star: only there steps are shortened."""
    x = X.copy()
    star = F[(F == 300).any(axis=1)]
    x[300] = unit((0.02 * X[300] + 0.98 * X[star[star != 300][0]])[None])[0]
    damping = Levenberg(VertexSystem(F, len(X)), np.full(len(X), 1e-8), systems=20)
    trials = list(newton(problem(), damping, x))
    assert trials
    assert all((orientation_signs(trial.x, F) > 0).all() for trial in trials)
    assert trials[-1].value < 0.1 * problem().value(x)


def test_what_a_step_folds_is_mended_by_small_moves_or_by_embedding():
    p = problem()
    i, j = F[0, :2]
    for target in (X[j] + 0.02 * (X[j] - X[i]), -X[i]):
        move = np.zeros_like(X)
        move[i] = target - X[i]
        trial = p.accept(X, move)
        assert trial.folded.any()
        assert np.isfinite(trial.value)
        assert (orientation_signs(trial.x, F) > 0).all()


@pytest.mark.parametrize(
    ("first", "factor", "least"), [(0.3, 0.5, 0.01), (0.2, 0.9, 0.05), (0.01, 0.1, 0.02)]
)
def test_steps_end_where_the_rest_of_a_geometric_series_is_less_than_the_least_gain(
    first, factor, least
):
    gains = first * factor ** np.arange(200)
    rest = np.array([gains[k + 1 :].sum() for k in range(len(gains))])
    end = Aitken(least)
    ended = next(k for k, gain in enumerate(gains) if end.reached(gain))
    assert ended == max(0, int(np.argmax(rest < least)))
    assert end.further == pytest.approx(rest[ended]) if ended else end.further == first


def test_gains_that_do_not_fall_never_end_and_damped_steps_end_by_their_own():
    end = Aitken(0.1)
    assert not any(end.reached(gain) for gain in (0.2, 0.2, 0.3, 0.4))
    assert end.further == np.inf
    assert not end.reached(0.02, predicts=False)
    assert end.reached(0.009, predicts=False)
    assert end.further == np.inf


def test_what_becomes_of_a_step_does_not_depend_on_the_models_made_before():
    p, move = problem(), np.zeros_like(NOISY)
    i, j = F[0, :2]
    move[i] = NOISY[j] + 0.02 * (NOISY[j] - NOISY[i]) - NOISY[i]
    before = p.accept(NOISY, move)
    p.model(OFF_CENTRE)
    assert before.folded.any()
    assert np.isfinite(before.value)
    assert (p.accept(NOISY, move).x == before.x).all()


def test_angle_steps_lower_the_mean():
    v, f = samples.make("bird", n_vertices=1500)
    plain, polished = (spherical_conformal_map(v, f, polish=polish) for polish in (None, "angles"))
    assert polished.certificate.folding_free
    before, after = (np.abs(result.angle_differences()).mean() for result in (plain, polished))
    assert after < 0.93 * before


def test_a_polished_map_is_in_the_gauge():
    v, f = samples.make("bird", n_vertices=1500)
    result = spherical_conformal_map(v, f, polish="angles")
    assert result.certificate.folding_free
    assert np.linalg.norm(check_mesh(v, f).A @ result.sphere) < 1e-12
