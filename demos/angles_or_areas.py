"""Angles or areas? The same checkerboard through maps of balance 0, 1/2 and 1, on a body and on its sphere.

    python demos/angles_or_areas.py                           # a window
    python demos/angles_or_areas.py bunny.obj                 # your surface; or sample:bunny
    python demos/angles_or_areas.py sample:bunny picture.png  # a picture; needs no display

At balance 0 squares stay squares, and most limbs lie within one of them. At 1 each takes the same share of the body's
area as of the sphere's, and is sheared.
"""

import numpy as np

import igl_spheremap as ism
from igl_spheremap.apps.demo import run_demo
from igl_spheremap.apps.viewer.compare import show_parts
from igl_spheremap.apps.viewer.grid import Part
from igl_spheremap.apps.viewer.widgets import Colours
from igl_spheremap.draw.plot import fit, pose


def angles_or_areas(v, f, up, target, progress):
    mesh, turn = ism.check_mesh(v, f), pose(v, up)
    colours = Colours("checkerboard")  # whose poles stay at the tips of the same limbs
    bodies, spheres = [], []
    for balance in (0, 0.5, 1):
        result = ism.balanced_spherical_map(v, f, balance=balance, listener=progress.listener(f))
        board = colours.of(mesh, result.sphere)
        angle, area = (
            np.abs(result.angle_differences()).mean(),
            np.exp(np.abs(result.log_area_ratios()).mean()),
        )
        bodies.append(Part(f"balance {balance}", fit(v, turn), f, board))
        caption = f"angles differ by {angle:.1f} degrees,\nareas by a factor of {area:.3g}"
        spheres.append(
            Part(caption, result.sphere @ turn.T, f, board, image=True, legends=board.legends)
        )
    progress.close()
    show_parts([bodies, spheres], target, size=(1000, 720))


if __name__ == "__main__":
    run_demo(angles_or_areas, "sample:octopus:n_vertices=8000")
