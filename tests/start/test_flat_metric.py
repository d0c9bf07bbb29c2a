"""Flat metrics: triangles that may break, the convex energy's derivatives, and the layout."""

import numpy as np
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap.mesh.measure import angle_defects
from igl_spheremap.operators.laplacian import mollified_edge_lengths
from igl_spheremap.start.flat_metric import angle_laplacian, edge_log_scale, flat_metric, lay_out, triangle_angles

X, F = icosphere(3)
V = X * [1, 1.3, 2]


def test_angles_are_those_of_triangles_and_go_on_where_they_break():
    angles = np.degrees(triangle_angles(np.log([[3.0, 4, 5], [1e-30, 1e-30, 1e-30], [5, 1, 1], [1, 1, 2]])))
    assert np.allclose(angles[0], np.degrees([np.arcsin(0.6), np.arcsin(0.8), np.pi / 2]))
    assert np.allclose(angles[1], 60)
    assert np.allclose(angles[2:], [[180, 0, 0], [0, 0, 180]], atol=1e-5)


def test_the_laplacian_is_the_derivative_of_the_defects():
    """Springborn, Schroeder, Pinkall: the Hessian of the convex energy."""
    n, log_l = len(V), np.log(mollified_edge_lengths(V, F))
    rng = np.random.default_rng(0)
    u, d = 0.1 * rng.normal(size=n), rng.normal(size=n)
    h = 1e-6
    plus, minus = (angle_defects(triangle_angles(log_l + edge_log_scale(u + s * d, F)), F, n) for s in (h, -h))
    exact = angle_laplacian(triangle_angles(log_l + edge_log_scale(u, F)), F, n) @ d
    assert np.allclose((plus - minus) / (2 * h), exact, atol=1e-6 * np.abs(exact).max())


def test_a_flat_metric_is_flat_and_is_laid_out_isometrically():
    mesh = ism.check_mesh(V, F)
    flat = flat_metric(mesh, 100, X)
    assert not len(flat.broken)
    z = lay_out(flat)
    inner = np.setdiff1d(np.arange(len(V)), F[(F == 100).any(axis=1)])
    assert np.abs(angle_defects(flat.angles, flat.faces, len(V))[inner]).max() < 1e-8
    sides = np.column_stack(
        [np.abs(z[flat.faces[:, (k + 1) % 3]] - z[flat.faces[:, (k + 2) % 3]]) for k in range(3)]
    )
    ratio = sides / np.exp(flat.log_lengths)
    assert np.allclose(ratio, ratio[0, 0], rtol=1e-6)
    corners = z[flat.faces]
    areas = ((corners[:, 1] - corners[:, 0]).conj() * (corners[:, 2] - corners[:, 0])).imag
    assert (areas > 0).all()  # orientation is kept
