"""The parts of the viewer that need no window, and the pictures of a result."""

import ctypes
import os
import sys

import numpy as np
import pytest
from drawing import command, drive, needs_drawing, run, use

import igl_spheremap as ism
from igl_spheremap.apps.cli import main
from igl_spheremap.apps.viewer import choices, window
from igl_spheremap.apps.viewer.choices import SUBJECTS
from igl_spheremap.apps.viewer.colouring import Colours, relief
from igl_spheremap.draw import palette
from igl_spheremap.draw.plot import SIDES, UPS, fit, pose
from igl_spheremap.errors import DisplayError, FileError


@pytest.fixture(scope="module")
def dino():
    return ism.check_mesh(*ism.samples.make("dino", n_vertices=1500))


def test_the_help_lists_the_directions_that_there_are():
    assert ("auto", *UPS, *SIDES) == choices.UPS


@pytest.mark.parametrize("up", UPS)
def test_a_pose_is_a_rotation_with_up_upwards(dino, up):
    rotation = pose(dino.unit, up)
    assert rotation @ rotation.T == pytest.approx(np.eye(3))
    assert np.linalg.det(rotation) == pytest.approx(1)
    assert rotation[1] @ UPS[up] > 0.9


@pytest.mark.parametrize(("side", "x"), [("left", -1), ("right", 1)])
def test_a_view_from_a_side_shows_it_with_z_upwards(dino, side, x):
    rotation = pose(dino.unit, side)
    assert np.linalg.det(rotation) == pytest.approx(1)
    assert rotation[2].tolist() == [x, 0, 0]
    assert rotation[1].tolist() == [0, 0, 1]


@pytest.mark.parametrize("up", ["y", "z"])
@pytest.mark.parametrize("name", ["dino", "octopus"])
def test_what_stands_is_shown_standing_whatever_its_file_calls_up(name, up):
    v, _ = ism.samples.make(name, n_vertices=1500)
    turned = v if up == "z" else v[:, [1, 2, 0]]  # z becomes y
    assert pose(turned) == pytest.approx(pose(turned, up))


def test_fitting_moves_no_shape(dino):
    x = fit(dino.unit, pose(dino.unit))
    assert np.linalg.norm(x, axis=1).max() == pytest.approx(1)
    assert ism.angle_differences(dino.v, dino.f, x) == pytest.approx(0, abs=1e-6)


def test_ramps_give_their_stops_and_clamp_what_is_beyond():
    ramp = palette.diverging("u", 2.0)
    assert ramp.colours(np.array([-2.0, 2.0])) == pytest.approx(ramp.stops[[0, -1]])
    # overflow is a warning, which no picture has cause for
    for each in (ramp, palette.diverging("u", 1e-3)):
        with np.errstate(all="raise"):
            assert each.colours(np.array([-np.inf, np.inf])) == pytest.approx(each.stops[[0, -1]])
    level = palette.sequential("size", 0, 1).colours(np.linspace(0, 1, 50)) @ [
        0.2126,
        0.7152,
        0.0722,
    ]
    assert (np.diff(level) > 0).all()  # lightness alone tells the order


def test_folded_faces_stand_out_from_every_other_colour_for_red_green_blind_eyes():
    # Vienot, Brettel, Mollon 1999, deuteranopia, on linear RGB
    blind = np.array([[0.29275, 0.70725, 0], [0.29275, 0.70725, 0], [-0.02234, 0.02234, 1]])
    others = np.vstack(
        (palette.SURFACE, palette.sequential("", 0, 1).stops, palette.diverging("", 1).stops)
    )
    folded = window.linear(np.array(palette.FOLDED))
    for see in (np.eye(3), blind):
        apart = np.linalg.norm((window.linear(others) - folded) @ see.T, axis=1)
        assert apart.min() > 0.1


def test_every_subject_colours_every_face_and_finds_the_planted_fold(dino):
    x = ism.spherical_conformal_map(dino.v, dino.f).sphere
    planted = x.copy()
    vertex = int(np.argmax(ism.conformal_factor(dino.v, dino.f, x)))
    planted[vertex] = -planted[vertex]
    around = np.flatnonzero((dino.f == vertex).any(axis=1))
    for subject in SUBJECTS:
        assert len(Colours(subject).of(dino, x).folded) == 0
        found = Colours(subject).of(dino, planted)
        assert found.colours.shape == dino.f.shape
        assert 0 <= found.colours.min() <= found.colours.max() <= 1
        assert len(found.folded)
        assert set(found.folded) <= set(around)


def test_a_missing_library_is_one_line_with_the_packages(monkeypatch):
    def missing(name):
        raise OSError(name)

    monkeypatch.setattr(window.sys, "platform", "linux")
    monkeypatch.setattr(ctypes, "CDLL", missing)
    with pytest.raises(DisplayError, match=r"libEGL.*apt install libegl1") as error:
        window.backend(offscreen=True)
    assert "\n" not in str(error.value)


def test_relief_is_darker_in_hollows_whichever_way_the_faces_turn():
    v, f = ism.samples.make("dino", n_vertices=1500)
    outward, inward = (relief(ism.check_mesh(v, faces)) for faces in (f, f[:, ::-1]))
    assert outward == pytest.approx(inward)
    bright = relief(ism.check_mesh(*ism.samples.make("sphere", n_vertices=600)))
    assert bright.min() > 0.95
    assert 0.5 < outward.min() < 0.8 < 0.95 < outward.max() <= 1


def test_unknown_subjects_and_directions_are_refused():
    mesh = ism.check_mesh(*ism.samples.sphere(42))
    with pytest.raises(
        ValueError, match="unknown subject 'factor': choose one of foldings, angle differences"
    ):
        Colours("factor")
    with pytest.raises(ValueError, match="unknown direction 'up': choose one of auto, x, -x"):
        pose(mesh.unit, "up")


@needs_drawing
def test_opengl_that_does_not_start_is_one_line(tmp_path):
    code = """
from igl_spheremap.apps.viewer import window
try:
    window.open_window(offscreen=True)
except RuntimeError as error:
    print(type(error).__name__, error)
"""
    done = run([sys.executable, "-c", code], __EGL_VENDOR_LIBRARY_FILENAMES=str(tmp_path / "none"))
    assert done.returncode == 0
    assert done.stdout.startswith("DisplayError OpenGL did not start")
    assert len(done.stdout.splitlines()) == 1
    assert done.stderr == ""


@needs_drawing
def test_a_picture_of_a_result_shows_its_colours_as_the_legend_does(tmp_path):
    figures = drive(f"""
from igl_spheremap.apps.viewer.show import screenshot
v, f = ism.samples.make('sphere', n_vertices=600)
result = ism.spherical_conformal_map(v, f)
screenshot(result, {str(tmp_path / "a.png")!r})
image = window.grab()
screenshot(result, {str(tmp_path / "b.png")!r}, subject='area distortion', size=(600, 400))
smaller = window.grab()
figures = dict(drawn=drawn(image), vermilion=vermilion(image), shape=image.shape, smaller=smaller.shape,
            background=image[2, 2].tolist())
""")
    assert figures["shape"] == [760, 1280, 3]
    assert figures["smaller"] == [400, 600, 3]
    assert 0.2 < figures["drawn"] < 0.6
    assert figures["vermilion"] < 0.002  # the legend alone
    assert figures["background"] == [255, 255, 255]
    assert (tmp_path / "a.png").stat().st_size > 5000


@pytest.mark.parametrize("name", ["nowhere/a.png", "a.svg", "a", "folder.png"])
def test_a_picture_that_cannot_be_written_is_refused_before_anything_is_drawn(
    name, tmp_path, monkeypatch
):
    def drawn(*arguments, **options):
        raise AssertionError("a window was opened")

    (tmp_path / "folder.png").mkdir()
    monkeypatch.setattr(window, "open_window", drawn)
    result = ism.spherical_conformal_map(*ism.samples.sphere(42))
    with pytest.raises(ism.FileError, match=name):
        ism.screenshot(result, tmp_path / name)
    assert main(["view", "sample:sphere", "--screenshot", str(tmp_path / name)]) == 74
    assert [path.name for path in tmp_path.iterdir()] == ["folder.png"]


def test_a_video_that_cannot_be_written_is_refused_before_anything_is_drawn(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr(window, "open_window", None)
    (tmp_path / "file").write_text("")
    for name in ("nowhere/a.gif", "file"):
        assert main(["view", "sample:sphere", "--video", str(tmp_path / name)]) == 74
        assert name in capsys.readouterr().err


@needs_drawing
def test_no_body_leaves_its_cell_however_large_and_no_label_leaves_it_in_500_pixels():
    figures = drive("""
from igl_spheremap.apps.viewer.map_view import MapView
from dataclasses import replace
from igl_spheremap.apps.viewer.colouring import Colouring
from igl_spheremap.apps.viewer.grid import text_width, wrapped
app.open_for(Pictures('unused.png', size=(500, 300)))
v, f = ism.samples.make('dino', n_vertices=1500)
result = ism.spherical_conformal_map(v, f)
view = MapView(result.mesh, {'a caption that is ' + 9 * 'long ': result.sphere}, result=result)
widths = []
def draw():
    app.draw_app(view)
    for place, part in view.grid.parts.items():
        left, top, w, h = view.grid.cell(*place)
        widths.extend(w - text_width(line) for line in wrapped(part.caption, w))
ps.set_user_callback(draw)
window.grab()
left, _, w, _ = view.grid.cell(0, 1)
painted = [Colouring(np.tile(colour, (len(f), 1))) for colour in ([0.1, 0.9, 0.1], [0.1, 0.1, 0.9])]
view.grid.show([[replace(part, caption='', legends=(), colours=colours)
                 for part, colours in zip(view.grid.parts.values(), painted, strict=True)]])
view.grid.zoom = 8.0
image = window.grab().astype(int)
green = (image[..., 1] > image[..., 2] + 60).any(axis=0).nonzero()[0]
blue = (image[..., 2] > image[..., 1] + 60).any(axis=0).nonzero()[0]
panel = view.grid.panel
figures = dict(room=min(widths), border=left, green=[int(green[green > panel].min()), int(green.max())],
            blue=[int(blue[blue > panel].min()), int(blue.max())])
""")
    assert figures["room"] >= 0
    assert figures["green"][1] < figures["border"] + 2
    assert figures["border"] - 2 < figures["blue"][0] < figures["border"] + 40
    assert figures["blue"][1] > 490


def _viewed(name, vertices, subject):
    """The code of a window in which the map of a sample is viewed."""
    return f"""
from igl_spheremap.apps.viewer.map_view import MapView
app.open_for(Pictures('unused.png', size=(900, 400)))
v, f = ism.samples.make('{name}', n_vertices={vertices})
result = ism.spherical_conformal_map(v, f)
view = MapView(result.mesh, {{'map': result.sphere}}, result=result, subject='{subject}')
ps.set_user_callback(lambda: app.draw_app(view))

def rebalance(balance):
    view.rebalance(balance)
    view._run.wait()
    view._take_map()
"""


@needs_drawing
def test_the_balance_slider_goes_on_to_certified_maps_and_shows_what_their_areas_do():
    figures = drive(
        _viewed("spheroid", 500, "area distortion")
        + """
spread, facts, drawn_ = [], [], []
for balance in (0.5, 1.0, 0.0):
    rebalance(balance)
    drawn_.append(drawn(window.grab()))
    spread.append(float(np.abs(ism.log_area_ratios(v, f, view.result.sphere)).mean()))
    facts.append('\\n'.join(view.lines))
figures = dict(spread=spread, facts=facts, drawn=min(drawn_), back=bool((view.result.sphere == result.sphere).all()))
"""
    )
    half, equal, conformal = figures["spread"]
    assert equal < 0.02 < 0.4 * conformal < half < 0.7 * conformal
    assert figures["back"]
    assert all(
        "covered once (exact)" in text and "areas: change " in text for text in figures["facts"]
    )
    assert figures["drawn"] > 0.15


@needs_drawing
def test_another_balance_keeps_scale_poles_and_what_the_lens_does():
    figures = drive(
        _viewed("dumbbell", 800, "area distortion")
        + """
tip = int(np.argmin(result.conformal_factor()))
view.pick(tip)
view.look()
seen = []
for balance in (0.0, 1.0):
    rebalance(balance)
    view.show_subject('area distortion')
    high = view.colours.scales['area distortion'].high
    view.show_subject('checkerboard')
    around = view.grid.bodies[0, 1].x[f[(f == tip).any(axis=1)]]
    seen.append([high, view.colours._tips.tolist(), view.lens.power, float(around[..., 2].min())])
view.look(1.0)
rebalance(0.5)
whole = view.lens.power
behind = int(np.argmin((view.grid.bodies[0, 1].x @ view.grid.turn.T)[:, 2]))
view.pick(behind)
image = window.grab().astype(int)
left, top = (round(float(n)) for n in view.grid.pixels(view.grid.frame((0, 1)), view.grid.bodies[0, 1].x[behind]))
around = image[top - 14 : top + 14, left - 14 : left + 14]
ring = float(((around[..., 0] > 180) & (around[..., 1] < 90) & (around[..., 2] > 100)).mean())
figures = dict(seen=seen, ring=ring, whole=whole)
"""
    )
    (high, poles, power, _), (same, still, weaker, front) = figures["seen"]
    assert (high, poles) == (same, still)
    assert weaker < power / 3
    assert front > 0
    assert figures["whole"] == 1
    assert figures["ring"] > 0.05


@needs_drawing
def test_a_vertex_is_picked_on_either_side_and_the_lens_keeps_squares_around_it():
    figures = drive(
        _viewed("spheroid", 1000, "checkerboard")
        + """
window.grab()
view.grid.rotate(1.0, 0.5)
picked = []
for column in (1, 0):
    body = view.grid.bodies[0, column]
    front = int(np.argmax((body.x @ view.grid.turn.T)[:, 2]))
    view.grid.draw()
    view.pick(view.grid.vertex_at(view.grid.pixels(view.grid.frame((0, column)), body.x[front])))
    picked.append([view.grid.picked, front])
lines = view.lines
view.look(3.0)
seen = view.grid.bodies[0, 1].x
mean = [float(np.abs(ism.angle_differences(v, f, x)).mean()) for x in (result.sphere, seen)]
view.pick(view.grid.vertex_at([5.0, 5.0]))
figures = dict(mean=mean, free=ism.certify(seen, f).folding_free, picked=picked, lines=lines, none=view.grid.picked)
"""
    )
    before, after = figures["mean"]
    assert after < 2 * before + 0.2
    assert figures["free"]
    for vertex, front in figures["picked"]:
        assert vertex == front
    assert figures["none"] is None
    assert figures["lines"][0].startswith("vertex ")
    assert "angles differ by" in figures["lines"][1]


@needs_drawing
def test_the_lens_goes_to_the_vertex_that_is_picked_and_from_cluster_to_cluster():
    figures = drive("""
from igl_spheremap.apps.viewer.map_view import MapView
app.open_for(Pictures('unused.png', size=(900, 400)))
v, f = ism.samples.make('spheroid', n_vertices=300)
result = ism.spherical_conformal_map(v, f)
planted = result.sphere.copy()
tips = int(np.argmin(v[:, 2])), int(np.argmax(v[:, 2]))
for tip, far in zip(tips, (1.5, 1.0)):
    other = f[(f == tip).any(axis=1)].ravel()
    other = other[other != tip][0]
    planted[tip] = planted[other] + far * (planted[other] - planted[tip])
planted /= np.linalg.norm(planted, axis=1, keepdims=True)
view = MapView(result.mesh, {'map': planted}, result=result)
ps.set_user_callback(lambda: app.draw_app(view))
clusters, ahead = view.clusters, []
seen = lambda: view.grid.bodies[0, 1].x @ view.grid.turn.T
for k in range(len(clusters)):
    view.look(cluster=k)
    ahead.append(float(seen()[f[clusters[k]]][..., 2].min()))
    view.grid.rotate(2.0, 1.0)
vertex = int(np.argmin(np.abs(v[:, 2])))
view.pick(vertex)
view.look(40.0)
at, shown = seen()[vertex].tolist(), view.grid.insets[0, 1].visible
view.pick(tips[0])
next_at = seen()[tips[0]].tolist()
view.look(1.0)
plain = float(np.abs(view.grid.bodies[0, 1].x - planted @ view.turn.T).max())
sound = MapView(result.mesh, {'map': result.sphere}, result=result)
sound.pick(vertex)
sound.look(40.0)
sound.pick(None)
figures = dict(ahead=ahead, at=at, next=next_at, shown=shown, plain=plain, left=sound.grid.bodies[0, 1].magnified)
""")
    assert len(figures["ahead"]) == 2
    assert min(figures["ahead"]) > 0.3
    assert figures["at"] == pytest.approx([0, 0, 1])
    assert figures["next"] == pytest.approx([0, 0, 1])
    assert figures["shown"]
    assert figures["plain"] < 1e-12
    assert not figures["left"]  # the lens goes with the vertex


@needs_drawing
def test_the_small_sphere_covers_nothing_of_the_large_one():
    figures = drive("""
from igl_spheremap.apps.viewer.map_view import MapView
app.open_for(Pictures('unused.png', size=(900, 400)))
result = ism.spherical_conformal_map(*ism.samples.make('sphere', n_vertices=300))
view = MapView(result.mesh, {'map': result.sphere})
gaps = []
for size in ((1400, 900), (800, 600), (600, 900), (1400, 400), (500, 300)):
    ps.set_window_size(*size)
    (large, radius), (small, other) = view.grid.frame((0, 1)), view.grid.inset_frame((0, 1))
    gaps.append(float(np.hypot(*(large - small)[:2])) - radius - other)
figures = dict(gaps=gaps)
""")
    assert min(figures["gaps"]) >= 0


@needs_drawing
def test_every_widget_of_the_viewer_can_be_used_and_no_file_is_replaced(tmp_path):
    figures = use(f"""
import os
os.chdir({str(tmp_path)!r})
app.LENGTH, apps, room, figures = 3, [], [], {{}}
show_app, tick = app.show_app, ps.frame_tick

def keep(shown):
    apps.append(shown)
    show_app(shown)

def watched():
    room.append(apps[0].grid.panel)
    tick()

app.show_app, ps.frame_tick = keep, watched

def script(hand):
    hand.resize(500, 300)  # drawn in software, pixel by pixel
    figures['used'] = sorted(hand.everything(leave=('map',)))
    hand.choose('colours', 'checkerboard')
    squares = []
    for share in (0.1, 0.3, 0.45, 0.8):
        hand.slide('squares', share)
        squares.append(apps[0].colours.squares)
    figures['squares'] = squares
    hand.type('##name', 'mine')
    hand.click('map')
    hand.wait(lambda: hand.shows('wrote mine.npz'))
    open('mine.png', 'w').write('precious')
    hand.click('picture')
    hand.wait(lambda: hand.shows('wrote mine_2.png'))
    figures['kept'] = open('mine.png').read()
    figures['header'] = open('mine_2.png', 'rb').read(4).decode('latin1')

result = ism.spherical_conformal_map(*ism.samples.make('spheroid', n_vertices=200))
Hand().run(lambda: ism.show(result, up='left'), script)
figures['files'], figures['room'] = sorted(os.listdir()), min(room)
""")
    assert {"balance", "colours", "lens", "video"} <= set(figures["used"])
    assert not any(count % 2 for count in figures["squares"])
    assert figures["kept"] == "precious"
    assert figures["header"] == "\x89PNG"
    assert set(figures["files"]) == {"typed.gif", "typed.png", "mine.npz", "mine.png", "mine_2.png"}
    assert figures["room"] > 0


@pytest.mark.posix
@needs_drawing
def test_names_of_files_need_no_utf_8_but_those_of_pictures(tmp_path):
    pytest.importorskip("trimesh")
    pytest.importorskip("matplotlib")
    source, image = (tmp_path / os.fsdecode(name) for name in (b"\xff.obj", b"\xff.glb"))
    ism.write_mesh(source, *ism.samples.make("pear", n_vertices=300))
    command("map", source, image, "--plot", tmp_path / "map.png")
    command("view", source, "--screenshot", tmp_path / "view.png")
    command("play", source, "--method", "auto", "--screenshot", tmp_path / "play.png")
    assert len(list(tmp_path.glob("*.png"))) == 3
    assert ism.certify(*ism.read_mesh(image)).folding_free
    with pytest.raises(FileError, match="UTF-8"):
        window.check_picture(source.with_suffix(".png"))
