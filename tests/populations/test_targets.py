"""Every input has a target of its own."""

import pytest

from igl_spheremap.populations.targets import manifest_of, targets_of


def test_targets_follow_the_pattern():
    sources = ["s1/surf/lh.white", "s2/surf/rh.white"]
    assert targets_of("{folder}/{stem}.sphere.conformal", sources) == ["s1/surf/lh.sphere.conformal",
                                                                       "s2/surf/rh.sphere.conformal"]


@pytest.mark.parametrize(
    ("sources", "pattern"),
    [
        (["a/1.ply", "b/1.ply"], "out/{stem}.ply"),
        (["1.ply", "1.ply"], "{stem}.obj"),
        (["1.ply", "./1.ply"], "{stem}.obj"),
        (["1.ply"], "{folder}/{name}"),
        (["1.ply", "2.ply"], "{folder}/2.ply"),
        (["1.ply"], "{stem}.stl"),
        (["1.ply"], "{where}.ply"),
        (["1.ply"], "{stem:>9999999999}.ply"),
    ],
)
def test_what_would_be_lost_is_refused(sources, pattern):
    with pytest.raises(ValueError, match="out "):
        targets_of(pattern, sources)


def test_manifests_of_two_patterns_are_two():
    patterns = ["{stem}.ply", "{stem}.obj", "out/{stem}.ply", "{folder}/{stem}.ply", "/tmp/{stem}.ply", "one.ply"]
    places = [manifest_of(pattern) for pattern in patterns]
    assert len(set(places)) == len(places)
    assert places[4] == "/tmp/stem.ply.manifest.jsonl"
    assert not any(set("{}") & set(place) for place in places)
