"""The command line: exit statuses, one line per failure, and the same numbers for people and machines."""

from __future__ import annotations

import dataclasses
import json
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest
from corpus import CORPUS

from igl_spheremap import MeshError, samples, spherical_conformal_map
from igl_spheremap.apps.cli import main, map_command
from igl_spheremap.apps.cli.main import COMMANDS, build_parser
from igl_spheremap.apps.cli.status_line import Interrupt, StatusLine
from igl_spheremap.descent.iterate import Iterate
from igl_spheremap.io import read_map, read_mesh, write_mesh
from igl_spheremap.untangle.rounding import Float32Map
from igl_spheremap.verify.certificate import certify

SAMPLE = "sample:spheroid:n_vertices=500"


@pytest.fixture
def sphere(tmp_path) -> Path:
    """A map of the sample, written by the command itself."""
    path = tmp_path / "sphere.obj"
    assert main(["map", SAMPLE, str(path), "-q"]) == 0
    return path


def one_line(capsys) -> str:
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert err.startswith("igl-spheremap: ")
    return err


# map


def test_map_writes_certifies_and_tells(tmp_path, capsys):
    target, figures = tmp_path / "map.npz", tmp_path / "figures.json"
    assert main(["map", SAMPLE, str(target), "--json", str(figures)]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert "folding-free" in out
    assert "certified as written" in out
    result, told = read_map(target), json.loads(figures.read_text())
    assert told["vertices"] == len(result.vertices)
    assert told["energy"] == result.energy
    assert told["certificate"]["folding_free"] is True
    assert told["angle_differences"]["mean"] == pytest.approx(np.abs(result.angle_differences()).mean())


def test_summaries_fit_in_80_columns(tmp_path, capsys):
    target = str(tmp_path / "s.npz")
    assert main(["map", SAMPLE, target, "--method", "lai2014"]) == 0
    assert main(["check", SAMPLE, target]) == 0
    assert main(["info", SAMPLE]) == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if str(tmp_path) not in line]
    assert max(map(len, lines)) <= 80
    assert any(line.split()[:1] == ["round"] for line in lines)


def test_json_on_stdout_is_all_there_is(sphere, capsys):
    assert main(["check", SAMPLE, str(sphere), "--json", "-"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert json.loads(out)["certificate"]["degree"] == 1


def test_quiet_prints_nothing(tmp_path, capsys):
    assert main(["map", SAMPLE, str(tmp_path / "a.ply"), "-q"]) == 0
    assert capsys.readouterr() == ("", "")


def test_verbose_logs_every_iteration(tmp_path, capsys):
    assert main(["map", SAMPLE, str(tmp_path / "a.npz"), "-v", "-q"]) == 0
    assert len(capsys.readouterr().err.splitlines()) == len(read_map(tmp_path / "a.npz").history)


def test_options_reach_the_method(tmp_path):
    target = tmp_path / "a.npz"
    main(
        [
            "map",
            SAMPLE,
            str(target),
            "-q",
            "--method",
            "lai2014",
            "--max-iterations",
            "2",
            "--tolerance",
            "1e-9",
        ]
    )
    result = read_map(target)
    assert (result.method, result.settings) == ("lai2014", {"max_iterations": 2, "tolerance": 1e-9})


def test_foldings_that_remain_are_status_3_and_still_written(tmp_path, capsys, monkeypatch):
    def mirrored(*arguments, **options):
        result = spherical_conformal_map(*arguments, **options)
        return dataclasses.replace(
            result, sphere=-result.sphere, certificate=certify(-result.sphere, result.faces)
        )

    monkeypatch.setattr(map_command, "spherical_conformal_map", mirrored)
    assert main(["map", SAMPLE, str(tmp_path / "a.obj")]) == 3
    assert "not folding-free" in capsys.readouterr().out
    assert main(["check", SAMPLE, str(tmp_path / "a.obj")]) == 3


def test_a_rounded_file_is_status_3_and_says_what_would_do(tmp_path, capsys, monkeypatch):
    pytest.importorskip("nibabel")

    def crowded(*arguments, **options):
        result = spherical_conformal_map(*arguments, **options)
        i, j, _ = result.faces[0]
        result.sphere[j] = result.sphere[i] + 1e-9 * (result.sphere[j] - result.sphere[i])
        return result

    monkeypatch.setattr(map_command, "spherical_conformal_map", crowded)
    assert main(["map", SAMPLE, str(tmp_path / "rh.sphere")]) == 0
    assert "moved to keep float32 from folding" in " ".join(capsys.readouterr().out.split())

    def plainly(x, f, radius, v):
        return Float32Map((radius * x).astype(np.float32), certify(x, f), np.empty(0, dtype=np.int64))

    monkeypatch.setattr("igl_spheremap.io.written_map.certified_float32", plainly)
    assert main(["map", SAMPLE, str(tmp_path / "lh.sphere")]) == 3
    assert "rounded to this format" in " ".join(capsys.readouterr().out.split())


def test_freesurfer_from_end_to_end(tmp_path):
    freesurfer = pytest.importorskip("nibabel.freesurfer")
    v, f = samples.make("brain", n_vertices=4000)
    freesurfer.write_geometry(tmp_path / "lh.pial", v, f)
    assert main(["map", str(tmp_path / "lh.pial"), str(tmp_path / "lh.sphere"), "-q"]) == 0
    x, g = freesurfer.read_geometry(tmp_path / "lh.sphere")
    assert np.allclose(np.linalg.norm(x, axis=1), 100)
    assert np.array_equal(g, f)
    assert main(["check", str(tmp_path / "lh.pial"), str(tmp_path / "lh.sphere"), "-q"]) == 0


def test_gifti_keeps_what_the_source_said(tmp_path):
    nibabel = pytest.importorskip("nibabel")
    write_mesh(tmp_path / "in.surf.gii", *samples.sphere(162), metadata={"structure": "CortexRight"})
    assert (
        main(["map", str(tmp_path / "in.surf.gii"), str(tmp_path / "out.surf.gii"), "--radius", "2", "-q"])
        == 0
    )
    points = nibabel.load(tmp_path / "out.surf.gii").darrays[0]
    assert dict(points.meta) == {"AnatomicalStructurePrimary": "CortexRight", "GeometricType": "Spherical"}
    assert np.allclose(np.linalg.norm(points.data, axis=1), 2)


# check


def test_check_needs_one_archive_only(tmp_path, capsys):
    assert main(["map", SAMPLE, str(tmp_path / "a.npz"), "-q"]) == 0
    assert main(["check", str(tmp_path / "a.npz")]) == 0


def test_check_tells_foldings_from_other_meshes(sphere, tmp_path, capsys):
    x, f = read_mesh(sphere)
    write_mesh(tmp_path / "mirror.obj", -x, f)
    assert main(["check", SAMPLE, str(tmp_path / "mirror.obj"), "-q"]) == 3
    write_mesh(tmp_path / "bumpy.obj", x * np.linspace(1, 1.1, len(x))[:, None], f)
    assert main(["check", SAMPLE, str(tmp_path / "bumpy.obj"), "-q"]) == 3
    write_mesh(tmp_path / "huge.obj", x * 1e3, f)
    assert main(["check", SAMPLE, str(tmp_path / "huge.obj"), "-q"]) == 0
    x[3] = np.nan
    write_mesh(tmp_path / "nan.obj", x, f)
    assert main(["check", SAMPLE, str(tmp_path / "nan.obj")]) == 3
    assert "1 vertices not finite" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda x, f: (x[:-1], f[(f < len(x) - 1).all(axis=1)]), "vertices but"),
        (lambda x, f: (x, np.roll(np.arange(len(x)), 1)[f]), "not the same vertex order"),
    ],
)
def test_check_refuses_a_map_of_another_mesh(spoil, words, sphere, tmp_path, capsys):
    write_mesh(tmp_path / "other.obj", *spoil(*read_mesh(sphere)))
    assert main(["check", SAMPLE, str(tmp_path / "other.obj")]) == 2
    assert words in one_line(capsys)


# info


def test_info_counts(capsys):
    assert main(["info", SAMPLE, "--json", "-"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["vertices"] - told["edges"] + told["faces"] == 2
    assert told["deep_limbs"] == []


# failures


@pytest.mark.parametrize(
    ("arguments", "status"),
    [
        ([], 64),
        (["frobnicate"], 64),
        (["map", SAMPLE], 64),
        (["map", SAMPLE, "a.obj", "--method", "magic"], 64),
        (["info", "sample:unicorn"], 64),
        (["info", "sample:dino:wings=2"], 64),
        (["info", SAMPLE, "--keep-largest"], 64),
        (["map", SAMPLE, "a.obj", "--radius", "-1"], 64),
        (["info", "missing.obj"], 74),
        (["map", SAMPLE, "a.xyz"], 74),
        (["map", SAMPLE, "nowhere/a.obj"], 74),
        (["map", SAMPLE, "."], 74),
        (["info", "."], 74),
        (["info", SAMPLE, "--json", "nowhere/a.json"], 74),
    ],
)
def test_every_failure_is_one_line_and_a_status(arguments, status, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == status
    one_line(capsys)
    assert os.listdir(tmp_path) == []


def test_nothing_is_overwritten_without_force(sphere, capsys):
    before = sphere.read_bytes()
    assert main(["map", "sample:sphere:n_vertices=42", str(sphere)]) == 74
    assert "exists already" in one_line(capsys)
    assert sphere.read_bytes() == before
    assert main(["map", "sample:sphere:n_vertices=42", str(sphere), "--force", "-q"]) == 0
    assert sphere.read_bytes() != before


@pytest.mark.parametrize(
    ("error", "status"),
    [
        (MeshError("a\nb"), 2),
        (MemoryError(), 70),
        (KeyboardInterrupt(), 130),
        (OSError(28, "No space left"), 74),
    ],
)
def test_failures_within_are_told_in_one_line(error, status, tmp_path, monkeypatch, capsys):
    def fail(*_, **__):
        raise error

    monkeypatch.setattr(map_command, "spherical_conformal_map", fail)
    assert main(["map", SAMPLE, str(tmp_path / "a.obj")]) == status
    one_line(capsys)
    assert os.listdir(tmp_path) == []


@pytest.mark.corpus
@pytest.mark.parametrize("path", sorted((CORPUS / "invalid").glob("*")) or [None], ids=lambda p: p and p.stem)
def test_every_invalid_mesh_is_status_2_and_one_line(path, tmp_path, capfd):
    if path is None:
        pytest.skip("no meshes")
    assert main(["map", str(path), str(tmp_path / "out.obj")]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert str(path) in err
    assert os.listdir(tmp_path) == []


def test_repair_at_the_door(tmp_path, capsys):
    v, f = samples.sphere(42)
    write_mesh(tmp_path / "soup.obj", v[f].reshape(-1, 3), np.arange(3 * len(f)).reshape(-1, 3))
    assert main(["info", str(tmp_path / "soup.obj")]) == 2
    one_line(capsys)
    assert main(["info", str(tmp_path / "soup.obj"), "--repair"]) == 0
    out, err = capsys.readouterr()
    assert "120 edges" in out
    assert "welded 198 coincident vertices" in err


# the terminal


class Terminal:
    """A stream that says it is one."""

    def __init__(self) -> None:
        self.text = ""

    def isatty(self) -> bool:
        return True

    def write(self, text: str) -> None:
        self.text += text

    def flush(self) -> None:
        pass


def an_iterate() -> tuple[Iterate, np.ndarray]:
    x, f = samples.sphere(42)
    return Iterate("harmonic", 0, 7, x, 12.6, 1e-3, 0.5), f


def test_the_status_line_waits_and_clears(monkeypatch):
    clock = [0.0]
    monkeypatch.setattr("igl_spheremap.apps.cli.status_line.time.monotonic", lambda: clock[0])
    iterate, f = an_iterate()
    terminal = Terminal()
    line = StatusLine(terminal, f)
    line(iterate)
    assert terminal.text == ""
    clock[0] = 1.5
    line(iterate)
    line(iterate)  # within the same moment
    assert terminal.text.count("\r") == 1
    assert "harmonic 0.7" in terminal.text
    assert "foldings 0" in terminal.text
    line.clear()
    assert terminal.text.endswith(" " * 79 + "\r")


def test_no_status_line_in_a_file(tmp_path, monkeypatch):
    monkeypatch.setattr("igl_spheremap.apps.cli.status_line._PATIENCE", -1.0)
    iterate, f = an_iterate()
    with (tmp_path / "log").open("w") as file:
        line = StatusLine(file, f)
        line(iterate)
        line.clear()
    assert (tmp_path / "log").read_text() == ""


def test_ctrl_c_stops_at_the_next_iterate_and_keeps_it(tmp_path, monkeypatch):
    def pressed(*arguments, listener, **options):
        os.kill(os.getpid(), signal.SIGINT)
        return spherical_conformal_map(*arguments, listener=listener, **options)

    monkeypatch.setattr(map_command, "spherical_conformal_map", pressed)
    before = signal.getsignal(signal.SIGINT)
    assert main(["map", SAMPLE, str(tmp_path / "a.npz"), "--method", "lai2014", "-q"]) == 130
    assert signal.getsignal(signal.SIGINT) is before
    result = read_map(tmp_path / "a.npz")
    assert result.status.name == "STOPPED"
    assert len(result.history) <= 1


def test_interrupts_can_be_listened_to_in_any_thread():
    errors = []

    def enter() -> None:
        try:
            with Interrupt():
                pass
        except ValueError as error:
            errors.append(error)

    thread = threading.Thread(target=enter)
    thread.start()
    thread.join()
    assert errors == []


def test_help_shows_examples_that_parse():
    parser = build_parser()
    for command in COMMANDS:
        for line in command.examples.splitlines():
            words = line.split(" > ")[0].split()
            assert words[0] == "igl-spheremap"
            assert parser.parse_args(words[1:]).command == command.name


def test_completion_scripts_name_the_commands(capsys):
    pytest.importorskip("shtab")
    assert main(["completion", "bash"]) == 0
    out = capsys.readouterr().out
    assert all(command.name in out for command in COMMANDS)


def test_as_a_program(tmp_path):
    run = subprocess.run(
        [sys.executable, "-m", "igl_spheremap", "map", "sample:sphere:n_vertices=42", "a.off"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=100,
    )
    assert (run.returncode, run.stderr) == (0, "")
    assert "certified as written" in run.stdout


# repair and resample


def test_a_folded_map_is_mended_where_it_folds(sphere, tmp_path, capsys):
    x, f = read_mesh(sphere)
    x[7] = -x[7]
    write_mesh(tmp_path / "folded.ply", 5 * x, f)
    mended = tmp_path / "mended.ply"
    assert main(["repair", SAMPLE, str(tmp_path / "folded.ply"), str(mended), "--json", "-"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["before"]["certificate"]["folding_free"] is False
    assert told["after"]["certificate"]["folding_free"] is True
    assert 0 < told["moved"] < len(x) // 4
    assert np.allclose(np.linalg.norm(read_mesh(mended).v, axis=1), 5)
    assert main(["check", SAMPLE, str(mended), "-q"]) == 0


def test_a_map_without_directions_cannot_be_mended(sphere, tmp_path, capsys):
    x, f = read_mesh(sphere)
    x[7] = 0
    write_mesh(tmp_path / "zero.ply", x, f)
    assert main(["repair", SAMPLE, str(tmp_path / "zero.ply"), str(tmp_path / "out.ply")]) == 2
    assert "[7]" in one_line(capsys)


def test_resample_to_a_regular_sphere_and_to_another_map(sphere, tmp_path, capsys):
    target = tmp_path / "regular.ply"
    assert main(["resample", SAMPLE, str(sphere), str(target), "--to", "ico:3"]) == 0
    v, _ = read_mesh(target)
    assert len(v) == 642
    assert np.allclose(np.ptp(v, axis=0), np.ptp(samples.from_spec(SAMPLE[7:])[0], axis=0), rtol=0.05)
    assert main(["map", str(target), str(tmp_path / "other.ply"), "-q"]) == 0
    back = tmp_path / "back.ply"
    assert main(["resample", str(target), str(tmp_path / "other.ply"), str(back), "--to", str(sphere)]) == 0
    assert np.array_equal(read_mesh(back).f, read_mesh(sphere).f)


def test_resample_refuses(sphere, tmp_path, capsys):
    x, f = read_mesh(sphere)
    write_mesh(tmp_path / "mirror.ply", -x, f)
    assert main(["resample", SAMPLE, str(tmp_path / "mirror.ply"), str(tmp_path / "out.ply")]) == 3
    one_line(capsys)
    assert main(["resample", SAMPLE, str(sphere), str(tmp_path / "out.ply"), "--to", "ico:99"]) == 64
    one_line(capsys)


def test_polish_and_gauge_reach_the_method(tmp_path, capsys):
    figures = {}
    for name, flags in (("plain", []), ("polished", ["--polish", "angles"])):
        out = tmp_path / f"{name}.json"
        target = str(tmp_path / f"{name}.npz")
        assert main(["map", "sample:bird:n_vertices=1200", target, "--json", str(out), *flags]) == 0
        figures[name] = json.loads(out.read_text())
    assert figures["polished"]["settings"] == {"polish": "angles"}
    assert figures["polished"]["angle_differences"]["mean"] < figures["plain"]["angle_differences"]["mean"]
    capsys.readouterr()
    spring = ["map", "sample:spring:n_vertices=6000,turns=5", str(tmp_path / "s.npz"), "-f"]
    assert main(spring) == 0
    assert "drawn out" in capsys.readouterr().out
    assert main([*spring, "--gauge", "poles"]) == 0
    assert "drawn out" not in capsys.readouterr().out
    assert main(["map", "sample:bird", str(tmp_path / "b.npz"), "--polish", "mips", "--method", "lai2014"]) == 64
    assert "--polish" in capsys.readouterr().err
