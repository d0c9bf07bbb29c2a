"""The paper's algorithms take their matrices from libigl, the fast method its own assembly, and both are the same."""

from collections import Counter

import igl
import numpy as np
import pytest
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap.operators.laplacian import cotangent_laplacian, laplacian
from igl_spheremap.paper.star_map import weighted_mass

X, F = icosphere(2)
V = X * [1, 1.2, 1.6] + 0.1 * X**2
CALLS = (
    "cotmatrix",
    "cotmatrix_entries",
    "cotmatrix_intrinsic",
    "massmatrix",
    "massmatrix_intrinsic",
    "per_vertex_normals",
    "internal_angles",
)
MASSES = {igl.MASSMATRIX_TYPE_BARYCENTRIC: "barycentric", igl.MASSMATRIX_TYPE_FULL: "full"}


@pytest.fixture
def calls(monkeypatch):
    """How often functions of libigl are called, mass matrices by their kind."""
    counts = Counter()

    def counted(name, function):
        def call(*arguments):
            counts[f"{MASSES[arguments[2]]} {name}" if "mass" in name else name] += 1
            return function(*arguments)

        return call

    for name in CALLS:
        monkeypatch.setattr(igl, name, counted(name, getattr(igl, name)))
    return counts


def test_the_energy_takes_libigls_laplacian(calls):
    ism.harmonic_energy(V, F, X)
    assert calls == {"cotmatrix": 1}


def test_the_conformal_factor_takes_libigls_barycentric_masses(calls):
    ism.conformal_factor(V, F, X)
    assert calls == {"barycentric massmatrix": 2}


def test_the_projection_takes_libigls_full_mass_and_its_laplacian(calls):
    ism.weighted_eigen_projection(V, F, X)
    # A and B_u
    assert calls == {
        "cotmatrix": 1,
        "full massmatrix": 1,
        "full massmatrix_intrinsic": 1,
        # of source and image for e^{2u}, and for the centre c
        "barycentric massmatrix": 3,
    }


@pytest.mark.parametrize(
    "method",
    [
        ism.Lai2014(edge_weights="cotangent", metric="areas"),
        ism.Lai2014.as_printed(max_iterations=9),
        ism.GuYau(tutte=False),
    ],
)
def test_algorithm_1_and_gu_yau_take_libigls_matrices_once(calls, method):
    ism.spherical_conformal_map(V, F, method=method)
    assert (calls["cotmatrix"], calls["barycentric massmatrix"], calls["cotmatrix_entries"]) == (
        1,
        1,
        0,
    )
    assert calls["per_vertex_normals"] > 0 < calls["internal_angles"]


@pytest.mark.parametrize(("body", "flips"), [((X, F), 0), ((V, F), 1)])
def test_made_to_work_takes_libigls_laplacian_too_of_the_flipped_mesh_where_weights_are_negative(
    calls, body, flips
):
    negative = igl.cotmatrix(*body).data < 0
    assert (negative.sum() > len(body[0])) == bool(flips)
    calls.clear()
    ism.spherical_conformal_map(*body, method=ism.Lai2014(max_iterations=9, may_fold=True))
    assert (calls["cotmatrix"], calls["cotmatrix_intrinsic"]) == (1, flips)
    assert calls["cotmatrix_entries"] == 0


def test_each_round_of_algorithm_2_takes_a_full_mass(calls):
    v, f = ism.samples.make("bird", n_vertices=880)
    result = ism.algorithm_2(v, f, method=ism.Lai2014.as_printed(max_iterations=20, rounds=2))
    rounds = len(result.rounds) - 1
    assert calls["full massmatrix"] == calls["full massmatrix_intrinsic"] == rounds == 2
    assert calls["barycentric massmatrix"] == 1 + 3 * rounds
    assert (calls["cotmatrix"], calls["cotmatrix_entries"]) == (1, 0)


def test_the_fast_method_assembles_from_libigls_entries(calls):
    ism.spherical_conformal_map(V, F)
    assert calls["cotmatrix_entries"] > 0
    assert calls["cotmatrix"] == calls["barycentric massmatrix"] == calls["full massmatrix"] == 0


@pytest.mark.parametrize("body", ["spheroid", "dino"])
def test_both_assemblies_are_the_same_matrix(body):
    mesh = ism.check_mesh(*ism.samples.make(body, n_vertices=1500))
    ours, libigls = laplacian(mesh.unit, mesh.f, "cotangent", mesh.edges), cotangent_laplacian(mesh)
    assert np.array_equal(ours.indptr, libigls.indptr)
    assert np.array_equal(ours.indices, libigls.indices)
    assert (
        np.abs(ours.data - libigls.data).max() < 8 * np.finfo(float).eps * np.abs(ours.data).max()
    )
    assert abs(libigls - libigls.T).max() == 0


def test_the_weighted_mass_integrates_cubics_exactly():
    """For linear p, q and a linear weight w the sum p B q is the integral of w p q."""
    mesh = ism.check_mesh(V, F)
    rng = np.random.default_rng(0)
    w, p, q = rng.uniform(0.1, 2, (3, len(V)))
    # the rule of seven points, exact up to degree 5
    a, b = (6 - np.sqrt(15)) / 21, (6 + np.sqrt(15)) / 21
    rule = [((1 / 3, 1 / 3, 1 / 3), 9 / 40)]
    for s, sign in ((a, -1), (b, 1)):
        rule += [
            (np.roll((1 - 2 * s, s, s), k), (155 + sign * np.sqrt(15)) / 1200) for k in range(3)
        ]
    area = igl.doublearea(mesh.unit, mesh.f) / 2
    exact = sum(
        weight * (area * np.prod([y[F] @ at for y in (w, p, q)], axis=0)).sum()
        for at, weight in rule
    )
    assert np.isclose(p @ weighted_mass(mesh, w) @ q, exact, rtol=1e-13)
