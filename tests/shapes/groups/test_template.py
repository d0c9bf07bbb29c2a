import json

import numpy as np
import pytest
from family import AMOUNTS, body, family, spiral

import igl_spheremap as ism
from igl_spheremap.mesh.measure import surface_area
from igl_spheremap.shapes.correspondence.registration import reflected
from igl_spheremap.shapes.groups.features import FeatureFiles


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
    assert [len(member.map.sphere) for member in group.members] == [
        len(each.sphere) for each in maps
    ]
    assert np.allclose(group.shapes.mean(axis=0), group.vertices)
    assert np.allclose(np.tensordot(group.scores, group.modes, 1) + group.vertices, group.shapes)
    assert np.isclose(
        group.areas.sum(), np.mean([surface_area(each.vertices, each.faces) for each in maps])
    )
    assert group.map.certificate.folding_free
    assert group.compactness[-1] == pytest.approx(1)


def test_features_are_averaged_at_corresponding_points(group, maps):
    points = np.stack(
        [ism.resample(member.map, (group.sphere, group.faces)).v for member in group.members]
    )
    assert np.allclose(group.feature_mean, points.mean(axis=0))
    assert np.allclose(group.feature_sd, points.std(axis=0, ddof=1))


def same(one, other, order=slice(None)):
    """Whether two groups are equal bit for bit, with the members of one in another order."""
    return all(
        (getattr(one, name) == getattr(other, name)).all()
        for name in ("vertices", "modes", "variances", "areas", "spread")
    ) and all(
        (getattr(one, name) == getattr(other, name)[order]).all() for name in ("scores", "shapes")
    )


def test_processes_and_any_order_of_the_members_give_the_same_bits(maps, three, tmp_path):
    again = ism.shapes.template(
        [maps[k] for k in (2, 0, 1)], target="ico:2", engine=ism.Engine(processes=2), out=tmp_path
    )
    assert same(again, three, [2, 0, 1])
    assert again.members[0].map is None
    assert (
        ism.read_map(tmp_path / "members" / "1.npz").sphere == three.members[0].map.sphere
    ).all()


def test_what_was_done_is_not_done_again_and_lost_files_come_back(maps, here, tmp_path):
    before = ism.shapes.template(maps[:3], target="ico:1", engine=here, out=tmp_path)
    manifest = tmp_path / "manifest.jsonl"
    lines = manifest.read_bytes().splitlines(keepends=True)
    written = {
        path: path.read_bytes()
        for path in tmp_path.rglob("*")
        if path.is_file() and path != manifest
    }
    half = len(lines) // 2
    # as a client leaves it that is killed
    manifest.write_bytes(b"".join(lines[:half]) + lines[half][:20])
    next(path for path in written if path.parent.name == "members").unlink()
    again = ism.shapes.template(maps[:3], target="ico:1", engine=here, out=tmp_path)
    assert same(again, before)
    assert all(path.read_bytes() == data for path, data in written.items())
    jobs = [json.loads(line).get("key") for line in manifest.read_bytes().splitlines()[half + 1 :]]
    assert len(list(filter(None, jobs))) == sum(b'"key"' in line for line in lines[half:])
    assert all(member.map is None for member in again.members)


def test_a_member_that_changed_is_mapped_again(tmp_path, here):
    for k, mesh in enumerate(family(AMOUNTS[:4], n=200)):
        ism.write_mesh(tmp_path / f"{k}.ply", *mesh)
    files = [tmp_path / f"{k}.ply" for k in range(3)]
    out = tmp_path / "group"
    before = ism.shapes.template(files, target="ico:1", engine=here, out=out)
    maps = {path: path.stat().st_mtime_ns for path in (out / "work" / "map").iterdir()}
    (tmp_path / "3.ply").replace(files[2])
    again = ism.shapes.template(files, target="ico:1", engine=here, out=out)
    assert [path.stem for path, time in maps.items() if path.stat().st_mtime_ns != time] == ["2"]
    assert not same(again, before)
    assert same(again, ism.shapes.template(files, target="ico:1", engine=here))


def test_another_column_of_the_same_files_is_read(tmp_path, here):
    for k, (v, f) in enumerate(family(AMOUNTS[:3], n=150)):
        ism.write_mesh(tmp_path / f"{k}.ply", v, f)
        np.savez(tmp_path / f"{k}.npz", thickness=np.full(len(v), 2.0), curv=np.full(len(v), 5.0))
    files = [str(tmp_path / f"{k}.ply") for k in range(3)]
    for column, mean in (("thickness", 2), ("curv", 5)):
        features = [FeatureFiles((f"{tmp_path}/{k}.npz:{column}",)) for k in range(3)]
        found = ism.shapes.template(
            files, features=features, target="ico:1", engine=here, out=tmp_path / "out"
        )
        assert np.allclose(found.feature_mean, mean)


def test_units_of_length_change_no_digit(maps, three, here):
    unit = 2.0**150
    scaled = [ism.sphere_map(each.vertices * unit, each.faces, each.sphere) for each in maps[:3]]
    found = ism.shapes.template(scaled, target="ico:2", engine=here)
    assert np.allclose(found.vertices / unit, three.vertices)
    assert np.allclose(found.variances / unit**2, three.variances)
    placed = found.place(scaled[1])
    assert np.allclose(placed.scores / unit, three.place(maps[1]).scores)
    assert str(found.figures().compactness) == str(three.figures().compactness)


@pytest.mark.parametrize("unit", [1e300, 1e-300])
def test_units_whose_areas_are_no_float64_numbers_are_refused(maps, three, here, unit):
    scaled = [ism.sphere_map(each.vertices * unit, each.faces, each.sphere) for each in maps[:3]]
    for call in (
        lambda: ism.shapes.template(scaled, target="ico:1", engine=here),
        lambda: ism.shapes.series(scaled),
        lambda: three.place(scaled[0]),
    ):
        with pytest.raises(ism.MeshError, match="choose units"):
            call()


def test_mirrored_bodies_have_a_mirrored_template(three, maps, here):
    mirrored = ism.shapes.template(
        [reflected(each) for each in maps[:3]], target="ico:2", engine=here
    )
    assert three.place(reflected(mirrored.map)).member.distance < 0.02 * radius(three)
    # either sign fits a mode of which few members are
    sizes = np.abs(mirrored.scores), np.abs(three.scores)
    assert np.abs(sizes[0] - sizes[1]).max() < 0.1 * sizes[1][:, 0].std()


def test_a_member_that_counts_twice_moves_the_mean_by_no_more_than_its_weight(three, maps, here):
    twice = ism.shapes.template([*maps[:3], maps[1]], target="ico:2", engine=here)
    assert twice.place(three.map).member.distance < three.members[1].distance / 4 + 0.01 * radius(
        three
    )
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


def test_what_does_not_fit_is_left_out_with_its_reason(maps, here, tmp_path):
    v, f = ism.samples.make("spheroid", n_vertices=200)
    ism.write_mesh(tmp_path / "open.ply", v, f[1:])
    sources = [*maps[:3], tmp_path / "open.ply", tmp_path / "none.ply", (v, f[1:])]
    found = ism.shapes.template(sources, target="ico:1", engine=here)
    assert len(found.members) == 3
    assert {*found.left_out} == {str(tmp_path / "open.ply"), str(tmp_path / "none.ply"), "5"}
    assert all("open surface" in found.left_out[name] for name in (str(tmp_path / "open.ply"), "5"))
    assert not any(name in reason for name, reason in found.left_out.items() if "ply" in name)
    assert "can't read it" in found.left_out[str(tmp_path / "none.ply")]
    with pytest.raises(ism.MeshError, match="a group needs 3 surfaces or more, not 2"):
        ism.shapes.template(maps[:2])
    with pytest.raises(ism.MeshError, match="2 of 3 surfaces are left, 3 are needed; surface"):
        ism.shapes.template([*maps[:2], tmp_path / "none.ply"], target="ico:1", engine=here)


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"modes": 0}, ValueError, "modes"),
        ({"target": "ico"}, ValueError, "regular sphere"),
        ({"balance": 2}, ValueError, "balance"),
        ({"features": [[1.0]]}, ValueError, "features are of 1 surfaces"),
        ({"features": [[1.0], None, [1.0]]}, ism.MeshError, "surface b.ply have shape"),
        (
            {"features": [[1.0], [[1.0, 2.0]], [1.0]]},
            ism.MeshError,
            "surface b.ply have 2 columns, those of a.ply have 1",
        ),
    ],
)
def test_options_are_checked(options, error, words):
    with pytest.raises(error, match=words):
        ism.shapes.template(["a.ply", "b.ply", "c.ply"], **options)


def test_equal_surfaces_are_no_group(here):
    v, f = ism.samples.make("pear", n_vertices=124)
    with pytest.raises(ism.MeshError, match="all the same"):
        ism.shapes.template([(v, f)] * 3, target="ico:1", engine=here)


def test_a_surface_that_is_given_twice_is_said(here):
    v, f = ism.samples.make("pear", n_vertices=124)
    bodies = [(v * [1, 1, 1 + k / 10], f) for k in (1, 2, 1, 3)]
    (note, *_) = ism.shapes.template(bodies, target="ico:1", engine=here).notes
    assert "0 and 2 are the same surface" in note


@pytest.mark.posix
def test_links_in_a_groups_folder_are_replaced_and_none_is_taken_for_a_folder(three, tmp_path):
    """Every name in it is known before: somebody may have planted a link there."""
    mine, place = tmp_path / "mine", tmp_path / "group"
    ism.shapes.write_group(place, three)
    names = [path.relative_to(place) for path in place.rglob("*") if path.is_file()]
    assert len(names) > 6
    for name in names:
        (place / name).unlink()
        (place / name).symlink_to(mine)
    mine.write_text("precious")
    ism.shapes.write_group(place, three, force=True)
    assert mine.read_text() == "precious"
    assert not any((place / name).is_symlink() for name in names)
    for name in names:
        (place / name).unlink()
    (place / "members").rmdir()
    (place / "members").symlink_to(tmp_path)
    with pytest.raises(ism.FileError, match="is a link"):
        ism.shapes.write_group(place, three, force=True)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["group", "mine"]
