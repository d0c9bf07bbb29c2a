"""
Carry data from one mesh to another
===================================

Two meshes of the same surface, with other vertices: data go through the sphere, exactly located there. "adaptive-area"
keeps integrals to rounding.
"""

import numpy as np
from side_by_side import draw_surfaces

import igl_spheremap as ism

fine = ism.spherical_conformal_map(*ism.samples.make("brain", n_vertices=8000))
x, faces = ism.samples.sphere(642)  # a regular mesh of the sphere
depth = np.linalg.norm(fine.vertices - fine.vertices.mean(axis=0), axis=1)

weights = ism.transfer_matrix(fine, (x, faces), method="adaptive-area")
carried = weights.matrix @ depth
before, after = weights.source_areas @ depth, weights.received @ carried
print(f"integrals differ by {abs(after / before - 1):.1e}")
assert abs(after / before - 1) < 1e-12

figure = draw_surfaces(
    (
        f"{len(fine.vertices):,} vertices,\ndistance from the middle",
        fine.vertices,
        fine.faces,
        depth,
    ),
    (f"the same, carried to\n{len(x):,} vertices", weights.matrix @ fine.vertices, faces, carried),
    up="z",
)
figure
