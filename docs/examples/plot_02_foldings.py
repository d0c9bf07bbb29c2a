"""
Find and repair foldings
========================

The Gauss map sends each vertex to its normal. On a body with limbs it folds: here in red on the surface. Any map of any
program can be certified and repaired in this way.
"""

import numpy as np

import igl_spheremap as ism
from igl_spheremap.draw.palette import FOLDED, SURFACE
from igl_spheremap.draw.plot import draw_surfaces

v, f = ism.samples.make("bunny", n_vertices=5000)
gauss = ism.gauss_map(v, f)
certificate = ism.certify(gauss, f)
print(certificate)

repaired = ism.repair_foldings(v, f, gauss)
print(repaired.certificate)

# %%
# The repair keeps what it can of the map that it was given. The conformal map of this body has smaller angle differences:

for result in (repaired, ism.spherical_conformal_map(v, f)):
    print(f"{np.abs(result.angle_differences()).mean():.1f} degrees on average")

folded = np.tile(SURFACE, (len(f), 1))
folded[certificate.flipped] = FOLDED
figure = draw_surfaces(
    (f"{certificate.foldings:,} faces are folded", v, f, folded),
    ("the Gauss map", gauss, f, folded),
    ("repaired", repaired.sphere, f, None),
)
figure
