"""The caller's np.errstate decides nothing: numbers that over- and underflow on the way give the same results."""

import inspect

import numpy as np
import pytest
from doors import PUBLIC
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap.descent.energies import p_harmonic_energy

X, F = icosphere(2)
WILD = X * 10 ** np.random.default_rng(0).uniform(-200, 150, size=(len(X), 1))  # rows of all sizes
FOLDED = np.where(np.isin(np.arange(len(X)), [3, 5])[:, None], -X, X)


@pytest.mark.parametrize(
    "call",
    [
        lambda: ism.check_mesh(WILD, F).unit,
        lambda: ism.certify(WILD, F).degree,
        lambda: ism.certify(1e200 * X, F).off_sphere,
        lambda: ism.cayley_update(X, X[::-1], 1e200),
        lambda: ism.cayley_update(X, X[::-1], 1e-200),
        lambda: ism.gauss_map(WILD, F),
        lambda: ism.angle_differences(WILD, F, X),
        lambda: ism.conformal_factor(WILD, F, X),
        lambda: ism.harmonic_energy(WILD, F, X),
        lambda: p_harmonic_energy(WILD, F, X, 1.5),
        lambda: ism.weighted_eigen_projection(X, F, FOLDED).star_map,
        lambda: ism.spherical_conformal_map(1e-200 * X, F).sphere,
        lambda: ism.repair_foldings(X, F, FOLDED).sphere,
        lambda: ism.SphereLocator(X, F).locate(WILD[:40]).weights,
        lambda: ism.texture_atlas(WILD, F).uv,
        lambda: ism.samples.make("bird", n_vertices=900)[0],
        lambda: ism.samples.make("spheroid", n_vertices=500, aspect=30)[0],
    ],
    ids=lambda call: inspect.getsource(call).split(":")[1].split("(")[0].strip(),
)
def test_results_do_not_depend_on_the_callers_errstate(call):
    with np.errstate(all="ignore"):
        expected = call()
    with np.errstate(all="raise"):
        assert np.array_equal(call(), expected, equal_nan=True)


def test_every_public_function_has_a_gate():
    functions = {name: one for name, one in PUBLIC.items() if inspect.isfunction(one)}
    assert [
        name for name, function in functions.items() if not hasattr(function, "__wrapped__")
    ] == []
