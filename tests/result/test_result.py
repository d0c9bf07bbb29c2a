"""Common to all results: the same attributes, read from the run, and one door to another balance."""

import re

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.plane.plane_map import PlaneMap
from igl_spheremap.result.result import Result

V, F = ism.samples.make("spheroid", n_vertices=500)
ROWS, HALF = np.unique(F[V[F, 2].mean(axis=1) > 0], return_inverse=True)
PART = V[ROWS], HALF.reshape(-1, 3)
#: What only maps to the sphere and only maps to the plane have.
OWN = {
    "SphereMap": {"mesh", "sphere", "conformal_factor"},
    "PlaneMap": {"mesh", "plane", "rim", "image", "log_length_ratios"},
}
OWN |= {"DiskMap": OWN["PlaneMap"], "FlatMap": OWN["PlaneMap"]}


@pytest.fixture(scope="module")
def results():
    sphere, disk = ism.spherical_conformal_map(V, F), ism.disk_conformal_map(*PART)
    plane = PlaneMap(disk.mesh, disk.plane, disk.certificate, disk.run)
    found = [sphere, plane, disk, ism.flatten(*PART)]
    return {type(result).__name__: result for result in found}


def attributes(result):
    return {name for name in dir(result) if not name.startswith("_")}


def test_maps_of_one_surface_have_the_same_attributes(results):
    common = [attributes(result) - OWN[name] for name, result in results.items()]
    assert all(OWN[name] <= attributes(result) for name, result in results.items())
    assert common == common[:1] * 4
    assert {"vertices", "faces", "conformal", "angle_differences", "plot"} <= common[0]


def test_all_results_have_those_of_their_run(results):
    sphere = results["SphereMap"]
    between = [
        ism.shapes.register(sphere, sphere, stages=["rotation"]),
        ism.shapes.match(sphere, sphere),
    ]
    for result in (*results.values(), *between):
        assert isinstance(result, Result)
        for name in (
            "energy",
            "status",
            "iterations",
            "seconds",
            "timings",
            "method",
            "settings",
            "history",
            "rounds",
            "backend",
            "notes",
            "gauge",
            "stretch",
            "balance",
        ):
            assert getattr(result, name) == getattr(result.run, name)
        assert result.certificate.folding_free
        assert re.search(f"^{result.method}[:,] ", result.explain(), re.MULTILINE)
        assert "\n" not in repr(result)
        assert repr(result).startswith(f"{type(result).__name__}(")
    assert [result.method for result in between] == ["register", "match"]


@pytest.mark.parametrize("name", ["SphereMap", "DiskMap", "FlatMap"])
def test_maps_go_to_another_balance_and_say_which(results, name):
    before = results[name]
    after = before.rebalance(0.9)
    assert type(after) is type(before)
    assert after.balance == after.settings["balance"] == 0.9
    assert "balance=0.9" in repr(after)
    assert after.certificate.folding_free
    assert np.abs(after.log_area_ratios()).mean() < np.abs(before.log_area_ratios()).mean()
    assert after.history[: len(after.conformal.history)] == after.conformal.history
    assert after.seconds > after.conformal.seconds


@pytest.mark.parametrize(
    ("make", "name"), [(ism.balanced_disk_map, "DiskMap"), (ism.flatten, "FlatMap")]
)
def test_a_map_that_is_rebalanced_is_the_one_that_is_made_so(results, make, name):
    there, here = make(*PART, balance=0.4), results[name].rebalance(0.4)
    assert np.array_equal(there.plane, here.plane)
    assert (there.energy, there.history, there.notes) == (here.energy, here.history, here.notes)


def test_what_was_unrolled_stays_as_it_is():
    flat = ism.flatten([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 1]], [[0, 1, 2], [0, 2, 3]])
    assert np.array_equal(flat.rebalance(0.1).plane, flat.plane)


def test_what_has_no_balance_of_its_own_says_so(results):
    sphere = results["SphereMap"]
    for result in (results["PlaneMap"], ism.shapes.register(sphere, sphere, stages=["rotation"])):
        with pytest.raises(
            TypeError, match=r"can't be rebalanced; make another one, from maps of balance 0\.5"
        ):
            result.rebalance(0.5)


def test_the_story_of_a_map_agrees_with_its_figures(results):
    """No step is denied that was counted, rounds say what they began with, and another balance what it did."""
    result = results["SphereMap"]
    assert result.explain() == f"auto: {result.run.plan}"
    assert result.run.plan.endswith("the map stays as it is")
    assert result.iterations == sum(step.iteration > 0 for step in result.history) > 0
    balanced = result.rebalance(0.9)
    own = balanced.iterations - result.iterations
    angles, areas = (
        np.abs(balanced.angle_differences()).mean(),
        np.exp(np.abs(balanced.log_area_ratios()).mean()),
    )
    first, second = balanced.explain().splitlines()
    assert first == result.explain()
    assert second.startswith(
        f"auto, balance 0.9: {own} iterations; angles are {angles:.3g} degrees off in the mean, "
    )
    assert f"and areas by a factor of {areas:.3g}, not " in second
    assert results["FlatMap"].explain().splitlines()[-1].startswith("flatten, balance 0.7: ")


def test_rounds_say_how_many_faces_folded_before_and_after():
    iterates = []
    result = ism.spherical_conformal_map(
        *ism.samples.make("dino", n_vertices=1500),
        method=ism.Lai2014(rounds=0),
        listener=iterates.append,
    )
    (only,), line = result.rounds, result.explain().splitlines()[1]
    assert (
        only.foldings_before
        == ism.certify(iterates[0].x, result.faces).foldings
        > only.foldings_after
    )
    assert line.startswith(
        f"gauss map: {only.foldings_before:,} folded faces, after {only.iterations} iterations "
    )
    assert result.iterations == only.iterations
