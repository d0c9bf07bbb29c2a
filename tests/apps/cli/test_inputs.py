"""IN: files, samples and `-`, refusals in one line, and the effect of `--repair`; and OUT as `-`."""

from __future__ import annotations

import errno
import io
import json
import os
import sys
from types import SimpleNamespace
from typing import ClassVar

import numpy as np
import pytest
from corpus import CORPUS
from shell import one_line

import igl_spheremap as ism
from igl_spheremap import samples
from igl_spheremap.apps.cli import main
from igl_spheremap.io.files import read_mesh
from igl_spheremap.io.write_mesh import write_mesh


@pytest.mark.corpus
@pytest.mark.parametrize(
    "path", sorted((CORPUS / "invalid").glob("*")) or [None], ids=lambda p: p and p.stem
)
def test_every_invalid_mesh_is_status_2_and_one_line(path, tmp_path, capfd):
    if path is None:
        pytest.skip("no meshes")
    assert main(["map", str(path), str(tmp_path / "out.obj")]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert str(path) in err
    assert os.listdir(tmp_path) == []


def test_a_soup_is_refused_unless_it_is_repaired(tmp_path, capsys):
    v, f = samples.sphere(42)
    write_mesh(tmp_path / "soup.obj", v[f].reshape(-1, 3), np.arange(3 * len(f)).reshape(-1, 3))
    assert main(["map", str(tmp_path / "soup.obj"), str(tmp_path / "out.obj")]) == 2
    assert "weld the coincident vertices along them (--repair does)" in one_line(capsys)
    assert main(["info", str(tmp_path / "soup.obj"), "--repair"]) == 0
    out, err = capsys.readouterr()
    assert "120 edges" in out
    assert "welded 198 coincident vertices" in err


SAMPLE = "sample:spheroid:n_vertices=300"


def give(monkeypatch, data: bytes) -> None:
    monkeypatch.setattr(sys, "stdin", SimpleNamespace(buffer=io.BytesIO(data)))


@pytest.mark.parametrize("kind", ["obj", "off"])
def test_stdout_gets_what_a_file_gets(kind, tmp_path, capsys):
    path = tmp_path / f"sphere.{kind}"
    assert main(["map", SAMPLE, str(path), "-q"]) == 0
    assert main(["map", SAMPLE, "-", "--format", kind]) == 0
    out, err = capsys.readouterr()
    assert out == path.read_text()
    assert "certified as written" in err


def test_the_loss_of_the_vertex_order_is_reported(tmp_path, capsys):
    assert main(["map", SAMPLE, str(tmp_path / "a.ply"), "-q"]) == 0
    assert capsys.readouterr().err == ""
    assert main(["map", SAMPLE, str(tmp_path / "a.stl"), "-q"]) == 0
    assert "order is lost" in capsys.readouterr().err
    # And it is: the same positions, in another order.
    before, after = (read_mesh(tmp_path / name).v for name in ("a.ply", "a.stl"))
    assert before.shape == after.shape
    assert not np.allclose(before, after, atol=1e-3)


@pytest.mark.parametrize("kind", ["obj", "off", "ply", "npz"])
def test_stdin_is_read_as_a_file_is(kind, tmp_path, monkeypatch, capsys):
    path = tmp_path / f"mesh.{kind}"
    write_mesh(path, *ism.samples.from_spec("spheroid:n_vertices=300"))
    printed = []
    for source in (str(path), "-"):
        give(monkeypatch, path.read_bytes())
        assert main(["info", source, "--format", kind, "--json", "-"]) == 0
        printed.append(json.loads(capsys.readouterr().out))
    assert printed[1].pop("source") == "stdin"
    assert printed[0].pop("source") == str(path)
    assert printed[0] == printed[1]


def test_a_map_through_pipes(tmp_path, monkeypatch, capsys):
    def run(*arguments: str, piped: str = "") -> str:
        give(monkeypatch, piped.encode())
        assert main([*arguments, "-q"]) == 0
        return capsys.readouterr().out

    def mesh(text: str):
        (tmp_path / "piped.obj").write_text(text)
        return read_mesh(tmp_path / "piped.obj")

    sphere = run("map", SAMPLE, "-")
    repaired = run("repair", SAMPLE, "-", "-", piped=sphere)
    assert np.allclose(mesh(repaired).v, mesh(sphere).v, atol=1e-12)  # nothing to repair
    assert len(mesh(run("resample", SAMPLE, "-", "-", "--to", "ico:2", piped=repaired)).v) == 162
    assert run("check", SAMPLE, "-", piped=repaired) == ""


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["map", SAMPLE, "-", "--json", "-"], "can't both be stdout"),
        (["map", SAMPLE, "-", "--format", "ply"], "stdout takes text"),
        (["check", "-", "-"], "stdin is read once"),
        (["check", "-"], "stdin is read once"),
        (["check", SAMPLE], "holds no map"),
    ],
)
def test_what_makes_no_sense_is_refused_at_once(arguments, words, monkeypatch, capsys):
    give(monkeypatch, b"")
    assert main(arguments) == 64
    out, err = capsys.readouterr()
    assert out == ""
    assert words in err


def test_faults_of_stdin_are_reported_under_its_name(monkeypatch, tmp_path, capsys):
    v, f = ism.samples.sphere(42)
    rows = [f"v {x} {y} {z}" for x, y, z in v] + [f"f {a} {b} {c}" for a, b, c in f[1:] + 1]
    for data in (b"", b"v 1 2\n", b"v 0 0 0\nf 1 1 one\n", "\n".join(rows).encode()):
        give(monkeypatch, data)
        assert main(["map", "-", str(tmp_path / "out.obj")]) == 2
        out, err = capsys.readouterr()
        assert out == ""
        assert err.startswith("igl-spheremap: stdin: ")
        assert err.count("\n") == 1


def test_stdin_is_copied_in_pieces(monkeypatch, capsys):
    """A stream without end fills a disk at the worst, and no memory."""

    class Endless(io.RawIOBase):
        asked: ClassVar[list[int]] = []

        def read(self, size=-1):
            self.asked.append(size)
            if len(self.asked) > 3:
                raise OSError(errno.ENOSPC, "No space left on device")
            return b"x" * size

    monkeypatch.setattr(sys, "stdin", SimpleNamespace(buffer=Endless()))
    assert main(["info", "-"]) == 74
    assert capsys.readouterr().err.endswith("stdin.obj: No space left on device\n")
    assert 0 < min(Endless.asked) <= max(Endless.asked) <= 1 << 20


def test_a_mesh_from_stdin_is_mapped_to_a_file(tmp_path, monkeypatch, capsys):
    v, f = ism.samples.sphere(162)
    write_mesh(tmp_path / "in.obj", v, f)
    give(monkeypatch, (tmp_path / "in.obj").read_bytes())
    assert main(["map", "-", str(tmp_path / "out.ply")]) == 0
    x, g = read_mesh(tmp_path / "out.ply")
    assert np.array_equal(f, g)
    assert np.allclose(x, ism.spherical_conformal_map(v, f).sphere, atol=1e-12)


def test_a_sphere_in_the_place_of_its_surface_is_asked_about(tmp_path, capsys):
    v, f = ism.samples.make("dumbbell", n_vertices=300)
    ism.write_mesh(tmp_path / "s.ply", ism.spherical_conformal_map(v, f).sphere, f)
    ism.write_mesh(tmp_path / "v.ply", v, f)
    assert main(["check", str(tmp_path / "s.ply"), str(tmp_path / "v.ply")]) == 2
    assert "s.ply is a sphere and" in capsys.readouterr().err
    assert main(["check", str(tmp_path / "s.ply"), str(tmp_path / "s.ply"), "-q"]) == 0


def test_folders_and_files_that_are_read_are_refused_at_once_in_the_place_of_out(tmp_path, capsys):
    v, f = ism.samples.make("dumbbell", n_vertices=300)
    given = str(tmp_path / "v.ply")
    ism.write_mesh(given, v, f)
    assert main(["map", given, given]) == 64
    assert "would be lost" in capsys.readouterr().err
    assert main(["map", given, str(tmp_path)]) == 74
    assert "is a folder; name a file in it" in capsys.readouterr().err
    assert main(["batch", str(tmp_path), "--out", "{stem}.obj"]) == 64
    assert "is a folder; name its files" in capsys.readouterr().err
