"""
A group and its modes
=====================

Four pears of different bend and width, each on a mesh of its own, have a mean and modes: none of them is the
reference.
"""

import numpy as np
from side_by_side import draw_surfaces

import igl_spheremap as ism

rng = np.random.default_rng(0)
sources = []
for k in range(4):
    v, f = ism.samples.make("pear", n_vertices=300 + 20 * k)
    v = v * [1.2, 0.9, 1]
    bend, width = rng.normal(size=2)
    v[:, 0] += 0.1 * bend * v[:, 2] ** 2
    v[:, :2] *= 1 + 0.1 * width * np.exp(-(v[:, 2:] ** 2))
    sources.append((v, f))

group = ism.shapes.template(sources, target="ico:3", modes=2)
print(group)

# %%
# The first two modes from -2 to +2 standard deviations; colours show each point's movement.

views = []
for k, mode in enumerate(group.modes):
    moves = np.linalg.norm(mode, axis=1)
    for side in (-2, 2):
        scores = np.append(np.zeros(k), side * np.sqrt(group.variances[k]))
        views.append((f"mode {k + 1}: {side:+d} sd", group.shape(scores), group.faces, moves))

figure = draw_surfaces(*views, up="z")
figure
