"""
A bijection between two surfaces
================================

A dinosaur and a rabbit are matched through their spheres: each point of one has its place on the other, and back,
without foldings. Without landmarks the shapes alone decide the correspondence.
"""

import numpy as np
from side_by_side import draw_surfaces

import igl_spheremap as ism

a, b = (ism.samples.make(name, n_vertices=1200) for name in ("dino", "bunny"))
onto = ism.shapes.match(a, b)
assert onto.map.certificate.folding_free

# %%
# The common refinement of both meshes has positions on both surfaces, and between them. Colours go along the dinosaur,
# from the tip of its tail to its head.

common = onto.overlay()
on_source, on_target = (
    (one - one.mean(axis=0)) / np.ptp(one, axis=0).max()
    for one in (common.on_source, common.on_target)
)
along = on_source[:, 0]
figure = draw_surfaces(
    ("a dinosaur", on_source, common.faces, along),
    ("half of the way", (on_source + on_target) / 2, common.faces, along),
    ("a rabbit", on_target, common.faces, along),
    up="z",
)
figure
