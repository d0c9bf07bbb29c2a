"""The player: every iterate of a run, its foldings always in sight, computed beside the window."""

import json
import sys
from functools import partial

import numpy as np
import pytest
from checkerboard import COLOURS
from drawing import drive, needs_drawing, run

import igl_spheremap as ism
from igl_spheremap.apps.viewer.run import Run, Slide, stops, thin
from igl_spheremap.descent.iterate import Step
from igl_spheremap.descent.recording import Recording
from igl_spheremap.draw import palette

_PLAYER = """
from igl_spheremap.apps.viewer.player import Player
from igl_spheremap.apps.viewer.player import PlayerWindow
from igl_spheremap.maps.options import METHODS
from igl_spheremap.samples import from_spec

def red(image):
    'Pixels of the colour of folded faces in the right half, where the spheres are.'
    r, g, b = (image[:, image.shape[1] // 2 :, k].astype(int) for k in range(3))
    return int(((r > 150) & (g < 110) & (b < 90)).sum())

def player(name, method, kind=Player, **options):
    app.open_for(Namespace(screenshot='unused.png', video=None, size=(900, 360)), 'test')
    shown = kind(from_spec, name, METHODS[method](**options), size=(900, 360))
    ps.set_user_callback(lambda: app.draw_app(shown))
    return shown
"""


def play(code):
    return drive(_PLAYER + code)


@pytest.fixture(scope="module")
def dino_run():
    run = Run(partial(ism.samples.make, "dino", n_vertices=1500), "lai2014")
    run.wait()
    return run


def test_a_run_in_another_process_is_the_run_here(dino_run):
    v, f = ism.samples.make("dino", n_vertices=1500)
    recording = Recording(f)
    here = ism.spherical_conformal_map(v, f, "lai2014", listener=recording)
    assert (dino_run.result.sphere == here.sphere).all()
    slides = dino_run.slides[:-1]
    for slide in slides[:: len(slides) // 9]:
        frame = recording.frames[slide.index]
        assert (slide.x == frame.iterate.x).all()
        assert slide.foldings == frame.foldings == len(slide.folded)
    # all iterates but those that repeat the map before, at the start of a minimisation
    assert len(slides) == len(here.history) - sum(s.stage == "harmonic" and s.iteration == 0 for s in here.history)


def test_the_mask_of_a_slide_is_its_certificate(dino_run):
    slide = dino_run.slides[0]
    certificate = ism.certify(slide.x, dino_run.mesh.f)
    assert set(slide.folded) == {*certificate.flipped, *certificate.degenerate}
    assert slide.foldings > 100


def test_stops_are_before_and_after_each_star_map_and_at_both_ends(dino_run):
    slides = dino_run.slides
    marks = dict(stops(slides))
    assert marks["Gauss map"] == 0
    assert marks["end"] == len(slides) - 1
    assert marks["after the star map"] == marks["before the star map"] + 1
    assert slides[marks["after the star map"]].step.stage == "star map"
    assert slides[marks["before the star map"]].foldings > 0 == slides[-1].foldings


def test_thinning_keeps_the_ends_of_stages_and_most_where_foldings_change():
    counts = [*range(1000, 0, -10), *[0] * 900]
    steps = [Step("harmonic" if k < 500 else "sobolev", 0, k, 0.0, 0.0, 0.0) for k in range(1000)]
    numbered = enumerate(zip(steps, counts, strict=True))
    slides = [Slide(k, step, "", np.eye(3), n, np.packbits([n > 0])) for k, (step, n) in numbered]
    kept = [slide.index for slide in thin(slides, 60)]
    assert {0, 499, 500, 999} <= set(kept)
    assert len(kept) <= 64
    assert sum(k < 100 for k in kept) > 15  # even coverage would keep 6
    assert max(np.diff(kept)) < 100


def test_a_bounded_run_forgets_slides_but_not_its_stops(dino_run):
    load = partial(ism.samples.make, "dino", n_vertices=1500)
    bounded = Run(load, "lai2014", budget=40 * dino_run.slides[0].x.nbytes)
    bounded.wait()
    assert len(bounded.slides) <= 45
    assert [name for name, _ in stops(bounded.slides)] == [name for name, _ in stops(dino_run.slides)]
    assert [(bounded.slides[k].index, bounded.slides[k].foldings) for _, k in stops(bounded.slides)] == [
        (dino_run.slides[k].index, dino_run.slides[k].foldings) for _, k in stops(dino_run.slides)
    ]


def test_what_ends_a_run_in_its_process_is_known_here():
    run = Run(partial(np.zeros, 3), "auto")
    run.wait()
    assert isinstance(run.error, TypeError | ValueError)
    assert not run.running


def test_no_colour_but_that_of_folded_faces_is_red():
    ramps = [palette.sequential("", 0, 1), palette.diverging("", 1)]
    colours = np.vstack([ramp.colours(np.linspace(-1, 1, 400)) for ramp in ramps])
    others = [palette.SURFACE, palette.EDGES, palette.INK, palette.BACKGROUND, *COLOURS]
    for light in np.linspace(0.6, 1, 30):
        r, g, b = (255 * light * np.vstack((colours, others))).T
        assert not ((r > 150) & (g < 110) & (b < 90)).any()
    for r, g, b in (palette.FOLDED, palette.FOLDED_EDGES):
        assert (255 * r > 150) & (255 * g < 110) & (255 * b < 90)


@needs_drawing
def test_red_is_in_sight_in_every_picture_that_counts_foldings():
    figures = play("""
shown = player('dino', 'lai2014')
shown.prepare()
iterations = {slide.step.iteration: k for k, slide in enumerate(shown.run.slides) if not slide.step.round}
frames = [iterations[k] - 1 for k in (1, 20, 100, 400, 600)] + shown.stops() + [shown.frames()]
figures = []
for frame in frames:
    shown.go_to(frame)
    image = window.grab()
    figures.append([shown.facts()['before']['foldings'], shown.facts()['foldings'], red(image), drawn(image)])
""")
    assert sum(before > 0 for before, *_ in figures) > 6
    for before, after, red, drawn in figures:
        assert (red > 150) == (before + after > 0)
        assert (red == 0) == (before + after == 0)
        assert drawn > 0.15


@needs_drawing
def test_the_player_draws_while_it_computes_and_starts_another_run():
    figures = play("""
shown = player('dino:n_vertices=3000', 'lai2014', PlayerWindow, tolerance=1e-12, plateau=0.0, rounds=0)
seen = set()
while shown.run.running and len(seen) < 5:
    shown.tick()
    ps.request_redraw()
    ps.frame_tick()
    seen.add(len(shown.run.slides))
shown.run.stop()
shown.run.wait()
status = shown.run.result.status.name
shown.start('bird:n_vertices=1500', METHODS['auto']())
shown.prepare()
shown.go_to(shown.last_frame())
image = window.grab()
shown.start('unicorn', METHODS['auto']())
shown.run.wait()
window.grab()
figures = dict(seen=len(seen), status=status, drawn=drawn(image), error=str(shown.run.error))
""")
    assert figures["seen"] >= 5
    assert figures["status"] == "STOPPED"
    assert figures["drawn"] > 0.15
    assert "unicorn" in figures["error"]


@needs_drawing
def test_play_writes_a_video_and_what_its_frames_show(tmp_path):
    images = pytest.importorskip("PIL.Image")
    command = [sys.executable, "-m", "igl_spheremap", "play", "sample:dino:n_vertices=1500"]
    files = ["--video", str(tmp_path / "run.gif"), "--json", str(tmp_path / "run.json")]
    done = run([*command, *files, "--length", "20", "--size", "500", "250"])
    assert done.returncode == 0, done.stderr
    frames = json.loads((tmp_path / "run.json").read_text())["frames"]
    with images.open(tmp_path / "run.gif") as video:
        assert video.n_frames == len(frames) >= 20
        held = []
        for k in range(video.n_frames):
            video.seek(k)
            if video.info["duration"] == 1000:
                held.append(frames[k])
    assert [frame["stage"] for frame in held[1:3]] == ["harmonic", "star map"]
    assert held[0]["before"]["stage"] == "gauss map"
    assert held[-1]["title"] == "Result: certified folding-free"
    assert frames[0]["before"]["foldings"] > 100 > frames[-1]["foldings"] == 0
