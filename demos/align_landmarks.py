"""Move landmarks of a brain to given places on the sphere: by a Moebius map, by tents that fold, by a bijection.

    python demos/align_landmarks.py                           # a window
    python demos/align_landmarks.py bunny.obj                 # your surface; or sample:bunny
    python demos/align_landmarks.py sample:bunny picture.png  # a picture; needs no display

Points have no capacity in the plane: the harmonic energy is lowest where landmarks are pulled out like tents, which
fold (red). Descent along smooth fields that refuses foldings finds a bijection instead.
"""

import numpy as np

import igl_spheremap as ism
from igl_spheremap.apps.demo import run_demo
from igl_spheremap.apps.viewer.compare import landmark_part, show_parts
from igl_spheremap.draw.plot import fit, pose


def align_landmarks(v, f, up, target, progress):
    mesh, turn = ism.check_mesh(v, f), pose(v, up)
    landmarks = np.linspace(0, len(v) - 1, 40).astype(int)
    places = ism.spherical_conformal_map(v, f).sphere[landmarks]
    goals = places + 0.2 * np.random.default_rng(1).normal(size=places.shape)
    goals /= np.linalg.norm(goals, axis=1, keepdims=True)
    caption = f"{len(landmarks)} landmarks\n(blue; targets yellow, folded faces red)"
    row = [landmark_part(caption, mesh, fit(v, turn), landmarks)]
    for name, weight, may_fold in (
        ("Moebius map", 0, False),
        ("may fold", 100, True),
        ("may not fold", 100, False),
    ):
        steps = 300 if weight else 0
        result = ism.landmark_map(
            v,
            f,
            landmarks,
            goals,
            landmark_weights=weight,
            may_fold=may_fold,
            max_iterations=steps,
            listener=progress.listener(f),
        )
        miss = np.degrees(np.linalg.norm(result.sphere[landmarks] - goals, axis=1)).mean()
        caption = f"{name}:\n{miss:.1f} degrees off, {result.certificate.foldings} folded faces"
        row.append(landmark_part(caption, mesh, result.sphere, landmarks, goals, turn))
    progress.close()
    show_parts([row], target, size=(1280, 430))


if __name__ == "__main__":
    run_demo(align_landmarks, "sample:brain:n_vertices=4000")
