"""The baselines: maps through the plane are exact on spheres and convergent; Gu and Yau's ends where all others do."""

import numpy as np
import pytest
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap.maps.methods import in_gauge
from igl_spheremap.result.run import Run
from igl_spheremap.sphere.moebius import best_rotation, fix_gauge
from igl_spheremap.sphere.rows import unit_rows
from igl_spheremap.start.punctured import candidate_faces

X, F = icosphere(3)
V = X * [1, 1.3, 2]
MESH = ism.check_mesh(V, F)


def through(v, f, **options):
    return ism.spherical_conformal_map(v, f, method=ism.Stereographic(**options))


def test_the_laplace_beltrami_map_does_depend_on_the_puncture():
    """The artefact that the paper's introduction names."""
    maps = [through(V, F, puncture=face) for face in (0, 500)]
    assert np.abs(maps[0].sphere - maps[1].sphere).max() > 1e-3


def test_the_default_puncture_is_the_candidate_of_least_energy():
    v, f = ism.samples.make("dino", n_vertices=1500)
    faces = list(candidate_faces(ism.check_mesh(v, f)))
    energies = [through(v, f, puncture=face).energy for face in faces]
    assert max(energies) > min(energies)
    result = through(v, f)
    assert result.energy == min(energies)
    assert result.notes[0] == f"face {faces[np.argmin(energies)]} is punctured"


def test_smallest_meshes():
    v = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]
    assert through(v, [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]).certificate.folding_free
    v = np.vstack((np.eye(3), -np.eye(3)))
    f = [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
    assert through(v, f).certificate.folding_free


def test_errors_name_the_option():
    with pytest.raises(ValueError, match="faces 0 to 1279"):
        through(V, F, puncture=1280)
    with pytest.raises(ValueError, match="tutte_plateau is of the Tutte map"):
        ism.GuYau(tutte=False, tutte_plateau=1e-2)
    for face, error in ((-1, ValueError), (2.5, TypeError)):
        with pytest.raises(error, match=f"puncture is {face}; give "):
            through(V, F, puncture=face)


def test_a_map_that_the_gauge_would_fold_stays_where_it_is_and_certified():
    """A vertex within 4e-16 of the opposite edge lies on either side of it after a rotation, and a note says so."""
    x, k = X.copy(), F[0, 0]
    middle = X[F[0, 1:]].mean(axis=0)
    x[k] = middle + 4e-16 * (X[k] - middle)
    x = unit_rows(x)
    assert ism.certify(x, F).folding_free
    assert not ism.certify(fix_gauge(MESH, x), F).folding_free
    found = in_gauge(MESH, x, Run(ism.Status.DONE, 0.0))
    assert found.sphere is x
    assert found.certificate.folding_free
    assert (found.gauge, len(found.notes)) == ("free", 1)


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
    direct = through(V, F)
    given, repaired = ism.sphere_map(V, F, direct.sphere), ism.repair_foldings(V, F, direct.sphere)
    assert {direct.status, given.status, repaired.status, repaired.rounds[0].status} == {
        ism.Status.DONE
    }
    ended = ism.spherical_conformal_map(
        V, F, method=ism.Lai2014(gradient_tolerance=0.0, plateau=1e-4)
    )
    assert ended.status is ism.Status.PLATEAU
    assert ended.history[-1].residual > 0
