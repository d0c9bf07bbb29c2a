"""
Certify a map of another program
================================

A certificate needs only the images of the vertices and the faces. It names faults and their places. Here a vertex of a
sound map is moved across its neighbours.
"""

import numpy as np
from side_by_side import draw_surfaces

import igl_spheremap as ism

v, f = ism.samples.make("pear", n_vertices=600)
x = ism.spherical_conformal_map(v, f).sphere.copy()
assert ism.certify(x, f).folding_free

moved = int(np.argmin(x[:, 1]))  # in the middle of the picture
x[moved] += [0, 0, 0.3]
x[moved] /= np.linalg.norm(x[moved])
found = ism.certify(x, f)
print(found)
assert not found.folding_free
assert set(found.flipped) <= set(np.flatnonzero((f == moved).any(axis=1)))

folded = np.array(found.flipped)
figure = draw_surfaces(
    ("the surface", v, f, None, folded),
    (f"{found.foldings} folded faces", x, f, None, folded),
    up="z",
)
figure
