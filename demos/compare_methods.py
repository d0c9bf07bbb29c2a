"""One surface by the Gauss map and by every method: foldings in red, angle differences in colours.

    python demos/compare_methods.py                           # a window, where the colours can show other things
    python demos/compare_methods.py bunny.obj                 # your surface; or sample:bunny
    python demos/compare_methods.py sample:bunny picture.png  # a picture; needs no display

Gradient descent with fixed steps ("gu-yau") takes minutes on large meshes, and is left out there.
"""

import time

from arguments import run

import igl_spheremap as ism


def compare_methods(surface, picture):
    v, f = ism.read_mesh(surface)
    methods = ["gu-yau", "stereographic", "lai2014", "auto"]
    if len(v) > 20_000:
        methods.remove("gu-yau")
    maps = {"Gauss map": ism.gauss_map(v, f)}
    for method in methods:
        began = time.process_time()
        result = ism.spherical_conformal_map(v, f, method=method)
        seconds = time.process_time() - began
        maps[f"{method}\niterations: {result.iterations:,}, CPU: {seconds:.2f} s"] = result.sphere
        print(f"{method}: {result.certificate}")
    if picture:
        ism.screenshot(result, picture, subject="angle differences", maps=maps)
    else:
        ism.show(result, subject="angle differences", maps=maps)


if __name__ == "__main__":
    run(compare_methods, "sample:dino")
