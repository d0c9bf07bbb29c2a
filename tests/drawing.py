"""Whether pictures can be drawn here, and how tests run code that draws: each in a process of its own."""

import ctypes
import json
import os
import subprocess
import sys

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


def drive(code):
    """Run code that ends with a dict called `figures`, and return it."""
    script = f"{_PREAMBLE}\n{code}\nprint(json.dumps(figures))"
    done = run([sys.executable, "-c", script])
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def use(code):
    """Run code that uses a window by a `Hand`, prints nothing, and ends with a dict called `figures`; return it."""
    script = f"{_PREAMBLE}\nfrom hand import Hand\n{code}\nprint(json.dumps(figures))"
    done = run([sys.executable, "-c", script], LP_NUM_THREADS="0")
    assert done.returncode == 0, done.stderr
    assert not done.stderr, done.stderr
    *printed, figures = done.stdout.splitlines()
    assert not printed, printed
    return json.loads(figures)


def run(command, cwd=None, **environment):
    """Run a command that finds the package."""
    path = os.pathsep.join((str(ROOT), str(ROOT / "tests"), os.environ.get("PYTHONPATH", "")))
    return subprocess.run(
        command,
        capture_output=True,
        text=True,
        timeout=300,
        cwd=cwd,
        env={**os.environ, "PYTHONPATH": path, **environment},
    )
