"""A checkerboard of the sphere, carried back to the surface: squares stay squares, for the map is conformal.

    python demos/checkerboard.py                           # a window
    python demos/checkerboard.py bunny.obj                 # your surface; or sample:bunny
    python demos/checkerboard.py sample:bunny picture.png  # a picture; needs no display

In the window, click a vertex to see its image, and drag "lens": a Moebius map magnifies what is there, and every square
stays a square. "balance" gives up squares for equal areas.
"""

import igl_spheremap as ism
from igl_spheremap.apps.demo import run_demo


def checkerboard(v, f, up, target, progress):
    result = ism.spherical_conformal_map(v, f, listener=progress.listener(f))
    progress.close()
    if target:
        ism.screenshot(result, target, up=up, subject="checkerboard")
    else:
        ism.show(result, up=up, subject="checkerboard")


if __name__ == "__main__":  # "balance" computes in a process of its own, which imports this file
    run_demo(checkerboard, "sample:dino")
