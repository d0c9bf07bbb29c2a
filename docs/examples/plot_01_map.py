"""
Map a surface to the sphere
===========================

A rabbit, its conformal map, and the same checkerboard on both: a conformal map keeps squares square, at any size. The
map is certified in exact arithmetic: no face is folded, and the sphere is covered once.
"""

import numpy as np

import igl_spheremap as ism
from igl_spheremap.draw.palette import CHECKS
from igl_spheremap.draw.plot import draw_surfaces

v, f = ism.samples.make("bunny")  # or ism.read_mesh("bunny.ply")
result = ism.spherical_conformal_map(v, f)
assert result.certificate.folding_free

# %%
# Squares of the sphere by longitude and Mercator latitude, carried to the surface face by face.

x = result.sphere
middle = x[f].sum(axis=1)
middle /= np.linalg.norm(middle, axis=1)[:, None]
longitude, latitude = np.arctan2(middle[:, 1], middle[:, 0]), np.arctanh(middle[:, 2])
odd = np.floor(np.column_stack((longitude, latitude)) * 12 / np.pi).sum(axis=1) % 2
colours = np.array(CHECKS)[odd.astype(int)]

figure = draw_surfaces((f"{len(v):,} vertices", v, f, colours), ("its map to the sphere", x, f, colours))
figure
