"""Two surfaces and the way between them, in colours that a map carries."""

import pytest
from drawing import drive, needs_drawing

pytestmark = needs_drawing

_VIEW = """
from igl_spheremap.apps.viewer.carried_view import CarriedView
from igl_spheremap.draw.palette import LINES
from igl_spheremap.resampling.locate import Location
app.open_for(Pictures('unused.png', size=(1200, 500)))
a, b = (ism.balanced_spherical_map(*ism.samples.make(name, n_vertices=400), balance=1) for name in ('pear', 'dumbbell'))
front = np.argsort(-a.vertices[:, 1])[[40]]
onto = ism.shapes.SurfaceMap(a, b, front, Location(np.array([0]), np.eye(3)[:1]))
view = CarriedView(onto)
ps.set_user_callback(lambda: app.draw_app(view))
"""


def test_the_way_leads_from_a_to_b_and_back():
    figures = drive(
        _VIEW
        + """
ways = []
for show, _ in view.film(8):
    show()
    ways.append(view.way)
view.show_way(0.0)
start = float(np.abs(view.grid.parts[0, 1].x - view.ends[0]).max())
view.show_way(1.0)
figures = dict(ways=ways, start=start, end=float(np.abs(view.grid.parts[0, 1].x - view.ends[1]).max()),
               captions=[part.caption for part in view.grid.parts.values()], faces=len(onto.overlay().faces))
"""
    )
    assert figures["ways"][0] == 0
    assert max(figures["ways"]) == 1
    assert figures["ways"][1:] == pytest.approx(figures["ways"][:0:-1])
    assert figures["start"] == figures["end"] == 0
    assert figures["captions"][1] == f"100% of the way\n{figures['faces']:,} faces"
    assert "(4: isometry)" in figures["captions"][0]


def test_every_subject_is_drawn_and_landmarks_are_seen_on_all_three():
    figures = drive(
        _VIEW
        + """
shots, dots = [], []
for frame in range(view.frames()):
    view.go_to(frame)
    image = window.grab()
    shots.append(drawn(image))
    dots.append([sorted(body.points) for body in view.grid.bodies.values()])
figures = dict(shots=shots, dots=dots)
"""
    )
    assert min(figures["shots"]) > 0.1
    assert all(labels == ["landmark 0"] for frame in figures["dots"] for labels in frame)


def test_a_vertex_of_the_overlay_that_is_clicked_is_marked_on_all_three():
    figures = drive(
        _VIEW
        + """
window.grab()
body = view.grid.bodies[0, 2]
front = int(np.argmax((body.x @ view.grid.turn.T)[:, 2]))
view.pick(view.grid.vertex_at(view.grid.pixels(view.grid.frame((0, 2)), body.x[front])))
image = window.grab().astype(int)
magenta = (image[..., 0] > 180) & (image[..., 1] < 90) & (image[..., 2] > 100)
rings = [bool(part.any()) for part in np.array_split(magenta[:, view.grid.panel :], 3, axis=1)]
figures = dict(picked=view.grid.picked, front=front, rings=rings)
"""
    )
    assert figures["picked"] == figures["front"]
    assert figures["rings"] == [True, True, True]
