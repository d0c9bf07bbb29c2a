import numpy as np

from igl_spheremap.shapes.groups.modes import model_figures, principal_modes

RNG = np.random.default_rng(0)
WEIGHTS = RNG.uniform(1, 2, 30)
SHARES = WEIGHTS / WEIGHTS.sum()
FIELDS = RNG.normal(size=(2, 30, 3))


def planted(count, noise=0.0):
    """Deviations that two fields make, and their amounts."""
    amounts = RNG.normal(size=(count, 2)) * [3, 1]
    amounts -= amounts.mean(axis=0)
    return np.tensordot(amounts, FIELDS, 1) + noise * RNG.normal(size=(count, 30, 3)), amounts


def test_modes_are_orthonormal_over_the_area_and_make_the_shapes():
    away, _ = planted(12)
    found = principal_modes(away, WEIGHTS, 10)
    assert len(found.modes) == 2
    assert np.allclose(np.einsum("n,jnd,knd->jk", SHARES, found.modes, found.modes), np.eye(2))
    assert np.allclose(np.tensordot(found.scores, found.modes, 1), away)
    assert np.allclose(found.variances, found.scores.var(axis=0, ddof=1))
    assert np.isclose(found.variances.sum(), np.einsum("n,knd->", SHARES, away**2) / 11)


def test_a_mode_has_one_of_two_signs():
    away, _ = planted(12)
    assert ((principal_modes(away, WEIGHTS, 2).scores ** 3).sum(axis=0) > 0).all()
    assert ((principal_modes(-away, WEIGHTS, 2).scores ** 3).sum(axis=0) > 0).all()


def test_two_planted_modes_are_compact_general_and_specific():
    away, _ = planted(40)
    away -= away.mean(axis=0)
    found = model_figures(away, WEIGHTS, 5)
    assert np.isclose(found.compactness[-1], 1)
    assert found.generalisation[1] < 1e-6 < found.generalisation[0]


def test_leaving_one_out_is_as_by_hand_and_noise_makes_models_worse():
    away, _ = planted(12, noise=0.1)
    away -= away.mean(axis=0)
    found = model_figures(away, WEIGHTS, 3)
    rows = (away * np.sqrt(SHARES)[:, None]).reshape(12, -1)
    squares = []
    for k in range(12):
        rest = np.delete(rows, k, axis=0)
        axes = np.linalg.svd(rest - rest.mean(axis=0), full_matrices=False)[2][:2]
        off = rows[k] - rest.mean(axis=0)
        squares.append(((off - axes.T @ (axes @ off)) ** 2).sum())
    assert np.isclose(found.generalisation[1], np.sqrt(np.mean(squares)))
    assert (np.diff(found.compactness) > 0).all()
    assert (np.diff(found.generalisation) < 0).all()
    assert (found.specificity > 0).all()
