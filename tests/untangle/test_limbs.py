"""Deep limbs: their scale is foreseen, their solution is precise at every depth, drift draws them out as it should."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
from triangulations import icosphere

from igl_spheremap import samples, spherical_conformal_map
from igl_spheremap.descent.preconditioned import harmonic_map
from igl_spheremap.errors import FactorisationFailed
from igl_spheremap.mesh.check import check_mesh
from igl_spheremap.mesh.measure import corner_angles, vertex_areas
from igl_spheremap.operators.laplacian import laplacian
from igl_spheremap.operators.operators import build_operators
from igl_spheremap.untangle.depth import log_edges, predicted_log_edges
from igl_spheremap.untangle.nested import solve_limbs
from igl_spheremap.untangle.poles import poles_gauge, poles_limbs
from igl_spheremap.verify.certificate import orientation_signs


def _mapped(name, **parameters):
    mesh = check_mesh(*samples.make(name, **parameters))
    operators = build_operators(mesh, weights="delaunay")
    x = harmonic_map(mesh, operators).last.x
    return mesh, operators, x, -predicted_log_edges(mesh.v, mesh.f, x, operators.factor, operators.A)


@pytest.fixture(scope="module")
def octopus():
    return _mapped("octopus", n_vertices=3000, arm_length=3.0)


def test_the_predicted_scale_is_that_of_the_map(octopus):
    mesh, _, x, depth = octopus
    error = depth + log_edges(x, mesh.f)
    assert depth.max() > 10
    assert np.percentile(np.abs(error), 95) < 0.3


def test_log_edges_of_a_regular_solid():
    tetrahedron = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
    f = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    assert np.allclose(log_edges(tetrahedron, f), np.log(np.sqrt(8)))


def test_limbs_solved_in_frames_agree_with_the_solution_as_a_whole(octopus):
    mesh, operators, x, depth = octopus
    limbs = solve_limbs(x, operators.L, depth, operators.A)
    assert limbs.stretch == 1
    assert limbs.parent.max() >= 0
    y = limbs.onto_sphere(x)
    deep = limbs.frame >= 0
    assert deep.sum() > 100
    assert (y[~deep] == x[~deep]).all()
    # Edges are compared in units of themselves; the whole solution knows them to about 1e-12.
    edges = mesh.f[deep[mesh.f].all(axis=1)][:, :2]
    e, e0 = (z[edges[:, 0]] - z[edges[:, 1]] for z in (y, x))
    assert np.median(np.linalg.norm(e - e0, axis=1) / np.linalg.norm(e0, axis=1)) < 0.05


def _tube(around, rings):
    """Weights of a tube of squares that ends in one vertex, its open ring being outside; depths along it."""
    n = around * rings
    i = np.arange(n)
    right = (i // around) * around + (i + 1) % around
    down = i[:-around] + around
    rows, columns = np.concatenate((i, i[:-around], i[-around:])), np.concatenate((right, down, np.full(around, n)))
    W = sp.coo_matrix((np.ones(len(rows)), (rows, columns)), shape=(n + 1, n + 1)).tocsr()
    W = W + W.T
    step = 2 * np.pi / around  # nepers a ring, in the limit of small squares
    depth = np.append(i // around, rings) * step
    return sp.diags(np.asarray(W.sum(axis=1)).ravel()) - W, depth


def test_drift_shortens_a_limb_to_the_floor():
    around, rings = 60, 560
    L, depth = _tube(around, rings)
    x = np.zeros((around * rings + 1, 3))
    turn = 2 * np.pi * np.arange(around * rings) / around
    radius = np.exp(-depth[:-1])
    x[:-1] = np.column_stack((radius * np.cos(turn), radius * np.sin(turn), np.ones(around * rings)))
    x[-1, 2] = 1
    x /= np.linalg.norm(x, axis=1)[:, None]
    area = np.where(depth < 5, 1.0, 1e-3)
    for floor in (100.0, 40.0):
        limbs = solve_limbs(x, L.tocsr(), depth, area, floor=floor)
        size = limbs.scale.copy()
        for k in np.flatnonzero(limbs.parent >= 0):
            size[k] *= size[limbs.parent[k]]
        # the radius of a ring two thirds down the tube, against exp(-kappa * its depth below the onset at 9)
        ring = np.arange(around) + around * (2 * rings // 3)
        z = size[limbs.frame[ring]] * limbs.z[ring]
        across = np.log(np.abs(z - z.mean()).mean())
        kappa = 1 / limbs.stretch
        first = np.flatnonzero(limbs.frame < 0).max() // around
        expected = np.log(radius[first * around]) - kappa * (depth[ring[0]] - depth[first * around])
        assert kappa == pytest.approx(min(1.0, (floor - 9) / (depth.max() - 9)))
        assert across == pytest.approx(expected, abs=0.03 * abs(expected))


def test_the_poles_gauge_is_a_moebius_map_with_tips_at_the_poles():
    x, f = icosphere(3)
    area = np.ones(len(x))
    y = poles_gauge(x, (3, 77), area)
    assert (y[3] == [0, 0, 1]).all()
    assert (y[77] == [0, 0, -1]).all()
    assert abs(y[:, 2].mean()) < 1e-9
    assert (orientation_signs(y, f) > 0).all()
    a, b, c, d = (np.random.default_rng(k).permutation(len(x))[:200] for k in range(4))
    keep = (a != b) & (c != d) & (a != d) & (b != c)
    ratio = [np.linalg.norm(z[a] - z[b], axis=1) * np.linalg.norm(z[c] - z[d], axis=1)
             / np.maximum(np.linalg.norm(z[a] - z[d], axis=1) * np.linalg.norm(z[b] - z[c], axis=1), 1e-300)
             for z in (x, y)]
    assert np.allclose(ratio[0][keep], ratio[1][keep])


def test_a_spring_beyond_float64_is_held_on_the_axis():
    mesh, operators, x, depth = _mapped("spring", n_vertices=9000)
    assert depth.max() > 40
    x = solve_limbs(x, operators.L, depth, operators.A).onto_sphere(x)
    y, limbs = poles_limbs(mesh.v, mesh.f, x, operators.L, operators.factor, operators.A)
    assert limbs.stretch == 1
    assert (orientation_signs(y, mesh.f) > 0).all()
    assert log_edges(y, mesh.f).min() < -40
    drawn, held = (np.degrees(np.abs(corner_angles(z, mesh.f) - corner_angles(mesh.v, mesh.f))).mean() for z in (x, y))
    assert held < drawn / 2


def _worm(turns_of_length):
    """A tube of 20 vertices around, so many circumferences long, bent a little so that nothing is symmetric."""
    around, length = 20, 2 * np.pi * turns_of_length
    s = np.linspace(-length / 2, length / 2, int(length / (2 * np.pi / around)))
    r = np.sqrt(np.maximum(1 - np.maximum(np.abs(s) - (length / 2 - 1), 0) ** 2, 0))[1:-1, None]
    t = np.arange(around) * 2 * np.pi / around
    axis = np.column_stack((np.sin(s / 9), np.cos(s / 7), s))
    rings = axis[1:-1, None] + r[..., None] * np.column_stack((np.cos(t), np.sin(t), 0 * t))
    v = np.vstack((axis[:1], rings.reshape(-1, 3), axis[-1:]))
    a, b, last = np.arange(around), (np.arange(around) + 1) % around, len(v) - 1
    f = [np.column_stack((0 * a, 1 + b, 1 + a)), np.column_stack((last - around + a, last - around + b, 0 * a + last))]
    for k in range(1, last - around, around):
        f += [np.column_stack((k + a, k + b, k + b + around)), np.column_stack((k + a, k + b + around, k + a + around))]
    return check_mesh(v, np.vstack(f))


@pytest.mark.parametrize("turns_of_length", [10, 20])
def test_a_worm_whose_ends_are_beyond_float64_is_conformal_as_far_as_that_holds(turns_of_length):
    mesh = _worm(turns_of_length)
    result = spherical_conformal_map(mesh.v, mesh.f)
    assert result.certificate.folding_free
    drawn_out = np.pi * turns_of_length / 36  # half the worm is so many nepers deep, and edges of exp(-36) are kept
    assert result.stretch < 1.3 * max(1, drawn_out)
    assert np.abs(result.angle_differences()).mean() < (8 if turns_of_length == 10 else 16)


def test_limbs_around_a_map_that_means_nothing_are_refused():
    mesh = _worm(3)
    L, area = laplacian(mesh.v, mesh.f, "delaunay"), vertex_areas(mesh.v, mesh.f)
    depth = np.where(mesh.v[:, 2] > 0, 30.0, 0.0)
    x = np.full((len(area), 3), np.nan)
    with pytest.raises(FactorisationFailed):
        solve_limbs(x, L, depth, area)


def test_a_map_that_is_a_speck_as_a_whole_has_no_limbs():
    mesh = _worm(3)
    L, area = laplacian(mesh.v, mesh.f, "delaunay"), vertex_areas(mesh.v, mesh.f)
    limbs = solve_limbs(np.tile([0.0, 0.0, 1.0], (len(area), 1)), L, np.full(len(area), 40.0), area)
    assert not len(limbs.parent)
    assert limbs.stretch == 1
