"""The chart of checkerboards is conformal and wound around its poles."""

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.apps.viewer.colouring import (
    Colours,
    checkerboard,
    deepest_tips,
    mercator_corners,
    poles_at,
)
from igl_spheremap.draw.palette import SURFACE
from igl_spheremap.mesh.measure import corner_angles


@pytest.mark.parametrize("poles", [[[0, 0, 1], [0, 0, -1]], [[0.6, 0, 0.8], [0, 1, 0]]])
def test_the_chart_keeps_the_angles_of_small_faces(poles):
    poles = np.array(poles, dtype=float)
    errors = []
    for n in (2500, 10000):
        y, f = ism.samples.make("sphere", n_vertices=n)
        corners = mercator_corners(y, f, poles).reshape(-1, 3, 2)
        away = (y @ poles.T).max(axis=1)[f].max(axis=1) < 0.8
        flat = np.concatenate((corners, np.zeros((len(f), 3, 1))), axis=2)[away].reshape(-1, 3)
        own = np.arange(len(flat)).reshape(-1, 3)
        chart, sphere = (corner_angles(p, g) for p, g in ((flat, own), (y, f[away])))
        errors.append(np.abs(chart - sphere).mean())
    assert 1.7 < errors[0] / errors[1] < 2.4
    assert errors[1] < 0.01


def test_the_chart_is_wound_once_around_each_pole_with_latitude_rising_to_the_first():
    dino = ism.check_mesh(*ism.samples.make("dino", n_vertices=1500))
    y = ism.spherical_conformal_map(dino.v, dino.f).sphere
    tips = poles_at(y, deepest_tips(dino, y))
    corners = mercator_corners(y, dino.f, tips).reshape(-1, 3, 2)
    assert np.isfinite(corners).all()
    assert np.abs(corners[..., 0] - corners[:, :1, 0]).max() <= 0.5
    latitude = np.full(len(y), np.nan)
    latitude[dino.f] = corners[..., 1]
    assert np.argmax(latitude) in np.argsort(np.linalg.norm(y - tips[0], axis=1))[:8]
    assert np.argmin(latitude) in np.argsort(np.linalg.norm(y - tips[1], axis=1))[:8]


def test_the_squares_of_a_conformal_map_are_squares_on_the_surface():
    mesh = ism.check_mesh(*ism.samples.make("spheroid", n_vertices=4000))
    angles = []
    for balance in (0, 1):
        x = ism.balanced_spherical_map(mesh.v, mesh.f, balance=balance).sphere
        corners = checkerboard(mesh, x).checks.reshape(-1, 3, 2)
        flat = np.concatenate((corners, np.zeros((len(mesh.f), 3, 1))), axis=2).reshape(-1, 3)
        away = np.ptp(corners, axis=1).max(axis=1) < 1  # near a pole a face is wider than a square
        chart = corner_angles(flat, np.arange(len(flat)).reshape(-1, 3))
        angles.append(np.degrees(np.abs(chart - corner_angles(mesh.unit, mesh.f)))[away].mean())
    assert angles[0] < 2 < angles[1]


def test_caps_are_grey_and_count_in_no_scale():
    v, f = ism.samples.make("pear", n_vertices=1000)
    caps = v[f, 2].mean(axis=1) > np.quantile(v[:, 2], 0.9)
    x = ism.spherical_conformal_map(v, f).sphere.copy()
    top = int(v[:, 2].argmax())
    x[top] *= -1  # the largest of all errors
    mesh = ism.check_mesh(v, f, caps=caps)
    around = (f == top).any(axis=1)
    assert caps[around].all()
    for subject in ("foldings", "angle differences", "area distortion"):
        colours = Colours(subject).of(mesh, x)
        assert (colours.colours[caps] == SURFACE).all()
        assert not (colours.colours[~caps] == SURFACE).all(axis=1).any()
    squares = Colours("checkerboard").of(mesh, x).checks.reshape(-1, 3, 2)
    assert (squares[caps] == 0.5).all()
    own, all_faces = (
        Colours("area distortion").of(each, x).legends[0].high
        for each in (mesh, ism.check_mesh(v, f))
    )
    assert own <= all_faces
