"""
A bijection between two surfaces
================================

Two bodies are matched through their spheres: each point of one has its place on the other, and back, without foldings.
"""

import numpy as np

import igl_spheremap as ism
from igl_spheremap.draw.plot import draw_surfaces

a = ism.samples.make("pear", n_vertices=2000)
v, f = ism.samples.make("pear", n_vertices=1500)
bend = np.column_stack((v[:, 0] + 0.25 * v[:, 2] ** 2, v[:, 1], 1.2 * v[:, 2]))
onto = ism.match(a, (bend, f))
assert onto.map.certificate.folding_free

height = a[0][:, 2]
figure = draw_surfaces(
    ("a pear", *a, height),
    ("the same vertices on a bent one", onto.positions, a[1], height),
    ("the bent one itself", bend, f, None),
)
figure
