"""Ctrl-C from the first instruction of `main` on: one line and 130, in the middle of any import."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest

import igl_spheremap as ism
from igl_spheremap.apps.cli import arguments, main
from igl_spheremap.apps.cli.commands import COMMANDS
from igl_spheremap.apps.reproduce import ITEMS
from igl_spheremap.apps.reproduce.figures import FIGURES
from igl_spheremap.apps.reproduce.tables import TABLES
from igl_spheremap.io import FORMATS

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
    done = subprocess.run([sys.executable, "-c", INTERRUPTED, module], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "igl-spheremap: interrupted\n")


def test_next_to_nothing_is_imported_before_main():
    """Until it runs, Ctrl-C shows a traceback: Python's own start is all that is to be before it."""
    code = f"import sys; sys.path.insert(0, {str(Path(ism.__file__).parents[1])!r}); import igl_spheremap.apps.cli"
    words = [sys.executable, "-S", "-E", "-c", f"{code}; print(*sys.modules)"]
    loaded = subprocess.run(words, capture_output=True, text=True, check=True).stdout.split()
    assert not {"typing", "contextlib", "argparse", "re", "importlib.util"} & set(loaded)


def test_the_handler_of_the_caller_comes_back():
    before = signal.getsignal(signal.SIGINT)
    for words in (["info", "sample:sphere", "-q"], ["--help"], ["frobnicate"]):
        main(words)
        assert signal.getsignal(signal.SIGINT) is before


def test_help_imports_nothing_heavy():
    """Neither that of the program nor that of any command."""
    helps = [["--help"], *([command.name, "--help"] for command in COMMANDS)]
    code = f"import sys; from igl_spheremap.apps.cli import main; [main(words) for words in {helps}]"
    done = subprocess.run([sys.executable, "-c", f"{code}; print(*sys.modules)"], capture_output=True, text=True)
    loaded = done.stdout.split()
    assert not {"numpy", "scipy", "igl", "tqdm"} & set(loaded)
    assert "igl_spheremap" in loaded


def test_what_help_spells_out_is_what_there_is():
    assert tuple(ism.samples.names()) == arguments.SAMPLES
    assert tuple(entry.suffixes[0].lstrip(".") for entry in FORMATS) == arguments.READ
    assert (*TABLES, *FIGURES) == ITEMS


def test_a_command_imports_no_other(tmp_path):
    ism.write_mesh(tmp_path / "a.obj", *ism.samples.sphere(42))
    code = "import sys; from igl_spheremap.apps.cli import main; main(sys.argv[1:]); print(*sys.modules)"
    words = [sys.executable, "-c", code, "info", str(tmp_path / "a.obj"), "-q"]
    loaded = subprocess.run(words, capture_output=True, text=True, check=True).stdout.split()
    commands = {name for name in loaded if name.startswith("igl_spheremap.apps.cli.commands.")}
    assert commands == {"igl_spheremap.apps.cli.commands.info"}
