"""The buttons that save a window's view: a picture, a video and the map, of a result and of a run."""

from drawing import drive, needs_drawing

_PRESS = """
import os
from igl_spheremap.apps.viewer.app import draw_app
from PIL import Image

def press(shown, label, name):
    'Draw the panel with a button held down, and do what the window then has pending.'
    real, app.imgui.Button = app.imgui.Button, lambda text, *size: text == label
    shown._save.name = name
    ps.set_user_callback(lambda: draw_app(shown))
    ps.set_max_fps(-1)  # else polyscope skips ticks that follow each other faster than its frames
    ps.frame_tick()
    app.imgui.Button = real
    job, shown.pending = shown.pending, None
    return job()
"""


@needs_drawing
def test_the_buttons_of_a_result_write_picture_video_and_the_map_that_is_shown(tmp_path):
    figures = drive(
        _PRESS
        + f"""
from igl_spheremap.apps.viewer.map_view import MapView
os.chdir({str(tmp_path)!r})
app.LENGTH = 4
app.open_for(Pictures('unused.png', size=(700, 300)))
v, f = ism.samples.make('spheroid', n_vertices=600)
result = ism.spherical_conformal_map(v, f)
view = MapView(result.mesh, dict(map=result.sphere), result=result)
said = [press(view, 'picture', 'a'), press(view, 'video', 'b'), press(view, 'map', 'c')]
kept = bool((ism.read_map('c.npz').sphere == result.sphere).all())
said.append(press(view, 'map', 'again.obj'))
again, faces = ism.read_mesh('again.obj')
picture = np.asarray(Image.open('a.png').convert('RGB'))
video = Image.open('b.gif')
figures = dict(said=said, kept=kept, again=bool((again == result.sphere).all()),
            drawn=drawn(picture), frames=video.n_frames, panel=drawn(picture[:, :100]))
"""
    )
    assert [words.split(",")[0].split(":")[0] for words in figures["said"]] == [
        "wrote a.png",
        "wrote b.gif",
        "wrote c.npz",
        "wrote again.obj",
    ]
    assert all("folding-free" in words for words in figures["said"][2:])
    assert figures["kept"]
    assert figures["again"]
    assert figures["frames"] == 4
    assert figures["drawn"] > 0.1


@needs_drawing
def test_the_buttons_of_a_run_write_it_as_a_video_and_its_map_once_there_is_one(tmp_path):
    figures = drive(
        _PRESS
        + f"""
from functools import partial
from igl_spheremap.apps.viewer.player import Player, in_background
from igl_spheremap.maps.options import METHODS
from igl_spheremap.samples import from_spec
os.chdir({str(tmp_path)!r})
app.LENGTH = 5
if __name__ == '__main__':
    app.open_for(Pictures('unused.png', size=(1100, 400)))
    start = partial(in_background, from_spec, 400_000_000)
    shown = Player(start, 'spheroid:n_vertices=400', METHODS['lai2014']())
    shown.prepare()
    shown.go_to(shown.last_frame())
    said = [press(shown, 'video', 'run'), press(shown, 'map', 'run')]
    result, shown.run.result = shown.run.result, None
    said.append(press(shown, 'map', 'none'))
    figures = dict(said=said, frames=Image.open('run.gif').n_frames, none=os.path.exists('none.npz'),
                kept=bool((ism.read_map('run.npz').sphere == result.sphere).all()))
    shown.close()
"""
    )
    assert figures["said"][0].startswith("wrote run.gif")
    assert "folding-free" in figures["said"][1]
    assert figures["said"][2] == "there is no result yet"
    assert not figures["none"]
    assert figures["kept"]
    assert figures["frames"] > 1
