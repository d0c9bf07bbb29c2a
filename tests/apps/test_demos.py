"""Each demo is a short script that uses the library alone; it takes a surface, a picture, both or none."""

import ast
import re
import struct
import sys

import numpy as np
import pytest
from corpus import ROOT
from drawing import drive, needs_drawing, run, use

import igl_spheremap as ism
from igl_spheremap.apps import demo
from igl_spheremap.apps.viewer import choices

DEMOS = sorted((ROOT / "demos").glob("*.py"))
#: The player's are used in apps/viewer/test_windows.py; the other two have none.
WITH_WIDGETS = ("checkerboard", "compare_methods", "every_iteration")
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
    given = [ast.literal_eval(size) for size in re.findall(r"size=(\(.*?\))", scripts)]
    sizes = np.array([*given, choices.SIZE, choices.REGISTRATION_SIZE, choices.CARRIED_SIZE])
    assert len(given) == 2
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
    assert imported <= {"numpy", "polyscope", "igl_spheremap"}


@pytest.mark.parametrize(
    "words", [[], ["a.ply"], ["a.png"], ["a.png", "a.ply"], ["a.ply", "a.png"]]
)
def test_a_demo_takes_a_surface_and_a_picture_in_any_order_either_or_both(
    words, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    v, f = ism.samples.make("spheroid", n_vertices=200)
    ism.write_mesh("a.ply", v, f)
    monkeypatch.setattr(demo.window, "backend", lambda offscreen: "none")
    monkeypatch.setattr(sys, "argv", ["script.py", *words])
    given = []
    demo.run_demo(
        lambda v, f, up, target, progress: given.append((len(v), target)),
        "sample:sphere:n_vertices=42",
    )
    assert given == [(len(v) if "a.ply" in words else 42, "a.png" if "a.png" in words else None)]
    assert capsys.readouterr() == ("", "")


@pytest.mark.parametrize(("words", "sentence"), [
    (["b.ply", "a.png"], "b.ply: No such file"),
    (["sample:cow", "a.png"], "no sample is called 'cow'"),
    (["a.ply", "b.ply"], "give at most one surface and one picture"),
    (["nowhere/a.png"], "nowhere/a.png"),
    ([], "no display"),
])  # fmt: skip
def test_a_demo_ends_on_errors_with_one_sentence(words, sentence, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["script.py", *words])
    for name in NO_DISPLAY:
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(SystemExit, match="1"):
        demo.run_demo(lambda *given: None, "sample:sphere:n_vertices=42")
    out, err = capsys.readouterr()
    assert not out
    assert len(err.splitlines()) == 1
    assert sentence in err


#: Runs scripts one after the other; each draws a picture of its name.
DRAWING = """
import runpy, sys
from pathlib import Path
small, *scripts = sys.argv[1:]
for script in scripts:
    sys.argv = [script, small, f"{Path(script).stem}.png"]
    runpy.run_path(script, run_name="__main__")
"""


@needs_drawing
def test_demos_draw_their_pictures_without_a_display(tmp_path):
    own = [path for path in DEMOS if path.stem == "polyscope_scene"]  # starts polyscope itself
    for scripts in (own, [path for path in DEMOS if path not in own]):
        command = [sys.executable, "-c", DRAWING, SMALL, *map(str, scripts)]
        done = run(command, **NO_DISPLAY, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
    pictures = sorted(tmp_path.glob("*.png"))  # polyscope keeps its own settings beside them
    assert [path.stem for path in pictures] == [script.stem for script in DEMOS]
    for picture in pictures:
        assert min(png_size(picture)) > 400
        assert picture.stat().st_size > 30_000


@needs_drawing
def test_every_widget_of_the_demos_windows_can_be_used_and_no_file_is_left(tmp_path):
    figures = use(f"""
import os, runpy
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
    Hand().run(lambda: runpy.run_path(name, run_name='__main__'), script)
figures['files'] = os.listdir()
""")
    assert figures.pop("files") == []
    used = {name.split("/")[-1]: set(labels) for name, labels in figures.items()}
    assert {"play ", "<", ">", "##iteration", "stops", "lens", "folded faces"} <= used[
        "every_iteration.py"
    ]
    assert "colours" in used["compare_methods.py"]
    assert {"balance", "colours", "squares", "lens"} <= used["checkerboard.py"]


@needs_drawing
def test_every_iteration_shows_red_before_and_after_where_there_are_foldings():
    figures = drive(f"""
import runpy
apps = []
app.run_app = lambda shown, args: apps.append(shown)
sys.argv = ['every_iteration', 'sample:dino:n_vertices=1200', 'unused.png']
runpy.run_path({str(ROOT / "demos" / "every_iteration.py")!r}, run_name='__main__')
view, seen = apps[0], []
ps.set_user_callback(lambda: app.draw_app(view))
view.prepare()
for frame in np.linspace(0, view.frames() - 1, 7).astype(int):
    view.go_to(int(frame))
    image = window.grab()[:500]
    spheres = [view.grid.parts[0, k] for k in (1, 2)]
    captions, powers = [part.caption for part in spheres], [part.lens.power for part in spheres]
    seen.append([captions, [vermilion(image[:, 640 + 320 * k :][:, :320]) for k in range(2)], powers])
figures = dict(seen=seen)
""")
    folded = 0
    for captions, red, (power, same) in figures["seen"]:
        assert power == same
        for word, caption, share in zip(("Before", "After"), captions, red, strict=True):
            assert caption.startswith(f"{word}\n")
            assert (share > 1e-5) == (not caption.endswith("\n0 folded faces"))
            folded += share > 1e-5
    assert 0 < folded < 2 * len(figures["seen"])
