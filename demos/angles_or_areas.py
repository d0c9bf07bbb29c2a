"""Angles or areas? The same checkerboard through maps of balance 0, 1/2 and 1, on a body and on its sphere.

    python demos/angles_or_areas.py                           # a window
    python demos/angles_or_areas.py bunny.obj                 # your surface; or sample:bunny
    python demos/angles_or_areas.py sample:bunny picture.png  # a picture; needs no display

At balance 0 squares stay squares, and most limbs lie within one of them. At 1 each square takes the same share of the
body's area as of the sphere's, and is sheared.
"""

import numpy as np
from arguments import run

import igl_spheremap as ism


def angles_or_areas(surface, picture):
    result = ism.spherical_conformal_map(surface)
    maps = {}
    for balance in (0, 0.5, 1):
        result = result.rebalance(balance)
        maps[f"balance {balance}"] = result.sphere
        angle = np.abs(result.angle_differences()).mean()
        area = np.exp(np.abs(result.log_area_ratios()).mean())
        print(f"balance {balance}: angles differ by {angle:.1f} degrees on average,", end=" ")
        print(f"areas change {area:.3g}-fold (geometric mean over the faces)")
    if picture:
        ism.screenshot(result, picture, subject="checkerboard", maps=maps, size=(1000, 720))
    else:
        ism.show(result, subject="checkerboard", maps=maps)


if __name__ == "__main__":
    run(angles_or_areas, "sample:octopus:n_vertices=8000")
