"""
Map a surface to the sphere
===========================

A rabbit, its conformal map, and the same checkerboard on both: a conformal map keeps squares square, at any size. The
map is certified in exact arithmetic: no face is folded, and the sphere is covered once.
"""

import igl
import numpy as np
from side_by_side import draw_surfaces

import igl_spheremap as ism

v, f = ism.samples.make("bunny")  # or ism.read_mesh("bunny.ply")
result = ism.spherical_conformal_map(v, f)
assert result.certificate.folding_free

# %%
# Squares on the sphere, the same number around each of two tips: the logarithm of a chart that has one tip at 0 and the
# other at infinity is conformal, too. One is the tip that the map shrinks most. Faces are divided, so that squares have
# straight sides.

x, factor = result.sphere, result.conformal_factor()
one = int(np.argmin(factor))
other = int(np.argmin(np.where(x @ x[one] < 0, factor, np.inf)))
fine, faces = igl.upsample(np.hstack((v, x)), f, 2)
chart = (x[:, 0] + 1j * x[:, 1]) / (1 - x[:, 2])
middle = fine[faces, 3:].mean(axis=1)
middle /= np.linalg.norm(middle, axis=1)[:, None]
z = (middle[:, 0] + 1j * middle[:, 1]) / (1 - middle[:, 2])
squares = np.log((z - chart[one]) / (z - chart[other])) * 12 / np.pi
odd = (np.floor(squares.real) + np.floor(squares.imag)) % 2
colours = np.where(odd[:, None] > 0, (0.1, 0.3, 0.55), (0.95, 0.93, 0.88))

figure = draw_surfaces(
    (f"{len(v):,} vertices", fine[:, :3], faces, colours),
    ("its map to the sphere", fine[:, 3:], faces, colours),
)
figure
