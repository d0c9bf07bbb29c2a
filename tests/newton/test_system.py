"""Systems with two unknowns a vertex: assembled like dense ones, solved alike by all solvers, with or without a rim."""

import numpy as np
import pytest
from triangulations import icosphere

from igl_spheremap.errors import FactorisationFailed
from igl_spheremap.newton.system import PAIRS, VertexSystem, gram_blocks
from igl_spheremap.operators.factor.factorize import available_backends

BACKENDS = available_backends()


@pytest.fixture(params=["sphere", "disk"])
def mesh(request):
    """A closed mesh, or one with a rim whose vertices are numbered anew."""
    x, f = icosphere(2)
    if request.param == "disk":
        f = f[(x[f][:, :, 2] > -0.2).all(axis=1)]
        used, f = np.unique(f, return_inverse=True)
        x, f = x[used], f.reshape(-1, 3)
    return f, len(x)


def random_blocks(f, seed=0):
    """Blocks of random positive definite 6 x 6 matrices, and their dense sum."""
    rng = np.random.default_rng(seed)
    J = rng.normal(size=(7, 3, 2, len(f)))
    n = f.max() + 1
    dense = np.zeros((2 * n, 2 * n))
    for face, corners in enumerate(f):
        unknowns = (2 * corners[:, None] + [0, 1]).ravel()
        rows = J[..., face].reshape(7, 6)
        dense[np.ix_(unknowns, unknowns)] += rows.T @ rows
    return gram_blocks(J, J), dense


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("limbs", [False, True])
def test_solutions_are_those_of_the_dense_matrix(mesh, backend, limbs):
    f, n = mesh
    system = VertexSystem(f, n, backend, limbs=limbs)
    rng = np.random.default_rng(1)
    for seed in range(2):  # one analysis, several matrices
        blocks, dense = random_blocks(f, seed)
        share, added, corner = rng.random(n), rng.random(n), rng.normal(size=(2, n))
        at_vertices = np.einsum("an,bn->abn", corner, corner)
        values = system.damped(system.assemble(blocks, at_vertices), share, added)
        for i in range(n):
            dense[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] += at_vertices[:, :, i]
        dense[np.diag_indices(2 * n)] *= 1 + np.repeat(share, 2)
        dense[np.diag_indices(2 * n)] += np.repeat(added, 2)
        load = rng.normal(size=(4, 2, n))
        columns = load.transpose(2, 1, 0).reshape(2 * n, 4)
        expected = np.linalg.solve(dense, columns).reshape(n, 2, 4).transpose(2, 1, 0)
        factor = system.factorize(values)
        assert np.allclose(system.solve(factor, load), expected, atol=1e-9)
        assert np.allclose(system.solve(factor, load[0]), expected[0], atol=1e-9)


def test_what_faces_add_to_their_corners_is_summed(mesh):
    f, n = mesh
    parts = np.random.default_rng(0).normal(size=(2, 3, len(f)))
    expected = np.zeros((2, n))
    for face, corners in enumerate(f):
        for k, vertex in enumerate(corners):
            expected[:, vertex] += parts[:, k, face]
    assert np.allclose(VertexSystem(f, n).gathered(parts), expected)


def test_blocks_of_a_product_are_those_of_its_matrix():
    rng = np.random.default_rng(0)
    left, right = rng.normal(size=(2, 5, 3, 2, 4))
    for block, (i, j) in zip(gram_blocks(left, right), PAIRS, strict=True):
        assert np.allclose(block, np.einsum("ram,rbm->abm", left[:, i], right[:, j]))


def test_a_matrix_that_memory_does_not_hold_is_not_factorised(monkeypatch):
    """It has two unknowns a vertex; only callers that ask for it are refused."""
    x, f = icosphere(1)
    system = VertexSystem(f, len(x))
    values = system.assemble(random_blocks(f)[0])
    for most, fits in ((2 * len(x), True), (2 * len(x) - 1, False)):
        monkeypatch.setattr("igl_spheremap.newton.system.fits_memory", lambda n, k=most: n <= k)
        assert system.factorize(values).backend
        if fits:
            assert system.factorize(values, within_memory=True).backend
        else:
            with pytest.raises(FactorisationFailed, match="too large"):
                system.factorize(values, within_memory=True)


def test_entries_that_are_not_finite_fail():
    x, f = icosphere(1)
    system = VertexSystem(f, len(x))
    blocks, _ = random_blocks(f)
    blocks[0, 0, 0, 0] = np.nan
    with pytest.raises(FactorisationFailed, match="not finite"):
        system.factorize(system.assemble(blocks))
