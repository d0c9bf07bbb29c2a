"""
How conformal is a map?
=======================

Angle differences of every corner, in degrees, and the conformal factor of every vertex, whose logarithm measures the
shrinking of a place.
"""

import matplotlib.pyplot as plt
import numpy as np
from side_by_side import draw_surfaces

import igl_spheremap as ism

v, f = ism.samples.make("bunny", n_vertices=5000)
result = ism.spherical_conformal_map(v, f)
differences = result.angle_differences()
print(f"{np.abs(differences).mean():.2f} degrees on average")

figure, ax = plt.subplots(figsize=(4.5, 3), layout="constrained")
ax.hist(differences.ravel(), bins=100, range=(-20, 20))
ax.set(xlabel="angle difference, degrees", ylabel="corners")
figure

# %%
# Their places, and the most shrunk ones: the tips of the ears.

factor = np.log(result.conformal_factor()) / 2
figure = draw_surfaces(
    ("mean angle difference\nof each face, degrees", v, f, np.abs(differences).mean(axis=1)),
    ("u of the factor e²ᵘ", v, f, factor),
)
figure
