"""Members that lie wrong are turned right, or named, and good ones are not."""

from dataclasses import replace

import numpy as np
import pytest
from family import spiral
from scipy.spatial.transform import Rotation

import igl_spheremap as ism
from igl_spheremap.resampling.transfer import resample, sphere_mesh
from igl_spheremap.shapes.correspondence.registration import reflected
from igl_spheremap.shapes.groups.doubts import (
    copy_doubts,
    drift_doubts,
    group_doubts,
    member_doubts,
)
from igl_spheremap.shapes.groups.member_registration import (
    MemberRegistration,
    _beside,
    register_member,
)
from igl_spheremap.shapes.groups.sampling import at_points
from igl_spheremap.shapes.groups.turns import Turns
from igl_spheremap.shapes.harmonics.rotation import rotation_angle

ARMS = np.array([[1.0, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, 1]])


def cross(x, lengths):
    """A body of four arms in a plane, and a head."""
    off = ((x[:, None] - ARMS) ** 2).sum(axis=2)
    return x * [1, 1, 0.6] * (0.5 + np.exp(-6 * off) @ lengths)[:, None]


@pytest.fixture(scope="module")
def arms():
    """The body, as it is registered to itself: points that correspond are those of one place."""
    x, f = spiral(600, np.random.default_rng(0))
    mapped = ism.balanced_spherical_map(cross(x, np.array([1.2, 1.0, 0.9, 1.1, 0.5])), f, balance=1)
    return at_points(mapped, *sphere_mesh("ico:2"))


@pytest.mark.parametrize("angle", [90, 180])
def test_a_member_whose_arms_are_exchanged_is_turned_right(arms, angle):
    up = arms.sphere[np.argmax(arms.vertices[:, 2])]
    wrong = arms.sphere @ Rotation.from_rotvec(np.radians(angle) * up).as_matrix().T
    shape = resample(ism.sphere_map(arms.vertices, arms.faces, wrong), (arms.sphere, arms.faces)).v
    _, (restarts,) = Turns(arms.sphere).restarts(arms.vertices, [shape])
    found = register_member(arms, arms, wrong, restarts)
    assert found.turned
    assert np.median(np.linalg.norm(found.sphere - arms.sphere, axis=1)) < 0.1


def test_the_first_registration_is_that_which_leads_nearest(arms):
    turn = Rotation.from_rotvec([1.0, 2.0, 0.5]).as_matrix()
    turned = ism.sphere_map(arms.vertices, arms.faces, arms.sphere @ turn)
    assert (
        np.median(np.linalg.norm(register_member(turned, arms).sphere - arms.sphere, axis=1)) < 0.1
    )


def twisted(x, by, bulge):
    """A flat body that is wound about its axis, which tells it from its mirror image."""
    p, angle = x * [1.5, 0.7, 0.3], by * x[:, 0]
    turn = np.stack((np.cos(angle), -np.sin(angle), np.sin(angle), np.cos(angle)), axis=1).reshape(
        -1, 2, 2
    )
    p[:, 1:] = np.einsum("nij,nj->ni", turn, p[:, 1:])
    return p * (1 + bulge * np.exp(-4 * ((x - [1, 0, 0]) ** 2).sum(axis=1)))[:, None]


def test_a_mirrored_member_is_named_and_no_other(here):
    x, f = spiral(300, np.random.default_rng(0))
    sources = [
        ism.balanced_spherical_map(twisted(x, *each), f, balance=1)
        for each in ((1.2, 0.5), (1.1, 0.6), (1.3, 0.55), (1.15, 0.4), (1.25, 0.6))
    ]
    found = ism.shapes.template([*sources[:4], reflected(sources[4])], target="ico:2", engine=here)
    assert "mirror it" in " ".join(found.members[4].doubts)
    assert not any(member.doubts for member in found.members[:4])
    assert "mirror it" in " ".join(found.place(reflected(sources[0])).member.doubts)


def test_round_bodies_are_said_to_be_round_and_lie_nearest_about_their_axis(here):
    rng = np.random.default_rng(0)
    sources = []
    for length in (0.7, 0.9, 1.1, 1.4):
        x, f = spiral(300, rng)
        side = np.append(rng.normal(size=2), 0)
        bump = 0.05 * np.exp(-3 * ((x - side / np.linalg.norm(side)) ** 2).sum(axis=1))
        sources.append(
            (x * (1 + 0.4 * x[:, 2] + 0.4 * x[:, 2] ** 2 + bump)[:, None] * [1, 1, length], f)
        )
    found = ism.shapes.template(sources, target="ico:2", engine=here)
    assert "the bodies are round" in found.notes[0]
    turns = Turns(found.sphere)
    axis, _ = turns.restarts(found.vertices, found.shapes)
    assert max(rotation_angle(R) for R in turns.about(axis, found.vertices, found.shapes)) < 10


def test_good_groups_have_no_doubts(group, three, maps):
    for each in (group, three):
        assert not each.notes
        assert not any(member.doubts for member in each.members)
    assert not group.place(maps[0]).member.doubts


def test_doubts_survive_in_files(group, tmp_path):
    doubtful = replace(group.members[1], doubts=("it lies wrong: look", "twice"))
    noted = replace(
        group, members=(group.members[0], doubtful, *group.members[2:]), notes=("it moved",)
    )
    ism.shapes.write_group(tmp_path, noted)
    again = ism.shapes.read_group(tmp_path)
    assert again.notes == noted.notes
    assert [member.doubts for member in again.members] == [
        member.doubts for member in noted.members
    ]
    assert "it lies wrong: look; twice" in (tmp_path / "members.tsv").read_text()


NOTHING = MemberRegistration(np.empty((0, 3)), 0.95, rival=3.0, angle=90.0, mirrored=1.0)
NOISELESS = NOTHING._replace(correlation=1.0)
DISTANCES, CORRELATIONS = np.array([1.0, 1.1, 0.9, 1.2, 1.0]), np.full(5, 0.95)


@pytest.mark.parametrize(
    ("found", "distance", "words"),
    [
        (NOTHING, 1.2, None),
        (NOTHING, 2.5, "2.5 times as far"),
        (NOTHING._replace(rival=1.05), 1.0, "by 90 degrees"),
        (NOTHING._replace(mirrored=0.5), 1.0, "mirror it"),
        (NOTHING._replace(correlation=0.6), 1.0, "correlates"),
    ],
)
def test_what_is_doubted_of_a_member(found, distance, words):
    said = member_doubts(found, distance, DISTANCES, CORRELATIONS)
    assert len(said) == (words is not None)
    assert words is None or words in said[0]


def test_figures_without_variance_are_no_reason_to_doubt_and_none_to_trust():
    """Equal members lie at no distance from their mean; of balls the depth is the same everywhere."""
    still = np.zeros(5)
    assert not member_doubts(NOISELESS, 0.0, still, np.ones(5))
    assert not member_doubts(NOISELESS, 1.0, np.array([0.0, 0.0, 1.0, 1.1, 0.9]), np.ones(5))
    unknown = NOISELESS._replace(correlation=np.nan)
    (said,) = member_doubts(unknown, 1.0, DISTANCES, np.array([np.nan, 0.9, 0.9, 0.9, 0.9]))
    assert "depth is the same everywhere" in said
    low = NOISELESS._replace(correlation=0.2)
    (said,) = member_doubts(low, 1.0, DISTANCES, np.array([np.nan, 0.9, 0.9, 0.9, 0.2]))
    assert "correlates with the mean's by 0.20" in said


def test_what_fits_as_well_beside_a_perfect_fit_is_a_rival():
    assert [_beside(*pair) for pair in ((0.0, 0.0), (1.0, 0.0), (3.0, 2.0))] == [1.0, np.inf, 1.5]


def test_copies_of_a_surface_are_named():
    contents = [b"1", b"2", b"1", b"1", b"3", b"2"]
    assert copy_doubts(list("abcdef"), contents) == [
        "a and c and d are the same surface, which counts 3 times: leave copies out",
        "b and f are the same surface, which counts 2 times: leave copies out",
    ]
    assert not copy_doubts(list("abc"), [b"1", b"2", b"3"])


def test_what_is_doubted_of_a_drift():
    assert not [*drift_doubts(NOTHING, None)]
    assert "turned by 90 degrees" in next(drift_doubts(NOTHING._replace(rival=1.2), None))
    assert "turned about its axis" in next(drift_doubts(NOTHING, ARMS[0]))


def test_what_is_doubted_of_a_mean():
    calm, kinds = (
        np.array([row]).T for row in ([-1, -0.2, 0.4, 0.1, 0.7, -0.5], [1.0, 1.1, 0.9, -1, -1, -1])
    )
    assert not [*group_doubts([0.1, 0.001], True, None, [NOTHING] * 6, calm)]
    assert "moved by 4 percent" in next(group_doubts([0.1, 0.04], False, None, [NOTHING] * 6, calm))
    assert "symmetric" in next(
        group_doubts([0.001], True, None, [NOTHING._replace(rival=1.05)] * 6, calm)
    )
    assert "(0.00, 0.60, 0.80)" in next(
        group_doubts([0.001], True, np.array([0, 3.0, 4.0]), [NOTHING] * 6, calm)
    )
    assert "into 3 and 3" in next(group_doubts([0.001], True, None, [NOTHING] * 6, kinds))
