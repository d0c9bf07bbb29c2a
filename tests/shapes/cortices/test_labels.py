"""The margin of a label is the probability of its place under a Gaussian error, less that of the next one."""

import math

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.samples import sphere
from igl_spheremap.shapes.cortices.labels import label_margin


@pytest.fixture(scope="module")
def globe():
    x, f = sphere(10_242)
    return ism.sphere_map(x * [1, 1.2, 0.8], f, x)


def test_at_a_straight_border_it_is_the_error_function(globe):
    """Of a Gaussian at distance d from a straight line, erf(d / (sqrt(2) sigma)) more lies on this side."""
    width = 0.1
    d = np.linspace(-0.25, 0.25, 41)
    points = np.column_stack((np.sin(d), np.cos(d), np.zeros_like(d)))
    labels, margin = label_margin(globe, (globe.sphere[:, 0] > 0) * 5, points, width)
    expected = np.array([math.erf(abs(each) / (math.sqrt(2) * width)) for each in d])
    assert np.array_equal(labels[np.abs(d) > 0.02], 5 * (d[np.abs(d) > 0.02] > 0))
    assert np.abs(margin - expected).max() < 0.17
    assert np.abs(margin - expected).mean() < 0.06


def test_the_second_of_many_counts(globe):
    """Where three labels meet, each has a third."""
    turn = np.arctan2(globe.sphere[:, 1], globe.sphere[:, 0]) // (2 * np.pi / 3)
    _, margin = label_margin(globe, turn.astype(int), [[0.001, 0.001, 1]], 0.1)
    assert margin[0] < 0.25
    assert label_margin(globe, turn.astype(int), [[1, 0.5, 0]], 0.1)[1] == 1


def test_without_an_error_every_label_is_sure(globe):
    labels, margin = label_margin(globe, np.arange(len(globe.sphere)), globe.sphere, 0.0)
    assert np.array_equal(labels, np.arange(len(labels)))
    assert (margin == 1).all()
