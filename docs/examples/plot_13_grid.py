"""
A surface as an image
=====================

Positions, or any data, on a grid of latitudes and longitudes: an image for networks and transforms on the sphere.
"""

import matplotlib.pyplot as plt
import numpy as np

import igl_spheremap as ism

v, f = ism.samples.make("bunny", n_vertices=5000)
result = ism.balanced_spherical_map(v, f, balance=0.75)  # room for the ears
image = ism.shapes.to_grid(result, rows=128)
back = ism.shapes.from_grid(image, result)
size = np.ptp(v, axis=0).max()
print(
    f"read back at the vertices, off by {np.linalg.norm(back - v, axis=1).mean() / size:.2%} of the body's length"
)

figure, ax = plt.subplots(figsize=(6.5, 3.4), layout="constrained")
ax.imshow((image - v.min(axis=0)) / np.ptp(v, axis=0))
ax.set(
    title="x, y, z as red, green, blue",
    xticks=[0, 255],
    xticklabels=["-180°", "180°"],
    yticks=[0, 127],
    yticklabels=["north", "south"],
)
figure
