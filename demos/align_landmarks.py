"""Move landmarks of a brain to given places on the sphere: by a Moebius map, by tents that fold, by a bijection.

    python demos/align_landmarks.py              # a window
    python demos/align_landmarks.py picture.png  # a picture; needs no display

Points have no capacity in the plane: the harmonic energy is lowest where landmarks are pulled out like tents, which
fold (red). Descent along smooth fields that refuses foldings finds a bijection instead.
"""

import sys

import numpy as np

import igl_spheremap as ism
from igl_spheremap.apps.viewer.compare import landmark_part, show_parts
from igl_spheremap.draw.plot import fit, pose

v, f = ism.samples.make("brain", n_vertices=4000)
mesh, turn = ism.check_mesh(v, f), pose(v, "z")
landmarks = np.linspace(0, len(v) - 1, 40).astype(int)
places = ism.spherical_conformal_map(v, f).sphere[landmarks]
targets = places + 0.2 * np.random.default_rng(1).normal(size=places.shape)
targets /= np.linalg.norm(targets, axis=1, keepdims=True)
row = [landmark_part(f"{len(landmarks)} landmarks\n(blue; their targets are yellow)", mesh, fit(v, turn), landmarks)]
for name, weight, injective in (("best Moebius map", 0, True), ("may fold", 100, False), ("may not fold", 100, True)):
    steps = 300 if weight else 0
    result = ism.landmark_map(v, f, landmarks, targets, weight, may_fold=not injective, max_iterations=steps)
    miss = np.degrees(np.linalg.norm(result.sphere[landmarks] - targets, axis=1)).mean()
    caption = f"{name}:\n{miss:.1f} degrees off, {result.certificate.foldings} folded faces"
    row.append(landmark_part(caption, mesh, result.sphere, landmarks, targets, turn))
show_parts([row], *sys.argv[1:2], size=(1400, 460))
