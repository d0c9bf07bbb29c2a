"""
Angles or areas?
================

A conformal map shrinks limbs. A balance between 0 and 1 gives up angles for areas: at 1 each face has its share of the
sphere. None of these maps has foldings. Colours show the height of the surface: each place keeps its own.
"""

import numpy as np
from side_by_side import draw_surfaces

import igl_spheremap as ism

v, f = ism.samples.make("octopus", n_vertices=3000, arm_length=1)
views = [("the surface, coloured by height", v, f, v[:, 2])]
for balance in (0, 0.5, 1):
    result = ism.balanced_spherical_map(v, f, balance=balance)
    assert result.certificate.folding_free
    angle, area = (
        np.abs(result.angle_differences()).mean(),
        np.exp(np.abs(result.log_area_ratios()).mean()),
    )
    caption = f"balance {balance}: angles off by {angle:.1f}°,\nareas by a factor of {area:.3g}"
    views.append((caption, result.sphere, f, v[:, 2]))

figure = draw_surfaces(*views)
figure
