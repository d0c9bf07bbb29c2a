"""Spheres of other programs: certified as they are, or refused in a sentence."""

from __future__ import annotations

import numpy as np
import pytest

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
    with pytest.raises(ism.FoldingsRemain, match=r"flipped faces, e\.g\. .*repair_foldings") as caught:
        ism.sphere_map(v, f, x)
    kept = caught.value.result
    assert np.array_equal(kept.certificate.flipped, ism.certify(x, f).flipped)
    assert ism.sphere_map(v, f, ism.repair_foldings(v, f, kept.sphere).sphere).certificate.folding_free


def test_refusals(pear):
    v, f, result = pear
    x = result.sphere
    with pytest.raises(ism.MeshError, match="reflection"):
        ism.sphere_map(v, f, x * [-1, 1, 1])
    with pytest.raises(ism.MeshError, match="rows but the mesh has"):
        ism.sphere_map(v, f, x[:-1])
    with pytest.raises(ism.MeshError, match=r"zero or not finite in 1 row, e\.g\. 3;"):
        ism.sphere_map(v, f, np.where(np.arange(len(x))[:, None] == 3, np.nan, x))
    with pytest.raises(ism.FoldingsRemain, match="another mesh"):
        ism.sphere_map(v, f, np.random.default_rng(0).permutation(x))
