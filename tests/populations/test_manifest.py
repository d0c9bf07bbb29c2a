"""A manifest holds all that was finished, wherever the run that wrote it was killed."""

import json
import os
from dataclasses import replace

import pytest

from igl_spheremap.errors import FileError
from igl_spheremap.populations.manifest import JobResult, Manifest, fingerprint, fingerprints
from igl_spheremap.populations.table import Row, plain

RUN = {"options": "-", "by": "host:1"}
STATUSES = ("certified", "no mesh", "no mesh")
ROWS = {
    f"key{k}": Row(f"{k}.ply", f"{k}.obj", status, vertices=k) for k, status in enumerate(STATUSES)
}
PLAIN = [plain(row) for row in ROWS.values()]


@pytest.fixture
def written(tmp_path):
    """A manifest of three results, of which one has an output; the files that were read lie beside it."""
    output = tmp_path / "0.obj"
    output.write_text("v 0 0 0")
    with Manifest(tmp_path / "all.jsonl", RUN) as log:
        for key, row in ROWS.items():
            (tmp_path / row.source).write_text(key)
            result = JobResult(
                row, *(fingerprints([str(tmp_path / name)]) for name in (row.source, row.target))
            )
            log.add(key, result)
    return tmp_path / "all.jsonl", output


def found(path):
    """The rows of a new run, by their order."""
    with Manifest(path, RUN) as log:
        rows = [
            log.result(key, [str(path.parent / row.source)], [str(path.parent / row.target)])
            for key, row in ROWS.items()
        ]
    return [row and plain(row) for row in rows]  # NaN is not equal to itself


def test_results_are_found_again(written):
    assert found(written[0]) == PLAIN


def test_a_manifest_that_was_cut_off_anywhere_holds_what_came_before(written):
    path, _ = written
    whole = path.read_bytes()
    ends = [k for k in range(len(whole)) if whole[k : k + 1] == b"\n"]
    for cut in range(0, len(whole), 7):
        path.write_bytes(whole[:cut])
        complete = sum(end <= cut for end in ends[1:])
        assert [row is not None for row in found(path)] == [k < complete for k in range(3)]
        with Manifest(path, RUN) as log:
            log.add(
                "key2", JobResult(ROWS["key2"], fingerprints([str(path.parent / "2.ply")]), (None,))
            )
        assert found(path)[2] == PLAIN[2]


@pytest.mark.parametrize("name", ["0.obj", "0.ply"])
def test_a_result_counts_only_while_its_input_and_its_output_are_what_they_were(name, written):
    path, file = written[0], written[0].parent / name
    content = file.read_text()
    file.write_text(content + " ")
    assert found(path)[0] is None
    file.unlink()
    assert found(path)[0] is None
    file.write_text(content)  # a copy: another time, the same content
    assert found(path)[0] == PLAIN[0]


def test_the_last_result_of_a_key_counts(written):
    path, _ = written
    with Manifest(path, RUN) as log:
        row = replace(ROWS["key1"], status="failed")
        log.add("key1", JobResult(row, fingerprints([str(path.parent / "1.ply")]), (None,)))
    assert found(path)[1]["status"] == "failed"


@pytest.mark.parametrize("written_files", [(), (None,)])
def test_a_map_without_its_files_is_no_result_and_proves_nothing(written_files, tmp_path):
    source, target = str(tmp_path / "a.ply"), str(tmp_path / "a.obj")
    (tmp_path / "a.ply").write_text("one")
    with Manifest(tmp_path / "all.jsonl", RUN) as log:
        log.add("key", JobResult(Row("a.ply", "a.obj"), fingerprints([source]), written_files))
    with Manifest(tmp_path / "all.jsonl", RUN) as log:
        assert log.result("key", [source], [target]) is None
        (tmp_path / "a.obj").write_text("notes of mine")
        assert log.result("key", [source], [target]) is None
        assert not log.made("key", [target])


def test_texts_of_a_manifest_do_nothing_to_a_terminal(tmp_path):
    evil = "\x1b[2Jgone\n"
    row, source = Row("a.ply", "a.obj", "failed", worker=evil, notes=evil), str(tmp_path / "a.ply")
    (tmp_path / "a.ply").write_text("one")
    path = tmp_path / "all.jsonl"
    with Manifest(path, RUN | {"by": evil}) as log:
        log.add("key", JobResult(row, fingerprints([source]), (None,)))
        with pytest.raises(FileError, match="another run") as caught:
            Manifest(path, RUN)
    assert str(caught.value).isprintable()
    with Manifest(path, RUN) as log:
        taken = log.result("key", [source], [str(tmp_path / "a.obj")])
    assert (taken.worker + taken.notes).isprintable()


def test_a_result_whose_input_is_not_known_does_not_count(written):
    path, _ = written
    with Manifest(path, RUN) as log:
        log.add("key1", JobResult(ROWS["key1"], None, (None,)))
    assert found(path)[1] is None


def test_inputs_are_known_again_without_being_read(tmp_path):
    source = tmp_path / "a.ply"
    source.write_text("one")
    first = fingerprint(str(source))
    assert fingerprint(str(source), replace(first, sha256="of old")).sha256 == "of old"
    source.write_text("other")
    assert fingerprint(str(source), first).sha256 not in (first.sha256, "of old")
    assert fingerprint(str(tmp_path)) is None
    assert fingerprint(os.devnull) is None
    assert fingerprint(str(tmp_path / "none")) is None


def test_a_manifest_that_cannot_be_written_is_refused(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(FileError, match="can't make the folder"):
        Manifest(tmp_path / "file" / "all.jsonl", RUN)


@pytest.mark.parametrize(
    "text", ["v 0 0 0", "{\n}", '{"run": {}}\n', '{"source": "a.ply"}\n', "[", "\n"]
)
def test_no_other_file_is_taken_for_a_manifest(text, tmp_path):
    (tmp_path / "other.json").write_text(text)
    with pytest.raises(FileError, match="is not a manifest"):
        Manifest(tmp_path / "other.json", RUN)
    assert (tmp_path / "other.json").read_text() == text


#: Lines of a manifest that no run wrote.
BAD = [
    "x",
    "[]",
    "5",
    "{}",
    "null",
    '{"row": 5}',
    '{"row": {}}',
    '{"row": null, "key": 1}',
    "[" * 200_000,
    '{"a":' * 100_000,
    '{"igl_spheremap run": 5}',
    "\ud800".encode("utf-8", "surrogatepass").decode("latin-1"),
]
ROW_FAULTS = [
    {"vertices": float("inf")},
    {"vertices": 10**400},
    {"energy": 10**400},
    {"energy": "x"},
    {"vertices": None},
    {"vertices": []},
    {"seconds": {}},
]


def test_lines_that_no_run_wrote_are_ignored(written):
    path, _ = written
    good = {"key": "key1", "row": PLAIN[1], "read": None, "written": [None]}
    lines = [
        *BAD,
        *(json.dumps(good | {"row": PLAIN[1] | fault}) for fault in ROW_FAULTS),
        json.dumps(good | {"read": 5}),
        json.dumps(good | {"written": {"size": 1}}),
    ]
    with path.open("a", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")
    assert found(path) == PLAIN


def test_one_run_writes_at_a_time(written):
    path, _ = written
    with Manifest(path, RUN | {"by": "host:7"}):
        before = path.read_bytes()
        with pytest.raises(FileError, match="another run, host:7, writes"):
            Manifest(path, RUN)
        assert path.read_bytes() == before
    assert found(path) == PLAIN
