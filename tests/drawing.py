"""Whether pictures can be drawn here, and how tests run code that draws: each in a process of its own, forked."""

import atexit
import ctypes
import json
import os
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

import pytest
from corpus import ROOT


def missing():
    if not sys.platform.startswith("linux"):
        return "pictures without a window are drawn by EGL, which is Linux's"
    try:
        ctypes.CDLL("libEGL.so.1")
    except OSError:
        return "libEGL.so.1 is missing: apt install libegl1 libegl-mesa0 libgl1-mesa-dri"
    return ""


needs_drawing = pytest.mark.skipif(bool(missing()), reason=missing())

_PREAMBLE = """
import json, sys
from igl_spheremap.apps.viewer.choices import Pictures
from pathlib import Path
import numpy as np
import polyscope as ps
import igl_spheremap as ism
from igl_spheremap.apps.viewer import app, window
from igl_spheremap.draw.palette import FOLDED

def vermilion(image):
    'Share of pixels of the colour of folded faces, in any light.'
    r, g, b = (image[..., k].astype(float) for k in range(3))
    return float(((r > 60) & (g < 0.45 * r) & (b < 0.3 * r)).mean())

def drawn(image):
    'Share of pixels that are not background.'
    return float((image.min(axis=2) < 250).mean())
"""

#: Imports once, and forks for each line of stdin: OpenGL starts anew in each child.
_PARENT = """
import json, os, sys
import hand, igl_spheremap as ism
from igl_spheremap.apps.viewer import carried_view, compare, map_view, player, registered_view, show
public = [getattr(door, name) for door in (ism, ism.shapes) for name in dir(door)]
for line in sys.stdin:
    folder, environment, code = json.loads(line)
    if child := os.fork():
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
        continue
    for stream, name, mode in ((0, os.devnull, os.O_RDONLY), (1, "out", os.O_RDWR), (2, "err", os.O_RDWR)):
        os.dup2(os.open(os.path.join(folder, name), mode | os.O_CREAT), stream)
    os.environ |= environment
    exec(code, {"__name__": "__main__"})
    break
"""


def drive(code):
    """Run code that ends with a dict called `figures`, and return it."""
    printed, _ = _forked(f"{_PREAMBLE}\n{code}\nprint(json.dumps(figures))")
    return json.loads(printed[-1])


def use(code):
    """Run code that uses a window by a `Hand`, prints nothing, and ends with a dict called `figures`; return it."""
    script = f"{_PREAMBLE}\nfrom hand import Hand\n{code}\nprint(json.dumps(figures))"
    (*printed, figures), complaints = _forked(script, LP_NUM_THREADS="0")
    assert not complaints, complaints
    assert not printed, printed
    return json.loads(figures)


def command(*words):
    """Run the command line, without errors, and return the lines that it prints."""
    return _forked(
        f"from igl_spheremap.apps.cli import main\nassert main({[*map(str, words)]!r}) == 0"
    )[0]


def _forked(code, **environment):
    """Lines that code prints to stdout, and its stderr."""
    parent = _parent()
    with tempfile.TemporaryDirectory() as folder:
        parent.stdin.write(json.dumps((folder, environment, code)) + "\n")
        parent.stdin.flush()
        status = parent.stdout.readline()
        printed, complaints = (Path(folder, name).read_text() for name in ("out", "err"))
    assert status == "0\n", complaints
    return printed.splitlines(), complaints


@cache
def _parent():
    parent = subprocess.Popen(
        [sys.executable, "-c", _PARENT],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env=_places(),
    )
    atexit.register(parent.communicate)
    return parent


def run(command, cwd=None, **environment):
    """Run a command that finds the package."""
    return subprocess.run(
        command,
        capture_output=True,
        text=True,
        timeout=300,
        cwd=cwd,
        env={**_places(), **environment},
    )


def _places():
    """The environment of a process that finds the package, these tests, and the demos' common code."""
    places = (
        *(str(ROOT / folder) for folder in ("", "tests", "demos")),
        os.environ.get("PYTHONPATH", ""),
    )
    return os.environ | {"PYTHONPATH": os.pathsep.join(places)}
