"""Each demo is a short script that uses the library alone, and draws one picture."""

import ast
import struct
import sys

import pytest
from corpus import ROOT
from drawing import needs_drawing, run

DEMOS = sorted((ROOT / "demos").glob("*.py"))
#: Demos that take a surface take it first.
ON_A_SURFACE = ("folding_removal", "checkerboard", "compare_methods")


def png_size(path):
    header = path.read_bytes()[:24]
    assert header[:8] == b"\x89PNG\r\n\x1a\n"
    return struct.unpack(">II", header[16:])


def test_there_are_six():
    assert len(DEMOS) == 6


@pytest.mark.parametrize("demo", DEMOS, ids=lambda path: path.stem)
def test_a_demo_is_a_screen_that_uses_the_library_alone(demo):
    text = demo.read_text("utf-8")
    tree = ast.parse(text)
    code = [line for line in text.splitlines()[tree.body[0].end_lineno :] if line.strip()]
    assert len(code) <= 30
    imported = {name.partition(".")[0] for node in ast.walk(tree) if isinstance(node, ast.Import | ast.ImportFrom)
                for name in ([alias.name for alias in node.names] if isinstance(node, ast.Import) else [node.module])}
    assert imported <= {"sys", "numpy", "igl", "polyscope", "igl_spheremap"}


@needs_drawing
@pytest.mark.parametrize("demo", DEMOS, ids=lambda path: path.stem)
def test_a_demo_draws_its_picture_without_a_display(demo, tmp_path):
    picture = tmp_path / "picture.png"
    source = [""] if demo.stem in ON_A_SURFACE else []
    done = run([sys.executable, str(demo), *source, str(picture)], DISPLAY="", WAYLAND_DISPLAY="")
    assert done.returncode == 0, done.stderr
    assert min(png_size(picture)) > 400
    assert picture.stat().st_size > 50_000


@needs_drawing
def test_the_demo_of_foldings_takes_a_surface_and_writes_a_video(tmp_path):
    import igl_spheremap as ism

    ism.write_mesh(tmp_path / "body.obj", *ism.samples.make("bird", n_vertices=900))
    words = [sys.executable, str(ROOT / "demos" / "folding_removal.py"), str(tmp_path / "body.obj")]
    done = run([*words, str(tmp_path / "run")])
    assert done.returncode == 0, done.stderr
    assert len(list((tmp_path / "run").glob("*.png"))) > 20
