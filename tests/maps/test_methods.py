"""The baselines: maps through the plane are exact on spheres and convergent; Gu and Yau's ends where all others do."""

import numpy as np
import pytest
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap.errors import NotConverged
from igl_spheremap.sphere.moebius import best_rotation, center
from igl_spheremap.sphere.rows import unit_rows

X, F = icosphere(3)
V = X * [1, 1.3, 2]
MESH = ism.check_mesh(V, F)
PLANES = ("laplace-beltrami", "conformal-equivalence")


def through(v, f, plane, **options):
    return ism.spherical_conformal_map(v, f, method=ism.Stereographic(plane, **options))


def test_the_sphere_is_mapped_to_itself_by_conformal_equivalence():
    """Meshes inscribed in the sphere are equivalent to themselves: exact at any resolution."""
    x = unit_rows(X + 0.015 * np.random.default_rng(3).normal(size=X.shape))
    assert ism.certify(x, F).folding_free
    result = through(x, F, "conformal-equivalence")
    centred = center(x, ism.check_mesh(x, F).A)
    assert np.abs(result.angle_differences()).max() < np.abs(ism.angle_differences(x, F, centred)).max() + 1e-5
    assert np.allclose(cross_ratios(result.sphere), cross_ratios(x), rtol=1e-6)


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
        result = through(V, F, "conformal-equivalence", puncture=face)
        assert np.allclose(np.log(cross_ratios(result.sphere)), np.log(cross_ratios(V)), atol=1e-6)


def test_conformal_equivalence_does_not_depend_on_the_puncture():
    a, b = (through(V, F, "conformal-equivalence", puncture=face).sphere for face in (0, 500))
    assert np.abs(a - b).max() < 1e-6


def test_the_laplace_beltrami_map_does_depend_on_the_puncture():
    """The artefact that the paper's introduction names."""
    maps = [through(V, F, "laplace-beltrami", puncture=face) for face in (0, 500)]
    assert np.abs(maps[0].sphere - maps[1].sphere).max() > 1e-3


def test_conformal_equivalence_converges_to_the_exact_map_of_a_spheroid():
    errors = []
    for level in (2, 3, 4):
        x, f = icosphere(level)
        result = through(x * [1, 1, 2], f, "conformal-equivalence")
        errors.append(root_mean_square(result.sphere, exact_spheroid(x), f))
    rates = np.array(errors[:-1]) / errors[1:]
    assert (rates > 3.3).all()  # second order


def exact_spheroid(x, c=2.0):
    """Conformal map of the spheroid 1:1:c, given by its parametrisation over the sphere x."""
    t = np.arcsin(np.clip(x[:, 2], -1, 1))
    e = np.sqrt(c**2 - 1)
    # du = sqrt(sin^2 t + c^2 cos^2 t) / cos t dt, in closed form.
    s = np.sin(t)
    u = e * np.arcsin(e * s / c) + np.arctanh(np.clip(s / np.sqrt(c**2 - e**2 * s**2), -1 + 1e-16, 1 - 1e-16))
    rim = 1 / np.cosh(u)
    turn = np.arctan2(x[:, 1], x[:, 0])
    return np.column_stack((rim * np.cos(turn), rim * np.sin(turn), np.tanh(u)))


def root_mean_square(x, exact, f):
    A = ism.check_mesh(exact * [1, 1, 2], f).A
    turned = x @ best_rotation(x, exact, A)
    return np.sqrt(A @ ((turned - exact) ** 2).sum(axis=1))


def test_faces_that_break_are_named_and_the_rest_is_mapped():
    v = V + 0.08 * np.random.default_rng(1).normal(size=V.shape)
    result = through(v, F, "conformal-equivalence")
    assert any("break the triangle inequality" in note for note in result.notes)
    assert np.median(np.abs(result.angle_differences())) < 15


@pytest.mark.parametrize("plane", PLANES)
def test_smallest_meshes(plane):
    v = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]
    assert through(v, [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]], plane).certificate.folding_free
    v = np.vstack((np.eye(3), -np.eye(3)))
    f = [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
    assert through(v, f, plane).certificate.folding_free


def test_errors_name_the_option():
    with pytest.raises(ValueError, match="faces 0 to 1279"):
        through(V, F, "laplace-beltrami", puncture=1280)
    with pytest.raises(ValueError, match="angle_tolerance would have no effect: only plane='conformal-equivalence'"):
        ism.Stereographic(angle_tolerance=1e-6)
    with pytest.raises(ValueError, match="tutte_plateau is of the Tutte map"):
        ism.GuYau(tutte=False, tutte_plateau=1e-2)
    for face, error in ((-1, ValueError), (2.5, TypeError)):
        with pytest.raises(error, match=f"puncture is {face}; give "):
            through(V, F, "laplace-beltrami", puncture=face)
    with pytest.raises(NotConverged, match="Newton steps; allow more"):
        through(V, F, "conformal-equivalence", max_iterations=0)


def test_it_finds_the_map_that_the_fast_method_finds():
    slow = ism.spherical_conformal_map(V, F, method=ism.GuYau(gradient_tolerance=1e-5, plateau=0.0))
    fast = ism.spherical_conformal_map(V, F, tolerance=1e-8)
    assert slow.status is ism.Status.CONVERGED
    A = MESH.A
    turned = slow.sphere @ best_rotation(slow.sphere, fast.sphere, A)
    assert np.abs(turned - fast.sphere).max() < 1e-3
    assert np.isclose(slow.energy, fast.energy, rtol=1e-7)


def test_the_tutte_map_comes_first_and_is_recorded():
    result = ism.spherical_conformal_map(V, F, method="gu-yau")
    assert [entry.start for entry in result.rounds] == ["gauss map", "tutte map"]
    assert result.iterations == sum(entry.iterations for entry in result.rounds)
    assert result.certificate.folding_free
    (only,) = ism.spherical_conformal_map(V, F, method=ism.GuYau(tutte=False)).rounds
    assert only.start == "gauss map"


def test_the_tutte_energy_weighs_all_edges_alike():
    """It is half the sum of the squared edge lengths."""
    seen = []
    ism.spherical_conformal_map(V, F, method=ism.GuYau(max_iterations=1), listener=seen.append)
    tutte = next(it for it in seen if it.stage == "tutte")
    edges = np.unique(np.sort(np.vstack((F[:, :2], F[:, 1:], F[:, ::2])), axis=1), axis=0)
    lengths = ((tutte.x[edges[:, 0]] - tutte.x[edges[:, 1]]) ** 2).sum()
    assert np.isclose(tutte.energy, lengths / 2)


def test_a_listener_can_stop_it_in_either_stage():
    for stage in ("tutte", "harmonic"):

        def stop(iterate, stage=stage):
            if iterate.stage == stage and iterate.iteration == 3:
                raise StopIteration

        result = ism.spherical_conformal_map(V, F, method="gu-yau", listener=stop)
        assert result.status is ism.Status.STOPPED
        assert result.history[-1].stage == stage


def test_only_what_met_its_stopping_rule_has_converged():
    equivalent, direct = (through(V, F, plane) for plane in ("conformal-equivalence", "laplace-beltrami"))
    assert (equivalent.status, direct.status) == (ism.Status.CONVERGED, ism.Status.DONE)
    given, repaired = ism.sphere_map(V, F, direct.sphere), ism.repair_foldings(V, F, direct.sphere)
    assert {given.status, repaired.status, repaired.rounds[0].status} == {ism.Status.DONE}
    ended = ism.spherical_conformal_map(V, F, method=ism.Lai2014(gradient_tolerance=0.0, plateau=1e-4))
    assert ended.status is ism.Status.PLATEAU
    assert ended.history[-1].residual > 0
