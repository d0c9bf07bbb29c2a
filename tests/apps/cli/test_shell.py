"""What shells do: names that no encoding knows, closed and full streams, other locales, two programs at one file."""

from __future__ import annotations

import io
import json
import os
import shutil
import subprocess
import sys

import pytest
from shell import SAMPLE, one_line

from igl_spheremap import samples, write_mesh
from igl_spheremap.apps.cli import main
from igl_spheremap.apps.cli.commands import map as map_command
from igl_spheremap.maps.spherical_conformal_map import spherical_conformal_map

BALL = "sample:sphere:n_vertices=42"


@pytest.fixture
def nameless(tmp_path):
    """A mesh whose name is no text, and a name beyond ASCII in its folder's."""
    folder = tmp_path / "Köln"
    folder.mkdir()
    path = os.fsencode(folder) + b"/bad\xff.ply"
    write_mesh(folder / "plain.ply", *samples.sphere(42))
    try:
        os.rename(folder / "plain.ply", path)
    except OSError:
        pytest.skip("this file system takes no such names")
    return os.fsdecode(path)


@pytest.mark.posix
def test_names_without_an_encoding_are_escaped(nameless, tmp_path, monkeypatch):
    screen = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(screen, encoding="ascii"))
    assert main(["info", nameless]) == 0
    assert b"K\\xf6ln" in screen.getvalue().replace(b"\n", b"").replace(b" ", b"")
    assert main(["info", nameless, "--json", "-"]) == 0
    assert main(["info", nameless, "--json", str(tmp_path / "a.json")]) == 0
    assert json.loads((tmp_path / "a.json").read_text())["source"] == nameless


@pytest.mark.parametrize("words", [["info", BALL, "--json", "-"], ["map", BALL, "-"]])
def test_a_closed_stdout_is_refused_before_the_work(words, monkeypatch, capsys):
    monkeypatch.setattr(sys, "stdout", None)
    assert main(words) == 74
    assert capsys.readouterr().err == "igl-spheremap: can't write stdout: it is closed\n"


def test_closed_streams_cost_nothing_else(tmp_path, monkeypatch):
    write_mesh(tmp_path / "in.ply", *samples.sphere(42))
    for name in ("stdin", "stdout", "stderr"):
        monkeypatch.setattr(sys, name, None)
    assert main(["map", str(tmp_path / "in.ply"), str(tmp_path / "out.ply")]) == 0
    assert main(["info", "nowhere.ply"]) == 74
    assert main(["info", "-"]) == 74


def sh(line, folder, **environment):
    """A line in a shell, where $I is the command."""
    program = f"{sys.executable} -m igl_spheremap"
    places = {**os.environ, "I": program, **environment}
    return subprocess.run(["sh", "-c", line], cwd=folder, env=places, capture_output=True, text=True, timeout=60)


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full here")
@pytest.mark.parametrize("words", [f"info {BALL}", "--help", "map --help", "--version"])
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_full_disk_behind_stdout_is_one_line(words, unbuffered, tmp_path):
    done = sh(f"$I {words} > /dev/full", tmp_path, PYTHONUNBUFFERED=unbuffered)
    assert (done.returncode, done.stderr) == (74, "igl-spheremap: No space left on device\n")


@pytest.mark.posix
def test_descriptors_of_closed_streams_are_not_given_to_files(tmp_path):
    assert sh(f"$I map {BALL} out.obj >&- 2>&- <&-", tmp_path).returncode == 0
    assert main(["check", BALL, str(tmp_path / "out.obj"), "-q"]) == 0


def test_numbers_have_points_where_people_write_commas(tmp_path):
    if shutil.which("localedef") is None:
        pytest.skip("no localedef here")
    name = "de_DE.UTF-8"
    made = subprocess.run(["localedef", "-i", "de_DE", "-f", "UTF-8", str(tmp_path / name)], capture_output=True)
    if made.returncode:
        pytest.skip("no German locale can be made here")
    code = (
        "import locale, sys; locale.setlocale(locale.LC_ALL, ''); assert locale.str(0.5) == '0,5';"
        "from igl_spheremap.apps.cli import main;"
        f"main(['map', '{BALL}', 'comma.obj', '-q']); sys.exit(main(['check', '{BALL}', 'comma.obj', '--json', '-']))"
    )
    places = {**os.environ, "LOCPATH": str(tmp_path), "LC_ALL": name}
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env=places, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["certificate"]["folding_free"]
    assert main(["map", BALL, str(tmp_path / "point.obj"), "-q"]) == 0
    assert (tmp_path / "comma.obj").read_bytes() == (tmp_path / "point.obj").read_bytes()


def test_of_two_programs_that_write_one_file_the_first_wins(tmp_path, monkeypatch, capsys):
    target = tmp_path / "sphere.obj"

    def overtaken(*arguments, **options):
        monkeypatch.setattr(map_command, "spherical_conformal_map", spherical_conformal_map)
        assert main(["map", BALL, str(target), "-q"]) == 0
        return spherical_conformal_map(*arguments, **options)

    monkeypatch.setattr(map_command, "spherical_conformal_map", overtaken)
    assert main(["map", SAMPLE, str(target)]) == 74
    assert "exists already" in one_line(capsys)
    assert main(["check", BALL, str(target), "-q"]) == 0
    assert os.listdir(tmp_path) == ["sphere.obj"]


@pytest.mark.posix
@pytest.mark.parametrize("words", [
    ["map", "a.obj", "a.obj"],
    ["map", "a.obj", "./a.obj"],
    ["map", "a.obj", "link.obj"],
    ["repair", "a.obj", "b.obj", "b.obj"],
    ["repair", "a.obj", "b.obj", "a.obj"],
    ["resample", "a.obj", "b.obj", "c.obj", "--to", "c.obj"],
    ["map", "a.obj", "c.obj", "--json", "a.obj"],
    ["map", "a.obj", "c.obj", "--json", "c.obj"],
    ["map", "a.svg.obj", "c.obj", "--plot", "c.svg", "--json", "c.svg"],
])
def test_no_output_replaces_an_input_or_another_output(words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name in ("a.obj", "b.obj", "c.obj"):
        write_mesh(name, *samples.sphere(42))
    os.symlink("a.obj", "link.obj")
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert main([*words, "-f"]) == 64
    assert "would be lost" in one_line(capsys)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


@pytest.mark.parametrize(("words", "stopped"), [
    (["map", SAMPLE, "out.obj", "--report", "page"], "reporting.write_report"),
    (["repair", SAMPLE, "folded.obj", "out.obj"], "commands.repair.repair_foldings"),
    (["repair", SAMPLE, "folded.obj", "out.obj"], "commands.repair.write_map"),
    (["check", SAMPLE, "folded.obj"], "commands.check.certify_radius"),
])
def test_an_interrupt_is_one_line_and_leaves_whole_files_only(words, stopped, tmp_path, monkeypatch, capsys):
    if "--report" in words:
        pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    v, f = samples.from_spec(SAMPLE.partition(":")[2])
    write_mesh("folded.obj", -spherical_conformal_map(v, f).sphere, f)

    def pressed(*arguments, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr(f"igl_spheremap.apps.cli.{stopped}", pressed)
    assert main(words) == 130
    assert capsys.readouterr() == ("", "igl-spheremap: interrupted\n")
    written = ["out.obj"] if "map" in words else []
    assert sorted(os.listdir(tmp_path)) == ["folded.obj", *written]
    if written:
        assert main(["check", SAMPLE, "out.obj", "-q"]) == 0


def test_extras_are_asked_for_before_the_work(tmp_path, monkeypatch, capsys):
    def computed(*arguments, **options):
        raise AssertionError("the work has begun")

    missing = ("matplotlib", "nibabel")
    for name in {*missing, *(name for name in sys.modules if name.partition(".")[0] in missing)}:
        monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.setattr(map_command, "spherical_conformal_map", computed)
    monkeypatch.setattr("igl_spheremap.apps.reproduce.runs.spherical_conformal_map", computed)
    for words, user in (
        (["map", SAMPLE, "out.gii"], "GIFTI needs nibabel"),
        (["map", SAMPLE, "out.obj", "--plot", "a.svg"], "--plot needs matplotlib"),
        (["map", SAMPLE, "out.obj", "--report", "page"], "--report needs matplotlib"),
        (["reproduce", "table1", "fig9", "--out", str(tmp_path / "out"), "-q"], "a figure needs matplotlib"),
    ):
        monkeypatch.chdir(tmp_path)
        assert main(words) == 74
        line = one_line(capsys)
        assert user in line
        assert "pip install" in line
    assert os.listdir(tmp_path) == []
