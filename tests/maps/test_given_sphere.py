"""Spheres of other programs: certified as they are or refused in a sentence; folds are repaired, all else stays."""

from __future__ import annotations

import numpy as np
import pytest
from triangulations import icosphere

import igl_spheremap as ism


@pytest.fixture(scope="module")
def pear():
    v, f = ism.samples.make("pear", n_vertices=1000)
    return v, f, ism.spherical_conformal_map(v, f)


def test_our_own_sphere_comes_back(pear):
    v, f, result = pear
    again = ism.sphere_map(v, f, result.sphere)
    assert again.certificate.folding_free
    assert np.abs(again.sphere - result.sphere).max() < 1e-15
    assert np.isclose(again.energy, result.energy, rtol=1e-7)


def test_any_radius_and_float32(pear):
    v, f, result = pear
    again = ism.sphere_map(v, f, (100 * result.sphere).astype(np.float32))
    assert again.certificate.folding_free
    assert np.abs(again.sphere - result.sphere).max() < 1e-7
    assert np.allclose(ism.transfer(again, v, result), v, atol=1e-4)


def test_a_planted_fold_is_named_and_its_map_kept(pear):
    v, f, result = pear
    x = result.sphere.copy()
    x[[10, 20]] = x[[20, 10]]
    with pytest.raises(
        ism.FoldingsRemain, match=r"flipped faces, e\.g\. .*repair_foldings"
    ) as caught:
        ism.sphere_map(v, f, x)
    kept = caught.value.result
    assert np.array_equal(kept.certificate.flipped, ism.certify(x, f).flipped)
    assert ism.sphere_map(
        v, f, ism.repair_foldings(v, f, kept.sphere).sphere
    ).certificate.folding_free


def test_refusals(pear):
    v, f, result = pear
    x = result.sphere
    with pytest.raises(ism.MeshError, match="rows but the mesh has"):
        ism.sphere_map(v, f, x[:-1])
    with pytest.raises(ism.MeshError, match=r"zero or not finite in 1 row, e\.g\. 3;"):
        ism.sphere_map(v, f, np.where(np.arange(len(x))[:, None] == 3, np.nan, x))
    with pytest.raises(ism.FoldingsRemain, match="another mesh"):
        ism.sphere_map(v, f, np.random.default_rng(0).permutation(x))


@pytest.mark.parametrize("function", [ism.sphere_map, ism.repair_foldings])
def test_a_mirror_image_is_turned_and_said_to_have_been_one(pear, function):
    v, f, result = pear
    found = function(v, f, result.sphere * [1, 1, -1])
    assert np.array_equal(found.sphere, result.sphere)
    assert found.certificate.folding_free
    assert found.notes == ("the sphere was a mirror image, not folded: z is negated",)


def test_any_map_is_repaired_and_the_listener_sees_foldings_vanish():
    v, f = ism.samples.make("spheroid", n_vertices=1000)
    x = ism.spherical_conformal_map(v, f).sphere.copy()
    x[f[7, :2]] = x[f[7, 1::-1]]  # two neighbours exchanged
    seen = []
    result = ism.repair_foldings(v, f, x, listener=seen.append)
    assert result.certificate.folding_free
    assert seen[0].residual == ism.certify(x, f).foldings == result.rounds[0].foldings_before > 0
    far = np.linalg.norm(x - x[f[7, 0]], axis=1) > 0.5
    assert (result.sphere[far] == x[far]).all()
    assert seen[-1].residual == 0
    assert {it.stage for it in seen} == {"map", "repair", "repaired"}


def test_a_good_map_of_another_program_stays_bit_for_bit():
    x, f = icosphere(2)
    single = x.astype(np.float32)
    result = ism.repair_foldings(x, f, single)
    assert (result.sphere == single).all()
    assert result.certificate.folding_free
    assert result.gauge == "given"


def test_a_map_turned_inside_out_is_reflected():
    x, f = icosphere(3)
    v = x * [1.0, 1.1, 1.2]
    result = ism.repair_foldings(v, f, -x)
    assert result.certificate.folding_free
    assert np.abs(result.angle_differences()).mean() == pytest.approx(
        np.abs(ism.angle_differences(v, f, x)).mean()
    )


@pytest.mark.parametrize("bad", [0.0, np.nan, np.inf])
def test_rows_without_direction_are_refused(bad):
    x, f = icosphere(1)
    y = x.copy()
    y[5] = bad
    with pytest.raises(ism.MeshError):
        ism.repair_foldings(x, f, y)


def test_a_repaired_map_that_the_default_method_would_beat_says_so():
    v, f = ism.samples.make("dino", n_vertices=1500)
    repaired, made = (
        ism.repair_foldings(v, f, ism.gauss_map(v, f)),
        ism.spherical_conformal_map(v, f),
    )
    means = [np.abs(result.angle_differences()).mean() for result in (made, repaired)]
    assert 3 * means[0] < means[1]
    (note,) = repaired.notes
    assert f"{means[1]:.3g} degrees off" in note
    assert "spherical_conformal_map(v, f)" in note
    x = made.sphere.copy()
    x[[5, 90]] = x[[90, 5]]
    assert not ism.certify(x, f).folding_free
    assert ism.repair_foldings(v, f, x).notes == ()


@pytest.mark.parametrize("function", [ism.sphere_map, ism.repair_foldings])
def test_a_surface_in_the_place_of_its_sphere_is_said_to_be_one(function):
    """A projection from the origin may be free of foldings, but no program made that map; of a sphere it is the map."""
    v, f = ism.samples.make("pear", n_vertices=300)
    (note,) = function(v, f, v).notes
    assert note.startswith("the images are the surface itself and not a sphere")
    assert function(v, f, v * 1.001).notes == ()
    x, g = ism.samples.sphere(162)
    assert function(3 * x, g, 3 * x).notes == ()
