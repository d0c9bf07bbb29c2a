"""Point location against brute force, on triangles of any size."""

from __future__ import annotations

import igl.predicates
import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap import FoldingsRemain, MeshError, samples
from igl_spheremap.resampling.locate import BoxTree, Location, SphereLocator, barycentric_weights
from igl_spheremap.sphere.moebius import moebius
from igl_spheremap.sphere.rows import unit_rows
from igl_spheremap.verify.certificate import certify

OCTAHEDRON = np.vstack([np.eye(3), -np.eye(3)])
FACES = np.array(
    [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
)


def boosted(n_vertices: int, power: float) -> tuple[np.ndarray, np.ndarray]:
    """An icosphere most of which is crowded into a cap of radius 10**-power."""
    x, f = samples.sphere(n_vertices)
    for _ in range(2):
        x = moebius(x, [0, 0, -(1 - 10.0 ** -(power / 2))])
    return x, f


def brute_force(x: np.ndarray, f: np.ndarray, q: np.ndarray) -> np.ndarray:
    """The first of all faces whose three exact signs are not negative."""
    found = np.full(len(q), -1)
    for k, point in enumerate(q):
        signs = [
            igl.predicates.orient3d(
                np.tile(point, (len(f), 1)), x[f[:, i]], x[f[:, (i + 1) % 3]], np.zeros((1, 3))
            )
            for i in range(3)
        ]
        found[k] = np.flatnonzero(np.min(signs, axis=0) >= 0)[0]
    return found


def direction(x: np.ndarray, f: np.ndarray, location: Location) -> np.ndarray:
    return unit_rows(np.einsum("ij,ijk->ik", location.weights, x[f[location.face]]))


@pytest.mark.parametrize("power", [0, 2, 6, 10])
def test_against_brute_force(power):
    x, f = boosted(642, power)
    assert certify(x, f).folding_free
    rng = np.random.default_rng(0)
    uniform = unit_rows(rng.normal(size=(200, 3)))
    faces = rng.integers(0, len(f), 200)
    within = unit_rows(np.einsum("ij,ijk->ik", rng.dirichlet([1, 1, 1], 200), x[f[faces]]))
    edges = unit_rows(x[f[faces, 0]] + x[f[faces, 1]])
    q = np.vstack([uniform, within, edges, x])
    location = SphereLocator(x, f).locate(q)
    assert np.array_equal(location.face, brute_force(x, f, q))


@pytest.mark.parametrize("power", [0, 6, 10])
def test_weights_give_the_point_back(power):
    x, f = boosted(642, power)
    weights = np.random.default_rng(1).dirichlet([2, 2, 2], len(f))
    q = unit_rows(np.einsum("ij,ijk->ik", weights, x[f]))
    location = SphereLocator(x, f).locate(q)
    assert (location.weights >= 0).all()
    assert np.allclose(location.weights.sum(axis=1), 1, atol=1e-15)
    assert np.abs(direction(x, f, location) - q).max() < 1e-15
    size = np.sqrt(np.einsum("ij,ij->i", x[f[:, 1]] - x[f[:, 0]], x[f[:, 1]] - x[f[:, 0]]))
    assert np.array_equal(location.face, np.arange(len(f)))
    assert (np.abs(location.weights - weights).max(axis=1) * size).max() < 1e-14


def test_vertices_are_found_at_themselves():
    x, f = boosted(2562, 8)
    location = SphereLocator(x, f).locate(x)
    corner = location.weights.argmax(axis=1)
    assert np.array_equal(f[location.face, corner], np.arange(len(x)))
    assert location.weights.max(axis=1).min() == 1


def test_huge_faces_and_points_on_their_edges():
    locator = SphereLocator(OCTAHEDRON, FACES)
    q = np.array(
        [[1, 1, 1], [1, 1, 0], [1, 0, 0], [0, 0, -1], [-1, -2, 3], [0, -1, 1]], dtype=float
    )
    face, weights = locator.locate(q)
    assert face.tolist() == brute_force(OCTAHEDRON, FACES, unit_rows(q)).tolist()
    assert np.allclose(weights[0], 1 / 3)
    assert sorted(weights[1].round(12).tolist()) == [0, 0.5, 0.5]


@pytest.mark.parametrize("scale", [1e-300, 1e-7, 1.0, 1e300])
def test_only_directions_matter(scale):
    x, f = samples.sphere(642)
    q = np.random.default_rng(2).normal(size=(100, 3))
    locator = SphereLocator(x, f)
    assert np.array_equal(locator.locate(q * scale).face, locator.locate(unit_rows(q)).face)


def test_no_points_at_all():
    face, weights = SphereLocator(OCTAHEDRON, FACES).locate(np.empty((0, 3)))
    assert face.shape == (0,)
    assert weights.shape == (0, 3)


def test_what_cannot_be_located_is_refused():
    locator = SphereLocator(OCTAHEDRON, FACES)
    for bad in ([0, 0, 0], [np.nan, 0, 1], [np.inf, 0, 0]):
        with pytest.raises(MeshError, match="points are zero or not finite in 1 row"):
            locator.locate([bad])
    with pytest.raises(FoldingsRemain, match="a mirror image, not folded"):
        SphereLocator(-OCTAHEDRON, FACES)


def test_weights_are_ratios_of_cones():
    rng = np.random.default_rng(3)
    corners = (
        unit_rows(rng.normal(size=(50, 3)) * 0.1 + [0, 0, 1])
        .reshape(-1, 1, 3)[:48]
        .reshape(16, 3, 3)
    )
    corners[np.linalg.det(corners) < 0] = corners[np.linalg.det(corners) < 0][:, ::-1]
    weights = rng.dirichlet([1, 1, 1], 16)
    q = unit_rows(np.einsum("ij,ijk->ik", weights, corners))
    solved = np.linalg.solve(corners.transpose(0, 2, 1), q[:, :, None])[:, :, 0]
    found = barycentric_weights(q, *corners.transpose(1, 0, 2))
    assert np.allclose(found, solved / solved.sum(axis=1, keepdims=True), atol=1e-11)


@pytest.mark.parametrize("m", [1, 2, 3, 4, 5, 17, 300])
def test_the_tree_finds_every_box(m):
    rng = np.random.default_rng(m)
    centre = rng.normal(size=(m, 3)) * 10.0 ** rng.uniform(-12, 0, (m, 1))
    half = np.abs(centre) * rng.uniform(0, 1, (m, 3))
    low, high = centre - half, centre + half
    points = np.vstack([centre, low, high, rng.normal(size=(50, 3))])
    point, box = BoxTree(low, high).candidates(points)
    slow = [
        (i, j)
        for i in range(len(points))
        for j in range(m)
        if ((low[j] <= points[i]) & (points[i] <= high[j])).all()
    ]
    assert sorted(zip(point.tolist(), box.tolist(), strict=True)) == slow


def test_candidates_do_not_multiply_where_faces_crowd():
    """The work of a query does not grow with the range of sizes."""
    counts = []
    for power in (2, 10):
        x, f = boosted(10242, power)
        locator = SphereLocator(x, f)
        point, _ = locator._tree.candidates(unit_rows(x[f].sum(axis=1)))
        counts.append(len(point) / len(f))
    assert counts[1] < 1.2 * counts[0] < 10


@pytest.mark.parametrize("size", [1e-10, 1e-100, 1e-162, 1e-300])
def test_triangles_at_a_pole_are_located_down_to_the_smallest_numbers(size):
    angle = 2 * np.pi * np.arange(3) / 3
    flat = np.column_stack((np.cos(angle), np.sin(angle)))
    x = np.vstack(
        (
            np.column_stack((size * flat, np.ones(3))),
            np.column_stack((flat, np.zeros(3))),
            [[0, 0, -1]],
        )
    )
    f = [[0, 1, 2]]
    for i, j in ((0, 1), (1, 2), (2, 0)):
        f += [[i, 3 + i, 3 + j], [i, 3 + j, j], [3 + j, 3 + i, 6]]
    weights = np.array([[0.5, 0.3, 0.2], [0.1, 0.1, 0.8], [1, 0, 0]])
    face, found = SphereLocator(x, f).locate(weights @ x[:3])
    assert face.tolist() == [0, 0, 0]
    assert np.allclose(found, weights, atol=1e-9)


def test_points_within_any_distance_of_a_pole_have_weights():
    """Products of differences underflow there; a corner is at its own place."""
    x, f = ism.samples.sphere(42)
    for shrink in (1e-20, 1e-120, 1e-163, 1e-250, 1e-305):
        y = x.copy()
        near = np.arange(len(x)) != x[:, 2].argmax()
        plane = x[near, :2] / (1 - x[near, 2:])
        y[near] = np.column_stack((shrink * plane, -np.ones(near.sum())))
        assert ism.certify(y, f).folding_free
        face, weights = ism.SphereLocator(y, f).locate(y)
        assert (f[face, weights.argmax(axis=1)] == np.arange(len(y))).all()
        assert np.allclose(weights.max(axis=1), 1)
        middles = y[f[near[f].all(axis=1)]].mean(axis=1)
        _, weights = ism.SphereLocator(y, f).locate(middles)
        assert np.allclose(weights, 1 / 3, atol=1e-3)
