"""
How conformal is a map?
=======================

Angle differences of every corner, in degrees, and the conformal factor of every vertex, whose logarithm says how much a
place was shrunk.
"""

import numpy as np
from side_by_side import draw_surfaces

import igl_spheremap as ism
from igl_spheremap.draw.plot import new_figure, plot_angles

v, f = ism.samples.make("bunny", n_vertices=5000)
result = ism.spherical_conformal_map(v, f)
differences = result.angle_differences()
print(f"{np.abs(differences).mean():.2f} degrees on average")

figure, ((ax,),) = new_figure(1, 1, "", (4.5, 3))
plot_angles(ax, differences)
figure

# %%
# Where they are, and where the map shrinks most: the tips of the ears.

factor = np.log(result.conformal_factor()) / 2
figure = draw_surfaces(
    ("mean angle difference\nof each face, degrees", v, f, np.abs(differences).mean(axis=1)),
    ("u of the factor e²ᵘ", v, f, factor),
)
figure
