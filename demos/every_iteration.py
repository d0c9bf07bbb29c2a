"""The foldings before and after each iteration, with a listener and a slider in a polyscope program of your own.

    python demos/every_iteration.py              # a window
    python demos/every_iteration.py picture.png  # a picture; needs no display
"""

import sys

import numpy as np
import polyscope as ps
import polyscope.imgui as psim

import igl_spheremap as ism

v, f = ism.samples.make("dino", n_vertices=2000)
run = ism.Recording(f)  # a listener that keeps every iterate
ism.spherical_conformal_map(v, f, "lai2014", listener=run)
k = 20


def show():
    for side, frame in enumerate(run.frames[k : k + 2]):  # folded faces in red, before on the left, after on the right
        name, x = ("before", "after")[side], np.add(frame.iterate.x, [2.2 * side, 0, 0])
        colours = np.where(np.isin(np.arange(len(f)), frame.folded)[:, None], [0.8, 0.05, 0], [0.8, 0.85, 0.9])
        ps.register_surface_mesh(name, x, f).add_color_quantity("foldings", colours, defined_on="faces", enabled=True)


def panel():
    global k
    changed, k = psim.SliderInt("iteration", k, 0, len(run.frames) - 2)
    psim.TextUnformatted(f"{run.frames[k].foldings} folded faces before, {run.frames[k + 1].foldings} after")
    if changed:
        show()


ps.set_verbosity(0)  # without a display it tries one before it draws by EGL, and says so
ps.set_allow_headless_backends(True)
ps.init()
ps.set_ground_plane_mode("none")
show()
ps.look_at((0.75, 0.5, 5.2), (0.75, 0, 0))  # right of polyscope's own panel
ps.set_user_callback(panel)
ps.screenshot(sys.argv[1], include_UI=True) if sys.argv[1:] else ps.show()
