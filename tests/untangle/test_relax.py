"""Descent on the loss of stars: right derivatives, no folding, less loss."""

from __future__ import annotations

import numpy as np
import pytest
from triangulations import drawn_to_pole, icosphere, unit

from igl_spheremap.mesh.measure import corner_angles
from igl_spheremap.sphere.rows import column_axes
from igl_spheremap.untangle.relax import AngleLoss, relax_angles
from igl_spheremap.verify.certificate import orientation_signs


def _stretched(level=3):
    """A sphere, the same sphere stretched as a source, and noise that folds nothing."""
    x, f = icosphere(level)
    noisy = unit(x + 0.1 * 0.5**level * np.random.default_rng(0).normal(size=x.shape))
    assert (orientation_signs(noisy, f) > 0).all()
    return x * [1.0, 1.2, 1.5], noisy, f


def _values(loss, x, f):
    return loss.values((x[f[:, 1]] - x[f[:, 0]]).T, (x[f[:, 2]] - x[f[:, 0]]).T)


def _total(loss, x, f):
    return _values(loss, x, f).sum()


@pytest.mark.parametrize("k", [0, 1, 2])
def test_gradients_agree_with_differences(k):
    v, x, f = _stretched()
    loss = AngleLoss(corner_angles(v, f).T).at(3 * np.arange(len(f)) + k)
    p, a, b = (x[f[:, (k + j) % 3]].T for j in range(3))
    axes = column_axes(p)
    values, gradient, _ = loss.model(a - p, b - p, axes)
    assert np.allclose(values, loss.values(a - p, b - p), rtol=1e-12)
    h = 1e-6
    for i in range(2):
        step = h * axes[i]
        slope = (
            loss.values(a - p - step, b - p - step) - loss.values(a - p + step, b - p + step)
        ) / (2 * h)
        assert np.allclose(gradient[i], slope, rtol=1e-5, atol=1e-5 * np.abs(slope).max())


def test_loss_falls_with_every_sweep_and_no_face_folds():
    v, x, f = _stretched()
    loss = AngleLoss(corner_angles(v, f).T)
    last = _total(loss, x, f)
    for _ in range(4):
        x = relax_angles(x, f, loss, sweeps=1, tolerance=0)
        now = _total(loss, x, f)
        assert now < last
        assert (orientation_signs(x, f) > 0).all()
        last = now


@pytest.mark.filterwarnings("error")
def test_sides_without_length_raise_no_warning_and_spoil_no_number():
    v, x, f = _stretched()
    x[f[7, 1]] = x[f[7, 0]]
    around = np.isin(f, f[7]).any(axis=1)
    y = relax_angles(x, f, AngleLoss(corner_angles(v, f).T), sweeps=3)
    assert np.isfinite(y).all()
    assert (orientation_signs(y, f)[~around] > 0).all()


def test_an_isometric_image_is_a_fixed_point():
    x, f = icosphere(2)
    assert np.abs(relax_angles(x, f, AngleLoss(corner_angles(x, f).T), sweeps=5) - x).max() < 1e-9


def test_only_movable_vertices_move():
    v, x, f = _stretched()
    movable = x[:, 2] > 0.5
    y = relax_angles(x, f, AngleLoss(corner_angles(v, f).T), movable, sweeps=5)
    moved = (x != y).any(axis=1)
    assert moved.any()
    assert not moved[~movable].any()


def test_sweeps_move_vertices_beside_an_end_of_an_axis_alike_at_every_scale():
    v, x, f = _stretched()
    loss, movable, relaxed = AngleLoss(corner_angles(v, f).T), x[:, 2] > 0.3, []
    for size in (2.0**-40, 2.0**-700):
        y = drawn_to_pole(x, size)
        z = relax_angles(y, f, loss, movable, sweeps=3, tolerance=0)
        assert (y[movable] != z[movable]).any(axis=1).mean() > 0.9
        relaxed.append(z[movable, :2] / size)
    assert relaxed[1] == pytest.approx(relaxed[0], rel=1e-9)


def test_the_angle_loss_of_a_similar_image_is_its_smoothing():
    v, _, f = _stretched()
    loss = AngleLoss(corner_angles(v, f).T)
    assert np.isclose(_total(loss, 7 * v, f), 3 * loss.smoothing * len(f), rtol=1e-9)
    assert _total(loss, v * [1, 1, 3], f) > _total(loss, v, f)


def test_the_loss_does_not_depend_on_which_corner_comes_first():
    v, x, f = _stretched()
    loss = AngleLoss(corner_angles(v, f).T)
    turned = [
        _values(loss.at(3 * np.arange(len(f)) + k), x, np.roll(f, -k, axis=1)) for k in range(3)
    ]
    assert np.allclose(turned, turned[0], rtol=1e-9)
    some = np.arange(0, len(f), 2)
    assert (_values(loss.take(some), x, f[some]) == turned[0][some]).all()
