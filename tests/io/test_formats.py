"""The table of formats."""

from __future__ import annotations

from pathlib import Path

from file_names import needs

from igl_spheremap import io
from igl_spheremap.io import FORMATS, format_of, write_mesh


def test_every_format_is_in_the_table_once():
    suffixes = [suffix for entry in FORMATS for suffix in entry.suffixes]
    assert len(suffixes) == len(set(suffixes))
    package = Path(io.__file__).parent
    registered = {entry.read.__module__.rpartition(".")[2] for entry in FORMATS}
    assert registered == {p.stem for p in package.glob("*.py") if "\nFORMAT = " in p.read_text("utf-8")}


def test_files_without_a_telling_name_are_known_by_their_first_bytes(ball, tmp_path):
    for name in ("ball.off", "ball.ply", "ball.npz", "ball.glb", "ball.surf.gii", "ball.surf.gii.gz", "lh.sphere"):
        needs(name)
        write_mesh(tmp_path / name, *ball)
        (tmp_path / name).rename(tmp_path / "mystery")
        assert format_of(tmp_path / "mystery") is format_of(name)
        (tmp_path / "mystery").unlink()


def test_names_of_results_are_known_and_not_those_of_freesurfer_s_own_files():
    for name in ("lh.sphere.conformal", "rh.sphere.balanced", "lh.sphere.balanced.reg"):
        assert format_of(name).name == "FreeSurfer"
        assert name.removeprefix("lh.").removeprefix("rh.") not in ("sphere", "sphere.reg")
