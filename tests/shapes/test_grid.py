"""Images on grids of latitudes and longitudes: layout, round trips, seams and poles."""

from __future__ import annotations

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.shapes.basis import gauss_rows
from igl_spheremap.sphere.rows import unit_rows

POINTS = unit_rows(np.random.default_rng(0).normal(size=(500, 3)))
EDGES = np.array([[0, 0, 1], [0, 0, -1], [-1, 0, 0], [-1, 1e-17, 0], [1, 0, 0]], dtype=float)


@pytest.fixture(scope="module")
def ball():
    x, f = ism.samples.sphere(10 * 4**4 + 2)
    return ism.sphere_map(x * [1, 2, 3], f, x)


@pytest.mark.parametrize("kind", ["equirectangular", "gauss"])
def test_rows_run_from_north_and_columns_east(ball, kind):
    places = ism.to_grid(ball, ball.sphere, kind, rows=40)
    assert places.shape == (40, 80, 3)
    theta = np.arccos(gauss_rows(40)[0]) if kind == "gauss" else np.pi * (np.arange(40) + 0.5) / 40
    phi = 2 * np.pi * np.arange(80) / 80 if kind == "gauss" else 2 * np.pi * (np.arange(80) + 0.5) / 80 - np.pi
    directions = unit_rows(places.reshape(-1, 3)).reshape(places.shape)
    assert np.abs(directions[..., 2] - np.cos(theta)[:, None]).max() < 1e-12
    assert np.abs(directions[..., 0] - np.sin(theta)[:, None] * np.cos(phi)).max() < 1e-12


@pytest.mark.parametrize("kind", ["equirectangular", "gauss"])
def test_back_from_the_grid_at_second_order_over_seam_and_poles(kind):
    where = np.concatenate((POINTS, EDGES))
    errors = []
    for rows in (30, 60, 120):
        x, f = ism.samples.sphere(12)
        fine = ism.to_grid(ism.sphere_map(x, f, x), x, kind, rows)  # only for its points
        places = unit_rows(fine.reshape(-1, 3)).reshape(fine.shape)
        errors.append(np.abs(ism.from_grid(np.exp(places[..., 0] - places[..., 2]), where, kind)
                             - np.exp(where[:, 0] - where[:, 2])).max())
    assert np.log2(errors[0] / errors[2]) > 2 * 1.8


@pytest.mark.parametrize("kind", ["equirectangular", "gauss"])
def test_grid_points_keep_their_values_and_labels(ball, kind):
    rng = np.random.default_rng(1)
    x, f = ism.samples.sphere(12)
    places = ism.to_grid(ism.sphere_map(x, f, x), x, kind, 20).reshape(-1, 3)
    image = rng.normal(size=(20, 40, 2))
    assert np.allclose(ism.from_grid(image, places, kind), image.reshape(-1, 2), atol=1e-11)
    parcels = rng.integers(0, 9, (20, 40))
    assert np.array_equal(ism.from_grid(parcels, places, kind, labels=True), parcels.ravel())
    assert set(np.unique(ism.to_grid(ball, rng.integers(0, 3, len(ball.sphere)), kind, labels=True))) == {0, 1, 2}


def test_a_geometry_image_is_the_surface(ball):
    image = ism.to_grid(ball, rows=90)
    assert np.allclose(ism.from_grid(image, ball), ball.vertices, atol=0.01)
    assert np.array_equal(image, ism.to_grid(ball, ball.vertices, rows=90))


def test_the_picture_is_the_texture_of_its_atlas(ball):
    """A texture coordinate (u, v) of `texture_atlas` reads the pixel of its place."""
    atlas = ism.texture_atlas(ball.sphere, ball.faces, "equirectangular")
    image = ism.to_grid(ball, ball.sphere, rows=256)
    u, v = (atlas.uv % 1).T
    read = image[np.minimum(((1 - v) * 256).astype(int), 255), np.minimum((u * 512).astype(int), 511)]
    inland = np.abs(atlas.carry(ball.sphere)[:, 2]) < 0.99
    assert np.abs(read - atlas.carry(ball.sphere))[inland].max() < 0.02


def test_refusals(ball):
    with pytest.raises(ValueError, match="unknown kind of grid 'mercator'"):
        ism.to_grid(ball, kind="mercator")
    with pytest.raises(ValueError, match="rows is 0; give 1 or more"):
        ism.to_grid(ball, rows=0)
    with pytest.raises(ism.MeshError, match="even number of columns"):
        ism.from_grid(np.zeros((4, 7)), ball)
    with pytest.raises(ism.MeshError, match="values for"):
        ism.to_grid(ball, [1, 2, 3])
