"""The paper's algorithms by name: foldings removed in rounds, from any start."""

import numpy as np
import pytest
from triangulations import icosphere

import igl_spheremap as ism

X, F = icosphere(3)
V = X * [1, 1.2, 1.6]


def test_foldings_of_a_dinosaur_are_removed_in_at_most_three_rounds():
    v, f = ism.samples.make("dino", n_vertices=2500)
    stages = []
    result = ism.algorithm_2(v, f, listener=lambda it: stages.append((it.round, it.stage)))
    assert ism.certify(ism.gauss_map(v, f), f).foldings > 500
    assert result.rounds[0].start == "gauss map"
    assert result.rounds[0].foldings_before > 500
    assert [r.start for r in result.rounds[1:]] == ["star map"] * (len(result.rounds) - 1)
    assert 1 < len(result.rounds) <= 4
    assert result.rounds[-1].foldings_after == 0
    assert result.certificate.folding_free
    assert set(stages) == {(r.round, s) for r in result.rounds for s in (r.start, "harmonic")}


def test_on_a_delaunay_mesh_the_weights_are_the_papers():
    options = {"gradient_tolerance": 1e-2, "rounds": 0}
    papers, delaunay = (
        ism.spherical_conformal_map(X, F, method=ism.Lai2014(edge_weights=weights, **options))
        for weights in ("cotangent", "delaunay")
    )
    assert np.allclose(papers.sphere, delaunay.sphere, atol=1e-9)
    assert papers.settings == options | {"edge_weights": "cotangent"}


@pytest.mark.parametrize("flat", [[1, 1, 0], [1, 0, 0]], ids=["plane", "line"])
def test_surfaces_whose_gauss_map_is_no_start_begin_at_unweighted_eigenfunctions(flat):
    """The Gauss map of a flat body is two points, and so is the weight that it makes."""
    result = ism.algorithm_2(X * flat, F, method=ism.Lai2014(max_iterations=50))
    assert result.rounds[0].status is ism.Status.COLLAPSED
    assert [r.start for r in result.rounds[:2]] == ["gauss map", "star map"]
    assert result.certificate.folding_free


def test_a_note_says_that_a_round_began_without_weights():
    result = ism.algorithm_2(X * [1, 1, 0], F, method=ism.Lai2014(max_iterations=5))
    assert any("1 round began at unweighted eigenfunctions" in note for note in result.notes)


def test_the_weights_of_a_map_that_has_shrunk_are_used_where_their_star_map_is_the_better_one():
    v, f = ism.samples.make("dumbbell", n_vertices=300)
    seen = []
    result = ism.algorithm_2(v, f, listener=seen.append)
    k = [iterate.stage for iterate in seen].index("star map")
    last, star = seen[k - 1].x, seen[k].x
    assert ism.certify(last, f).degree == 0
    assert ism.certify(star, f).degree == 1
    weighted = ism.weighted_eigen_projection(v, f, last).star_map
    assert np.allclose(star, weighted, atol=1e-6)
    assert not any("unweighted" in note for note in result.notes)


def test_a_listener_can_stop_at_a_star_map():
    v, f = ism.samples.make("dino", n_vertices=1500)

    def stop(iterate):
        if iterate.stage == "star map":
            assert np.allclose(iterate.details["eigenvalues"], 2, atol=1)
            raise StopIteration

    result = ism.algorithm_2(v, f, method=ism.Lai2014(max_iterations=300), listener=stop)
    assert result.status is ism.Status.STOPPED
    assert len(result.rounds) == 2


def test_algorithm_1_alone_does_no_eigen_projection():
    v, f = ism.samples.make("dino", n_vertices=1500)
    result = ism.algorithm_1(v, f, method=ism.Lai2014(max_iterations=50))
    assert len(result.rounds) == 1
    assert not result.certificate.folding_free


def test_any_directions_are_taken_as_a_start_but_nothing_else():
    result = ism.algorithm_1(V, F, start=7 * X)
    assert result.certificate.folding_free
    for bad in (0 * X, np.full_like(X, np.nan)):
        with pytest.raises(ism.MeshError, match="zero or not finite"):
            ism.algorithm_1(V, F, start=bad)
    with pytest.raises(ism.MeshError, match="rows"):
        ism.algorithm_1(V, F, start=X[1:])


def test_a_map_far_from_conformal_is_noted():
    result = ism.algorithm_2(X * [1, 0, 0], F)
    assert result.certificate.folding_free
    mean = np.abs(result.angle_differences()).mean()
    assert mean > 20
    notes = " ".join(result.notes)
    assert "the repair made the map" in notes
    assert "the map is the star map" not in notes
    assert f"angles are {mean:.3g} degrees off in the mean" in notes


def test_a_correction_that_hardly_moved_is_noted():
    v, f = ism.samples.make("dino", n_vertices=1500)
    result = ism.algorithm_2(v, f)
    last = result.rounds[-1]
    assert (last.start, last.status) == ("star map", ism.Status.STALLED)
    assert f"the map is the star map after {last.iterations} iteration" in " ".join(result.notes)


def test_on_a_coarse_image_the_star_map_is_kept_if_algorithm_1_leads_away_from_the_angles():
    """The chords of a dumbbell's image have less energy while its angles get worse."""
    v, f = ism.samples.make("dumbbell", n_vertices=300)
    seen = []
    result = ism.algorithm_2(v, f, listener=seen.append)
    star, last = ([it for it in seen if it.round == 1][k] for k in (0, -1))
    assert last.energy < star.energy
    assert np.abs(ism.angle_differences(v, f, last.x)).mean() > 15
    mean = np.abs(ism.angle_differences(v, f, star.x)).mean()
    assert np.abs(result.angle_differences()).mean() == pytest.approx(mean, rel=0.05)
    assert result.energy == pytest.approx(result.rounds[-1].energy)
    assert any("the map is the star map after 0 iterations" in note for note in result.notes)
