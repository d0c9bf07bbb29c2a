"""Each demo, off screen: its numbers against the library's, and its picture not blank."""

import importlib
import runpy
import struct
import sys

import numpy as np
import pytest
from drawing import DEMOS, ROOT, drive, needs_drawing, run

import igl_spheremap as ism
from igl_spheremap.apps.viewer import window

pytestmark = needs_drawing


def png_size(path):
    header = path.read_bytes()[:24]
    assert header[:8] == b"\x89PNG\r\n\x1a\n"
    return struct.unpack(">II", header[16:])


def test_compare_methods_judges_as_the_library_does():
    figures = drive("""
import compare_methods
demo = start(compare_methods, ['sample:dino:n_vertices=1500', '--methods', 'auto', 'stereographic'])
shots = []
for frame in range(demo.frames()):
    demo.go_to(frame)
    shots.append(drawn(window.grab()))
figures = dict(names=[c.name for c in demo.contenders], means=[c.mean for c in demo.contenders],
            foldings=[c.foldings for c in demo.contenders], shots=shots,
            beyond=[float(c.share[[0, -1]].sum()) for c in demo.contenders])
""")
    v, f = ism.samples.make("dino", n_vertices=1500)
    result = ism.spherical_conformal_map(v, f)
    assert figures["names"] == ["Gauss map", "auto", "stereographic"]
    assert figures["means"][1] == pytest.approx(np.abs(result.angle_differences()).mean())
    assert figures["foldings"][0] == ism.certify(ism.gauss_map(v, f), f).foldings
    assert figures["foldings"][1] == 0
    assert figures["beyond"][1] < 0.1  # its angle differences are nearly all within the histogram
    assert min(figures["shots"]) > 0.15


def test_conformal_texture_moves_by_conformal_maps_only():
    figures = drive("""
import conformal_texture
demo = start(conformal_texture, ['sample:spheroid:n_vertices=3000'])
before = np.abs(ism.angle_differences(demo.mesh.vertices, demo.mesh.f, demo.y)).mean()
window.grab()
at = demo.handle()
demo.drag_to(at + [40.0, -25.0])
image = window.grab()
moved = demo.handle() - at
after = np.abs(ism.angle_differences(demo.mesh.vertices, demo.mesh.f, demo.y)).mean()
demo.stage.rotate(1.0, 0.5)
front = int(np.argmax((demo.image.x @ demo.stage.turn.T)[:, 2]))
demo.stage.draw()
demo.pick(demo.stage.to_pixels(0, 1, demo.image.x[front]))
free = ism.certify(demo.y, demo.mesh.f).folding_free
figures = dict(before=before, after=after, moved=moved.tolist(), free=free,
            strength=float(np.linalg.norm(demo.centre)), drawn=drawn(image), picked=demo.picked, front=front)
""")
    assert figures["moved"] == pytest.approx([40, -25])
    assert 0.1 < figures["strength"] < 0.95
    assert figures["free"]
    assert figures["after"] < 2 * figures["before"] + 0.2
    assert figures["drawn"] > 0.3
    assert figures["picked"] == figures["front"]


def test_align_landmarks_shows_each_map_with_its_foldings():
    figures = drive("""
import align_landmarks as demo
left, right = (ism.check_mesh(*ism.samples.make(name, n_vertices=1500)) for name in ('pear', 'dumbbell'))
demo.hemispheres = lambda others: (left, right, demo._spread(left, others))
alignment = demo.align(1000.0, 40)
app.open_for(Namespace(screenshot='unused.png', video=None, size=(1400, 440)), 'test')
view = alignment.view()
ps.set_user_callback(lambda: app.draw_app(view))
image = window.grab()
columns = [image[:, 350 * k : 350 * k + 350] for k in range(4)]
maps = alignment.maps.values()
figures = dict(foldings=[one.certificate.foldings for one in maps], red=[vermilion(column) for column in columns[1:]],
            drawn=min(drawn(column) for column in columns), miss=[float(alignment.misses(one).mean()) for one in maps])
""")
    assert figures["drawn"] > 0.1
    assert [red > 1e-4 for red in figures["red"]] == [count > 0 for count in figures["foldings"]]
    before, free, injective = figures["miss"]
    assert free < before > injective
    assert figures["foldings"][1] > 0


def test_gallery_makes_the_first_picture(tmp_path):
    done = run([sys.executable, str(DEMOS / "gallery.py"), "dino", "--to", str(tmp_path)])
    assert done.returncode == 0, done.stderr
    assert png_size(tmp_path / "dino.png") == (1200, 440)
    assert 20_000 < (tmp_path / "dino.png").stat().st_size < 300_000


def test_the_pictures_in_the_repository_are_the_gallery_s(monkeypatch):
    monkeypatch.syspath_prepend(str(DEMOS))
    gallery = importlib.import_module("gallery")
    images = {path.stem: path for path in (ROOT / "docs" / "images").glob("*.png")}
    assert set(gallery.PICTURES) <= set(images)
    assert max(path.stat().st_size for path in images.values()) < 300_000


def test_video_is_numbered_pictures(tmp_path):
    script = str(DEMOS / "conformal_texture.py")
    done = run(
        [
            sys.executable,
            script,
            "sample:sphere:n_vertices=300",
            "--video",
            str(tmp_path),
            "--length",
            "3",
            "--size",
            "500",
            "300",
        ]
    )
    assert done.returncode == 0, done.stderr
    pictures = sorted(tmp_path.iterdir())
    assert [path.name for path in pictures] == ["00000.png", "00001.png", "00002.png"]
    assert {png_size(path) for path in pictures} == {(500, 300)}
    assert len({path.read_bytes() for path in pictures}) == 3


def test_what_is_wrong_takes_one_line(tmp_path):
    script = DEMOS / "conformal_texture.py"
    words = ["sample:sphere:n_vertices=200", "--frame", "100000", "--screenshot", str(tmp_path / "out.png")]
    done = run([sys.executable, str(script), *words])
    assert done.returncode == 70
    assert len(done.stderr.splitlines()) == 1
    assert done.stderr.startswith("conformal_texture.py: ")


@pytest.mark.parametrize(
    ("name", "source", "status"), [("conformal_texture", "sample:unicorn", 64), ("compare_methods", "nowhere.obj", 74)]
)
def test_a_source_that_is_wrong_takes_one_line(name, source, status, monkeypatch, capsys):
    script = str(DEMOS / f"{name}.py")
    monkeypatch.syspath_prepend(str(DEMOS))
    monkeypatch.setattr(sys, "argv", [script, source])
    with pytest.raises(SystemExit) as end:
        runpy.run_path(script, run_name="__main__")
    assert end.value.code == status
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert err.startswith(f"{name}.py: ")


def test_without_a_display_a_window_is_refused_in_one_line(monkeypatch, capsys):
    script = str(DEMOS / "folding_removal.py")
    monkeypatch.setattr(sys, "argv", [script, "sample:sphere:n_vertices=200"])
    monkeypatch.setattr(window, "_offscreen", None)  # as in a process that has drawn nothing
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(SystemExit) as end:
        runpy.run_path(script, run_name="__main__")
    assert end.value.code == 70
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert "--screenshot" in err
