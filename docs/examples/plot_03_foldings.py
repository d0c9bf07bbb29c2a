"""
Find and repair foldings
========================

The Gauss map sends each vertex to its normal. On a body with limbs it folds: here in red on the surface. Any map of any
program can be certified and repaired in this way.
"""

import numpy as np
from side_by_side import draw_surfaces

import igl_spheremap as ism

v, f = ism.samples.make("bunny", n_vertices=2500)
gauss = ism.gauss_map(v, f)
certificate = ism.certify(gauss, f)
print(certificate)

repaired = ism.repair_foldings(v, f, gauss)
print(repaired.certificate)

# %% The repair keeps as much of the given map as it can. The conformal map of this body has smaller angle differences.

conformal = ism.spherical_conformal_map(v, f)
degrees = [np.abs(result.angle_differences()).mean() for result in (repaired, conformal)]

folded = np.array(certificate.flipped)
figure = draw_surfaces(
    (f"{certificate.foldings:,} faces are folded", v, f, None, folded),
    ("the Gauss map", gauss, f, None, folded),
    (f"repaired: angles off by {degrees[0]:.0f}°", repaired.sphere, f, None),
    (f"the conformal map: by {degrees[1]:.1f}°", conformal.sphere, f, None),
)
figure
