"""Watch foldings vanish: each iteration of the paper's algorithms, before and after it, in polyscope.

    python demos/folding_removal.py                    # a window: play, pause, step, turn, zoom
    python demos/folding_removal.py bunny.obj          # your surface
    python demos/folding_removal.py bunny.obj run.gif  # a video or a picture; needs no display

Algorithm 1 minimises the harmonic energy from the Gauss map, which folds, and may end with foldings. The star map of
Algorithm 2 then removes them, and Algorithm 1 goes on from there. Folded faces are red, and nothing else is. A lens, a
Moebius map, magnifies the largest cluster of them; the small sphere shows where that is.
"""

import sys

import igl_spheremap as ism

if __name__ == "__main__":  # the map is computed in a process of its own, which imports this file
    source, target = [*sys.argv[1:], None, None][:2]
    v, f = ism.read_mesh(source) if source else ism.samples.make("dino", n_vertices=2000)
    ism.play(v, f, "lai2014", target)
