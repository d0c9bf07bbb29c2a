"""The foldings before and after each iteration: a listener keeps the iterates of your own run, polyscope shows them.

    python demos/every_iteration.py                           # a window with a slider
    python demos/every_iteration.py bunny.obj                 # your surface; or sample:bunny
    python demos/every_iteration.py sample:bunny picture.png  # a picture of the last change; needs no display

Above is the iterate before a step, below the one after it. Folded faces are red on the surface and on its sphere, where
limbs are tiny: zoom in, or see folding_removal.py, which has a lens.
"""

import numpy as np
import polyscope as ps
from arguments import run
from polyscope import imgui
from scene import begin_scene, end_scene

import igl_spheremap as ism

PLACES = "", ", on the sphere"
GREY, RED = (0.8, 0.8, 0.8), (0.7, 0.02, 0.0)


def every_iteration(surface, picture):
    v, f = ism.read_mesh(surface)
    recording = ism.Recording(f)  # is called with every iterate, and keeps them
    ism.spherical_conformal_map(v, f, method="lai2014", listener=recording)
    frames = recording.frames
    size = np.ptp(v, axis=0).max()

    def show(k):
        for row, name in enumerate(("before", "after")):
            frame = frames[k + row]
            colours = np.tile(GREY, (len(f), 1))
            colours[frame.folded] = RED
            for column, x in enumerate((v, size / 2 * frame.iterate.x)):
                part = ps.register_surface_mesh(f"{name}{PLACES[column]}", x, f)
                part.set_position(1.1 * size * np.array([column, 0, -row]))
                part.add_color_quantity("folded", colours, "faces", enabled=True)

    def slider():
        nonlocal at
        moved, at = imgui.SliderInt("iterate", at, 0, len(frames) - 2)
        if moved:
            show(at)

    begin_scene(picture)
    changes = np.flatnonzero(np.diff([frame.foldings for frame in frames]))
    at = int(max(changes, default=0))
    show(at)
    ps.set_user_callback(slider)
    end_scene(picture)


if __name__ == "__main__":
    run(every_iteration, "sample:dino:n_vertices=2000")
