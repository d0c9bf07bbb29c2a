import re

import numpy as np
import pytest
from family import group_of
from scipy.stats import f_oneway, linregress
from scipy.stats import t as student

import igl_spheremap as ism

RNG = np.random.default_rng(0)
NOISE = group_of(RNG.normal(size=(20, 30, 3)))


def test_of_one_coordinate_the_statistic_is_that_of_analysis_of_variance():
    data, names = RNG.normal(size=(20, 30)), np.repeat(["a", "b", "c"], [6, 7, 7])
    found = ism.shapes.permutation_test(NOISE, names, data=data, permutations=19)
    expected = f_oneway(*(data[names == level] for level in "abc")).statistic
    assert np.allclose(found.statistic, expected)
    assert found.levels == ("a", "b", "c")
    means = [data[names == level].mean(axis=0) for level in "abc"]
    assert np.allclose(found.effect[:, :, 0], [means[1] - means[0], means[2] - means[0]])


def test_effects_and_errors_are_those_of_least_squares():
    x, age = RNG.normal(size=20), RNG.normal(size=20)
    found = ism.shapes.permutation_test(NOISE, x, covariates=age, permutations=19)
    columns = np.column_stack((x, np.ones(20), age))
    for point in (0, 7):
        y = NOISE.shapes[:, point]
        beta, squares = np.linalg.lstsq(columns, y, rcond=None)[:2]
        assert np.allclose(found.effect[0, point], beta[0])
        variance = squares.sum() / (3 * 17) * np.linalg.inv(columns.T @ columns)[0, 0]
        assert np.isclose(found.error[0, point], np.sqrt(variance))


def test_margins_are_those_of_students_t():
    x, data = RNG.normal(size=20), RNG.normal(size=(20, 4))
    found = ism.shapes.permutation_test(NOISE, x, data=data, permutations=19)
    for point in range(4):
        theirs = linregress(x, data[:, point])
        assert np.isclose(found.margin[0, point], theirs.stderr * student.ppf(0.975, 18))


def test_chance_finds_something_anywhere_in_one_of_twenty_experiments():
    found = 0
    for draw in range(200):
        labels = np.random.default_rng(draw).permutation(20) < 10
        found += (
            ism.shapes.permutation_test(NOISE, labels, permutations=99, seed=draw).p.min() <= 0.05
        )
    assert 2 <= found <= 20


def test_what_is_planted_is_found_where_it_is():
    labels = np.arange(20) < 10
    shapes = NOISE.shapes.copy()
    shapes[labels, :3] += [0, 0, 4]
    found = ism.shapes.permutation_test(group_of(shapes), labels, permutations=199, seed=1)
    assert (found.p[:3] == 1 / 200).all()
    assert (found.p[3:] > 0.05).all()
    assert np.abs(found.effect[0, :3] - [0, 0, 4]).max() < 4 * found.error[0, :3].max()
    assert (found.explained[:3] > 0.5).all()
    assert ((found.statistic > found.threshold) == (found.p <= 0.05)).all()


def test_what_a_covariate_explains_is_not_the_variables():
    age = np.arange(20.0)
    shapes = NOISE.shapes + 0.5 * age[:, None, None]
    variable = age + RNG.normal(size=20)
    assert ism.shapes.permutation_test(group_of(shapes), variable, permutations=99).p.min() <= 0.05
    assert (
        ism.shapes.permutation_test(
            group_of(shapes), variable, covariates=age, permutations=99
        ).p.min()
        > 0.05
    )


SITE = np.repeat([0, 1, 2], [6, 7, 7])
WAYS = {
    "dummies": (SITE[:, None] == [1, 2]).astype(float),
    "all dummies": (SITE[:, None] == [0, 1, 2]).astype(float),
    "a constant": np.column_stack((SITE == 1, SITE == 2, np.full(20, 7.0))),
    "twice": np.column_stack((SITE == 1, SITE == 1, 1e200 * (SITE == 2))),
}


@pytest.mark.parametrize("augment", [False, True])
def test_p_does_not_change_with_how_covariates_are_written(augment):
    x = np.random.default_rng(3).normal(size=20)
    one, *others = (
        ism.shapes.permutation_test(NOISE, x, covariates=each, permutations=99, augment=augment)
        for each in WAYS.values()
    )
    for found in others:
        assert np.allclose(found.statistic, one.statistic)
        assert (found.p == one.p).all()


def test_statistic_and_p_are_those_of_nilearn():
    theirs = pytest.importorskip("nilearn.mass_univariate").permuted_ols
    rng = np.random.default_rng(4)
    x, age, data = rng.normal(size=(20, 1)), rng.normal(size=(20, 2)), rng.normal(size=(20, 30))
    data[:, 0] += x[:, 0]
    found = ism.shapes.permutation_test(NOISE, x, covariates=age, data=data, permutations=999)
    out = theirs(x, data, age, n_perm=999, random_state=0, output_type="dict")
    assert np.allclose(found.statistic, out["t"][0] ** 2)
    assert np.abs(found.p - 10 ** -out["logp_max_t"][0]).max() < 5 * np.sqrt(0.25 / 999)


def test_units_of_data_and_variable_change_no_p():
    x = RNG.normal(size=20)
    one = ism.shapes.permutation_test(NOISE, x, permutations=19)
    for unit in (1e300, 1e-300):
        found = ism.shapes.permutation_test(
            NOISE, unit * x, data=unit * NOISE.shapes, permutations=19
        )
        assert (found.p == one.p).all()
        assert np.allclose(found.effect, one.effect)
        assert np.allclose(found.error, one.error)


def skewed(draw):
    """Eleven members, two covariates and a variable that goes with them, and data that depend on neither."""
    rng = np.random.default_rng(draw)
    covariates, own = np.exp(2 * rng.normal(size=(11, 2))), np.exp(2 * rng.normal(size=11))
    return covariates.mean(axis=1) + own, covariates, np.exp(2 * rng.normal(size=(11, 30, 3)))


def test_augmented_models_keep_the_promise_for_skewed_data():
    few, kept, broken = group_of(RNG.normal(size=(11, 30, 3))), 0, 0
    for draw in range(100):
        x, z, data = skewed(draw)
        options = {"covariates": z, "data": data, "permutations": 99}
        kept += ism.shapes.permutation_test(few, x, **options, augment=True).p.min() <= 0.05
        broken += ism.shapes.permutation_test(few, x, **options).p.min() <= 0.05
    assert kept <= 5 < broken


def test_few_members_for_the_covariates_are_said():
    x, z, _ = skewed(0)
    few = group_of(RNG.normal(size=(11, 30, 3)))
    assert (
        "11 members are few for 2"
        in ism.shapes.permutation_test(few, x, covariates=z, permutations=19).notes[0]
    )
    assert not ism.shapes.permutation_test(
        few, x, covariates=z, permutations=19, augment=True
    ).notes
    assert not ism.shapes.permutation_test(few, x, permutations=19).notes


@pytest.mark.parametrize(
    ("variable", "least"),
    [
        ("aaabbb", 2 * 6 * 6 / 720),  # permutations within and of the groups
        ("aab", 2 / 6),
        ([1, 2, 3], 2 / 6),
        ([1, 2, 4], 1 / 6),
        ("aaaabbbb", None),
    ],
)
def test_members_too_few_for_any_finding_are_told_with_the_least_p(variable, least):
    count = len(variable)
    found = ism.shapes.permutation_test(
        group_of(NOISE.shapes[:count]), [*variable], permutations=4999
    )
    if least is None:
        assert not found.notes
        return
    (note,) = found.notes
    said = float(re.search(r"no p is below (\S+),", note)[1])
    assert np.isclose(said, least, rtol=0.1)
    assert found.p.min() >= 0.99 * said


def test_augmented_models_find_what_is_planted():
    labels = np.arange(20) < 10
    shapes = NOISE.shapes.copy()
    shapes[labels, :3] += [0, 0, 8]
    found = ism.shapes.permutation_test(
        group_of(shapes), labels, covariates=np.arange(20) % 5, permutations=99, augment=True
    )
    assert (found.p[:3] <= 0.05).all()
    assert (found.p[3:] > 0.05).all()


@pytest.mark.parametrize(
    ("variable", "options", "words"),
    [
        (np.ones(20), {}, "constant"),
        (np.arange(20), {"covariates": 2.0 * np.arange(20)}, "follows from"),
        (np.arange(5), {}, "for 20 members"),
        (["a", "b"], {}, "2 values for 20 members"),
        (np.full(20, np.nan), {}, "finite"),
        (np.arange(20), {"data": np.ones(20)}, "data of shape"),
        (np.arange(20), {"covariates": RNG.normal(size=(20, 18))}, "too few"),
        (
            np.arange(20),
            {"covariates": RNG.normal(size=(20, 9)), "augment": True},
            "with augment=True",
        ),
        (np.ones((20, 1)) * np.arange(20)[:, None] @ [[1, 2]], {}, "follows from"),
        (["a"] * 20, {}, "'a' for all"),
        (["a"] * 10 + ["NA"] * 10, {}, "no value for 10"),
        (["a"] * 19 + [None], {}, "no value for 1"),
        (np.arange(20), {"covariates": ["a", "b"] * 10}, "give numbers"),
    ],
)
def test_what_can_not_be_tested_is_said(variable, options, words):
    with pytest.raises(ism.MeshError, match=words):
        ism.shapes.permutation_test(NOISE, variable, **options)


@pytest.mark.parametrize("augment", [False, True])
@pytest.mark.parametrize("value", [0.0, 7e8, 1e-300])
def test_where_nothing_varies_nothing_is_found(value, augment):
    """Rounding is no variance: not that of a mean of equal numbers, and not what is left of what covariates explain."""
    age = RNG.normal(size=20)
    explained = value * (3 + age)[:, None] * np.ones((20, 9))
    for data, covariates in ((np.full((20, 9), value), age), (explained, age)):
        found = ism.shapes.permutation_test(
            NOISE,
            RNG.normal(size=20),
            covariates=covariates,
            data=data,
            permutations=19,
            augment=augment,
        )
        assert (found.p == 1).all()
        for each in (found.statistic, found.explained, found.effect, found.error, found.margin):
            assert (each == 0).all()
        assert "nothing can depend on the variable" in found.notes[0]


def test_points_that_do_not_vary_change_nothing_for_the_others():
    x, data = RNG.normal(size=20), RNG.normal(size=(20, 5))
    data[:, 1] += 5 * x
    still = np.column_stack((np.full(20, 3.7), data, np.zeros(20)))
    one, other = (
        ism.shapes.permutation_test(NOISE, x, data=each, permutations=99) for each in (data, still)
    )
    assert (one.p == other.p[1:-1]).all()
    assert (other.p[[0, -1]] == 1).all()
    assert (other.explained[[0, -1]] == 0).all()


@pytest.mark.parametrize(
    "pair", [("control", "control "), ("\u00e4", "a\u0308"), ("a b", "a\u00a0 b")]
)
def test_levels_that_look_the_same_are_one(pair):
    names = np.where(np.arange(20) < 10, *pair).astype(object)
    with pytest.raises(ism.MeshError, match="for all members"):
        ism.shapes.permutation_test(NOISE, names, permutations=19)
    names[:5] = "other"
    assert len(ism.shapes.permutation_test(NOISE, names, permutations=19).levels) == 2
