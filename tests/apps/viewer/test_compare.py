"""Surfaces side by side: each with its own figures, on the same scale."""

from itertools import pairwise

import numpy as np
import pytest
from drawing import drive, needs_drawing, use

import igl_spheremap as ism

pytestmark = needs_drawing


def test_a_comparison_judges_as_the_library_does():
    figures = drive("""
from igl_spheremap.apps.viewer.map_view import MapView
app.open_for(Pictures('unused.png', size=(1000, 680)))
v, f = ism.samples.make('dino', n_vertices=1500)
maps = {'Gauss map': ism.gauss_map(v, f), 'auto': ism.spherical_conformal_map(v, f).sphere}
shown = MapView(ism.check_mesh(v, f), maps)
ps.set_user_callback(lambda: app.draw_app(shown))
shots = []
for frame in range(shown.frames()):
    shown.go_to(frame)
    shots.append(drawn(window.grab()))
buttons, press = [], window.imgui.Button
window.imgui.Button = lambda label, *size: buttons.append(label) or press(label, *size)
window.grab()
figures = dict(captions=[part.caption for part in shown.grid.parts.values()], shots=shots, buttons=buttons)
""")
    v, f = ism.samples.make("dino", n_vertices=1500)
    result = ism.spherical_conformal_map(v, f)
    folded = ism.certify(ism.gauss_map(v, f), f).foldings
    gauss, auto = (
        np.abs(ism.angle_differences(v, f, x)).mean() for x in (ism.gauss_map(v, f), result.sphere)
    )
    assert figures["captions"] == [
        "Gauss map",
        "auto",
        f"{folded:,} folded faces\nangles differ by {gauss:.3g} degrees",
        f"0 folded faces\nangles differ by {auto:.3g} degrees",
    ]
    assert min(figures["shots"]) > 0.15
    assert "picture" in figures["buttons"]
    assert "map" not in figures["buttons"]  # which of them?


def test_maps_that_are_compared_are_of_the_surface(tmp_path):
    result = ism.spherical_conformal_map(*ism.samples.sphere(42))
    for maps, said in (
        ({}, "maps has none"),
        ({"short": result.sphere[1:]}, "short have 41 rows"),
        ({"flat": 0 * result.sphere}, "flat"),
    ):
        with pytest.raises(ValueError, match=said):
            ism.screenshot(result, tmp_path / "a.png", maps=maps)
        with pytest.raises(ValueError, match=said):
            ism.show(result, maps=maps)


def test_a_picture_of_maps_shows_each_of_them_with_its_name(tmp_path):
    figures = drive(f"""
from igl_spheremap.apps.viewer import show
v, f = ism.samples.make('dumbbell', n_vertices=300)
shown = []
present = show.present
def noted(build, *given, **options):
    return present(lambda: shown.append(build()) or shown[0], *given, **options)
show.present = noted
result = ism.spherical_conformal_map(v, f)
maps = dict(gauss=ism.gauss_map(v, f), large=100 * result.sphere)
ism.screenshot(result, {str(tmp_path / "a.png")!r}, maps=maps, size=(600, 400))
figures = dict(names=list(shown[0].maps), sizes=[float(abs(x).max()) for x in shown[0].maps.values()])
""")
    assert figures["names"] == ["gauss", "large"]
    assert max(figures["sizes"]) <= 1 + 1e-15
    assert (tmp_path / "a.png").exists()


def test_words_of_narrow_columns_do_not_lie_on_each_other():
    figures = drive("""
from igl_spheremap.apps.viewer import grid
from igl_spheremap.apps.viewer.map_view import MapView
app.open_for(Pictures('unused.png', size=(900, 700)))
v, f = ism.samples.make('dino', n_vertices=1500)
maps = dict.fromkeys('bcde', ism.gauss_map(v, f)) | {'a': ism.spherical_conformal_map(v, f).sphere}
shown = MapView(ism.check_mesh(v, f), maps, subject='angle differences')
words, write = [], grid.text
def noted(canvas, x, y, line):
    words.append((y, x - grid.text_width(line) / 2, x + grid.text_width(line) / 2, line))
    write(canvas, x, y, line)
grid.text = noted
ps.set_user_callback(lambda: app.draw_app(shown))
window.grab()
figures = dict(words=sorted(set(words)))
""")
    assert any("beyond" in line for *_, line in figures["words"])
    for (y, _, right, line), (below, left, _, other) in pairwise(figures["words"]):
        assert right <= left if y == below else below - y > 12, (line, other)


def test_the_lens_fits_the_map_with_the_fewest_foldings_and_columns_say_their_share_beyond_the_scale():
    figures = drive("""
from igl_spheremap.apps.viewer.map_view import MapView
app.open_for(Pictures('unused.png', size=(900, 700)))
v, f = ism.samples.make('dino', n_vertices=1500)
sound = ism.spherical_conformal_map(v, f)
planted = sound.sphere.copy()
tip = int(np.argmin(sound.conformal_factor()))
other = next(int(vertex) for vertex in f[(f == tip).any(axis=1)][0] if vertex != tip)
planted[tip] = 2 * planted[other] - planted[tip]
planted[tip] /= np.linalg.norm(planted[tip])
maps = {'Gauss map': ism.gauss_map(v, f), 'one fold': planted, 'auto': sound.sphere}
shown = MapView(sound.mesh, maps, subject='angle differences')
shown.look()
said = [[legend.label for legend in shown.grid.parts[0, k].legends if hasattr(legend, 'label')] for k in range(3)]
figures = dict(power=shown.lens.power, said=said)
""")
    assert figures["power"] > 1  # of the Gauss map, which is folded all over, it would be 1
    assert all(len(labels) == 1 for labels in figures["said"])
    assert "beyond" in figures["said"][0][0]


def test_a_vertex_of_a_flat_map_is_marked_on_both_sides_and_one_of_two_surfaces_on_none():
    figures = use("""
from igl_spheremap.apps.viewer.compare import PartsView, plane_view
from igl_spheremap.apps.viewer.grid import Part

def build():
    views.append(plane_view('cap', disk, ism.flatten(disk.v, disk.f).plane, 'z'))
    return views[0]

def script(hand):
    for x in (250, 750):
        hand.click_at(x, 250)
        figures['picked'].append(views[0].grid.picked is not None)
        hand.key(app.imgui.ImGuiKey_Escape)
        figures['picked'].append(views[0].grid.picked is not None)
    both = PartsView([[Part('one', v, f), Part('other', *ism.samples.sphere(42))]])
    both.pick(3)
    figures['picked'].append(both.grid.picked is not None)

views, figures = [], dict(picked=[])
v, f = ism.samples.make('sphere', n_vertices=500)
cap = ism.repair_disk(v, f[(v[f, 2] > 0).all(axis=1)])
disk = ism.check_disk(cap.v, cap.f)
Hand().run(lambda: app.present(build, size=(1000, 500)), script)
""")
    assert figures["picked"] == [True, False, True, False, False]
