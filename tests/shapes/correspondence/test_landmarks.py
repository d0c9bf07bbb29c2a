"""Landmarks at points of faces and curves: met bit for bit where they were planted, and refusals by name."""

from __future__ import annotations

import igl
import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.resampling.transfer import interpolate
from igl_spheremap.shapes.correspondence.landmarks import with_vertices
from igl_spheremap.shapes.correspondence.surface_map import nearest
from igl_spheremap.sphere.rows import unit_rows


def places(result, points):
    return interpolate(result.vertices, result.faces, points)


def true_goals(pair, points):
    """The nearest points of the second surface."""
    return nearest(pair[1], places(pair[0], points), "B")


@pytest.fixture(scope="module")
def inside():
    """In faces, one after the other in one face, on the side of one, and at a corner."""
    rng = np.random.default_rng(0)
    weights = rng.dirichlet(np.ones(3), 7)
    weights[5], weights[6] = [0.3, 0.7, 0], [0, 0, 1]
    return ism.Location(np.array([10, 200, 200, 200, 300, 400, 500]), weights)


def test_landmarks_in_faces_are_met_bit_for_bit(pair, inside):
    a, b = pair[:2]
    goals = true_goals(pair, inside)
    onto = ism.shapes.match(a, b, landmarks=(inside, goals))
    assert np.array_equal(
        onto.map.sphere[onto.landmarks], unit_rows(interpolate(b.sphere, b.faces, goals))
    )
    assert onto.map.certificate.folding_free
    assert onto.landmark_errors.max() < 1e-12
    assert np.allclose(
        onto.map.vertices[onto.landmarks],
        places(a, inside),
        rtol=0,
        atol=1e-15 * np.ptp(a.vertices),
    )
    assert np.array_equal(onto.map.vertices[: len(a.sphere)], a.vertices)
    assert len(onto.map.sphere) == len(a.sphere) + 6
    assert onto.landmarks[6] == a.faces[500, 2]
    assert onto.notes == (
        "faces of the source are divided at landmarks: 6 vertices come after its own",
    )


def test_divided_faces_are_the_same_surface(pair):
    """Many points in few faces, some along lines, some twice, some nearer to sides than rounding is to faces."""
    a = pair[0]
    rng = np.random.default_rng(1)
    weights = rng.dirichlet(np.ones(3), 60)
    t = np.linspace(0.1, 0.9, 9)[:, None]
    weights[:9] = t * weights[20] + (1 - t) * weights[21]
    weights[30:40, 0] = 0
    weights[40:45, 1] *= 1e-13
    weights[45:50] = weights[:5]
    weights /= weights.sum(axis=1, keepdims=True)
    points = ism.Location(np.repeat([3, 40, 3, 41], 15), weights)
    points.face[45:50] = points.face[:5]
    divided, added, vertices = with_vertices(a, points)
    assert divided.certificate.folding_free
    assert len(divided.sphere) == len(a.sphere) + len(added.face)
    assert np.abs(divided.vertices[vertices] - places(a, points)).max() < 1e-12 * np.ptp(a.vertices)
    assert np.array_equal(vertices[45:50], vertices[:5])
    areas = [igl.doublearea(each.vertices, each.faces).sum() for each in (divided, a)]
    assert np.isclose(*areas, rtol=1e-12)


def test_places_at_vertices_are_these_vertices(pair):
    a, b = pair[:2]
    chosen = [5, 50, 150, 270]
    goals = true_goals(pair, ism.Location(*(part[chosen] for part in corners(a))))
    there, again = (
        ism.shapes.match(a, b, landmarks=(each, goals))
        for each in (chosen, ism.Location(*(part[chosen] for part in corners(a))))
    )
    assert np.array_equal(there.map.sphere, again.map.sphere)
    assert np.array_equal(again.landmarks, chosen)
    assert again.notes == ()


def corners(result):
    """Vertices by face and weights."""
    face, corner = np.empty((2, len(result.sphere)), dtype=np.int64)
    for k in range(3):
        face[result.faces[:, k]], corner[result.faces[:, k]] = np.arange(len(result.faces)), k
    return face, np.eye(3)[corner]


def test_features_are_those_of_the_given_vertices(pair, inside):
    a, b = pair[:2]
    values = a.vertices, b.vertices
    onto = ism.shapes.match(a, b, landmarks=(inside, true_goals(pair, inside)), features=values)
    assert onto.map.certificate.folding_free
    assert onto.landmark_errors.max() < 1e-12
    with pytest.raises(ism.MeshError, match=rf"features of the source .*{len(a.sphere)}"):
        ism.shapes.match(
            a, b, landmarks=(inside, true_goals(pair, inside)), features=(values[1], values[1])
        )


def path(result, start, steps):
    """Vertices of a walk along edges, as straight as these are."""
    neighbours = igl.adjacency_list(result.faces)
    walk, ahead = [start], np.zeros(3)
    for _ in range(steps):
        there = [n for n in neighbours[walk[-1]] if n not in walk]
        to = result.vertices[there] - result.vertices[walk[-1]]
        to /= np.linalg.norm(to, axis=1, keepdims=True)
        best = int((to @ ahead).argmax())
        walk.append(there[best])
        ahead = to[best]
    return np.array(walk)


def test_a_curve_goes_to_a_curve_point_by_point_at_the_same_lengths(pair):
    a, b = pair[:2]
    curve = path(a, 7, 8)
    on_b = true_goals(pair, ism.Location(*(part[curve] for part in corners(a))))
    first = [7], ism.Location(on_b.face[:1], on_b.weights[:1])
    onto = ism.shapes.match(a, b, landmarks=first, curves=[(curve, on_b)])
    # the first one, which was given twice, once
    assert np.array_equal(np.sort(onto.landmarks), np.sort(curve))
    assert onto.landmark_errors.max() < 1e-12
    assert onto.map.certificate.folding_free
    off = np.linalg.norm(onto.positions[onto.landmarks] - places(b, on_b), axis=1)
    steps = np.linalg.norm(np.diff(places(b, on_b), axis=0), axis=1)
    assert off.max() < 0.5 * steps.max()  # within the spacing: lengths differ by what the meshes do
    assert off[[0, -1]].max() < 1e-12


def test_a_curve_of_points_in_faces_goes_to_fewer_points(pair):
    a, b = pair[:2]
    curve = path(b, 20, 8)
    on_a = nearest(a, b.vertices[curve], "A")
    onto = ism.shapes.match(a, b, curves=[(on_a, curve[[0, 4, 8]])])
    assert len(onto.landmarks) == len(curve)
    assert onto.landmark_errors.max() < 1e-12
    p, q, r = b.vertices[curve[[0, 4, 8]]]
    lengths = np.linalg.norm(np.diff(places(a, on_a), axis=0), axis=1)
    shares = np.append(0, np.cumsum(lengths)) / lengths.sum()
    whole = np.linalg.norm(q - p) + np.linalg.norm(r - q)
    found = onto.positions[onto.landmarks]
    assert np.allclose(found[[0, -1]], [p, r], atol=1e-12)
    # the place at its share of the chords
    middle = p + shares[2] * whole * (q - p) / np.linalg.norm(q - p)
    assert np.linalg.norm(found[2] - middle) < 0.2 * np.linalg.norm(q - p)


@pytest.mark.parametrize(
    ("curves", "words"),
    [
        ([([0, 1, 2],)], "no pair for curve 0"),
        (
            [([0, 5], [0, 1]), ([0, 9000], [0, 1])],
            "point 1 of curve 1 of the source is vertex 9000",
        ),
        ([([4], [4, 5])], "curve 0 of the source has no length"),
        ([([4, 5], [7, 7])], "curve 0 of the target has no length"),
        (
            [([4, 5], [1, 2]), ([8, 4], [9, 10])],
            "point 0 of curve 0 and point 1 of curve 1 are one point of the source",
        ),
        (
            [([4, 5], [1, 2]), ([8, 9], [1, 10])],
            "point 0 of curve 0 and point 0 of curve 1 are one point of the target",
        ),
        ([([0.5, 1], [0, 1])], "points of curve 0 of the source are not a list of vertex indices"),
        (
            [(ism.Location([10**6, 0], np.eye(3)[:2]), [0, 1])],
            "point 0 of curve 0 of the source is in face 1000000",
        ),
    ],
)
def test_wrong_curves_are_named(pair, curves, words):
    with pytest.raises(ism.MeshError, match=words):
        ism.shapes.match(*pair[:2], curves=curves)
