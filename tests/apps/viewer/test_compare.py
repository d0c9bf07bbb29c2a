"""Surfaces side by side: each with its own figures, on the same scale."""

import numpy as np
import pytest
from drawing import drive, needs_drawing

import igl_spheremap as ism

pytestmark = needs_drawing


def test_a_comparison_judges_as_the_library_does():
    figures = drive("""
from igl_spheremap.apps.viewer.compare import Comparison
app.open_for(Pictures('unused.png', size=(1000, 680)))
v, f = ism.samples.make('dino', n_vertices=1500)
maps = {'Gauss map': ism.gauss_map(v, f), 'auto': ism.spherical_conformal_map(v, f).sphere}
shown = Comparison(ism.check_mesh(v, f), maps)
ps.set_user_callback(lambda: app.draw_app(shown))
shots = []
for frame in range(shown.frames()):
    shown.go_to(frame)
    shots.append(drawn(window.grab()))
share = {name: one[1] for name, one in shown._histograms.items()}
figures = dict(captions=[body.caption for body in shown.grid.bodies.values()], shots=shots,
            beyond=float(share['auto'][[0, -1]].sum()), total=[float(one.sum()) for one in share.values()])
""")
    v, f = ism.samples.make("dino", n_vertices=1500)
    result = ism.spherical_conformal_map(v, f)
    folded = ism.certify(ism.gauss_map(v, f), f).foldings
    assert figures["captions"][0] == f"Gauss map\n{folded:,} folded faces"
    assert figures["captions"][2:] == [
        "auto\n0 folded faces",
        f"angles differ by\n{np.abs(result.angle_differences()).mean():.3g} degrees",
    ]
    assert figures["beyond"] < 0.1  # its angle differences are nearly all within the histogram
    assert figures["total"] == pytest.approx([1, 1])
    assert min(figures["shots"]) > 0.15


def test_a_map_with_landmarks_shows_its_foldings_and_how_far_it_is_off():
    figures = drive("""
from igl_spheremap.apps.viewer.compare import PartsView, landmark_part
from igl_spheremap.draw.palette import LINES
v, f = ism.samples.make('spheroid', n_vertices=1500)
mesh, x = ism.check_mesh(v, f), ism.spherical_conformal_map(v, f).sphere
landmarks = np.argsort(-x[:, 2])[:8]  # in front
targets = x[landmarks] * [-1, -1, 1]
planted = x.copy()
planted[landmarks[0]] = np.array([0.3, 0.0, 1.0]) / np.hypot(0.3, 1.0)
app.open_for(Pictures('unused.png', size=(1200, 400)))
parts = [landmark_part('surface', mesh, x, landmarks), landmark_part('map', mesh, x, landmarks, targets),
         landmark_part('folded', mesh, planted, landmarks, targets)]
view = PartsView([parts])
ps.set_user_callback(lambda: app.draw_app(view))
image = window.grab()
columns = [image[:, 400 * k : 400 * k + 400].astype(int) for k in range(3)]
def share(image, colour):
    return float((abs(image - 255 * np.array(colour)).sum(axis=2) < 60).mean())
figures = dict(yellow=[share(column, LINES[5]) for column in columns],
               blue=[share(column, LINES[0]) for column in columns], red=[vermilion(column) for column in columns])
""")
    assert [share > 1e-4 for share in figures["yellow"]] == [False, True, True]
    assert min(figures["blue"]) > 1e-4
    assert [share > 1e-4 for share in figures["red"]] == [False, False, True]
