"""Damaged files, 200 of each kind: a reader reads them, or names the fault in one line, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest
from file_names import needs
from mutants import CASES, judge, mutant, write_sound

from igl_spheremap.io.files import read_mesh


@pytest.mark.parametrize(
    ("reader", "name"), CASES, ids=[f"{reader.__name__}-{name}" for reader, name in CASES]
)
def test_only_errors_of_one_line_leave_a_reader(reader, name, tmp_path, capfd):
    needs(name)
    sound, rng, path = write_sound(tmp_path, name), np.random.default_rng(1), tmp_path / name
    for _ in range(200):
        path.write_bytes(mutant(sound, rng))
        assert judge(reader, path) in ("read", "refused")
    assert capfd.readouterr() == ("", "")


def test_a_fault_is_seen(tmp_path):
    """The test above rests on this."""
    (tmp_path / "a.obj").write_text("v 0 0\n")
    assert judge(read_mesh, tmp_path / "a.obj") == "refused"
    assert judge(lambda path: {}[path], "a.obj") == "KeyError: 'a.obj'"
