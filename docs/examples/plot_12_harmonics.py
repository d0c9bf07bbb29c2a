"""
Spherical harmonics of a shape
==============================

The map makes a shape a function on the sphere, and its harmonics describe it to any degree.
"""

from side_by_side import draw_surfaces

import igl_spheremap as ism

v, f = ism.samples.make("brain", n_vertices=8000)
result = ism.spherical_conformal_map(v, f)
shape = ism.shapes.spherical_harmonics(result, degree=30)
error = shape.error()

views = [(f"{len(v):,} vertices", v, f, None)]
for degree in (3, 10, 30):
    part = ism.shapes.SphericalHarmonics(shape.coefficients[: (degree + 1) ** 2])
    views.append(
        (f"degree {degree}: {error[degree]:.2f} percent off", part.evaluate(result.sphere), f, None)
    )

figure = draw_surfaces(*views, up="z")
figure
