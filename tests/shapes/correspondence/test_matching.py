"""Maps between surfaces: identities, symmetries, planted truth, landmarks bit for bit, and refusals by name."""

from __future__ import annotations

import igl
import numpy as np
import pytest
from bodies import worm
from scipy.spatial.transform import Rotation

import igl_spheremap as ism
from igl_spheremap.mesh.check import check_faces
from igl_spheremap.mesh.measure import vertex_areas
from igl_spheremap.shapes.correspondence.levels import Level, bisected
from igl_spheremap.shapes.correspondence.strain import ComposedStrain
from igl_spheremap.sphere.rows import tangent_axes, unit_rows


def mapped(name, n):
    return ism.balanced_spherical_map(*ism.samples.make(name, n_vertices=n), balance=1.0)


def size(v):
    return np.sqrt(((v - v.mean(axis=0)) ** 2).sum(axis=1).mean())


def error(a, positions, truth):
    w = vertex_areas(a.vertices, a.faces)
    return w @ np.linalg.norm(positions - truth, axis=1) / w.sum() / size(truth)


def test_one_shape_at_two_resolutions_comes_nearer_to_the_truth(pair, found):
    a, b, truth, _ = pair
    start = ism.shapes.register(a, b, stages=["rotation", "moebius"]).map.sphere
    before = error(a, ism.transfer(b, b.vertices, start), truth)
    assert error(a, found.positions, truth) < 0.6 * before
    assert found.map.certificate.folding_free
    assert found.notes == ()


def test_a_surface_on_itself_is_the_identity(pair):
    a = pair[0]
    assert error(a, ism.shapes.match(a, a).positions, a.vertices) < 1e-3


def test_forward_and_inverse_are_inverse(pair, found):
    a, b = pair[:2]
    rng = np.random.default_rng(0)
    for there, back, source in (
        (found.forward, found.inverse, a),
        (found.inverse, found.forward, b),
    ):
        weights = rng.dirichlet(np.ones(3), 200)
        points = ism.Location(rng.integers(len(source.faces), size=200), weights)
        again = back(there(points))
        p, q = (
            np.einsum("ij,ijk->ik", each.weights, source.vertices[source.faces[each.face]])
            for each in (points, again)
        )
        assert np.abs(p - q).max() < 1e-12 * size(source.vertices)


def test_the_matrix_carries_positions(pair, found):
    assert np.abs(found.matrix() @ pair[1].vertices - found.positions).max() < 1e-12
    assert np.allclose(found.matrix().sum(axis=1), 1)


def test_similarities_and_numbering_change_nothing(pair, found):
    """Of either body."""
    a, b = pair[:2]
    R, rng = Rotation.from_rotvec([0.3, -1.0, 0.5]).as_matrix(), np.random.default_rng(1)
    ranks = []

    def moved(result):
        order = rng.permutation(len(result.sphere))
        ranks.append(np.argsort(order))
        return ism.sphere_map(
            (3.0 * result.vertices @ R.T + 5.0)[order],
            ranks[-1][result.faces],
            result.sphere[order],
        )

    onto = ism.shapes.match(moved(a), moved(b))
    positions = (onto.positions[ranks[0]] - 5.0) @ R / 3.0
    assert error(a, positions, found.positions) < 0.02  # where steps end depends on rounding


def test_a_to_b_is_strained_as_b_to_a(pair, found):
    there, back = (
        found.distortion().figures,
        ism.shapes.match(pair[1], pair[0]).distortion().figures,
    )
    for over, under in (("over_source", "over_target"), ("over_target", "over_source")):
        for measure, most in (
            ("symmetric_dirichlet", 0.1),
            ("area_ratio", 0.1),
            ("angle_ratio", 0.2),
        ):
            assert there[over][measure]["median"] == pytest.approx(
                back[under][measure]["median"], rel=most
            )


def test_faces_of_b_without_area_are_no_obstacle(pair, found):
    """Three corners on a line, and two of them at one place."""
    a, b = pair[:2]
    v = b.vertices.copy()
    i, j, k = b.faces[100]
    v[k] = (v[i] + v[j]) / 2
    i, j, _ = b.faces[600]
    v[i] = v[j]
    squeezed = ism.sphere_map(v, b.faces, b.sphere)
    there, back = ism.shapes.match(a, squeezed), ism.shapes.match(squeezed, a)
    for onto in (there, back):
        assert onto.map.certificate.folding_free
        assert np.isfinite(onto.positions).all()
    assert error(a, there.positions, found.positions) < 0.03


def test_limbs_are_spread_where_they_move_and_told_where_they_stay():
    """A conformal map leaves the ends of a worm no room that float64 could divide on the other body."""
    deep, pear = ism.spherical_conformal_map(*worm(10, 6)), mapped("pear", 100)
    there, back = ism.shapes.match(deep, pear), ism.shapes.match(pear, deep)
    assert there.map.certificate.folding_free
    assert back.map.certificate.folding_free
    lost = there.distortion().figures["over_source"], back.distortion().figures["over_target"]
    assert lost[0]["symmetric_dirichlet"]["above_100"] < lost[1]["symmetric_dirichlet"]["above_100"]
    assert "% of the target's area has a symmetric Dirichlet energy above 100" in back.notes[-1]


def test_a_rough_match_says_so_and_a_good_one_does_not():
    pear, dumbbell = mapped("pear", 1500), mapped("dumbbell", 1500)
    rough = ism.shapes.match(pear, dumbbell)
    assert rough.distortion().figures["over_target"]["symmetric_dirichlet"]["p95"] > 100
    assert len(rough.notes) == 1
    assert "the match is rough" in rough.notes[0]
    assert "landmarks" in rough.notes[0]
    assert ism.shapes.match(pear, mapped("spheroid", 600)).notes == ()


def test_landmarks_are_met_bit_for_bit(pair):
    a, b, truth, vertices = pair
    chosen = np.random.default_rng(2).permutation(np.unique(vertices, return_index=True)[1])[:10]
    onto = ism.shapes.match(a, b, landmarks=(chosen, vertices[chosen]))
    assert np.array_equal(onto.map.sphere[chosen], b.sphere[vertices[chosen]])
    assert onto.map.certificate.folding_free
    assert onto.landmark_errors.max() < 1e-12
    assert error(a, onto.positions, truth) < 0.03
    soft = ism.shapes.match(a, b, landmarks=(chosen, vertices[chosen]), soft=True)
    assert 0 < soft.landmark_errors.max() < 0.1 * size(b.vertices)


def test_landmarks_far_from_each_other_are_met_on_split_faces(pair):
    """Five vertices onto any five others: faces are split where the triangles allow no such map."""
    a, b = pair[:2]
    rng = np.random.default_rng(3)
    chosen, goals = rng.permutation(len(a.sphere))[:5], rng.permutation(len(b.sphere))[:5]
    onto = ism.shapes.match(a, b, landmarks=(chosen, goals))
    assert np.array_equal(onto.map.sphere[chosen], b.sphere[goals])
    assert onto.map.certificate.folding_free
    assert np.array_equal(onto.map.vertices[: len(a.sphere)], a.vertices)
    assert bool(onto.notes) == (len(onto.map.sphere) > len(a.sphere))


def test_landmarks_are_vertices_of_coarse_levels():
    """Which surfaces of more vertices go through."""
    a, b = mapped("pear", 700), mapped("pear", 100)
    chosen, goals = [3, 200, 600], np.argmax(b.sphere @ a.sphere[[3, 200, 600]].T, axis=0)
    coarse = Level.of(a, "A", np.array(chosen)).coarser(642)
    assert np.array_equal(coarse.map.sphere[coarse.landmarks], a.sphere[chosen])
    assert coarse.map.certificate.folding_free
    onto = ism.shapes.match(a, b, landmarks=(chosen, goals))
    assert np.array_equal(onto.map.sphere[chosen], b.sphere[goals])
    assert onto.map.certificate.folding_free


def test_features_agree_more_than_without_them(pair, found):
    a, b = pair[:2]
    values = tuple(np.sin(3 * each.vertices / size(each.vertices)) for each in (a, b))
    shifted = np.sin(3 * a.vertices / size(a.vertices) + 0.3)
    onto = ism.shapes.match(a, b, features=(shifted, values[1]), feature_weight=3.0)
    off = [np.abs(each.matrix() @ values[1] - shifted).mean() for each in (found, onto)]
    assert off[1] < off[0]
    assert onto.map.certificate.folding_free


def test_a_listener_may_stop(pair):
    a, b, _, vertices = pair
    chosen = np.arange(0, 280, 60)
    seen = []

    def stop_at_the_third(iterate):
        seen.append(iterate)
        if len(seen) == 3:
            raise StopIteration

    onto = ism.shapes.match(a, b, landmarks=(chosen, vertices[chosen]), listener=stop_at_the_third)
    assert np.array_equal(onto.map.sphere, seen[-1].x)
    assert all(ism.certify(iterate.x, a.faces).folding_free for iterate in seen)


def test_the_gradient_of_the_strain_is_its_first_variation(pair):
    a, b = (Level.of(each, "A") for each in pair[:2])
    strain = ComposedStrain(a, b, 0.5, 0.1)
    axes = np.ascontiguousarray(np.stack(tangent_axes(a.map.sphere)).transpose(0, 2, 1))
    gradient, _ = strain.derivatives(a.map.sphere, axes)
    h = 1e-7
    for vertex in (3, 100, 255):  # one at a time: none crosses an edge of B
        for k in range(2):
            move = np.zeros_like(a.map.sphere)
            move[vertex] = h * axes[k, :, vertex]
            ahead, behind = (
                strain.by_face(unit_rows(a.map.sphere + sign * move)).sum() for sign in (1, -1)
            )
            assert np.isclose(gradient[k, vertex], (ahead - behind) / (2 * h), rtol=1e-4, atol=1e-5)


def test_bisected_faces_are_a_sphere_of_the_same_area():
    x, f = ism.samples.sphere(162)
    edges = np.stack(
        [np.linalg.norm(x[f[:, k - 2]] - x[f[:, k - 1]], axis=1) for k in range(3)], axis=1
    )
    edges[: len(f) // 2] = 0
    finer, ends, parts = bisected(f, edges, len(x))
    y = np.concatenate((x, x[ends].mean(axis=1)))
    assert len(ends) > 10
    assert np.array_equal(check_faces(finer, len(y)), finer)
    areas = igl.doublearea(y, finer)
    assert np.allclose(np.bincount(parts, areas), igl.doublearea(x, f))
    kept = {tuple(face) for face in finer.tolist()}
    assert {tuple(face) for face in f[: len(f) // 2].tolist()} & kept


def test_landmarks_that_cannot_be_met_are_named():
    """A face of a coarse mesh that is turned over."""
    a = mapped("pear", 100)
    face = a.faces[0]
    with pytest.raises(
        ism.MapError, match=r"of 3 landmarks can't be met .* give soft=True"
    ) as refused:
        ism.shapes.match(a, a, landmarks=(face, face[::-1]))
    assert refused.value.result.certificate.folding_free


@pytest.mark.parametrize(
    ("landmarks", "words"),
    [
        (([0, 1, 2],), "no pair for landmarks"),
        (([0, 1], [0]), "2 landmarks of the source have 1 points of the target"),
        (([0, 5000], [0, 1]), "landmark 1 of the source is vertex 5000"),
        (([0, -1], [0, 1]), "landmark 1 of the source is vertex -1"),
        (([0, 7, 7], [0, 1, 2]), "landmark 1 and landmark 2 are one point of the source"),
        (([0, 7, 8], [4, 1, 4]), "landmark 0 and landmark 2 are one point of the target"),
        (([0.5, 1], [0, 1]), "landmarks of the source are not a list of vertex indices"),
        (([], []), "landmarks of the source are not a list"),
        (
            ([0], ism.Location(np.array([0]), np.array([[0.9, 0.9, -0.8]]))),
            "weights of point 0 of the target",
        ),
        (
            ([0], ism.Location(np.array([10**6]), np.array([[1.0, 0, 0]]))),
            "point 0 of the target is in face 1000000",
        ),
    ],
)
def test_wrong_landmarks_are_named(pair, landmarks, words):
    with pytest.raises(ism.MeshError, match=words):
        ism.shapes.match(*pair[:2], landmarks=landmarks)


def test_refusals(pair):
    a, b = pair[:2]
    with pytest.raises(ValueError, match="feature_weight is -1"):
        ism.shapes.match(a, b, feature_weight=-1)
    folded = a.sphere.copy()
    folded[[10, 20]] = folded[[20, 10]]
    with pytest.raises(ism.FoldingsRemain) as refused:
        ism.sphere_map(a.vertices, a.faces, folded)
    with pytest.raises(ism.FoldingsRemain, match=r"^the source: "):
        ism.shapes.match(refused.value.result, b)
    with pytest.raises(TypeError, match=r"^the target: int is given without faces"):
        ism.shapes.match(a, 3)
    with pytest.raises(ism.MeshError, match=r"^the target: open surface") as refused:
        ism.shapes.match(a, (b.vertices, b.faces[1:]))
    assert refused.value.remedy.options == {"holes": "fill"}
    ball = ism.sphere_map(a.sphere, a.faces, a.sphere)
    with pytest.raises(ism.MeshError, match="is a sphere"):
        ism.shapes.match(ball, b)
    with pytest.raises(ism.MeshError, match="is a sphere"):
        ism.shapes.register(
            a, ism.sphere_map(b.sphere, b.faces, b.sphere), features=(a.vertices, b.vertices)
        )


def test_a_surface_that_is_inside_out_is_named(pair):
    """Only its mirror image could be laid on the other."""
    a, b = pair[:2]
    out = ism.sphere_map(a.vertices * [-1, 1, 1], a.faces, a.sphere)
    for call in (ism.shapes.match, ism.shapes.register):
        with pytest.raises(
            ism.MeshError, match="the source is inside out: its faces point inwards"
        ) as refused:
            call(out, b)
        assert refused.value.remedy.function == "repair_mesh"
        with pytest.raises(ism.MeshError, match="the target is inside out"):
            call(b, out)


def test_an_exactly_flat_surface_is_named(pair):
    a, b = pair[:2]
    flat = ism.sphere_map(a.vertices * [1, 1, 0], a.faces, a.sphere)
    for call, what in ((ism.shapes.match, "curvature and depth"), (ism.shapes.register, "depths")):
        with pytest.raises(ism.MeshError, match=f"{what} of the target are constant"):
            call(b, flat)
