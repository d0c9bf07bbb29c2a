"""Exact factors of sparse symmetric positive definite matrices: their interface, and a class for each library.

An `Analysis` is the symbolic factorisation of a sparsity pattern: it orders the unknowns and allocates the factor. Then
it factorises one matrix of that pattern after the other.
"""

from __future__ import annotations

import os
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

import numpy as np
import scipy.sparse as sp

from ...errors import FactorisationFailed
from ...mesh.arrays import HALF_DIGITS
from ...timings import phase
from .ordering import Numbering, bandwidth_order, inverse_permutation, nested_dissection

Solver = Callable[[np.ndarray], np.ndarray]

#: cvxopt has one set of options for all threads.
_OPTIONS = threading.Lock()


@dataclass(frozen=True, eq=False)
class Entries:
    """The sparsity pattern of symmetric matrices that have the same number of rows for each vertex of a graph.

    Attributes
    ----------
    graph : (n, n) csr_matrix
        Symmetric pattern of the vertices, with a full diagonal; its values don't matter.
    rows, columns : (e,) int arrays
        Row and column of each entry, once; row r belongs to vertex ``r // unknowns``.
    mirrored : bool
        Whether both (i, j) and (j, i) are among them; else only one of the two is.
    unknowns : int
        Rows for each vertex.
    repeated : bool
        Whether many matrices of the pattern follow: a library may search longer for an order.
    limbs : bool
        Whether the graph has narrow limbs, on which minimum degree fills less than a dissection.
    numbering : callable
        Numbers the vertices of the graph before an order is sought, which breaks ties by these numbers.
    """

    graph: sp.csr_matrix
    rows: np.ndarray
    columns: np.ndarray
    mirrored: bool = False
    unknowns: int = 1
    repeated: bool = False
    limbs: bool = False
    numbering: Numbering = bandwidth_order

    @classmethod
    def of(cls, P: sp.csr_matrix, numbering: Numbering = bandwidth_order) -> Entries:
        """All entries of a matrix."""
        columns = np.arange(P.shape[0], dtype=P.indices.dtype).repeat(np.diff(P.indptr))
        return cls(P, P.indices, columns, mirrored=True, numbering=numbering)

    def are_of(self, P: sp.csr_matrix) -> bool:
        """Whether they are all entries of a matrix."""
        return self.mirrored and np.array_equal(self.rows, P.indices)

    @property
    def n(self) -> int:
        """Rows of the matrices."""
        return self.unknowns * int(self.graph.shape[0])

    def expanded(self, order: np.ndarray) -> np.ndarray:
        """Order of the rows from one of the vertices."""
        if self.unknowns == 1:
            return order
        return (
            self.unknowns * order[:, None] + np.arange(self.unknowns, dtype=order.dtype)
        ).ravel()

    def lower(self, order: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rows and columns of the lower triangle of the reordered matrix, and the numbers of their entries."""
        rank = inverse_permutation(order)
        rows, columns = rank.take(self.rows), rank.take(self.columns)
        if not self.mirrored:
            return np.maximum(rows, columns), np.minimum(rows, columns), np.arange(len(rows))
        lower = np.flatnonzero(rows >= columns)
        return rows.take(lower), columns.take(lower), lower

    def full(self, order: np.ndarray) -> tuple[sp.csc_matrix, np.ndarray]:
        """The reordered matrix, both triangles, with zeros as values, and the number of each value's entry."""
        rank = inverse_permutation(order)
        rows, columns = rank.take(self.rows), rank.take(self.columns)
        numbers = np.arange(1, len(rows) + 1)
        if not self.mirrored:
            off = np.flatnonzero(rows != columns)
            rows, columns = np.append(rows, columns[off]), np.append(columns, rows[off])
            numbers = np.append(numbers, numbers[off])
        A = sp.csc_matrix((numbers, (rows, columns)), shape=(self.n, self.n))
        entry = A.data - 1
        A.data = np.zeros(len(entry))
        return A, entry


class Analysis(ABC):
    """An order and room for the factors of one pattern, one at a time."""

    backend: ClassVar[str]
    factorised = 0  # matrices so far

    def __init__(self, entries: Entries) -> None:
        self.entries = entries

    @classmethod
    def waits(cls) -> bool:
        """Whether its library would wait for ever in this process."""
        return False

    @abstractmethod
    def _numeric(self, values: np.ndarray) -> tuple[np.ndarray, Solver]:
        """Order and solver of the reordered matrix with these entries, whose i-th row is row ``order[i]`` of P."""

    @phase("factorisation")
    def factorize(self, values: np.ndarray) -> Factor:
        """Factor of a matrix with these entries. It replaces the factor before, whose further use raises.

        Raises FactorisationFailed for a matrix that is not finite, or not numerically positive definite. SuperLU does
        not see the latter.
        """
        if not np.isfinite(values).all():
            raise FactorisationFailed("the matrix has entries that are not finite")
        self.factorised += 1
        order, solver = self._numeric(values)
        return Factor(self, self.factorised, order, inverse_permutation(order), solver)


@dataclass(frozen=True, eq=False)
class Factor:
    """The inverse of a symmetric positive definite matrix."""

    analysis: Analysis
    number: int  # matrices that the analysis has factorised, up to this one
    order: np.ndarray
    rank: np.ndarray
    solver: Solver

    @property
    def backend(self) -> str:
        """Name of the solver."""
        return self.analysis.backend

    @phase("solves")
    def solve(self, b: np.ndarray) -> np.ndarray:
        """``P^-1 b`` for right-hand sides in the columns of an (n,) or (n, k) array.

        Raises a RuntimeError once another matrix was factorised in its place.
        """
        b, n = np.asarray(b, dtype=np.float64), len(self.order)
        if b.ndim not in (1, 2) or b.shape[0] != n:
            raise ValueError(f"right-hand side has shape {b.shape}; expected ({n},) or ({n}, k)")
        if self.number != self.analysis.factorised:
            raise RuntimeError(
                "another matrix was factorised in the place of this factor; solve with that factor"
            )
        x = np.empty_like(b)
        x.T[...] = self.solver(b.T.take(self.order, axis=-1).T).T.take(self.rank, axis=-1)
        return x


class Cholmod(Analysis):
    """CHOLMOD through cvxopt, with wheels for every system, under the GPL."""

    backend: ClassVar[str] = "cvxopt"
    #: Unknowns from which on it takes nested dissection: no slower than minimum degree, and less fill.
    dissects_from: ClassVar[int] = 100_000

    def __init__(self, entries: Entries) -> None:
        import cvxopt

        # cvxopt.cholmod is set a moment after another thread has imported it
        from cvxopt import cholmod

        super().__init__(entries)
        self._cvxopt: Any = cvxopt
        self._cholmod: Any = cholmod
        vertices, tried = self._order_of_vertices()
        given = {}
        if tried:
            given = {"p": cvxopt.matrix(np.arange(entries.n))}
        self._order = entries.expanded(vertices)
        self._A = self._matrix(*entries.lower(self._order), entries.n)
        self._entry = np.asarray(self._A.V, dtype=np.int64).ravel()  # cvxopt sorts by columns
        with self._options(nmethods=tried):
            self._symbolic = cholmod.symbolic(self._A, **given)

    def _order_of_vertices(self) -> tuple[np.ndarray, int]:
        """An order, and the number of orders to try, this one first; 0 leaves the choice to CHOLMOD."""
        from cvxopt import amd

        graph, tried = self.entries.graph, 1
        if self.entries.n >= self.dissects_from:
            if self.entries.repeated:
                tried = 2
            return nested_dissection(graph, self.entries.numbering).order, tried
        vertices = self.entries.numbering(graph)
        if self.entries.unknowns == 1:
            return vertices, 0
        # minimum degree on the vertices' graph: a quarter of the entries, the same fill
        half = self._matrix(*Entries.of(graph).lower(vertices), len(vertices))
        return vertices[np.asarray(amd.order(half)).ravel()], tried

    def _matrix(self, rows: np.ndarray, columns: np.ndarray, values: np.ndarray, n: int) -> Any:
        A = sp.coo_matrix((values.astype(np.float64), (rows, columns)), shape=(n, n))
        A.has_canonical_format = True  # no entry twice
        # in order of columns: cvxopt takes half of the time
        A, matrix = A.tocsc(), self._cvxopt.matrix
        columns = np.arange(n).repeat(np.diff(A.indptr))
        return self._cvxopt.spmatrix(
            matrix(A.data), matrix(A.indices.astype(np.int64)), matrix(columns), (n, n)
        )

    @contextmanager
    def _options(self, **options: int) -> Iterator[None]:
        """Options of CHOLMOD while one thread uses it; the caller's own are restored."""
        current = self._cholmod.options
        with _OPTIONS:
            before = dict(current)
            current.update(supernodal=2, **options)
            try:
                yield
            finally:
                current.clear()
                current.update(before)

    def _numeric(self, values: np.ndarray) -> tuple[np.ndarray, Solver]:
        self._A.V = self._cvxopt.matrix(values.take(self._entry))
        try:
            with self._options():
                self._cholmod.numeric(self._A, self._symbolic)
        except ArithmeticError as error:
            raise FactorisationFailed(f"CHOLMOD: not positive definite ({error})") from error
        except MemoryError as error:  # rows of a hundred thousand entries fill the factor
            raise FactorisationFailed("CHOLMOD: the factor does not fit into memory") from error
        return self._order, self._solve

    def _solve(self, b: np.ndarray) -> np.ndarray:
        matrix = self._cvxopt.matrix
        with self._options():
            if b.size == len(b):
                x = matrix(b)
                self._cholmod.solve(self._symbolic, x)
            # sparse right-hand sides go through the factor four at a time: a third of the time
            else:
                x = matrix(
                    self._cholmod.spsolve(
                        self._symbolic, self._cvxopt.sparse(matrix(np.asfortranarray(b)))
                    )
                )
        return np.asarray(x).reshape(b.shape)


class Rslab(Analysis):
    """The LDL^T factorisation of rslab, under the MIT licence; its bits don't depend on the number of threads."""

    backend: ClassVar[str] = "rslab"
    _process: ClassVar[int | None] = None

    def __init__(self, entries: Entries) -> None:
        import rslab

        super().__init__(entries)
        self._order = entries.expanded(entries.numbering(entries.graph))
        rows, columns, numbers = entries.lower(self._order)
        A = sp.csc_matrix((numbers + 1.0, (rows, columns)), shape=(entries.n, entries.n))
        self._entry = A.data.astype(np.int64) - 1
        # least fill; positive definite matrices need no scaling
        self._symbolic = rslab.analyze(
            A, path="ldlt", ordering="amf", scaling="identity", threads=1
        )

    @classmethod
    def waits(cls) -> bool:
        """Whether this process was forked from one that solved: it lacks the threads that solves wait for."""
        return cls._process not in (None, os.getpid())

    def _numeric(self, values: np.ndarray) -> tuple[np.ndarray, Solver]:
        try:
            factor = self._symbolic.factor(values.take(self._entry))
        except RuntimeError as error:
            raise FactorisationFailed(f"rslab: {error}") from error
        if factor.inertia[0] < factor.n:
            raise FactorisationFailed("rslab: the matrix is not numerically positive definite")
        return self._order, partial(self._solve, factor)

    def _solve(self, factor: Any, b: np.ndarray) -> np.ndarray:
        if self.waits():
            raise RuntimeError(
                "rslab can't solve in a process that was forked from one where it did: start processes by spawn, or "
                "give another backend"
            )
        Rslab._process = os.getpid()
        if b.ndim == 1:
            return np.asarray(factor.solve(b))
        return np.asarray(factor.solve_many(np.ascontiguousarray(b)))


class SuperLU(Analysis):
    """SuperLU as it comes with scipy, in symmetric mode without pivoting: as good as a Cholesky factorisation.

    Minimum degree breaks ties by index: in a mesh's own order, as on bodies with spikes, it can make twenty times the
    fill.
    """

    backend: ClassVar[str] = "scipy"
    #: Unknowns from which on it takes nested dissection: below, minimum degree costs less.
    dissects_from: ClassVar[int] = 40_000

    def __init__(self, entries: Entries) -> None:
        from scipy.sparse.linalg import splu

        super().__init__(entries)
        self._splu = splu
        small = entries.n < self.dissects_from
        if small and (entries.limbs or not entries.repeated):
            vertices, self._rule = entries.numbering(entries.graph), "MMD_AT_PLUS_A"
        else:
            vertices = nested_dissection(entries.graph, entries.numbering).order
            self._rule = "NATURAL"
        self._order = entries.expanded(vertices)
        self._A, self._entry = entries.full(self._order)

    def _numeric(self, values: np.ndarray) -> tuple[np.ndarray, Solver]:
        self._A.data = values.take(self._entry)
        try:
            lu = self._splu(
                self._A,
                permc_spec=self._rule,
                diag_pivot_thresh=0.0,
                options={"SymmetricMode": True, "Equil": False},
            )
        except RuntimeError as error:
            raise FactorisationFailed(f"SuperLU: {error}") from error
        order = self._order
        # keep the order found: SuperLU would search for it every time
        if self.entries.repeated and self._rule != "NATURAL":
            self._order, self._rule = self._order[np.argsort(lu.perm_c)], "NATURAL"
            self._A, self._entry = self.entries.full(self._order)
        return order, lu.solve


def check_definite(P: sp.csr_matrix, factor: Factor) -> None:
    """SuperLU factorises indefinite matrices without an error: try the inverse on three right-hand sides."""
    i = np.arange(P.shape[0], dtype=np.float64)
    # the last: all directions
    b = np.stack([np.ones_like(i), np.cos(i), np.cos(i**2 % 1009.0)], axis=1)
    x = factor.solve(b)
    backward_error = np.abs(P @ x - b).max() / (np.abs(P.data).max() * np.abs(x).max() + 1.0)
    if not ((b * x).sum(axis=0) > 0.0).all() or not backward_error < HALF_DIGITS:
        raise FactorisationFailed("SuperLU: the matrix is not numerically positive definite")
