"""A map in a polyscope scene of your own: a surface, its sphere, and the map's measures as polyscope's quantities.

    python demos/polyscope_scene.py                           # a window
    python demos/polyscope_scene.py bunny.obj                 # your surface; or sample:bunny
    python demos/polyscope_scene.py sample:bunny picture.png  # a picture; needs no display

Choose another quantity in polyscope's panel: foldings, angle differences, area ratios, or the conformal factor, which
the scene adds itself.
"""

from arguments import run
from scene import begin_scene, end_scene

import igl_spheremap as ism


def polyscope_scene(surface, picture):
    result = ism.spherical_conformal_map(surface)
    begin_scene(picture)
    factor = result.conformal_factor()
    for structure in ism.add_to_polyscope(result, shown="checkerboard"):  # the surface, its sphere
        structure.add_scalar_quantity("conformal factor", factor, enabled=False)
    end_scene(picture)


if __name__ == "__main__":
    run(polyscope_scene, "sample:dino")
