"""The fast map and its start, on meshes too coarse for the chord energy."""

from __future__ import annotations

import numpy as np

from igl_spheremap.descent.preconditioned import harmonic_map
from igl_spheremap.mesh.check import check_mesh
from igl_spheremap.operators.operators import build_operators
from igl_spheremap.start.punctured import is_coarse, punctured_start
from igl_spheremap.verify.distortion import mean_angle_difference


def test_a_start_that_faces_cut_deep_through_is_kept_where_the_energy_misleads():
    """A square bar, each side but two triangles: the worse its chords, the less energy they have."""
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    v = np.vstack((corners, corners + np.array([0.0, 0.0, 8.0])))
    f = np.array([[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7]]
                 + [face for a, b in ((0, 1), (1, 2), (2, 3), (3, 0)) for face in ([a, b, b + 4], [a, b + 4, a + 4])])
    mesh = check_mesh(v, f)
    operators = build_operators(mesh)
    start = punctured_start(mesh, operators).x
    seen = []
    last = harmonic_map(mesh, operators, listener=lambda iterate: seen.append(iterate.x)).last.x
    assert is_coarse(mesh, last)
    mean = mean_angle_difference(mesh, last)
    assert mean == min(mean_angle_difference(mesh, x) for x in (seen[0], seen[-1]))
    assert np.abs(seen[0] - start).max() < 1e-9
