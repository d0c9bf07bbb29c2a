"""Each demo is a short script that uses the library alone; it takes a surface, a picture, both or none."""

import ast
import re
import struct
import sys

import arguments
import numpy as np
import pytest
from corpus import ROOT
from drawing import drive, needs_drawing, run, use

import igl_spheremap as ism
from igl_spheremap.apps.viewer import choices

#: What they share.
SHARED = {"arguments", "scene"}
DEMOS = [path for path in sorted((ROOT / "demos").glob("*.py")) if path.stem not in SHARED]
#: Those with a window of the package's own; the player's is used in apps/viewer/test_windows.py.
WITH_WIDGETS = ("checkerboard", "compare_methods", "angles_or_areas")
#: Those that start polyscope themselves.
SCENES = ("align_landmarks", "every_iteration", "polyscope_scene")
SMALL = "sample:dumbbell:n_vertices=300"
NO_DISPLAY = {"DISPLAY": "", "WAYLAND_DISPLAY": ""}


def png_size(path):
    header = path.read_bytes()[:24]
    assert header[:8] == b"\x89PNG\r\n\x1a\n"
    return struct.unpack(">II", header[16:])


def test_there_are_seven():
    assert len(DEMOS) == 7


def test_windows_fit_a_small_screen():
    scripts = "".join(path.read_text("utf-8") for path in DEMOS)
    given = [ast.literal_eval(size) for size in re.findall(r"size=(\(\d{3,}, \d{3,}\))", scripts)]
    sizes = np.array([*given, choices.SIZE, choices.ROW_SIZE])
    assert len(given) == 1
    assert (sizes <= [1366, 768]).all()


@pytest.mark.parametrize("script", DEMOS, ids=lambda path: path.stem)
def test_a_demo_is_a_screen_that_uses_the_library_alone(script):
    text = script.read_text("utf-8")
    tree = ast.parse(text)
    code = [line for line in text.splitlines()[tree.body[0].end_lineno :] if line.strip()]
    assert len(code) <= 40
    imported = {
        name.partition(".")[0]
        for node in ast.walk(tree)
        if isinstance(node, ast.Import | ast.ImportFrom)
        for name in (
            [alias.name for alias in node.names] if isinstance(node, ast.Import) else [node.module]
        )
    }
    assert imported <= {"numpy", "polyscope", "igl_spheremap", "time", *SHARED}


@pytest.mark.parametrize(
    "words", [[], ["a.ply"], ["a.png"], ["a.png", "a.ply"], ["a.ply", "a.png"]]
)
def test_a_demo_takes_a_surface_and_a_picture_in_any_order_either_or_both(
    words, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["script.py", *words])
    given = []
    arguments.run(lambda *words: given.append(words), "sample:sphere")
    assert given == [
        ("a.ply" if "a.ply" in words else "sample:sphere", "a.png" if "a.png" in words else None)
    ]
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize(("words", "sentence"), [
    (["b.ply", "a.png"], "b.ply: No such file"),
    (["sample:cow", "a.png"], "no sample is called 'cow'"),
    (["a.ply", "b.ply"], "give at most one surface and one picture"),
    (["nowhere/a.png"], "nowhere/a.png"),
])  # fmt: skip
def test_a_demo_ends_on_errors_with_one_sentence(words, sentence, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["script.py", *words])
    with pytest.raises(SystemExit, match=rf"^script\.py: .*{re.escape(sentence)}.*$"):
        arguments.run(lambda surface, picture: ism.read_mesh(surface), "sample:sphere")


@pytest.mark.parametrize("script", ["checkerboard", "every_iteration"])
@needs_drawing
def test_without_a_display_a_demo_asks_for_the_name_of_a_picture(script, tmp_path):
    done = run([sys.executable, ROOT / "demos" / f"{script}.py", SMALL], **NO_DISPLAY, cwd=tmp_path)
    assert done.returncode == 1
    assert done.stderr.count("\n") == 1
    assert "no display" in done.stderr


#: Runs scripts one after the other; each draws a picture of its name.
DRAWING = """
import runpy, sys
from pathlib import Path
small, *scripts = sys.argv[1:]
for script in scripts:
    sys.argv = [script, small, Path(script).stem + ".png"]
    runpy.run_path(script, run_name="__main__")
"""


@needs_drawing
def test_demos_draw_their_pictures_without_a_display(tmp_path):
    packaged = [path for path in DEMOS if path.stem not in SCENES]
    for scripts in (packaged, *([path] for path in DEMOS if path not in packaged)):
        command = [sys.executable, "-c", DRAWING, SMALL, *map(str, scripts)]
        done = run(command, **NO_DISPLAY, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
    pictures = sorted(tmp_path.iterdir())
    assert [path.stem for path in pictures] == [script.stem for script in DEMOS]
    for picture in pictures:
        assert min(png_size(picture)) > 400
        assert picture.stat().st_size > 20_000


@needs_drawing
def test_every_widget_of_the_demos_windows_can_be_used_and_no_file_is_left(tmp_path):
    figures = use(f"""
import contextlib, io, os, runpy
os.chdir({str(tmp_path)!r})
scripts, figures = {[str(script) for script in DEMOS if script.stem in WITH_WIDGETS]!r}, {{}}

def script(hand):
    hand.resize(1400, 900)
    hand.click_at(475, 360)  # a vertex of the surface, for the lens
    hand.resize(500, 300)
    used = hand.everything(leave=('picture', 'video', 'map'))
    hand.drag((400, 150), (440, 190))
    hand.wheel(400, 150, 2)
    figures[name] = sorted(used)

for name in scripts:
    sys.argv = [name, {SMALL!r}]
    with contextlib.redirect_stdout(io.StringIO()):
        Hand().run(lambda: runpy.run_path(name, run_name='__main__'), script)
figures['files'] = os.listdir()
""")
    assert figures.pop("files") == []
    used = {name.split("/")[-1]: set(labels) for name, labels in figures.items()}
    assert "colours" in used["compare_methods.py"]
    assert {"balance", "colours", "squares", "lens"} <= used["checkerboard.py"]


@needs_drawing
def test_the_slider_shows_red_before_and_after_where_there_are_foldings(tmp_path):
    figures = drive(f"""
import os, runpy
os.chdir({str(tmp_path)!r})
from polyscope import imgui
sys.argv = ['every_iteration.py', 'sample:dino:n_vertices=1200', 'unused.png']
recording, callbacks, seen = ism.Recording, [], []
class Kept(recording):
    def __init__(self, f):
        super().__init__(f)
        callbacks.append(self)
ism.Recording = Kept
ps.set_user_callback = callbacks.append
runpy.run_path({str(ROOT / "demos" / "every_iteration.py")!r}, run_name='__main__')
kept, slider = callbacks
for k in np.linspace(0, len(kept.frames) - 2, 7).astype(int).tolist():
    imgui.SliderInt = lambda label, at, low, high: (True, k)
    slider()
    halves = np.split(ps.screenshot_to_buffer(), 2)
    seen.append([[kept.frames[k + row].foldings, vermilion(half)] for row, half in enumerate(halves)])
figures = dict(seen=seen)
""")
    shown = [step for steps in figures["seen"] for step in steps]
    assert 0 < sum(foldings > 0 for foldings, _ in shown) < len(shown)
    for foldings, red in shown:
        assert (red > 1e-5) == (foldings > 0)
