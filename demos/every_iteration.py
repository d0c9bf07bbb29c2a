"""The foldings before and after each iteration: a listener keeps the iterates of your own run, and a window plays them.

    python demos/every_iteration.py                           # a window
    python demos/every_iteration.py bunny.obj                 # your surface; or sample:bunny
    python demos/every_iteration.py sample:bunny picture.png  # a picture of the last change; needs no display

Folded faces are red. Both spheres are seen through one lens, a Moebius map that magnifies the largest cluster of them.
"""

import igl_spheremap as ism
from igl_spheremap.apps.demo import run_demo
from igl_spheremap.apps.viewer.player import play_recording


def every_iteration(v, f, up, target, progress):
    recording, show_progress = ism.Recording(f), progress.listener(f)

    def listener(iterate):  # is called with every iterate; the recording keeps them
        recording(iterate)
        show_progress(iterate)

    result = ism.spherical_conformal_map(v, f, method="lai2014", listener=listener)
    progress.close()
    play_recording(result, recording, target, up=up)


if __name__ == "__main__":
    run_demo(every_iteration, "sample:dino:n_vertices=2000")
