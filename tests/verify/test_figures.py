"""Statistics of distortions, also where there is nothing to take them of."""

import warnings

import numpy as np

import igl_spheremap as ism
from igl_spheremap.verify.figures import angle_figures, log_figures


def test_figures_are_those_of_numpy():
    d = np.random.default_rng(0).normal(size=(50, 3))
    expected = {"mean": np.abs(d).mean(), "p99": np.percentile(np.abs(d), 99), "max": np.abs(d).max()}
    assert log_figures(d) == expected
    assert angle_figures(d) == expected | {"median": np.median(np.abs(d)), "p95": np.percentile(np.abs(d), 95)}


def test_ratios_of_zero_areas_are_left_out():
    assert log_figures(np.array([0.5, -1.5, np.inf, -np.inf, np.nan])) == log_figures(np.array([0.5, 1.5]))


def test_a_surface_without_any_area_has_no_figures_but_a_summary():
    """All vertices at two points: no face has an area, so that no logarithm is finite."""
    x, f = ism.samples.sphere(42)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        result = ism.spherical_conformal_map(np.where(x[:, [0]] > 0, 1.0, 0.0) * [1, 0, 0], f)
        assert np.isnan(list(log_figures(result.area_ratios()).values())).all()
        assert "nan on average" in result._repr_html_()
