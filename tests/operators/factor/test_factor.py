"""All factorisations agree, and fail alike."""

import os
import subprocess
import sys
import threading

import igl
import numpy as np
import pytest
import scipy.sparse as sp

import igl_spheremap as ism
from igl_spheremap.errors import FactorisationFailed
from igl_spheremap.mesh.measure import vertex_areas
from igl_spheremap.operators.factor import factor as factor_module
from igl_spheremap.operators.factor import factorize as factorize_module
from igl_spheremap.operators.factor.factor import Cholmod, Entries, SuperLU
from igl_spheremap.operators.factor.factorize import analyse, available_backends, factorize
from igl_spheremap.operators.laplacian import laplacian

BACKENDS = ("cvxopt", "rslab", "scipy")


def problem(n_subdivisions, regularisation=1e-9):
    v, f = igl.loop(*igl.icosahedron(), n_subdivisions)
    v = np.ascontiguousarray(v / np.linalg.norm(v, axis=1)[:, None] * [1.0, 1.5, 2.0])
    areas = vertex_areas(v, f)
    return (laplacian(v, f) + regularisation * sp.diags_array(areas / areas.sum())).tocsc()


def right_hand_sides(n, k=3, seed=0):
    b = np.random.default_rng(seed).normal(size=(n, k))
    return b - b.mean(axis=0)


@pytest.fixture(params=BACKENDS)
def backend(request):
    if request.param not in available_backends():
        pytest.skip(f"{request.param} is not installed")
    return request.param


@pytest.mark.parametrize("n_subdivisions", [0, 2, 3])
def test_agrees_with_a_dense_solve(backend, n_subdivisions):
    P = problem(n_subdivisions, 1e-3)
    b = right_hand_sides(P.shape[0])
    factor = factorize(P, backend)
    assert factor.backend == backend
    np.testing.assert_allclose(factor.solve(b), np.linalg.solve(P.toarray(), b), atol=1e-10)


def test_many_levels(backend):
    P = problem(5)
    b = right_hand_sides(P.shape[0])
    assert np.abs(P @ factorize(P, backend).solve(b) - b).max() < 1e-10


def test_pinned_vertices(backend):
    P = problem(4, 0.0)[3:, 3:].tocsc()
    b = right_hand_sides(P.shape[0])
    assert np.abs(P @ factorize(P, backend).solve(b) - b).max() < 1e-10


def lower_triangle(P, **options):
    """The lower triangle of a matrix, and its values."""
    P = P.tocsr()
    rows = np.arange(P.shape[0]).repeat(np.diff(P.indptr))
    lower = rows >= P.indices
    return Entries(P, rows[lower], P.indices[lower], **options), P.data[lower]


@pytest.mark.parametrize("limbs", [False, True])
@pytest.mark.parametrize("dissect_from", [0, 10**9])
def test_all_orders_of_a_backend_solve_a_matrix_and_others_of_its_pattern(
    backend, dissect_from, limbs, monkeypatch
):
    for library in (Cholmod, SuperLU):
        monkeypatch.setattr(library, "dissects_from", dissect_from)
    P = problem(4, 1e-3)
    b = right_hand_sides(P.shape[0])
    entries, values = lower_triangle(P, repeated=True, limbs=limbs)
    analysis = analyse(entries, backend)
    x = analysis.factorize(values).solve(b)
    np.testing.assert_allclose(P @ x, b, atol=1e-10)
    for factor in (4, 2, 0.5):
        np.testing.assert_allclose(
            factor * analysis.factorize(factor * values).solve(b), x, atol=1e-9
        )


def test_the_order_of_another_matrix_is_used_again(backend):
    P = problem(4, 1e-3)
    b = right_hand_sides(P.shape[0])
    first = factorize(P, backend)
    x = first.solve(b)
    np.testing.assert_allclose(factorize(4 * P, backend, reuse=first).solve(b), x / 4, rtol=1e-15)
    other = problem(3, 1e-3)
    y = factorize(other, backend, reuse=factorize(P, backend)).solve(b[: other.shape[0]])
    np.testing.assert_allclose(other @ y, b[: other.shape[0]], atol=1e-10)


def test_a_factor_raises_once_another_matrix_was_factorised_in_its_place(backend):
    P = problem(3)
    b = right_hand_sides(P.shape[0])
    first = factorize(P, backend)
    second = factorize(4 * P, backend, reuse=first)
    assert second.solve(b).shape == b.shape
    with pytest.raises(RuntimeError, match="solve with that factor"):
        first.solve(b)
    with pytest.raises(FactorisationFailed):
        factorize(-P, backend, reuse=second)
    with pytest.raises(RuntimeError, match="solve with that factor"):  # its memory was written to
        second.solve(b)


def test_entries_of_either_triangle_with_several_rows_a_vertex(backend):
    graph = problem(2).tocsr()
    rng = np.random.default_rng(3)
    dense = np.kron(graph.toarray() != 0, np.ones((2, 2))) * rng.normal(
        size=(2 * graph.shape[0],) * 2
    )
    dense = dense + dense.T + 50 * np.eye(len(dense))
    rows, columns = np.nonzero(np.tril(dense))
    turned = rng.random(len(rows)) < 0.5
    rows, columns = np.where(turned, columns, rows), np.where(turned, rows, columns)
    factor = analyse(Entries(graph, rows, columns, unknowns=2), backend).factorize(
        dense[rows, columns]
    )
    b = right_hand_sides(len(dense))
    np.testing.assert_allclose(factor.solve(b), np.linalg.solve(dense, b), atol=1e-10)


def test_threads_share_the_options_of_cvxopt_and_leave_the_callers_own_alone(monkeypatch):
    """Each thread takes an order, and thereby options, of its own; what they solve is what one alone solves."""
    cholmod = pytest.importorskip("cvxopt.cholmod")
    monkeypatch.setitem(cholmod.options, "supernodal", 0)
    monkeypatch.setitem(cholmod.options, "postorder", False)
    P = problem(4, 1e-3)
    b = right_hand_sides(P.shape[0])
    entries, values = lower_triangle(P)
    alone = analyse(entries, "cvxopt").factorize(values).solve(b)
    seen, failures = [], []

    def work(k):
        try:
            for scale in range(1, 8):
                analysis = analyse(lower_triangle(P, repeated=bool(k % 2))[0], "cvxopt")
                seen.append(
                    np.abs(scale * analysis.factorize(scale * values).solve(b) - alone).max()
                )
        except Exception as error:  # a thread's exceptions are lost
            failures.append(error)

    threads = [threading.Thread(target=work, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not failures
    assert len(seen) == 28
    assert max(seen) < 1e-9 * np.abs(alone).max()
    assert (cholmod.options["supernodal"], cholmod.options["postorder"]) == (0, False)
    assert "nmethods" not in cholmod.options


def test_a_library_that_another_thread_has_just_imported_is_used(monkeypatch):
    """For a moment it is in `sys.modules`, and not yet an attribute of its package."""
    cvxopt = (
        pytest.importorskip("cvxopt.cholmod")
        and pytest.importorskip("cvxopt.amd")
        and sys.modules["cvxopt"]
    )
    for name in ("amd", "cholmod"):
        monkeypatch.delattr(cvxopt, name)
    P = problem(2, 1e-3)
    b = right_hand_sides(P.shape[0])
    np.testing.assert_allclose(P @ factorize(P, "cvxopt").solve(b), b, atol=1e-10)


def test_one_right_hand_side_is_a_column(backend):
    P = problem(3, 1e-3)
    b = right_hand_sides(P.shape[0])
    factor = factorize(P, backend)
    kept = b.copy()
    one = factor.solve(b[:, 0])
    assert one.shape == (P.shape[0],)
    np.testing.assert_allclose(one, factor.solve(b)[:, 0], atol=1e-12)
    assert (b == kept).all()


def test_same_bits_again(backend):
    P = problem(4)
    b = right_hand_sides(P.shape[0])
    assert (factorize(P, backend).solve(b) == factorize(P.copy(), backend).solve(b)).all()


@pytest.mark.parametrize("shift", [1.0, 1e-2])
def test_indefinite_matrices_fail(backend, shift):
    P = problem(4)
    with pytest.raises(FactorisationFailed):
        factorize(P - shift * sp.eye_array(P.shape[0]), backend)


def test_non_finite_matrices_fail(backend):
    P = problem(2)
    P.data[5] = np.nan
    with pytest.raises(FactorisationFailed, match="not finite"):
        factorize(P, backend)


def test_a_backend_is_obeyed_by_every_step(monkeypatch):
    """A map, its polish and another balance, of a body whose map folds."""
    made, factorize = [], factor_module.Analysis.factorize

    def noted(self, values):
        made.append(self.backend)
        return factorize(self, values)

    monkeypatch.setattr(factor_module.Analysis, "factorize", noted)
    v, f = ism.samples.make("octopus", n_vertices=1300)
    method = ism.Auto(backend="scipy", polish="angles")
    result = ism.spherical_conformal_map(v, f, method=method)
    conformal = len(made)
    assert result.rebalance(0.5).backend == result.backend == "scipy"
    assert 1 < conformal < len(made)
    assert set(made) == {"scipy"}


@pytest.mark.posix
def test_a_forked_process_takes_another_solver_than_one_that_would_wait_for_ever():
    """Threads do not come along: rslab's solves in the child would never end."""
    pytest.importorskip("rslab")
    code = """
import os, numpy as np, scipy.sparse as sp
from igl_spheremap.operators.factor.factorize import available_backends, factorize
P = sp.diags_array([np.full(9, -1.0), np.full(10, 4.0), np.full(9, -1.0)], offsets=[-1, 0, 1]).tocsr()
before, b = factorize(P, "rslab"), np.ones((10, 3))
x = before.solve(b)
child = os.fork()
if not child:
    assert "rslab" not in available_backends()
    assert np.allclose(factorize(P).solve(b), x)
    for words, call in (("spawn", lambda: before.solve(b)), ("forked", lambda: factorize(P, "rslab"))):
        try:
            call()
        except (RuntimeError, ValueError) as error:
            assert words in str(error)
        else:
            os._exit(1)
    os._exit(0)
assert os.waitpid(child, 0)[1] == 0
assert np.array_equal(factorize(P, "rslab").solve(b), x)
"""
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


def test_unknown_backend():
    with pytest.raises(ValueError, match="unknown backend 'mumps'"):
        factorize(problem(1), "mumps")


def test_missing_backend(monkeypatch):
    monkeypatch.setattr(factorize_module, "_loads", lambda module: module.startswith("scipy"))
    with pytest.raises(
        ValueError, match=r"needs cvxopt\.cholmod, which is not .*, or choose 'scipy'"
    ):
        factorize(problem(1), "cvxopt")


def test_auto_needs_nothing_but_scipy(monkeypatch):
    monkeypatch.setattr(factorize_module, "_loads", lambda module: module.startswith("scipy"))
    assert available_backends() == ("scipy",)
    assert factorize(problem(2)).backend == "scipy"


def test_wrong_shape_of_right_hand_side():
    with pytest.raises(ValueError, match=r"expected \(12,\) or \(12, k\)"):
        factorize(problem(0)).solve(np.zeros(13))


@pytest.mark.posix
@pytest.mark.parametrize(
    ("megabytes", "status", "words"),
    [(240, 70, "the system lets this process take 2"), (400, 0, ", scipy: ")],
)
def test_a_limit_of_memory_leads_to_a_smaller_solver_or_a_sentence(
    megabytes, status, words, tmp_path
):
    """Else OpenBLAS waits for memory without end at 240 MB, and with faster solvers ends the process at 400."""
    command = (
        f"ulimit -t 20; ulimit -v {megabytes * 1024}; "
        f"exec {sys.executable} -m igl_spheremap map sample:spheroid:n_vertices=500 m.npz"
    )
    environment = {
        name: value for name, value in os.environ.items() if not name.endswith("_NUM_THREADS")
    }
    done = subprocess.run(
        ["sh", "-c", command],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        env=environment,
        check=False,
    )
    assert done.returncode == status, done
    assert words in done.stdout + done.stderr
    assert len(done.stderr.splitlines()) <= 1


def test_solvers_are_chosen_by_the_memory_that_is_left(monkeypatch):
    for left, chosen in ((1e9, available_backends()[0]), (100e6, "scipy")):
        factorize_module._loads.cache_clear()
        monkeypatch.setattr(factorize_module, "bytes_left", lambda left=left: left)
        assert factorize(problem(2)).backend == chosen
    factorize_module._loads.cache_clear()
    monkeypatch.setattr(factorize_module, "bytes_left", lambda: 20e6)
    with pytest.raises(MemoryError, match="libraries need 80; raise the limit"):
        factorize(problem(2))
    factorize_module._loads.cache_clear()


def test_a_solver_whose_library_can_not_be_loaded_is_passed_over(monkeypatch):

    def refuse(module):
        if not module.startswith("scipy"):
            raise ImportError("failed to map segment from shared object")

    factorize_module._loads.cache_clear()
    monkeypatch.setattr(factorize_module, "import_module", refuse)
    try:
        assert factorize(problem(2)).backend == "scipy"
    finally:
        factorize_module._loads.cache_clear()
