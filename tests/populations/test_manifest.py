"""A manifest holds all that was finished, wherever the run that wrote it was killed."""

import os
from dataclasses import replace

import pytest

from igl_spheremap.errors import FileError
from igl_spheremap.populations.fingerprint import fingerprint
from igl_spheremap.populations.manifest import Manifest
from igl_spheremap.populations.table import Row, plain, read_table

RUN = {"options": "-", "by": "host:1"}
ROWS = {f"key{k}": Row(f"{k}.ply", f"{k}.obj", vertices=k) for k in range(3)}
PLAIN = [plain(row) for row in ROWS.values()]


@pytest.fixture
def written(tmp_path):
    """A manifest of three results, of which one has an output, and the place of that."""
    output = tmp_path / "0.obj"
    output.write_text("v 0 0 0")
    with Manifest(tmp_path / "all.jsonl", RUN) as log:
        log.add_inputs({"0.ply": fingerprint(str(output))})
        for key, row in ROWS.items():
            log.add(key, row, fingerprint(str(output)) if key == "key0" else None)
    return tmp_path / "all.jsonl", output


def found(path, output):
    with Manifest(path, RUN) as log:
        rows = [log.result(key, str(output) if key == "key0" else "none.obj") for key in ROWS]
    return [row and plain(row) for row in rows]  # NaN is not equal to itself


def test_results_are_found_again(written):
    assert found(*written) == PLAIN
    assert [plain(row) for row in read_table(written[0])] == PLAIN


def test_a_manifest_that_was_cut_off_anywhere_holds_what_came_before(written):
    path, output = written
    whole = path.read_bytes()
    ends = [k for k in range(len(whole)) if whole[k : k + 1] == b"\n"]
    for cut in range(0, len(whole), 7):
        path.write_bytes(whole[:cut])
        complete = sum(end <= cut for end in ends[2:])
        assert [row is not None for row in found(path, output)] == [k < complete for k in range(3)]
        with Manifest(path, RUN) as log:
            log.add("key2", ROWS["key2"], None)
        assert found(path, output)[2] == PLAIN[2]


def test_a_result_counts_only_while_its_output_is_what_was_written(written):
    path, output = written
    content = output.read_text()
    output.write_text(content + " ")
    assert found(path, output)[0] is None
    output.unlink()
    assert found(path, output)[0] is None
    output.write_text(content)  # a copy: another time, the same content
    assert found(path, output)[0] == PLAIN[0]


def test_the_last_result_of_a_key_counts(written):
    path, output = written
    with Manifest(path, RUN) as log:
        log.add("key1", replace(ROWS["key1"], status="failed"), None)
    assert found(path, output)[1]["status"] == "failed"


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
    with pytest.raises(FileError, match="no folder"):
        Manifest(tmp_path / "none" / "all.jsonl", RUN)


def test_no_other_file_is_taken_for_a_manifest(tmp_path):
    (tmp_path / "mesh.obj").write_text("v 0 0 0")
    with pytest.raises(FileError, match="is no manifest"):
        Manifest(tmp_path / "mesh.obj", RUN)
    assert (tmp_path / "mesh.obj").read_text() == "v 0 0 0"


def test_one_run_writes_at_a_time(written):
    path, output = written
    with Manifest(path, RUN | {"by": "host:7"}):
        before = path.read_bytes()
        with pytest.raises(FileError, match="another run, host:7, writes"):
            Manifest(path, RUN)
        assert path.read_bytes() == before
    assert found(path, output) == PLAIN
