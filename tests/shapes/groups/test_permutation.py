import numpy as np
import pytest
from scipy.stats import f_oneway

import igl_spheremap as ism
from igl_spheremap.shapes.groups.group import Group, Member

RNG = np.random.default_rng(0)
NONE = np.empty((30, 0))


def group_of(shapes):
    """A group of these shapes, without modes."""
    mean = shapes.mean(axis=0)
    members = tuple(Member(str(k), None, 1.0, 1.0, 1.0) for k in range(len(shapes)))
    return Group(mean, np.zeros((0, 3), int), mean, shapes, np.empty((0, *mean.shape)), np.empty(0),
                 np.empty((len(shapes), 0)), members, np.ones(len(mean)), np.ones(len(mean)), NONE, NONE, {}, ())


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


def test_chance_finds_something_anywhere_in_one_of_twenty_experiments():
    found = 0
    for draw in range(200):
        labels = np.random.default_rng(draw).permutation(20) < 10
        found += ism.shapes.permutation_test(NOISE, labels, permutations=99, seed=draw).p.min() <= 0.05
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
    assert ism.shapes.permutation_test(group_of(shapes), variable, covariates=age, permutations=99).p.min() > 0.05


@pytest.mark.parametrize(("variable", "options", "words"), [
    (np.ones(20), {}, "constant"), (np.arange(20), {"covariates": 2.0 * np.arange(20)}, "follows from"),
    (np.arange(5), {}, "for 20 members"), (["a", "b"], {}, "2 values for 20 members"),
    (np.full(20, np.nan), {}, "finite"), (np.arange(20), {"data": np.ones(20)}, "data of shape"),
    (np.arange(20), {"covariates": RNG.normal(size=(20, 18))}, "too few"),
])
def test_what_can_not_be_tested_is_said(variable, options, words):
    with pytest.raises(ism.MeshError, match=words):
        ism.shapes.permutation_test(NOISE, variable, **options)
