"""One surface by the Gauss map and by every method: foldings in red, angle differences in colours and as histograms.

    python demos/compare_methods.py                        # a window, where the colours can show other things
    python demos/compare_methods.py bunny.obj              # your surface
    python demos/compare_methods.py bunny.obj picture.png  # a picture; needs no display
"""

import sys

import igl_spheremap as ism
from igl_spheremap.apps.viewer.compare import compare

source, target = [*sys.argv[1:], None, None][:2]
v, f = ism.read_mesh(source) if source else ism.samples.make("dino")
mesh = ism.check_mesh(v, f)
maps = {"Gauss map": ism.gauss_map(v, f)}
for method in ("gu-yau", "stereographic", "lai2014", "auto"):
    maps[method] = ism.spherical_conformal_map(v, f, method).sphere
compare(mesh, maps, target)
