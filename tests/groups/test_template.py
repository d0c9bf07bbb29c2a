import numpy as np
import pytest
from family import AMOUNTS, body, spiral

import igl_spheremap as ism
from igl_spheremap.correspondence.registration import reflected
from igl_spheremap.mesh.measure import surface_area


def radius(group):
    """Root mean square radius of the mean surface."""
    w = group.areas / group.areas.sum()
    return np.sqrt(w @ ((group.vertices - w @ group.vertices) ** 2).sum(axis=1))


def test_planted_amounts_are_linear_in_the_scores_and_the_mean_is_the_planted_one(group):
    scores = np.column_stack((group.scores[:, :2], np.ones(len(AMOUNTS))))
    for amount in AMOUNTS.T:
        fit = scores @ np.linalg.lstsq(scores, amount, rcond=None)[0]
        assert np.corrcoef(fit, amount)[0, 1] > 0.95
    x, f = spiral(1000, np.random.default_rng(0))
    planted = ism.balanced_spherical_map(body(x, *AMOUNTS.mean(axis=0)), f, balance=1)
    assert group.place(planted).member.distance < 0.02 * radius(group)


def test_members_are_certified_and_make_the_mean(group, maps):
    assert all(member.map.certificate.folding_free for member in group.members)
    assert [len(member.map.sphere) for member in group.members] == [len(each.sphere) for each in maps]
    assert np.allclose(group.shapes.mean(axis=0), group.vertices)
    assert np.allclose(np.tensordot(group.scores, group.modes, 1) + group.vertices, group.shapes)
    assert np.isclose(group.areas.sum(), np.mean([surface_area(each.vertices, each.faces) for each in maps]))
    assert group.map.certificate.folding_free
    assert group.compactness[-1] == pytest.approx(1)


def test_features_are_averaged_at_corresponding_points(group, maps):
    points = np.stack([ism.resample(member.map, (group.sphere, group.faces)).v for member in group.members])
    assert np.allclose(group.feature_mean, points.mean(axis=0))
    assert np.allclose(group.feature_sd, points.std(axis=0, ddof=1))


def test_any_order_of_the_members_and_processes_give_the_same_bits(three, maps):
    order = [2, 0, 1]
    again = ism.template([maps[k] for k in order], target="ico:2", processes=2)
    for name in ("vertices", "modes", "variances", "areas", "spread"):
        assert (getattr(again, name) == getattr(three, name)).all()
    assert (again.scores == three.scores[order]).all()
    assert all((member.map.sphere == three.members[k].map.sphere).all()
               for k, member in zip(order, again.members, strict=True))


def test_mirrored_bodies_have_a_mirrored_template(three, maps):
    mirrored = ism.template([reflected(each) for each in maps[:3]], target="ico:2")
    assert three.place(reflected(mirrored.map)).member.distance < 0.02 * radius(three)
    assert np.abs(mirrored.scores - three.scores).max() < 0.1 * three.scores[:, 0].std()


def test_a_member_that_counts_twice_moves_the_mean_by_no_more_than_its_weight(three, maps):
    twice = ism.template([*maps[:3], maps[1]], target="ico:2")
    assert twice.place(three.map).member.distance < three.members[1].distance / 4 + 0.01 * radius(three)
    assert np.allclose(twice.scores[1], twice.scores[-1])


def test_a_new_member_is_placed_and_the_group_stays(group, maps):
    before = group.vertices.copy()
    found = group.place(maps[2])
    assert np.abs(found.scores - group.scores[2]).max() < 0.1 * group.scores[:, 0].std()
    assert (group.vertices == before).all()


def test_a_shape_of_given_scores(group):
    assert (group.shape([]) == group.vertices).all()
    assert np.allclose(group.shape(group.scores[0]), group.shapes[0])
    with pytest.raises(ValueError, match="give at most one for each"):
        group.shape(np.ones(20))


def test_what_does_not_fit_is_left_out_with_its_reason(maps, tmp_path):
    v, f = ism.samples.make("spheroid", n_vertices=300)
    ism.write_mesh(tmp_path / "open.ply", v, f[1:])
    found = ism.template([*maps[:3], tmp_path / "open.ply", tmp_path / "none.ply", (v * [1, 1, 40], f)], target="ico:1",
                         farthest=2)
    assert len(found.members) == 3
    assert [*found.left_out] == [str(tmp_path / "open.ply"), str(tmp_path / "none.ply"), "5"]
    assert "open surface" in found.left_out[str(tmp_path / "open.ply")]
    assert "times as far" in found.left_out["5"]
    with pytest.raises(ism.MeshError, match="a group needs 3"):
        ism.template([*maps[:2], tmp_path / "none.ply"], target="ico:1")


@pytest.mark.parametrize(("options", "error", "words"), [
    ({"modes": 0}, ValueError, "modes"), ({"target": "ico"}, ValueError, "regular sphere"),
    ({"balance": 2}, ValueError, "balance"), ({"features": [[1.0]]}, ValueError, "features are of 1 surfaces"),
    ({"farthest": 0}, ValueError, "farthest"), ({"processes": 0}, ValueError, "processes"),
])
def test_options_are_checked(options, error, words):
    with pytest.raises(error, match=words):
        ism.template(["a.ply", "b.ply", "c.ply"], **options)
