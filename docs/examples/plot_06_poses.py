"""
One surface in many poses
=========================

A mapper checks a mesh and orders its matrices once, and maps every pose of it. The same place of the body then lies at
nearly the same place of the sphere.
"""

import time

import numpy as np
from side_by_side import draw_surfaces

import igl_spheremap as ism

v, f = ism.samples.make("bunny", n_vertices=4000)
mapper = ism.SphereMapper(v, f)
views, seconds = [], []
for bend in (0.0, 0.4, 0.8):
    turned = bend * np.maximum(v[:, 2] - 2, 0)  # the ears and the head nod forwards
    pose = v + np.column_stack((turned, np.zeros(len(v)), -turned / 2))
    start = time.process_time()
    mapper.move(pose)
    result = mapper.map()
    seconds.append(time.process_time() - start)
    assert result.certificate.folding_free
    views.append((f"bend {bend}, coloured by\nx on the sphere", pose, f, result.sphere[:, 0]))
print("seconds of each pose: " + ", ".join(f"{one:.2f}" for one in seconds))

figure = draw_surfaces(*views, up="z")
figure
