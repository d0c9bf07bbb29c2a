"""Balanced maps through the front door: their promises, from conformal to area-preserving."""

from pathlib import Path

import numpy as np
import pytest
from bodies import random_body

import igl_spheremap as ism
from igl_spheremap.sphere.moebius import best_rotation
from igl_spheremap.sphere.rows import unit_rows
from igl_spheremap.verify.certificate import orientation_signs

V, F = ism.samples.make("dino", n_vertices=1500)


@pytest.fixture(scope="module")
def family():
    """Maps of five balances, with the number of folded faces of every iterate."""
    folded = []

    def count(iterate):
        if iterate.stage in ("opening", "balance"):
            folded.append(int((orientation_signs(iterate.x, F) <= 0).sum()))

    maps = {
        balance: ism.balanced_spherical_map(V, F, balance=balance, listener=count)
        for balance in (0, 0.25, 0.5, 0.75, 1)
    }
    return maps, folded


def test_every_iterate_is_free_of_foldings_and_every_map_certified(family):
    maps, folded = family
    assert len(folded) > 20
    assert not any(folded)
    assert all(ism.certify(result.sphere, F).folding_free for result in maps.values())


@pytest.mark.parametrize("depth", [8, 30, 60])
def test_random_bodies_are_certified_at_every_iterate(depth):
    v, f = random_body(1, depth, 2, (6, 9))
    folded = []

    def count(iterate):
        if iterate.stage in ("opening", "balance"):
            folded.append(ism.certify(iterate.x, f).foldings)

    conformal = ism.spherical_conformal_map(v, f)
    for balance in (0.5, 1):
        assert conformal.rebalance(balance, listener=count).certificate.folding_free
    assert folded
    assert not any(folded)


def test_area_distortion_falls_and_angle_distortion_rises(family):
    maps = family[0].values()
    assert all(result.status is ism.Status.CONVERGED for result in maps)
    assert (np.diff([np.abs(result.log_area_ratios()).mean() for result in maps]) < 0).all()
    assert (np.diff([np.abs(result.angle_differences()).mean() for result in maps]) > 0).all()


def test_areas_are_source_areas_times_a_power_of_the_conformal_factor(family):
    maps = family[0]
    conformal = maps[0].log_area_ratios()
    for balance in (0.25, 0.5, 0.75):
        slope = np.polyfit(conformal, maps[balance].log_area_ratios(), 1)[0]
        assert slope == pytest.approx(1 - balance, abs=0.03)


def test_balance_0_is_the_conformal_map_bit_for_bit(family):
    conformal = ism.spherical_conformal_map(V, F)
    for result in (family[0][0], family[0][1].rebalance(0)):
        np.testing.assert_array_equal(result.sphere, conformal.sphere)
        assert result.balance == 0


def test_scaling_rotating_and_renumbering_commute(family):
    rng = np.random.default_rng(0)
    order, rotation = rng.permutation(len(V)), np.linalg.qr(rng.normal(size=(3, 3)))[0]
    rotation *= np.linalg.det(rotation)
    rank = np.argsort(order)
    moved = ism.balanced_spherical_map(7 * V[order] @ rotation + 3, rank[F], balance=0.5)
    x, y = family[0][0.5].sphere[order] @ rotation, moved.sphere
    assert np.abs(y @ best_rotation(y, x, np.ones(len(x))) - x).max() < 1e-3
    assert np.abs(y - x).max() < 2e-3


def test_a_slider_takes_fewer_steps_from_a_neighbour(family):
    maps = family[0]
    near, far = maps[0.75].rebalance(0.8), maps[0].rebalance(0.8)
    assert near.certificate.folding_free
    assert near.iterations < far.iterations
    assert np.abs(near.log_area_ratios()).mean() == pytest.approx(
        np.abs(far.log_area_ratios()).mean(), rel=0.03
    )


def test_a_map_that_goes_to_another_balance_gives_the_same_numbers(family):
    np.testing.assert_array_equal(
        ism.SphereMapper(V, F).map().rebalance(1).sphere, family[0][1].sphere
    )


def test_a_balanced_map_from_a_file_goes_on(family, tmp_path):
    ism.write_map(tmp_path / "map.npz", family[0][0.5])
    back = ism.read_map(tmp_path / "map.npz")
    assert back.balance == 0.5
    np.testing.assert_array_equal(
        back.rebalance(0.75).sphere, family[0][0.5].rebalance(0.75).sphere
    )


def test_a_listener_ends_with_a_bijection():
    def stop(iterate):
        if iterate.stage == "opening" and iterate.iteration == 2:
            raise StopIteration

    result = ism.balanced_spherical_map(V, F, balance=1, listener=stop)
    assert result.status is ism.Status.STOPPED
    assert result.certificate.folding_free


def test_a_spring_whose_conformal_image_is_rounding_opens_and_its_status_is_short():
    v, f = ism.samples.make("spring", n_vertices=2000)
    result = ism.balanced_spherical_map(v, f, balance=1)
    assert result.certificate.folding_free
    assert np.abs(result.conformal.log_area_ratios()).mean() > 30
    assert np.abs(result.log_area_ratios()).mean() < 2.6
    assert result.status is ism.Status.SHORT
    assert "balance 1" in result.notes[-1]


@pytest.mark.parametrize("balance", [-0.1, 1.5, float("nan")])
def test_a_balance_outside_is_refused(balance):
    with pytest.raises(ValueError, match="from 0 to 1"):
        ism.balanced_spherical_map(V, F, balance=balance)


def test_a_folded_map_is_refused():
    folded = ism.algorithm_1(V, F, method=ism.Lai2014(max_iterations=1))
    assert not folded.certificate.folding_free
    with pytest.raises(ism.FoldingsRemain, match="repair_foldings"):
        folded.rebalance(0.5)


def test_a_cortex_is_less_distorted_than_by_the_sphere_that_freesurfer_ships():
    nilearn = pytest.importorskip("nilearn")
    folder = Path(nilearn.__path__[0]) / "datasets" / "data" / "fsaverage5"
    v, f = ism.read_mesh(folder / "white_left.gii.gz")
    positions, _ = ism.read_mesh(folder / "sphere_left.gii.gz")
    theirs = unit_rows(positions)
    ours = ism.balanced_spherical_map(v, f, balance=0.85).sphere
    limits = {ism.log_area_ratios: 0.15, ism.angle_differences: 11, ism.log_length_ratios: 0.14}
    for distortion, limit in limits.items():
        assert (
            np.abs(distortion(v, f, ours)).mean() < limit < np.abs(distortion(v, f, theirs)).mean()
        )
