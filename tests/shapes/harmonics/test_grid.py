"""Images on grids of latitudes and longitudes: layout, round trips, seams and poles."""

from __future__ import annotations

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.shapes.harmonics.basis import gauss_rows
from igl_spheremap.sphere.rows import unit_rows

POINTS = unit_rows(np.random.default_rng(0).normal(size=(500, 3)))
KINDS = ["equirectangular", "equiangular", "gauss"]
EDGES = np.array([[0, 0, 1], [0, 0, -1], [-1, 0, 0], [-1, 1e-17, 0], [1, 0, 0]], dtype=float)


@pytest.fixture(scope="module")
def ball():
    x, f = ism.samples.sphere(10 * 4**4 + 2)
    return ism.sphere_map(x * [1, 2, 3], f, x)


def latitudes(kind, rows):
    return {
        "gauss": np.arccos(gauss_rows(rows)[0]),
        "equiangular": np.pi * np.arange(rows) / (rows - 1),
        "equirectangular": np.pi * (np.arange(rows) + 0.5) / rows,
    }[kind]


@pytest.mark.parametrize("kind", KINDS)
def test_rows_run_from_north_and_columns_east(ball, kind):
    places = ism.shapes.to_grid(ball, ball.sphere, kind=kind, rows=40)
    assert places.shape == (40, 80, 3)
    theta = latitudes(kind, 40)
    phi = 2 * np.pi * np.arange(80) / 80 + (np.pi / 80 - np.pi if kind == "equirectangular" else 0)
    directions = unit_rows(places.reshape(-1, 3)).reshape(places.shape)
    assert np.abs(directions[..., 2] - np.cos(theta)[:, None]).max() < 1e-12
    assert np.abs(directions[..., 0] - np.sin(theta)[:, None] * np.cos(phi)).max() < 1e-12


@pytest.mark.parametrize("kind", KINDS)
def test_back_from_the_grid_at_second_order_over_seam_and_poles(kind):
    where = np.concatenate((POINTS, EDGES))
    errors = []
    for rows in (30, 60, 120):
        x, f = ism.samples.sphere(12)
        # only for its points
        fine = ism.shapes.to_grid(ism.sphere_map(x, f, x), x, kind=kind, rows=rows)
        places = unit_rows(fine.reshape(-1, 3)).reshape(fine.shape)
        errors.append(
            np.abs(
                ism.shapes.from_grid(np.exp(places[..., 0] - places[..., 2]), where, kind=kind)
                - np.exp(where[:, 0] - where[:, 2])
            ).max()
        )
    assert np.log2(errors[0] / errors[2]) > 2 * 1.8


@pytest.mark.parametrize("kind", KINDS)
def test_grid_points_keep_their_values_and_labels(ball, kind):
    rng = np.random.default_rng(1)
    x, f = ism.samples.sphere(12)
    places = ism.shapes.to_grid(ism.sphere_map(x, f, x), x, kind=kind, rows=20).reshape(-1, 3)
    image, parcels = rng.normal(size=(20, 40, 2)), rng.integers(0, 9, (20, 40))
    if kind == "equiangular":  # the first and the last row are a point each
        image[[0, -1]], parcels[[0, -1]] = image[[0, -1], :1], parcels[[0, -1], :1]
    assert np.allclose(
        ism.shapes.from_grid(image, places, kind=kind), image.reshape(-1, 2), atol=1e-11
    )
    assert np.array_equal(
        ism.shapes.from_grid(parcels, places, kind=kind, labels=True), parcels.ravel()
    )
    labels = rng.integers(0, 3, len(ball.sphere))
    assert set(np.unique(ism.shapes.to_grid(ball, labels, kind=kind, labels=True))) == {0, 1, 2}


def points(kind, rows, columns):
    """Colatitudes and longitudes of a grid, read off the points of the sphere that it has."""
    x, f = ism.samples.sphere(12)
    grid = ism.shapes.to_grid(ism.sphere_map(x, f, x), x, kind=kind, rows=rows, columns=columns)
    places = unit_rows(grid.reshape(-1, 3))
    theta = np.arccos(places[:, 2]).reshape(rows, columns)[:, 0]
    middle = places.reshape(rows, columns, 3)[rows // 2]
    return theta, np.arctan2(middle[:, 1], middle[:, 0]) % (2 * np.pi - 1e-9)


@pytest.mark.parametrize(
    ("kind", "theirs", "rows", "columns"), [("equiangular", "mwss", 9, 16), ("gauss", "gl", 8, 15)]
)
def test_grids_of_s2fft(kind, theirs, rows, columns):
    samples = pytest.importorskip("s2fft.sampling.s2_samples", reason="s2fft is not installed")
    theta, phi = points(kind, rows, columns)
    assert np.abs(theta - samples.thetas(8, theirs)).max() < 1e-7
    assert np.abs(phi - samples.phis_equiang(8, theirs)).max() < 1e-7


@pytest.mark.parametrize(
    ("kind", "theirs"), [("equiangular", "equiangular"), ("gauss", "legendre-gauss")]
)
def test_grids_of_torch_harmonics(kind, theirs):
    quadrature = pytest.importorskip(
        "torch_harmonics.quadrature", reason="torch-harmonics is not installed"
    )
    theta, phi = points(kind, 8, 16)
    assert np.abs(theta - quadrature.precompute_latitudes(8, grid=theirs)[0].numpy()).max() < 1e-7
    assert np.abs(phi - quadrature.precompute_longitudes(16).numpy()).max() < 1e-7


def test_a_geometry_image_is_the_surface(ball):
    image = ism.shapes.to_grid(ball, rows=90)
    assert np.allclose(ism.shapes.from_grid(image, ball), ball.vertices, atol=0.01)
    assert np.array_equal(image, ism.shapes.to_grid(ball, ball.vertices, rows=90))


def test_the_picture_is_the_texture_of_its_atlas(ball):
    """A texture coordinate (u, v) of `texture_atlas` reads the pixel of its place."""
    atlas = ism.texture_atlas(ball.sphere, ball.faces, projection="equirectangular")
    image = ism.shapes.to_grid(ball, ball.sphere, rows=256)
    u, v = (atlas.uv % 1).T
    read = image[
        np.minimum(((1 - v) * 256).astype(int), 255), np.minimum((u * 512).astype(int), 511)
    ]
    inland = np.abs(atlas.carry(ball.sphere)[:, 2]) < 0.99
    assert np.abs(read - atlas.carry(ball.sphere))[inland].max() < 0.02


def test_refusals(ball):
    with pytest.raises(ValueError, match="unknown kind of grid 'mercator'"):
        ism.shapes.to_grid(ball, kind="mercator")
    with pytest.raises(ValueError, match="rows is 0; give 1 or more"):
        ism.shapes.to_grid(ball, rows=0)
    with pytest.raises(ValueError, match="rows is 1; give 2 or more"):
        ism.shapes.to_grid(ball, kind="equiangular", rows=1)
    with pytest.raises(ValueError, match="columns is 0; give 1 or more"):
        ism.shapes.to_grid(ball, columns=0)
    with pytest.raises(ism.MeshError, match="even number of columns"):
        ism.shapes.from_grid(np.zeros((4, 7)), ball)
    with pytest.raises(ism.MeshError, match="values for"):
        ism.shapes.to_grid(ball, [1, 2, 3])
