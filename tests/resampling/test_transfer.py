"""Data and surfaces carried through the sphere: exact cases, round trips, convergence."""

from __future__ import annotations

import numpy as np
import pytest

from igl_spheremap import FoldingsRemain, MeshError, samples, spherical_conformal_map
from igl_spheremap.resampling.locate import Location, SphereLocator
from igl_spheremap.resampling.transfer import interpolate, regular_mesh, resample, transfer
from igl_spheremap.shapes.harmonics.grid import to_grid
from igl_spheremap.shapes.harmonics.harmonics import spherical_harmonics
from igl_spheremap.sphere.rows import unit_rows
from igl_spheremap.verify.certificate import certify


@pytest.fixture(scope="module")
def maps():
    """The same spheroid, meshed twice."""
    return [spherical_conformal_map(*samples.make("spheroid", n_vertices=n)) for n in (1500, 4000)]


def test_a_mesh_to_itself_is_the_identity(maps):
    values = np.random.default_rng(0).normal(size=(len(maps[0].sphere), 2, 2))
    assert np.array_equal(transfer(maps[0], values, maps[0]), values)
    labels = np.random.default_rng(0).integers(0, 99, len(maps[0].sphere))
    carried = transfer(maps[0], labels, maps[0], labels=True)
    assert np.array_equal(carried, labels)
    assert carried.dtype == labels.dtype


def test_constants_and_bounds_are_kept(maps):
    n = len(maps[0].sphere)
    assert np.allclose(transfer(maps[0], np.full(n, 7.0), maps[1]), 7, atol=1e-14)
    values = np.random.default_rng(1).normal(size=n)
    carried = transfer(maps[0], values, maps[1])
    assert values.min() <= carried.min() <= carried.max() <= values.max()
    assert set(transfer(maps[0], np.sign(values), maps[1], labels=True)) <= {-1, 1}


def test_one_shape_meshed_twice_corresponds(maps):
    """The same surface: its points are carried to themselves, but for the size of the faces."""
    carried = transfer(maps[0], maps[0].vertices, maps[1])
    extent = np.ptp(maps[0].vertices, axis=0).max()
    assert np.abs(carried - maps[1].vertices).max() < 0.02 * extent


def test_there_and_back(maps):
    rng = np.random.default_rng(2)
    m = len(maps[0].faces)
    here = Location(rng.integers(0, m, 500), rng.dirichlet([1, 1, 1], 500))
    a, b = (SphereLocator(result.sphere, result.faces) for result in maps)

    def points(locator, location):
        return unit_rows(interpolate(locator.x, locator.f, location))

    back = a.locate(points(b, b.locate(points(a, here))))
    assert np.array_equal(back.face, here.face)
    assert np.abs(back.weights - here.weights).max() < 1e-10
    assert np.allclose(points(a, back), points(a, here), atol=1e-15)


def test_resampling_converges_at_second_order():
    """A smooth function through ever finer meshes of the sphere."""
    q = unit_rows(np.random.default_rng(3).normal(size=(2000, 3)))
    errors = []
    for k in (2, 3, 4, 5):
        x, f = regular_mesh(f"ico:{k}")
        carried = transfer(SphereLocator(x, f), np.sin(3 * x[:, 0]) * x[:, 1], q)
        errors.append(np.sqrt(np.mean((carried - np.sin(3 * q[:, 0]) * q[:, 1]) ** 2)))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (orders > 1.8).all()


def test_resampled_surfaces_keep_shape_and_topology(maps):
    v, f = resample(maps[1], "ico:4")
    extent = np.ptp(maps[1].vertices, axis=0)
    assert np.allclose(np.ptp(v, axis=0), extent, rtol=0.02)
    result = spherical_conformal_map(v, f)
    assert result.certificate.folding_free
    # a conformal image of itself
    assert np.abs(result.sphere - regular_mesh("ico:4")[0]).max() < 0.05


def test_resampling_on_the_other_mesh_of_the_sphere(maps):
    a, b = maps
    again = resample(a, (b.sphere, b.faces))
    assert np.array_equal(again.f, b.faces)
    assert np.array_equal(again.v, transfer(a, a.vertices, b))
    assert np.array_equal(again.x, b.sphere)
    assert np.array_equal(resample(a, b).v, again.v)


@pytest.mark.parametrize("k", range(5))
def test_regular_spheres(k):
    x, f = regular_mesh(f"ico:{k}")
    assert len(x) == 10 * 4**k + 2
    assert certify(x, f).folding_free


@pytest.mark.parametrize("word", ["ico", "ico:", "ico:x", "ico:-1", "ico:10", "uv:3"])
def test_no_other_regular_spheres(word):
    with pytest.raises(ValueError, match="ico:0 to ico:9"):
        regular_mesh(word)


def test_refusals(maps):
    with pytest.raises(MeshError, match="values for"):
        transfer(maps[0], np.zeros(3), maps[1])
    x, f = regular_mesh("ico:1")
    with pytest.raises(FoldingsRemain):
        transfer(SphereLocator(-x, f), np.zeros(len(x)), x)
    location = Location(np.array([0]), np.array([[0.2, 0.5, 0.3]]))
    assert interpolate(np.arange(len(x)), f, location, labels=True).tolist() == [f[0, 1]]


def test_data_come_after_the_map_that_they_lie_over(maps):
    source, target = maps
    values = source.vertices[:, 0]
    for call in (
        lambda: transfer(values, source, target),
        lambda: to_grid(values, source),
        lambda: spherical_harmonics(values, source),
    ):
        with pytest.raises(TypeError, match=r"^source is .*; give a SphereMap"):
            call()
