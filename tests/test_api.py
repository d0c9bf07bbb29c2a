"""The names that users may rely on: none is added, renamed, removed or given another default unseen."""

import api


def test_names_flags_and_statuses_are_those_of_the_snapshot():
    assert api.text().splitlines() == api.SNAPSHOT.read_text("utf-8").splitlines(), (
        "if the change is meant, write the snapshot anew by `python tests/api.py`, and name the change in CHANGELOG.md"
    )


def test_the_snapshot_covers_both_doors():
    lines = api.SNAPSHOT.read_text("utf-8").splitlines()
    assert len(lines) == len(set(lines))
    for name in api.PUBLIC:
        assert any(
            line.startswith((name + ":", name + "(", name + ".", name + " =")) for line in lines
        ), name
