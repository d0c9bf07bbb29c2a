"""The player: every iterate of a run, its foldings always in sight, computed beside the window."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from functools import partial

import numpy as np
import pytest
from drawing import command, drive, needs_drawing, run

import igl_spheremap as ism
from igl_spheremap.apps.viewer.background_run import ShownRun, changes
from igl_spheremap.draw import palette
from igl_spheremap.result.recording import Recording

LAI2014 = partial(ism.spherical_conformal_map, method="lai2014")

_PLAYER = """
from functools import partial
from igl_spheremap.apps.viewer.player import Player, in_background
from igl_spheremap.maps.options import METHODS
from igl_spheremap.samples import from_spec

def red(image):
    'Pixels of the colour of folded faces in the right half above the curves, where the spheres are.'
    r, g, b = (image[:250, image.shape[1] // 2 :, k].astype(int) for k in range(3))
    return int(((r > 150) & (g < 110) & (b < 90)).sum())

def player(name, method, **options):
    app.open_for(Pictures('unused.png', size=(900, 360)))
    shown = Player(partial(in_background, from_spec, 400_000_000), name, METHODS[method](**options))
    shown.grid.panel = 0  # as in pictures
    ps.set_user_callback(lambda: app.draw_app(shown))
    return shown
"""


def play(code):
    return drive(_PLAYER + code)


@pytest.fixture(scope="module")
def dino_run():
    run = ShownRun().begin(partial(ism.samples.make, "dino", n_vertices=1200), LAI2014)
    run.wait()
    return run


def test_a_run_in_another_process_is_the_run_here(dino_run):
    v, f = ism.samples.make("dino", n_vertices=1200)
    recording = Recording(f)
    here = ism.spherical_conformal_map(v, f, method="lai2014", listener=recording)
    assert (dino_run.result.sphere == here.sphere).all()
    # all iterates but those that repeat the map before, at the start of a minimisation
    different = [recording.frames[0]]
    for frame in recording.frames[1:]:
        if (
            frame.iterate.iteration
            or np.abs(frame.iterate.x - different[-1].iterate.x).max() >= 1e-9
        ):
            different.append(frame)
    frames = dino_run.frames[:-1]
    assert [frame.index for frame in frames] == list(range(len(different)))
    for shown, frame in zip(frames, different, strict=True):
        assert (shown.iterate.x == frame.iterate.x).all()
        assert shown.foldings == frame.foldings == len(shown.folded)


def test_changes_of_the_foldings_are_few_and_each_is_large():
    rng = np.random.default_rng(0)
    flickering = np.where(rng.random(3000) < 0.5, 0, rng.integers(1, 40, 3000))
    for counts in (flickering, np.arange(5000)[::-1], np.array([7]), np.array([0, 1, 1])):
        found, levels = changes(counts), np.log2(1.0 + counts)
        starts = np.concatenate(([0], found + 1))
        assert len(found) <= 24
        assert (np.abs(np.diff(levels[starts])) >= 1).all()
    assert changes(np.array([0, 1, 1])).tolist() == [0]
    assert len(changes(np.arange(5000)[::-1])) == 12


def test_the_next_change_is_the_first_one_beyond(dino_run):
    steps = dino_run.changes.tolist()
    assert len(steps) > 1
    for k in range(0, len(dino_run.foldings), 7):
        assert dino_run.change(k, 1) == next((j for j in steps if j > k), None)
        assert dino_run.change(k, -1) == next((j for j in steps[::-1] if j < k), None)


def test_the_mask_of_a_frame_is_its_certificate(dino_run):
    frame = dino_run.frames[0]
    certificate = ism.certify(frame.iterate.x, dino_run.mesh.f)
    assert set(frame.folded) == {*certificate.flipped, *certificate.degenerate}
    assert frame.foldings > 100


def test_stops_are_before_and_after_each_star_map_and_at_both_ends(dino_run):
    frames = dino_run.frames
    marks = dict(dino_run.stops())
    assert marks["Gauss map"] == 0
    assert dino_run.title(frames[0]) == "Gauss map, iteration 0"
    assert marks["end"] == len(frames) - 1
    assert marks["after the star map"] == marks["before the star map"] + 1
    assert frames[marks["after the star map"]].iterate.stage == "star map"
    assert frames[marks["before the star map"]].foldings > 0 == frames[-1].foldings


def test_a_bounded_run_forgets_frames_but_not_its_stops_and_says_so(dino_run):
    load = partial(ism.samples.make, "dino", n_vertices=1200)
    bounded = ShownRun(40 * dino_run.frames[0].iterate.x.nbytes).begin(load, LAI2014)
    bounded.wait()
    assert len(bounded.frames) <= 40
    assert f"{len(bounded.frames)} of {len(dino_run.frames)} iterates are kept" in bounded.memory
    assert "every iterate is kept" in dino_run.memory
    assert (bounded.foldings == dino_run.foldings).all()
    assert [name for name, _ in bounded.stops()] == [name for name, _ in dino_run.stops()]
    assert [(bounded.frames[k].index, bounded.frames[k].foldings) for _, k in bounded.stops()] == [
        (dino_run.frames[k].index, dino_run.frames[k].foldings) for _, k in dino_run.stops()
    ]


def test_what_ends_a_run_in_its_process_is_known_here():
    run = ShownRun().begin(partial(np.zeros, 3), ism.spherical_conformal_map)
    run.wait()
    assert isinstance(run.error, TypeError | ValueError)
    assert not run.running


def _large_then_killed():
    """Arrays that no pipe takes at once, from a process that is killed while they are on their way."""
    threading.Timer(1.0, lambda: os.kill(os.getpid(), signal.SIGKILL)).start()
    return ism.samples.make("spheroid", n_vertices=100_000)


@pytest.mark.posix
def test_a_run_that_is_killed_within_a_message_is_an_error_and_not_waited_for():
    run = ShownRun().begin(_large_then_killed, ism.spherical_conformal_map)
    run.process.join()  # nobody takes the message, so the process is killed as it sends
    run.stop()
    run.wait()
    assert str(run.error) == "the computation ended with exit code -9"


@pytest.mark.posix
def test_the_process_of_a_run_ends_with_a_window_that_is_killed():
    code = """
import time
from functools import partial
import igl_spheremap as ism
from igl_spheremap.apps.viewer.background_run import ShownRun, changes
run = ShownRun().begin(partial(ism.samples.make, 'dumbbell', n_vertices=300),
                    partial(ism.spherical_conformal_map, method='lai2014'))
while run.mesh is None and run.running:
    run.poll(0.1, 0.1)
print(run.process.pid, flush=True)
time.sleep(60)
"""
    with subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, text=True
    ) as window:
        process = int(window.stdout.readline())
        window.kill()

    def is_alive():
        state = run(["ps", "-o", "stat=", "-p", str(process)]).stdout.strip()
        # a process that ended may wait to be reaped
        return bool(state) and not state.startswith("Z")

    until = time.monotonic() + 30
    while is_alive() and time.monotonic() < until:
        time.sleep(0.1)
    assert not is_alive()


def test_no_colour_but_that_of_folded_faces_is_red():
    ramps = [
        palette.sequential("", 0, 1),
        palette.pale("", 0, 1),
        palette.sizes("", 1),
        palette.diverging("", 1),
    ]
    colours = np.vstack([ramp.colours(np.linspace(-1, 1, 400)) for ramp in ramps])
    others = [palette.SURFACE, palette.EDGES, palette.INK, palette.BACKGROUND, *palette.CHECKS]
    for light in np.linspace(0.6, 1, 30):
        r, g, b = (255 * light * np.vstack((colours, others))).T
        assert not ((r > 150) & (g < 110) & (b < 90)).any()
    for r, g, b in (palette.FOLDED, palette.FOLDED_EDGES):
        assert (255 * r > 150) & (255 * g < 110) & (255 * b < 90)


@needs_drawing
def test_red_is_in_sight_in_every_picture_that_counts_foldings():
    figures = play("""
shown = player('dino:n_vertices=1200', 'lai2014')
shown.prepare()
iterations = {frame.iterate.iteration: k for k, frame in enumerate(shown.run.frames) if not frame.iterate.round}
stops = [k - 1 for _, k in shown.run.stops() if k]
frames = [iterations[k] - 1 for k in (1, 20, 100, 200)] + stops
figures = []
for frame in frames:
    shown.go_to(frame)
    image = window.grab()
    figures.append([shown.facts()['before']['foldings'], shown.facts()['foldings'], red(image), drawn(image)])
""")
    assert sum(before > 0 for before, *_ in figures) > 5
    for before, after, red, drawn in figures:
        assert (red > 150) == (before + after > 0)
        assert (red == 0) == (before + after == 0)
        assert drawn > 0.15


@needs_drawing
def test_the_strip_shows_each_stage_s_foldings_on_body_and_sphere_through_one_lens():
    figures = play("""
shown = player('dino:n_vertices=1200', 'lai2014')
ps.set_window_size(1280, 760)
shown.prepare()
shown.go_to(shown.last_frame())
image = window.grab().astype(int)
red = (image[..., 0] > 150) & (image[..., 1] < 110) & (image[..., 2] < 90)
columns = []
for k in range(shown.grid.columns):
    cells = [[round(n) for n in shown.grid.cell(row, k)] for row in (0, 1)]
    seen = [int(red[top : top + h - 50, left : left + w].sum()) for left, top, w, h in cells]
    lens = shown.grid.parts[1, k].lens
    columns.append([shown.grid.parts[0, k].caption, seen, lens.power if lens else 1])
shown.go_to(0)
figures = dict(columns=columns, curve=int(red[-150:].sum()), back=shown.grid.rows)
""")
    captions, seen, powers = zip(*figures["columns"], strict=True)
    assert [caption.partition(",")[0].partition(" 1")[0] for caption in captions] == [
        "Gauss map",
        "Algorithm",
        "Algorithm",
        "Star map",
        "Result: certified folding-free\n0 folded faces",
    ]
    folded = [not caption.endswith("\n0 folded faces") for caption in captions]
    assert folded == [True, True, True, False, False]
    assert [[count > 50 for count in pair] for pair in seen] == [[fold, fold] for fold in folded]
    assert powers[0] == powers[1] == 1 < powers[2] == powers[3] == powers[4]
    assert figures["curve"] > 200
    assert figures["back"] == 1  # a step after the strip


@needs_drawing
def test_the_checkerboard_is_on_the_spheres_with_and_without_the_lens_and_a_scale_stays():
    figures = play("""
from igl_spheremap.draw.palette import CHECKS
shown = player('dino:n_vertices=1200', 'lai2014')
ps.set_window_size(1280, 760)
shown.prepare()
shown.go_to(100)
dark, scales, powers = [], [], []
shown.colours.subject = 'checkerboard'
for power in (None, 1.0):
    shown.look(power)
    image = window.grab()[:500].astype(int)
    blue = (image[..., 2] > image[..., 0] + 40) & (image[..., 0] < 60)
    dark.append([float(blue[:, left : left + 420].mean()) for left in (430, 858)])
    powers.append([[shown.grid.parts[0, k].lens.power for k in (1, 2)], shown.grid.insets[0, 1].visible])
shown.colours.subject = 'angle differences'
for frame in (100, 0, 200, 300):
    shown.go_to(frame)
    scales.append([legend.ends if hasattr(legend, 'ends') else legend[0] for legend in shown.grid.parts[0, 0].legends])
figures = dict(dark=dark, scales=scales, powers=powers)
""")
    assert min(map(min, figures["dark"])) > 0.1
    (through, small), (plain, none) = figures["powers"]
    assert through[0] == through[1] > 1
    assert small
    assert plain == [1, 1]
    assert not none
    scale, red = figures["scales"][0]
    assert all(shown[0] == scale for shown in figures["scales"])
    assert red.startswith("folded face")


@needs_drawing
def test_the_curve_of_a_window_has_each_folding_of_its_run():
    figures = play("""
import polyscope.implot as implot
shown = player('dino:n_vertices=1200', 'lai2014')
shown.prepare()
shown.tick()
drawn, plot = {}, implot.PlotLine
implot.PlotLine = lambda name, x, y: (drawn.update({name: (x.tolist(), y.tolist())}), plot(name, x, y))
window.grab()
figures = dict(drawn=drawn['folded faces'], foldings=shown.run.foldings.tolist())
""")
    x, y = figures["drawn"]
    peaks = [k for k, count in enumerate(figures["foldings"]) if count]
    assert [k for k, count in zip(x, y, strict=True) if count] == peaks
    assert len(peaks) > 200
    assert np.sinh(y) == pytest.approx([figures["foldings"][int(k)] for k in x])


@needs_drawing
def test_the_player_draws_while_it_computes_and_starts_another_run():
    figures = play("""
shown = player('dino:n_vertices=1500', 'lai2014', gradient_tolerance=1e-12, plateau=0.0, rounds=0)
seen = set()
while shown.run.running and len(seen) < 5:
    shown.tick()
    ps.request_redraw()
    ps.frame_tick()
    seen.add(len(shown.run.frames))
shown.run.stop()
shown.run.wait()
status = shown.run.result.status.name
shown.start('bird:n_vertices=1000', METHODS['auto']())
shown.prepare()
shown.go_to(shown.last_frame())
image = window.grab()
kept = shown.run
shown.start('unicorn', METHODS['auto']())
shown._next.wait()
shown.tick()
window.grab()
figures = dict(seen=len(seen), status=status, drawn=drawn(image), error=str(shown.refusal), kept=shown.run is kept)
""")
    assert figures["seen"] >= 5
    assert figures["status"] == "STOPPED"
    assert figures["drawn"] > 0.1
    assert "unicorn" in figures["error"]
    assert figures["kept"]  # a wrong name ends no run


@needs_drawing
def test_play_writes_a_video_and_what_its_frames_show(tmp_path):
    images = pytest.importorskip("PIL.Image")
    files = "--video", tmp_path / "run.gif", "--json", tmp_path / "run.json"
    command("play", "sample:dino:n_vertices=1200", *files, "--length", 16, "--size", 500, 250)
    frames = json.loads((tmp_path / "run.json").read_text())["frames"]
    with images.open(tmp_path / "run.gif") as video:
        assert video.n_frames == len(frames) >= 12
        held = []
        for k in range(video.n_frames):
            video.seek(k)
            if video.info["duration"] == 1000:
                held.append(frames[k])
    assert [frame["stage"] for frame in held[1:3]] == ["harmonic", "star map"]
    assert held[0]["before"]["stage"] == "gauss map"
    assert held[-1]["title"] == "Result: certified folding-free"
    assert frames[0]["before"]["foldings"] > 100 > frames[-1]["foldings"] == 0


@needs_drawing
def test_each_surface_stands_by_its_own_name_and_a_clicked_vertex_is_marked_on_all_bodies():
    figures = play("""
files = {
    'sample:bird': ism.samples.make('bird', n_vertices=1000),
    'a.obj': ism.samples.make('dumbbell', n_vertices=300),
}
app.open_for(Pictures('unused.png', size=(900, 360)))
start = partial(in_background, files.get, 400_000_000)
shown = Player(start, 'sample:bird', METHODS['auto'](), up='z')
shown.grid.panel = 0
shown.prepare()
turns = [shown.turn.tolist()]
shown.start('a.obj', METHODS['auto']())
shown.prepare()
shown.tick()
shown.prepare()
turns.append(shown.turn.tolist())
from igl_spheremap.draw.plot import pose
by_shape = pose(shown.mesh.unit, 'auto').tolist()
shown.go_to(0)
ps.set_user_callback(lambda: app.draw_app(shown))
window.grab()
body = shown.grid.bodies[0, 0]
front = int(np.argmax((body.x @ shown.grid.turn.T)[:, 2]))
pixel = shown.grid.pixels(shown.grid.frame((0, 0)), body.x[front])
shown.pick(shown.grid.vertex_at(pixel))
image = window.grab().astype(int)
magenta = (image[..., 0] > 180) & (image[..., 1] < 90) & (image[..., 2] > 100)
rings = sum(bool(part.any()) for part in np.array_split(magenta, 3, axis=1))
shown.look(3.0)
ahead = float((shown.grid.bodies[0, 1].x @ shown.grid.turn.T)[front, 2])
figures = dict(turns=turns, by_shape=by_shape, picked=shown.grid.picked, front=front, rings=rings, ahead=ahead)
""")
    assert figures["picked"] == figures["front"]
    assert figures["rings"] == 3
    assert figures["ahead"] == pytest.approx(1)
    assert figures["turns"][1] == figures["by_shape"]
    assert figures["turns"][0] != figures["turns"][1]


@needs_drawing
def test_the_lens_stays_on_the_cluster_that_was_chosen_from_step_to_step():
    figures = play("""
shown = player('dino:n_vertices=1200', 'lai2014')
shown.prepare()
shown.go_to(100)
shown.look(None, 1)
chosen, faces = shown.cluster, set(shown.clusters[1].tolist())
shown.go_to(101)
kept = faces & set(shown.clusters[shown.cluster].tolist())
figures = dict(chosen=chosen, count=len(faces), kept=len(kept), largest=len(shown.clusters[0]))
""")
    assert figures["chosen"] == 1
    assert figures["kept"] > figures["count"] / 2
    assert figures["count"] <= figures["largest"]
