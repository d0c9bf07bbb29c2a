"""A map in a polyscope scene of your own: a surface, its sphere, and the map's measures as polyscope's quantities.

    python demos/polyscope_scene.py                           # a window
    python demos/polyscope_scene.py bunny.obj                 # your surface; or sample:bunny
    python demos/polyscope_scene.py sample:bunny picture.png  # a picture; needs no display

Choose another quantity in polyscope's panel: foldings, angle differences, area ratios, or the conformal factor, which
the scene adds itself.
"""

import polyscope as ps

import igl_spheremap as ism
from igl_spheremap.apps.demo import run_demo


def polyscope_scene(v, f, up, target, progress):
    result = ism.spherical_conformal_map(v, f, listener=progress.listener(f))
    progress.close()
    ps.set_verbosity(0)
    ps.set_allow_headless_backends(target is not None)
    ps.init()
    ps.set_up_dir("z_up")
    surface, sphere = ism.add_to_polyscope(result, "dino", shown="checkerboard")
    for structure in (surface, sphere):
        factor = ism.conformal_factor(v, f, result.sphere)
        structure.add_scalar_quantity("conformal factor", factor, enabled=False)
    ps.reset_camera_to_home_view()
    if target:
        ps.screenshot(target)
    else:
        ps.show()


if __name__ == "__main__":
    run_demo(polyscope_scene, "sample:dino")
