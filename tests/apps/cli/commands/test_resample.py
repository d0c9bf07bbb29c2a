"""`igl-spheremap resample`."""

from __future__ import annotations

import numpy as np
from shell import SAMPLE, one_line

from igl_spheremap import samples
from igl_spheremap.apps.cli import main
from igl_spheremap.io.files import read_mesh
from igl_spheremap.io.write_mesh import write_mesh


def test_resample_to_a_regular_sphere_and_to_another_map(sphere, tmp_path, capsys):
    target = tmp_path / "regular.ply"
    assert main(["resample", SAMPLE, str(sphere), str(target), "--to", "ico:3"]) == 0
    v, _ = read_mesh(target)
    assert len(v) == 642
    assert np.allclose(
        np.ptp(v, axis=0), np.ptp(samples.from_spec(SAMPLE[7:])[0], axis=0), rtol=0.05
    )
    assert main(["map", str(target), str(tmp_path / "other.ply"), "-q"]) == 0
    back = tmp_path / "back.ply"
    assert (
        main(["resample", str(target), str(tmp_path / "other.ply"), str(back), "--to", str(sphere)])
        == 0
    )
    assert np.array_equal(read_mesh(back).f, read_mesh(sphere).f)


def test_resample_refuses(sphere, tmp_path, capsys):
    x, f = read_mesh(sphere)
    write_mesh(tmp_path / "mirror.ply", -x, f)
    assert main(["resample", SAMPLE, str(tmp_path / "mirror.ply"), str(tmp_path / "out.ply")]) == 2
    assert "the sphere is a mirror image" in one_line(capsys)
    assert (
        main(["resample", SAMPLE, str(sphere), str(tmp_path / "out.ply"), "--to", "ico:99"]) == 64
    )
    one_line(capsys)
