"""Flat metrics: triangles that may break, the convex energy's derivatives, the layout, and the map to the sphere."""

import numpy as np
import pytest
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap.errors import MapError
from igl_spheremap.mesh.measure import angle_defects
from igl_spheremap.operators.laplacian import mollified_edge_lengths
from igl_spheremap.sphere.moebius import best_rotation, center, fix_gauge
from igl_spheremap.sphere.rows import unit_rows

flat_metrics = pytest.importorskip(
    "benchmarks.flat_metric", reason="the benchmarks are not installed"
)
angle_laplacian, edge_log_scale = flat_metrics.angle_laplacian, flat_metrics.edge_log_scale
triangle_angles = flat_metrics.triangle_angles

X, F = icosphere(3)
V = X * [1, 1.3, 2]


def through(v, f, face=0):
    mesh = ism.check_mesh(v, f)
    return fix_gauge(mesh, flat_metrics.through_flat_metric(mesh, face))


def test_angles_are_those_of_triangles_and_go_on_where_they_break():
    angles = np.degrees(
        triangle_angles(np.log([[3.0, 4, 5], [1e-30, 1e-30, 1e-30], [5, 1, 1], [1, 1, 2]]))
    )
    assert np.allclose(angles[0], np.degrees([np.arcsin(0.6), np.arcsin(0.8), np.pi / 2]))
    assert np.allclose(angles[1], 60)
    assert np.allclose(angles[2:], [[180, 0, 0], [0, 0, 180]], atol=1e-5)


def test_the_laplacian_is_the_derivative_of_the_defects():
    """Springborn, Schroeder, Pinkall: the Hessian of the convex energy."""
    n, log_l = len(V), np.log(mollified_edge_lengths(V, F))
    rng = np.random.default_rng(0)
    u, d = 0.1 * rng.normal(size=n), rng.normal(size=n)
    h = 1e-6
    plus, minus = (
        angle_defects(triangle_angles(log_l + edge_log_scale(u + s * d, F)), F, n) for s in (h, -h)
    )
    exact = angle_laplacian(triangle_angles(log_l + edge_log_scale(u, F)), F, n) @ d
    assert np.allclose((plus - minus) / (2 * h), exact, atol=1e-6 * np.abs(exact).max())


def test_a_flat_metric_is_flat_and_is_laid_out_isometrically():
    mesh = ism.check_mesh(V, F)
    flat = flat_metrics.flat_metric(mesh, 100, X)
    assert not len(flat.broken)
    z = flat_metrics.lay_out(flat)
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


def test_the_sphere_is_mapped_to_itself_by_conformal_equivalence():
    """Meshes inscribed in the sphere are equivalent to themselves: exact at any resolution."""
    x = unit_rows(X + 0.015 * np.random.default_rng(3).normal(size=X.shape))
    assert ism.certify(x, F).folding_free
    sphere = through(x, F)
    centred = center(x, ism.check_mesh(x, F).A)
    assert (
        np.abs(ism.angle_differences(x, F, sphere)).max()
        < np.abs(ism.angle_differences(x, F, centred)).max() + 1e-5
    )
    assert np.allclose(cross_ratios(sphere), cross_ratios(x), rtol=1e-6)


def cross_ratios(x):
    """Length cross-ratios of all inner edges: the invariants of discrete conformal equivalence."""
    far = {}
    for a, b, c in F.tolist():
        far[a, b], far[b, c], far[c, a] = c, a, b
    edges = np.array([(i, j, far[i, j], far[j, i]) for i, j in far if i < j])
    i, j, k, m = edges.T

    def d(p, q):
        return np.linalg.norm(x[p] - x[q], axis=1)

    return d(i, k) * d(j, m) / (d(j, k) * d(i, m))


def test_conformal_equivalence_keeps_all_length_cross_ratios():
    """Through flattening, layout, projection and gauge, from any puncture."""
    for face in (0, 100):
        assert np.allclose(
            np.log(cross_ratios(through(V, F, face))), np.log(cross_ratios(V)), atol=1e-6
        )


def test_conformal_equivalence_does_not_depend_on_the_puncture():
    a, b = (through(V, F, face) for face in (0, 500))
    assert np.abs(a - b).max() < 1e-6


def test_conformal_equivalence_converges_to_the_exact_map_of_a_spheroid():
    errors = []
    for level in (2, 3, 4):
        x, f = icosphere(level)
        errors.append(root_mean_square(through(x * [1, 1, 2], f), exact_spheroid(x), f))
    rates = np.array(errors[:-1]) / errors[1:]
    assert (rates > 3.3).all()  # second order


def exact_spheroid(x, c=2.0):
    """Conformal map of the spheroid 1:1:c, given by its parametrisation over the sphere x."""
    t = np.arcsin(np.clip(x[:, 2], -1, 1))
    e = np.sqrt(c**2 - 1)
    # du = sqrt(sin^2 t + c^2 cos^2 t) / cos t dt, in closed form.
    s = np.sin(t)
    u = e * np.arcsin(e * s / c) + np.arctanh(
        np.clip(s / np.sqrt(c**2 - e**2 * s**2), -1 + 1e-16, 1 - 1e-16)
    )
    rim = 1 / np.cosh(u)
    turn = np.arctan2(x[:, 1], x[:, 0])
    return np.column_stack((rim * np.cos(turn), rim * np.sin(turn), np.tanh(u)))


def root_mean_square(x, exact, f):
    A = ism.check_mesh(exact * [1, 1, 2], f).A
    turned = x @ best_rotation(x, exact, A)
    return np.sqrt(A @ ((turned - exact) ** 2).sum(axis=1))


def test_faces_that_break_are_named_and_the_rest_is_mapped():
    v = V + 0.08 * np.random.default_rng(1).normal(size=V.shape)
    assert len(flat_metrics.flat_metric(ism.check_mesh(v, F), 0, X).broken)
    assert np.median(np.abs(ism.angle_differences(v, F, through(v, F)))) < 15


def test_an_iteration_that_does_not_end_is_an_error():
    with pytest.raises(MapError, match="Newton steps; allow more"):
        flat_metrics.flat_metric(ism.check_mesh(V, F), 0, X, max_iterations=0)


@pytest.mark.parametrize(
    ("v", "f"),
    [
        (
            [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]],
            [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]],
        ),
        (
            np.vstack((np.eye(3), -np.eye(3))),
            [
                [0, 1, 2],
                [1, 3, 2],
                [3, 4, 2],
                [4, 0, 2],
                [1, 0, 5],
                [3, 1, 5],
                [4, 3, 5],
                [0, 4, 5],
            ],
        ),
    ],
)
def test_smallest_meshes(v, f):
    assert ism.certify(through(v, f), f).folding_free
