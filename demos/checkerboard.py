"""A checkerboard of the sphere, carried back to the surface: squares stay squares, for the map is conformal.

    python demos/checkerboard.py                        # a window
    python demos/checkerboard.py bunny.obj              # your surface
    python demos/checkerboard.py bunny.obj picture.png  # a picture; needs no display

In the window, "Moebius map" shows a handle: what is under it grows, and every square stays a square. Click a vertex to
see its image. "balance" gives up squares for equal areas.
"""

import sys

import igl_spheremap as ism

source, target = [*sys.argv[1:], None, None][:2]
v, f = ism.read_mesh(source) if source else ism.samples.make("dino")
result = ism.spherical_conformal_map(v, f)
if target:
    ism.screenshot(result, target, subject="checkerboard")
else:
    ism.show(result, subject="checkerboard")
