"""One surface by the Gauss map and by every method: foldings in red, angle differences in colours.

    python demos/compare_methods.py                           # a window, where the colours can show other things
    python demos/compare_methods.py bunny.obj                 # your surface; or sample:bunny
    python demos/compare_methods.py sample:bunny picture.png  # a picture; needs no display

Gradient descent with fixed steps ("gu-yau") takes minutes on large meshes, and is left out there.
"""

import igl_spheremap as ism
from igl_spheremap.apps.demo import run_demo
from igl_spheremap.apps.viewer.compare import compare


def compare_methods(v, f, up, target, progress):
    methods = ["gu-yau", "stereographic", "lai2014", "auto"]
    if len(v) > 20_000:
        progress.write(f"gu-yau is left out: on {len(v):,} vertices it takes minutes")
        methods.remove("gu-yau")
    maps = {"Gauss map": ism.gauss_map(v, f)}
    for method in methods:
        progress.begin(method)
        maps[method] = ism.spherical_conformal_map(
            v, f, method=method, listener=progress.listener(f)
        ).sphere
    progress.close()
    compare(ism.check_mesh(v, f), maps, target, up=up)


if __name__ == "__main__":
    run_demo(compare_methods, "sample:dino")
