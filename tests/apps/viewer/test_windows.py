"""Every window under a hand: each widget is used, and nothing raises, prints, or goes wrong in the window."""

from functools import partial

import pytest
from drawing import needs_drawing, use

import igl_spheremap as ism
from igl_spheremap.apps.viewer.background_run import ShownRun
from igl_spheremap.apps.viewer.choices import SUBJECTS, TIPS
from igl_spheremap.apps.viewer.player import parameters
from igl_spheremap.maps.options import METHODS


@needs_drawing
def test_every_widget_of_the_player_can_be_used_and_leads_where_it_says(tmp_path):
    figures = use(f"""
import os
from igl_spheremap.maps.options import METHODS
os.chdir({str(tmp_path)!r})
app.LENGTH = 3

def script(hand):
    def at():
        return hand.find('##iteration').value

    def done():
        hand.wait(lambda: hand.has('##iteration') and not hand.find('stop').enabled)

    done()
    hand.click('pause')
    hand.click_at(*hand.find('folded faces, by iterate').at(0.5))
    figures['pressed'] = at()
    plot = hand.find('folded faces, by iterate')
    hand.drag(plot.at(0.5), (plot.at(0.6)[0], plot.rectangle[1] - 50))  # beyond the plot
    figures['dragged'] = at()
    for act in (lambda: hand.click('next'), lambda: hand.click('previous'), lambda: hand.click('>'),
                lambda: hand.key(app.imgui.ImGuiKey_DownArrow), lambda: hand.key(app.imgui.ImGuiKey_LeftArrow)):
        act()
        hand.frame(2)
        figures['visited'].append(at())
    hand.click_at(470, 130)  # a vertex of the surface, for the lens
    hand.resize(500, 300)  # drawn in software, pixel by pixel
    typed = {{'max iterations': '9', '##name': 'saved'}}
    figures['used'] = sorted(hand.everything(leave=('run', 'play '), typed=typed))
    hand.choose('speed', 'x100')
    hand.choose('stops', 'Gauss map')
    figures['visited'].append(at())
    hand.key(app.imgui.ImGuiKey_Space)
    hand.wait(lambda: hand.has('play '))
    figures['visited'].append(at())
    hand.choose('method', 'lai2014')
    hand.type('delta', '5')
    figures['refused'] = hand.shows('delta is 5; give a number from 0 to 1')
    for size in ((1400, 900), (640, 400), (500, 300)):
        hand.resize(*size)
    hand.type('mesh', 'sample:unicorn')
    hand.click('run')
    hand.wait(lambda: hand.shows('unicorn'))
    hand.type('mesh', 'sample:dumbbell:n_vertices=3000')
    hand.choose('method', 'lai2014')
    hand.click('run')
    hand.wait(lambda: hand.find('stop').enabled)
    hand.click('stop')
    done()
    figures['methods'] = hand.open('method')
    hand.click('lai2014')
    for button in (0, 1):
        hand.drag((400, 150), (440, 190), button)
    hand.wheel(400, 150, 2)
    hand.click('picture')
    hand.wait(lambda: hand.shows('wrote sample_dumbbell_n_vertices_3000_run.png'))

figures = dict(visited=[])
v, f = ism.samples.make('bird', n_vertices=1000)
method = ism.Lai2014(edge_weights='cotangent', metric='areas')
Hand().run(lambda: ism.play(v, f, method=method, size=(640, 400)), script)
figures['methods_there'] = list(METHODS)
figures['files'] = sorted(os.listdir())
""")
    method = ism.Lai2014(edge_weights="cotangent", metric="areas")
    run = ShownRun().begin(
        partial(ism.samples.make, "bird", n_vertices=1000),
        partial(ism.spherical_conformal_map, method=method),
    )
    run.wait()
    start = figures["dragged"]
    assert figures["pressed"] < start
    # the numbers of the axis lie to the left of the curve
    assert 0.2 < start / len(run.foldings) < 0.6
    after = run.change(start, 1)
    before = run.change(after, -1)
    again = run.change(before + 1, 1) or before + 1
    assert figures["visited"] == [
        after,
        before,
        before + 1,
        again,
        again - 1,
        0,
        run.iterations[-1],
    ]
    assert {
        "mesh",
        "samples",
        "method",
        "parameters",
        "##iteration",
        "previous",
        "stops",
        "lens",
        "picture",
        "map",
        "folded faces, by iterate",
        "fit",
        "whole sphere",
    } <= set(figures["used"])
    assert figures["refused"]
    assert figures["methods"] == figures["methods_there"]
    assert figures["files"] == [
        "sample_dumbbell_n_vertices_3000_run.png",
        "saved.gif",
        "saved.npz",
        "saved.png",
    ]


def test_every_parameter_has_a_tooltip_and_no_other():
    assert {name for method in METHODS.values() for name in parameters(method())} == TIPS.keys()


@needs_drawing
@pytest.mark.parametrize("size", [(1280, 760), (1366, 768)])
def test_the_player_s_controls_are_all_in_sight_and_stay_where_they_are(size, tmp_path):
    figures = use(f"""
import os
os.chdir({str(tmp_path)!r})

def script(hand):
    def note(state):
        hand.frame(2)
        figures['places'][state] = {{w.kind + w.label.replace('pause', 'play '): w.rectangle for w in hand.widgets
                                    if w.window[0] == 0}}

    def done():
        hand.wait(lambda: hand.has('##iteration') and not hand.find('stop').enabled)

    hand.wait(lambda: hand.has('##iteration'))
    note('computing')
    done()
    note('ended')
    hand.wait(lambda: hand.has('play '))
    note('paused')
    hand.type('mesh', 'sample:unicorn')
    hand.click('run')
    hand.wait(lambda: hand.shows('unicorn'))
    note('refused')
    figures['kept'] = hand.find('##iteration').value > 0 and hand.has('play ')

figures = dict(places={{}})
v, f = ism.samples.make('dumbbell', n_vertices=300)
Hand().run(lambda: ism.play(v, f, method='auto', size={size!r}), script)
""")
    places = figures["places"]
    assert len(places["computing"]) > 18
    for state in ("ended", "paused", "refused"):
        assert places[state] == places["computing"], state
    assert max(bottom for _, _, _, bottom in places["ended"].values()) < size[1]
    assert figures["kept"]


@needs_drawing
def test_a_mesh_that_is_refused_can_be_repaired_in_the_window(tmp_path):
    v, f = ism.samples.make("dumbbell", n_vertices=300)
    ism.write_mesh(tmp_path / "open.ply", v, f[1:])
    figures = use(f"""
import os
os.chdir({str(tmp_path)!r})

def script(hand):
    hand.wait(lambda: hand.has('##iteration'))
    hand.type('mesh', 'open.ply')
    hand.click('run')
    hand.wait(lambda: hand.shows('Still shown: the given mesh'))
    for size in ((1280, 760), (640, 480)):
        hand.resize(*size)
        button = hand.find('repair and run')
        figures['cut'] = button.rectangle[3] > button.window[3]
    hand.click('repair and run')
    hand.wait(lambda: not hand.shows('Still shown'))
    hand.wait(lambda: hand.has('##iteration') and not hand.find('stop').enabled)
    figures['shown'] = hand.find('mesh').value
    hand.type('mesh', 'sample:unicorn')
    hand.click('run')
    hand.wait(lambda: hand.shows('unicorn'))
    figures['repairable'] = hand.has('repair and run')
    hand.click('close')
    figures['closed'] = not hand.shows('Still shown')

figures = {{}}
v, f = ism.samples.make('dumbbell', n_vertices=300)
Hand().run(lambda: ism.play(v, f, method='auto'), script)
""")
    assert figures == {"cut": False, "shown": "open.ply", "repairable": False, "closed": True}


@needs_drawing
def test_what_goes_wrong_in_a_window_is_said_there_and_the_window_goes_on():
    figures = use("""
from igl_spheremap.apps.viewer.map_view import MapView

def broken(self, *chosen):
    raise IndexError('planted')

def script(hand):
    hand.resize(500, 300)
    look, MapView.look, hand.strict = MapView.look, broken, False
    hand.slide('lens', 0.9)
    figures['said'] = hand.failures()
    MapView.look = look
    hand.click('close')
    hand.strict = True
    hand.everything(leave=('picture', 'video', 'map', 'balance'))

figures = {}
result = ism.spherical_conformal_map(*ism.samples.make('spheroid', n_vertices=200))
Hand().run(lambda: ism.show(result), script)
""")
    assert "IndexError: planted" in figures["said"][0]


@needs_drawing
def test_keys_choose_colours_and_lens_forget_a_vertex_and_write_a_picture(tmp_path):
    figures = use(f"""
import os
from igl_spheremap.apps.viewer.map_view import MapView
os.chdir({str(tmp_path)!r})

def build():
    views.append(MapView(result.mesh, {{'map': result.sphere}}, result=result))
    return views[0]

def script(hand):
    imgui, view = app.imgui, views[0]
    powers = []
    for number in range(4, 0, -1):
        hand.key(getattr(imgui, f'ImGuiKey_{{number}}'))
        figures['colours'].append(view.subject)
    hand.click_at(390, 180)
    figures['picked'] = hand.shows('vertex ') and view.grid.picked is not None
    for _ in range(3):
        powers.append(view.lens.power)
        hand.key(imgui.ImGuiKey_L)
    figures['powers'] = powers
    hand.drag((390, 180), (440, 200))
    hand.wheel(390, 180, 2)
    turned = view.grid.zoom > 1 and not np.array_equal(view.grid.turn, np.eye(3))
    hand.key(imgui.ImGuiKey_R)
    figures['reset'] = turned and view.grid.zoom == 1 and np.array_equal(view.grid.turn, np.eye(3))
    hand.key(imgui.ImGuiKey_Escape)
    figures['forgotten'] = view.grid.picked is None and not hand.shows('vertex ')
    hand.type('##name', 'lrs', enter=False)  # into a field: no key of the window
    figures['typed'] = view.lens.power
    hand.key(imgui.ImGuiKey_Enter)
    hand.key(imgui.ImGuiKey_S)
    hand.wait(lambda: hand.shows('wrote lrs.png'))

views, figures = [], dict(colours=[])
result = ism.spherical_conformal_map(*ism.samples.make('spheroid', n_vertices=1500))
Hand().run(lambda: app.present(build, size=(700, 360)), script)
""")
    assert figures["colours"] == list(reversed(SUBJECTS))
    assert figures["picked"]
    whole, fit, again = figures["powers"]
    assert whole == again == 1 < fit
    assert figures["reset"]
    assert figures["forgotten"]
    assert figures["typed"] == 1
    assert [path.name for path in tmp_path.iterdir()] == ["lrs.png"]


@needs_drawing
def test_a_file_that_fails_or_is_stopped_leaves_the_window_as_it_was(tmp_path):
    figures = use(f"""
import os
from igl_spheremap.apps.viewer.map_view import MapView
os.chdir({str(tmp_path)!r})

def escape():
    app.imgui.GetIO().AddKeyEvent(app.imgui.ImGuiKey_Escape, True)

def script(hand):
    for name, button in (('missing/a', 'picture'), ('missing/a', 'video'), ('missing/a', 'map')):
        hand.type('##name', name)
        hand.click(button)
        hand.wait(lambda: hand.shows('missing'))
        figures['there'].append(hand.has('picture'))
    MapView.film = lambda self, length: [(escape, False)] * 9
    hand.type('##name', 'a')
    hand.click('video')
    hand.wait(lambda: hand.shows('stopped drawing a.gif'))
    figures['there'].append(hand.has('picture'))

figures = dict(there=[])
result = ism.spherical_conformal_map(*ism.samples.make('spheroid', n_vertices=200))
Hand().run(lambda: ism.show(result), script)
""")
    assert figures["there"] == [True] * 4
    assert not list(tmp_path.iterdir())


@needs_drawing
def test_escape_in_a_menu_closes_it_and_forgets_no_vertex():
    figures = use("""
from igl_spheremap.apps.viewer.map_view import MapView

def script(hand):
    hand.click_at(470, 380)
    for expected in (True, False):
        if expected:
            hand.open('colours')
        hand.key(app.imgui.ImGuiKey_Escape)
        hand.frame(2)
        figures['open'].append(any(w.kind == 'Selectable' for w in hand.widgets))
        figures['picked'].append(hand.shows('vertex '))

figures = dict(open=[], picked=[])
result = ism.spherical_conformal_map(*ism.samples.make('spheroid', n_vertices=200))
Hand().run(lambda: ism.show(result), script)
""")
    assert figures == {"open": [False, False], "picked": [True, False]}
