"""The command line as a whole: statuses, one line a failure, imports, closed and full streams, other locales."""

from __future__ import annotations

import io
import json
import os
import re
import shutil
import signal
import subprocess
import sys
from types import SimpleNamespace

import pytest
from shell import SAMPLE, one_line

import igl_spheremap as ism
from igl_spheremap import MeshError, samples, write_mesh
from igl_spheremap.apps.cli import main
from igl_spheremap.apps.cli.commands import map as map_command
from igl_spheremap.apps.cli.parser import build_parser
from igl_spheremap.apps.cli.table import COMMANDS, GROUPS
from igl_spheremap.apps.reproduce.figures import FIGURES
from igl_spheremap.apps.reproduce.items import ITEMS
from igl_spheremap.apps.reproduce.tables import TABLES
from igl_spheremap.balance.balanced_spherical_map import balanced_spherical_map
from igl_spheremap.io.formats import FORMATS


@pytest.mark.parametrize(
    ("arguments", "status"),
    [
        (["frobnicate"], 64),
        (["--frobnicate"], 64),
        (["map", SAMPLE], 64),
        (["map", SAMPLE, "a.obj", "--method", "magic"], 64),
        (["info", "sample:unicorn"], 64),
        (["info", "sample:dino:wings=2"], 64),
        (["view", SAMPLE, "--frame", "1"], 64),
        (["map", SAMPLE, "a.obj", "--radius", "-1"], 64),
        (["map", SAMPLE, "a.npz", "--radius", "2"], 64),
        (["map", SAMPLE, "a.obj", "--with-surface"], 64),
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


@pytest.mark.parametrize(
    ("error", "status"),
    [
        (MeshError("a\nb"), 2),
        (MemoryError(), 70),
        (KeyboardInterrupt(), 130),
        (OSError(28, "No space left"), 74),
    ],
)
def test_failures_within_are_reported_in_one_line(error, status, tmp_path, monkeypatch, capsys):
    def fail(*_, **__):
        raise error

    monkeypatch.setattr(map_command, "balanced_spherical_map", fail)
    assert main(["map", SAMPLE, str(tmp_path / "a.obj")]) == status
    one_line(capsys)
    assert os.listdir(tmp_path) == []


@pytest.mark.skipif(sys.platform == "win32", reason="SIGTERM ends a process at once")
def test_sigterm_ends_a_command_as_ctrl_c_does(tmp_path, monkeypatch, capsys):
    before = signal.getsignal(signal.SIGTERM)
    monkeypatch.setattr("json.dumps", lambda *_, **__: signal.raise_signal(signal.SIGTERM))
    assert main(["info", SAMPLE, "--json", str(tmp_path / "a.json")]) == 143
    assert capsys.readouterr() == ("", "igl-spheremap: terminated\n")
    assert os.listdir(tmp_path) == []
    assert signal.getsignal(signal.SIGTERM) is before


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        (["mpa", "a.obj"], "no command 'mpa'; did you mean map?"),
        (["bunny.obj"], "no command 'bunny.obj'; did you mean map bunny.obj OUT?"),
        (["map", SAMPLE, "a.obj", "--fource"], "map takes no --fource; did you mean --force?"),
        (["info", SAMPLE, "--jsn=-"], "info takes no --jsn=-; did you mean --json?"),
        (["info", SAMPLE, "more"], "it takes fewer names: put one with spaces in quotes"),
        (["--verison"], "no flag '--verison'; did you mean --version?"),
        (["sample:bunny", "a.obj"], "did you mean map sample:bunny OUT?"),
        (
            ["map", SAMPLE, "a.obj", "--method", "laii2014"],
            "there is no laii2014; did you mean lai2014?",
        ),
        (["map", SAMPLE, "a.obj", "--json"], "argument --json: it takes FILE"),
        (["view", SAMPLE, "--size", "800"], "argument --size: it takes WIDTH HEIGHT"),
        (["map", "sample:dino,n_vertices=100", "a.obj"], "a colon: dino:n_vertices=100"),
        (["map", SAMPLE, "--output", "a.obj", "b.obj"], "OUT is the second name of a line"),
    ],
)
def test_a_wrong_word_is_answered_by_the_one_that_may_be_meant(words, meant, capsys):
    assert main(words) == 64
    assert meant in one_line(capsys)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("harmonics a.ply s.ply c.coef --to ico:3", "--to goes with --surface"),
        ("disk a.ply b.obj --rim 3", "--rim goes with --fill-holes"),
        ("map a.ply b.obj --up z", "--up goes with --report"),
        ("play a.ply --frame 3", "--frame goes with --screenshot"),
        (
            "match a.ply b.ply c.ply --colours places",
            "--colours goes with --show, --screenshot or --video",
        ),
        ("view a.ply s.ply --balance 1", "s.ply, a map that is there, takes no --balance"),
    ],
)
def test_a_flag_that_would_be_ignored_is_refused(words, said, capsys):
    assert main(words.split()) == 64
    assert said in one_line(capsys)


def test_completion_is_what_shtab_makes_of_the_whole_parser(monkeypatch, capsys):
    def complete(parser, shell):
        return f"{shell}: {parser.format_help()}"

    monkeypatch.setitem(
        sys.modules, "shtab", SimpleNamespace(complete=complete, SUPPORTED_SHELLS=["bash"])
    )
    assert main(["--completion", "bash"]) == 0
    assert capsys.readouterr().out == f"bash: {build_parser().format_help()}"
    assert main(["--completion", "cmd"]) == 64
    assert "give one of bash" in one_line(capsys)
    monkeypatch.setitem(sys.modules, "shtab", None)
    assert main(["--completion", "bash"]) == 74
    assert "pip install shtab" in one_line(capsys)


@pytest.mark.parametrize("command", [row.name for row in COMMANDS])
def test_help_begins_with_the_names_the_purpose_and_an_example(command, capsys):
    (row,) = (row for row in COMMANDS if row.name == command)
    assert main([command, "--help"]) == 0
    usage, _, purpose, _, title, example, *_ = capsys.readouterr().out.splitlines()
    assert usage.startswith(f"usage: igl-spheremap {command} [options]")
    assert (purpose, title, example.strip()) == (row.purpose, "examples:", row.examples[0])


def test_without_words_the_help_is_printed(capsys):
    assert main([]) == 0
    assert capsys.readouterr().out.startswith("usage: igl-spheremap")


def test_help_lists_each_command_once_under_what_it_is_about(capsys):
    assert sorted(name for names in GROUPS.values() for name in names) == sorted(
        row.name for row in COMMANDS
    )
    assert main(["--help"]) == 0
    listed = re.findall(
        r"^(?:  (\S.*):|    ([a-z][a-z-]*)  .*)$", capsys.readouterr().out, re.MULTILINE
    )
    expected = [word for title, names in GROUPS.items() for word in (title, *names)]
    assert [title or name for title, name in listed] == expected


def test_help_lists_the_samples(capsys):
    assert main(["--help"]) == 0
    assert ", ".join(samples.names()) in capsys.readouterr().out


def test_help_shows_examples_that_parse():
    parser = build_parser()
    for command in COMMANDS:
        for line in command.examples:
            words = line.split(" > ")[0].split()
            assert words[0] == "igl-spheremap"
            assert parser.parse_args(words[1:]).command == command.name


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


INTERRUPTED = """
import signal, sys

class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == sys.argv[1]:
            signal.raise_signal(signal.SIGINT)

from igl_spheremap.apps.cli import main
sys.meta_path.insert(0, Finder())
sys.exit(main(["info", "sample:sphere"]))
"""


MODULES = ["argparse", "numpy", "igl.pyigl_core", "tqdm", "igl_spheremap.apps.cli.commands.info"]


@pytest.mark.parametrize("module", MODULES)
def test_ctrl_c_during_imports_is_one_line(module):
    done = subprocess.run(
        [sys.executable, "-c", INTERRUPTED, module], capture_output=True, text=True, timeout=60
    )
    assert (done.returncode, done.stdout, done.stderr) == (
        130,
        "",
        "igl-spheremap: interrupted by you\n",
    )


def test_what_takes_time_to_import_is_imported_by_main():
    """Before `main` runs nothing catches Ctrl-C."""
    code = "import sys, igl_spheremap.apps.cli; print(*sys.modules)"
    loaded = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout.split()
    assert not {"argparse", "numpy", "scipy", "igl", "tqdm"} & set(loaded)


def test_the_handler_of_the_caller_comes_back():
    before = signal.getsignal(signal.SIGINT)
    for words in (["info", "sample:sphere", "-q"], ["--help"], ["frobnicate"]):
        main(words)
        assert signal.getsignal(signal.SIGINT) is before


def test_help_and_wrong_lines_import_nothing_heavy():
    lines = [
        ["--version"],
        ["map"],
        ["map", "a", "b", "--method", "magic"],
        ["--frobnicate"],
        ["--help"],
        *([command.name, "--help"] for command in COMMANDS),
    ]
    code = (
        f"import sys; from igl_spheremap.apps.cli import main; [main(words) for words in {lines}]"
    )
    done = subprocess.run(
        [sys.executable, "-c", f"{code}; print(*sys.modules)"], capture_output=True, text=True
    )
    loaded = done.stdout.split()
    assert not {"numpy", "scipy", "igl", "tqdm"} & set(loaded)
    assert "igl_spheremap" in loaded


def test_help_lists_what_there_is(capsys):
    assert (*TABLES, *FIGURES) == ITEMS
    assert main(["--help"]) == 0
    text = capsys.readouterr().out
    assert main(["info", "--help"]) == 0
    formats = " ".join(capsys.readouterr().out.split())
    for entry in FORMATS:
        assert f" {entry.suffixes[0]} " in text or entry.name == "FreeSurfer"
        assert f" {entry.suffixes[0].lstrip('.')}" in formats
    assert main(["info", "-", "--format", "docx"]) == 64
    assert "there is no docx" in capsys.readouterr().err


def test_a_command_imports_no_other(tmp_path):
    ism.write_mesh(tmp_path / "a.obj", *ism.samples.sphere(42))
    code = "import sys; from igl_spheremap.apps.cli import main; main(sys.argv[1:]); print(*sys.modules)"
    words = [sys.executable, "-c", code, "info", str(tmp_path / "a.obj"), "-q"]
    loaded = subprocess.run(words, capture_output=True, text=True, check=True).stdout.split()
    commands = {name for name in loaded if name.startswith("igl_spheremap.apps.cli.commands.")}
    assert commands == {"igl_spheremap.apps.cli.commands.info"}


BALL = "sample:sphere:n_vertices=42"


@pytest.fixture
def nameless(tmp_path):
    """A mesh whose name is not a text, and a name beyond ASCII in its folder's."""
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
    return subprocess.run(
        ["sh", "-c", line], cwd=folder, env=places, capture_output=True, text=True, timeout=60
    )


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
    made = subprocess.run(
        ["localedef", "-i", "de_DE", "-f", "UTF-8", str(tmp_path / name)], capture_output=True
    )
    if made.returncode:
        pytest.skip("no German locale can be made here")
    code = (
        "import locale, sys; locale.setlocale(locale.LC_ALL, ''); assert locale.str(0.5) == '0,5';"
        "from igl_spheremap.apps.cli import main;"
        f"main(['map', '{BALL}', 'comma.obj', '-q']); sys.exit(main(['check', '{BALL}', 'comma.obj', '--json', '-']))"
    )
    places = {**os.environ, "LOCPATH": str(tmp_path), "LC_ALL": name}
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, env=places, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["certificate"]["folding_free"]
    assert main(["map", BALL, str(tmp_path / "point.obj"), "-q"]) == 0
    assert (tmp_path / "comma.obj").read_bytes() == (tmp_path / "point.obj").read_bytes()


def test_of_two_programs_that_write_one_file_the_first_wins(tmp_path, monkeypatch, capsys):
    target = tmp_path / "sphere.obj"

    def overtaken(*arguments, **options):
        monkeypatch.setattr(map_command, "balanced_spherical_map", balanced_spherical_map)
        assert main(["map", BALL, str(target), "-q"]) == 0
        return balanced_spherical_map(*arguments, **options)

    monkeypatch.setattr(map_command, "balanced_spherical_map", overtaken)
    assert main(["map", SAMPLE, str(target)]) == 74
    assert "exists already" in one_line(capsys)
    assert main(["check", BALL, str(target), "-q"]) == 0
    assert os.listdir(tmp_path) == ["sphere.obj"]


@pytest.mark.posix
@pytest.mark.parametrize(
    "words",
    [
        ["map", "a.obj", "a.obj"],
        ["map", "a.obj", "./a.obj"],
        ["map", "a.obj", "link.obj"],
        ["repair", "a.obj", "b.obj", "b.obj"],
        ["repair", "a.obj", "b.obj", "a.obj"],
        ["resample", "a.obj", "b.obj", "c.obj", "--to", "c.obj"],
        ["map", "a.obj", "c.obj", "--json", "a.obj"],
        ["map", "a.obj", "c.obj", "--json", "c.obj"],
        ["map", "a.svg.obj", "c.obj", "--plot", "c.svg", "--json", "c.svg"],
    ],
)
def test_no_output_replaces_an_input_or_another_output(words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name in ("a.obj", "b.obj", "c.obj"):
        write_mesh(name, *samples.sphere(42))
    os.symlink("a.obj", "link.obj")
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert main([*words, "-f"]) == 64
    assert "would be lost" in one_line(capsys)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


@pytest.mark.parametrize(
    ("words", "stopped"),
    [
        (["map", SAMPLE, "out.obj", "--report", "page"], "commands.map.write_report"),
        (["repair", SAMPLE, "folded.obj", "out.obj"], "commands.check.repair_foldings"),
        (["repair", SAMPLE, "folded.obj", "out.obj"], "output.write_map"),
        (["check", SAMPLE, "folded.obj"], "commands.check.certify_radius"),
    ],
)
def test_an_interrupt_is_one_line_and_leaves_whole_files_only(
    words, stopped, tmp_path, monkeypatch, capsys
):
    if "--report" in words:
        pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    v, f = samples.from_spec(SAMPLE.partition(":")[2])
    write_mesh("folded.obj", -ism.spherical_conformal_map(v, f).sphere, f)

    def pressed(*arguments, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr(f"igl_spheremap.apps.cli.{stopped}", pressed)
    assert main(words) == 130
    assert capsys.readouterr() == ("", "igl-spheremap: interrupted by you\n")
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
    monkeypatch.setattr(map_command, "balanced_spherical_map", computed)
    monkeypatch.setattr("igl_spheremap.apps.reproduce.runs.spherical_conformal_map", computed)
    for words, user in (
        (["map", SAMPLE, "out.gii"], "GIFTI needs nibabel"),
        (["map", SAMPLE, "out.obj", "--plot", "a.svg"], "--plot needs matplotlib"),
        (["map", SAMPLE, "out.obj", "--report", "page"], "--report needs matplotlib"),
        (
            ["reproduce", "table1", "fig9", "--out", str(tmp_path / "out"), "-q"],
            "a figure needs matplotlib",
        ),
    ):
        monkeypatch.chdir(tmp_path)
        assert main(words) == 74
        line = one_line(capsys)
        assert user in line
        assert "pip install" in line
    assert os.listdir(tmp_path) == []


def test_a_backend_that_matplotlib_refuses_is_one_line(tmp_path):
    pytest.importorskip("matplotlib")
    words = ["map", "sample:sphere:n_vertices=42", "s.ply", "--plot", "s.png"]
    run = subprocess.run(
        [sys.executable, "-m", "igl_spheremap", *words],
        cwd=tmp_path,
        env=os.environ | {"MPLBACKEND": "foo"},
        capture_output=True,
        text=True,
    )
    assert run.stderr.count("\n") == 1
    assert "'foo' is not a valid value for backend" in run.stderr
