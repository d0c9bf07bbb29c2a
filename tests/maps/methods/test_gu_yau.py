"""The method of Gu and Yau: its two stages, and that it ends where all others do."""

import numpy as np
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap.sphere.gauge import best_rotation

X, F = icosphere(3)
V = X * [1, 1.3, 2]
MESH = ism.check_mesh(V, F)


def test_it_finds_the_map_that_the_fast_method_finds():
    slow = ism.spherical_conformal_map(V, F, ism.GuYau(tolerance=1e-5, plateau=0.0))
    fast = ism.spherical_conformal_map(V, F, tolerance=1e-8)
    assert slow.status is ism.Status.CONVERGED
    A = MESH.A
    turned = slow.sphere @ best_rotation(slow.sphere, fast.sphere, A)
    assert np.abs(turned - fast.sphere).max() < 1e-3
    assert np.isclose(slow.energy, fast.energy, rtol=1e-7)


def test_the_tutte_map_comes_first_and_is_recorded():
    result = ism.spherical_conformal_map(V, F, "gu-yau")
    assert [entry.start for entry in result.rounds] == ["gauss map", "tutte map"]
    assert result.iterations == sum(entry.iterations for entry in result.rounds)
    assert result.certificate.folding_free
    (only,) = ism.spherical_conformal_map(V, F, ism.GuYau(tutte=False)).rounds
    assert only.start == "gauss map"


def test_the_tutte_energy_weighs_all_edges_alike():
    """It is half the sum of the squared edge lengths."""
    seen = []
    ism.spherical_conformal_map(V, F, ism.GuYau(max_iterations=1), listener=seen.append)
    tutte = next(it for it in seen if it.stage == "tutte")
    edges = np.unique(np.sort(np.vstack((F[:, :2], F[:, 1:], F[:, ::2])), axis=1), axis=0)
    lengths = ((tutte.x[edges[:, 0]] - tutte.x[edges[:, 1]]) ** 2).sum()
    assert np.isclose(tutte.energy, lengths / 2)


def test_a_listener_can_stop_it_in_either_stage():
    for stage in ("tutte", "harmonic"):

        def stop(iterate, stage=stage):
            if iterate.stage == stage and iterate.iteration == 3:
                raise StopIteration

        result = ism.spherical_conformal_map(V, F, "gu-yau", listener=stop)
        assert result.status is ism.Status.STOPPED
        assert result.history[-1].stage == stage
