"""A checkerboard of the sphere, carried back to the surface: squares stay squares: the map is conformal.

    python demos/checkerboard.py                           # a window
    python demos/checkerboard.py bunny.obj                 # your surface; or sample:bunny
    python demos/checkerboard.py sample:bunny picture.png  # a picture; needs no display

In the window, click a vertex to see its image, and drag "lens": a Moebius map magnifies the place, and every square
stays a square. "balance" gives up squares for equal areas.
"""

from arguments import run

import igl_spheremap as ism


def checkerboard(surface, picture):
    result = ism.spherical_conformal_map(surface)
    if picture:
        ism.screenshot(result, picture, subject="checkerboard")
    else:
        ism.show(result, subject="checkerboard")


if __name__ == "__main__":  # "balance" computes in a process of its own, which imports this file
    run(checkerboard, "sample:dino")
