"""Move landmarks of a brain to given places on the sphere: by a Moebius map, by tents that fold, by a bijection.

    python demos/align_landmarks.py                           # a window
    python demos/align_landmarks.py bunny.obj                 # your surface; or sample:bunny
    python demos/align_landmarks.py sample:bunny picture.png  # a picture; needs no display

Points have no capacity in the plane: the harmonic energy is lowest where landmarks are pulled out like tents, which
fold (red). The repaired map is a bijection, whose landmarks lie a little farther from their targets. A line leads from
each landmark (blue) to its target (yellow).
"""

import numpy as np
import polyscope as ps
from arguments import run
from scene import begin_scene, end_scene

import igl_spheremap as ism

MAPS = ("Moebius map", 0, False), ("may fold", 300, True), ("may not fold", 300, False)
GREY, RED = (0.8, 0.8, 0.8), (0.7, 0.02, 0.0)
BLUE, YELLOW, INK = (0.0, 0.45, 0.7), (0.94, 0.89, 0.26), (0.1, 0.1, 0.1)


def align_landmarks(surface, picture):
    v, f = ism.read_mesh(surface)
    x = ism.spherical_conformal_map(v, f).sphere
    landmarks = np.linspace(0, len(v) - 1, 40).astype(int)
    goals = x[landmarks] + 0.2 * np.random.default_rng(1).normal(size=(40, 3))
    goals /= np.linalg.norm(goals, axis=1, keepdims=True)
    begin_scene(picture)
    for k, (name, steps, may_fold) in enumerate(MAPS):
        result = ism.landmark_map(v, f, landmarks, goals, may_fold=may_fold, max_iterations=steps)
        at = result.sphere[landmarks]
        miss = np.degrees(np.linalg.norm(at - goals, axis=1)).mean()
        print(f"{name}: {miss:.1f} degrees off, {result.certificate.foldings} folded faces")
        colours = np.tile(GREY, (len(f), 1))
        colours[list(result.certificate.flipped)] = RED
        sphere = ps.register_surface_mesh(name, result.sphere, f)
        sphere.add_color_quantity("folded", colours, "faces", enabled=True)
        dots = (
            ps.register_point_cloud(f"{name}: targets", goals, color=YELLOW),
            ps.register_point_cloud(f"{name}: landmarks", at, color=BLUE),
        )
        lines = np.column_stack((np.arange(40), np.arange(40, 80)))
        ways = ps.register_curve_network(
            f"{name}: ways", 1.01 * np.vstack((at, goals)), lines, color=INK
        )
        ways.set_radius(0.01, relative=False)
        for part in dots:
            part.set_radius(0.03, relative=False)
        for part in (sphere, ways, *dots):
            part.set_position((2.2 * k, 0, 0))
    end_scene(picture)


if __name__ == "__main__":
    run(align_landmarks, "sample:brain:n_vertices=4000")
