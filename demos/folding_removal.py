"""Watch foldings vanish: each iteration of the paper's algorithms, before and after it, in polyscope.

    python demos/folding_removal.py                           # a window: play, pause, step, turn, zoom
    python demos/folding_removal.py bunny.obj                 # your surface; or sample:bunny
    python demos/folding_removal.py sample:bunny picture.png  # a picture, or a video run.gif; needs no display

Algorithm 1 minimises the harmonic energy from the Gauss map, which folds, and may end with foldings. The star map of
Algorithm 2 then removes them, and Algorithm 1 goes on from there. Folded faces are red, and nothing else is. A lens, a
Moebius map, magnifies the largest cluster of them; the small sphere shows where that is.
"""

from arguments import run

import igl_spheremap as ism


def folding_removal(surface, picture):
    ism.play(surface, method="lai2014", out=picture)


if __name__ == "__main__":  # the map is computed in a process of its own, which imports this file
    run(folding_removal, "sample:dino:n_vertices=2000")
