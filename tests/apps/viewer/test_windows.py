"""Every window under a hand: each widget is used, and nothing raises, prints, or goes wrong in the window."""

from drawing import needs_drawing, use


@needs_drawing
def test_every_widget_of_the_player_can_be_used(tmp_path):
    figures = use(f"""
import os
from igl_spheremap.maps.options import METHODS
os.chdir({str(tmp_path)!r})
app.LENGTH = 3

def script(hand):
    def done():
        hand.wait(lambda: hand.has('##iteration') and not hand.has('stop'))
    done()
    figures['used'] = sorted(hand.everything(leave=('run',), typed={{'max iterations': '100000', '##name': 'saved'}}))
    for size in ((1400, 900), (500, 300), (800, 500)):
        hand.resize(*size)
    hand.type('mesh', 'sample:spheroid:n_vertices=200')
    hand.choose('method', 'lai2014')
    hand.click('run')
    done()
    hand.type('mesh', 'sample:dumbbell:n_vertices=3000')
    hand.click('run')
    hand.wait(lambda: hand.has('stop'))
    hand.click('stop')
    done()
    figures['methods'] = hand.open('method')
    hand.click('lai2014')
    for button in (0, 1):
        hand.drag((600, 250), (650, 300), button)
    hand.wheel(600, 250, 2)
    hand.click('picture')
    hand.click('replace it')
    hand.wait(lambda: hand.shows('wrote saved.png'))

figures = {{}}
v, f = ism.samples.make('dumbbell', n_vertices=300)
Hand().run(lambda: ism.play(v, f, size=(800, 500)), script)
figures['methods_there'] = list(METHODS)
figures['files'] = sorted(os.listdir())
""")
    assert {"mesh", "samples", "method", "parameters", "max iterations", "##iteration", "previous", "next", "stops",
            "lens", "picture", "map", "folded faces"} <= set(figures["used"])
    assert figures["methods"] == figures["methods_there"]
    assert figures["files"] == ["saved.gif", "saved.npz", "saved.png"]


@needs_drawing
def test_what_goes_wrong_in_a_window_is_said_there_and_the_window_goes_on():
    figures = use("""
from igl_spheremap.apps.viewer.result_view import ResultView

def broken(self, centre):
    raise IndexError('planted')

def script(hand):
    hand.click('Moebius map')
    move, ResultView.move, hand.strict = ResultView.move, broken, False
    hand.slide('strength', 0.9)
    figures['said'] = hand.failures()
    ResultView.move = move
    hand.click('close')
    hand.strict = True
    hand.everything(leave=('picture', 'video', 'map', 'balance'))

figures = {}
result = ism.spherical_conformal_map(*ism.samples.make('spheroid', n_vertices=200))
Hand().run(lambda: ism.show(result), script)
""")
    assert "IndexError: planted" in figures["said"][0]
