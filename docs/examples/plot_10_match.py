"""
A bijection between two surfaces
================================

A dinosaur and a rabbit are matched through their spheres: each point of one has its place on the other, and back,
without foldings. Without landmarks the shapes alone decide what lies where.
"""

import numpy as np

import igl_spheremap as ism
from igl_spheremap.draw.plot import draw_surfaces, fit

a, b = (ism.samples.make(name, n_vertices=2000) for name in ("dino", "bunny"))
onto = ism.match(a, b)
assert onto.map.certificate.folding_free

# %%
# The common refinement of both meshes has positions on both surfaces, and half of the way. Colours go along the
# dinosaur, from the tip of its tail to its head.

common = onto.overlay()
on_a, on_b = (fit(one, np.eye(3)) for one in (common.on_a, common.on_b))
along = on_a[:, 0]
figure = draw_surfaces(
    ("a dinosaur", on_a, common.faces, along),
    ("half of the way", (on_a + on_b) / 2, common.faces, along),
    ("a rabbit", on_b, common.faces, along),
    up="z",
)
figure
