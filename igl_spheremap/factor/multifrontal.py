"""A multifrontal Cholesky factorisation in numpy, along the tree of a nested dissection.

Each part of the dissection is a front: a small dense matrix of the part's own unknowns (its pivots) and of
those later ones that they touch (its border). Eliminating the pivots leaves an update of the border, which
is added to the front of the parent. All fronts of a height are independent: those of similar size are
stacked, padded and eliminated together by LAPACK, so that Python's cost is that of some hundred stacks and
not of the unknowns.

References: Duff and Reid (1983), *The Multifrontal Solution of Indefinite Sparse Symmetric Linear
Equations*; Liu (1992), *The Multifrontal Method for Sparse Matrix Solution: Theory and Practice*.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.linalg.lapack import dpotrf, dtrtri
from threadpoolctl import ThreadpoolController

from ..errors import FactorisationFailed
from ..ordering import Dissection, nested_dissection
from .base import Factor

_LEAF = 64
_STACK_ENTRIES = 250_000  # a stack that stays in the cache
_STACK_SPREAD = 1.12  # sizes within a stack: bounds what padding costs
_LARGE_BORDER = 48  # from here on a loop over fronts is cheaper than index arrays for all


@dataclass(frozen=True)
class _Stack:
    """Eliminated fronts of similar size. Padding points to row n."""

    pivots: np.ndarray  # (c, k) rows
    border: np.ndarray  # (c, m) rows
    inverse: np.ndarray  # (c, k, k): of the Cholesky factor of the pivots
    below: np.ndarray  # (c, m, k): the factor's part in the border


class _Level:
    """All fronts of one height: rows, sizes, and where each lies in a buffer of stacked squares."""

    def __init__(self, start: np.ndarray, pivots: np.ndarray, keys: np.ndarray, n: int) -> None:
        self.n, self.start, self.pivots, self.keys = n, start, pivots, keys
        self.parts = len(start)
        self.front, self.rows = np.divmod(keys, n)  # of each border row
        self.border = np.bincount(self.front, minlength=self.parts)
        self.first = np.cumsum(self.border) - self.border
        self.stacks = list(self._stack_up())
        self.offset, self.stride, self.padded, self.stack_of = np.empty((4, self.parts), np.int64)
        self.stack_offset, end = [], 0
        for i, fronts in enumerate(self.stacks):
            k, stride = self._padded_sizes(fronts)
            self.offset[fronts] = end + np.arange(len(fronts)) * stride**2
            self.stride[fronts], self.padded[fronts], self.stack_of[fronts] = stride, k, i
            self.stack_offset.append(end)
            end += len(fronts) * stride**2
        self.entries = end

    def _padded_sizes(self, fronts: np.ndarray) -> tuple[int, int]:
        """Pivots and stride of a stack; the last row and column of a front take what padding writes."""
        k = int(self.pivots[fronts].max())
        return k, k + int(self.border[fronts].max()) + 1

    def _stack_up(self) -> Iterator[np.ndarray]:
        """Split the fronts into stacks of similar size, left children first."""
        size = self.pivots + self.border
        by_size = np.lexsort((self.border, size))
        size = size[by_size]
        i = 0
        while i < self.parts:
            alike = int(np.searchsorted(size, int(_STACK_SPREAD * size[i]) + 4, side="right"))
            j = min(alike, i + max(1, int(_STACK_ENTRIES / (size[i] + 8) ** 2)))
            yield by_size[i:j][np.argsort(by_size[i:j] & 1, kind="stable")]
            i = j

    def local(self, front: np.ndarray, row: np.ndarray, is_pivot: np.ndarray) -> np.ndarray:
        """Index of a row within its front."""
        index = row - self.start[front]
        outside = ~is_pivot
        at = front[outside]
        rank = np.searchsorted(self.keys, at * self.n + row[outside])
        index[outside] = rank - self.first[at] + self.padded[at]
        return index


@dataclass(frozen=True)
class _Entries:
    """Entries of the permuted matrix whose columns are pivots of one height, in the lower triangle."""

    front: np.ndarray
    row: np.ndarray
    column: np.ndarray
    value: np.ndarray
    is_pivot: np.ndarray  # whether the row is a pivot of the front as well


def build(P: sp.csc_matrix) -> Factor:
    """Factorise `P`; raise FactorisationFailed where it is not positive definite."""
    n = P.shape[0]
    rows = P.T  # the same matrix, by rows
    tree = nested_dissection(rows, _LEAF)
    entries = _entries_by_height(rows[tree.order][:, tree.order].tocsr(), tree)
    levels = _symbolic(entries, tree, n)
    blas = ThreadpoolController().select(user_api="blas")
    with blas.limit(limits=1):  # its threads would burn five times the CPU time waiting for each other
        stacks = _eliminate(levels, entries, tree)

    def apply(b: np.ndarray) -> np.ndarray:
        permuted = np.zeros((b.size // n, n + 1))
        permuted[:, :n] = b.reshape(n, -1)[tree.order].T
        with blas.limit(limits=1):
            _substitute(stacks, permuted)
        x = np.empty((n, len(permuted)))
        x[tree.order] = permuted[:, :n].T
        return x.reshape(b.shape)

    return Factor("multifrontal", n, apply, nnz=sum(s.inverse.size + s.below.size for s in stacks))


def _entries_by_height(P: sp.csr_matrix, tree: Dissection) -> list[_Entries]:
    """Split the lower triangle by the height at which its columns are eliminated."""
    rows = np.repeat(np.arange(P.shape[0], dtype=np.int32), np.diff(P.indptr))
    height = tree.height.astype(np.int8)
    rise = height[rows] - height[P.indices]
    lower = np.flatnonzero((rise > 0) | ((rise == 0) & (rows >= P.indices)))
    lower = lower[np.argsort(height[P.indices[lower]], kind="stable")]
    bounds = np.searchsorted(height[P.indices[lower]], np.arange(tree.depth + 2))
    result = []
    for h in range(tree.depth + 1):
        chosen = lower[bounds[h]:bounds[h + 1]]
        column, row = P.indices[chosen].astype(np.int64), rows[chosen].astype(np.int64)
        result.append(_Entries(tree.path[column] >> h, row, column, P.data[chosen], rise[chosen] == 0))
    return result


def _symbolic(entries: list[_Entries], tree: Dissection, n: int) -> list[_Level]:
    """Find the border of each front: what its entries touch, and what its children leave."""
    last = (tree.path | ((np.int64(1) << tree.height) - 1)) * 64 + tree.height
    levels: list[_Level] = []
    for h, e in enumerate(entries):
        mine = (((np.arange(1 << (tree.depth - h)) + 1) << h) - 1) * 64 + h
        start = np.searchsorted(last, mine)
        keys = e.front[~e.is_pivot] * n + e.row[~e.is_pivot]
        if h > 0:
            child = levels[-1]
            left = tree.height[child.rows] > h
            keys = np.concatenate([keys, (child.front[left] >> 1) * n + child.rows[left]])
        levels.append(_Level(start, np.searchsorted(last, mine, side="right") - start, np.unique(keys), n))
    return levels


def _eliminate(levels: list[_Level], entries: list[_Entries], tree: Dissection) -> list[_Stack]:
    """Eliminate level by level, from the leaves up."""
    result = []
    fronts = np.empty(0)
    for h, (level, e) in enumerate(zip(levels, entries, strict=True)):
        target = level.offset[e.front] + level.local(e.front, e.row, e.is_pivot) * level.stride[e.front]
        target += e.column - level.start[e.front]
        is_root = h == tree.depth
        parent = None if is_root else levels[h + 1]
        parent_fronts = np.zeros(0 if parent is None else parent.entries)
        index = level.rows if parent is None else parent.local(level.front >> 1, level.rows,
                                                               tree.height[level.rows] == h + 1)
        if h > 0:
            fronts[target] += e.value
            stacked: Iterator[np.ndarray] = (fronts[i:i + size] for i, size in _extents(level))
        else:
            stacked = _assemble_leaves(level, e, target)
        for members, front in zip(level.stacks, stacked, strict=True):
            stack, update, to_parent = _eliminate_stack(level, members, front, index)
            result.append(stack)
            if parent is not None and update.shape[1]:
                _extend_add(parent, members, update, to_parent, parent_fronts)
        fronts = parent_fronts
    return result


def _extents(level: _Level) -> Iterator[tuple[int, int]]:
    """Offset and number of entries of each stack."""
    return zip(level.stack_offset, np.diff([*level.stack_offset, level.entries]).tolist(), strict=True)


def _assemble_leaves(level: _Level, e: _Entries, target: np.ndarray) -> Iterator[np.ndarray]:
    """The leaves' fronts, which need no update and much room, one stack at a time in the same buffer."""
    stack = level.stack_of[e.front].astype(np.int32)
    order = np.argsort(stack, kind="stable")
    bounds = np.searchsorted(stack[order], np.arange(len(level.stacks) + 1))
    target, value = target[order], e.value[order]
    buffer = np.empty(max(size for _, size in _extents(level)))
    for i, (offset, size) in enumerate(_extents(level)):
        these = slice(bounds[i], bounds[i + 1])
        buffer[:size] = 0.0
        buffer[target[these] - offset] = value[these]
        yield buffer[:size]


def _eliminate_stack(
    level: _Level, members: np.ndarray, flat: np.ndarray, index: np.ndarray
) -> tuple[_Stack, np.ndarray, np.ndarray]:
    """Eliminate the pivots of a stack; return it, the updates, and the borders' places in the parents."""
    k, stride = level._padded_sizes(members)
    front = flat.reshape(len(members), stride, stride)
    is_padding = np.arange(k) >= level.pivots[members, None]
    which, pivot = np.nonzero(is_padding)
    front[which, pivot, pivot] = 1.0
    inverse = np.empty((len(members), k, k))
    for i in range(len(members) if k else 0):
        upper, info = dpotrf(front[i, :k, :k].T, lower=0)
        if info != 0:
            raise FactorisationFailed("multifrontal: the matrix is not positive definite")
        inverse[i] = dtrtri(upper, lower=0, overwrite_c=1)[0].T
    below = front[:, k:-1, :k] @ inverse.transpose(0, 2, 1)
    update = below @ below.transpose(0, 2, 1)
    np.subtract(front[:, k:-1, k:-1], update, out=update)

    pivots = np.where(is_padding, level.n, level.start[members, None] + np.arange(k))
    place = np.arange(stride - 1 - k)
    is_padding = place >= level.border[members, None]
    place = np.minimum(level.first[members, None] + place, max(len(level.rows) - 1, 0))
    border = np.where(is_padding, level.n, level.rows[place]) if place.size else place
    to_parent = np.where(is_padding, -1, index[place]) if place.size else place
    return _Stack(pivots, border, inverse, below), update, to_parent


def _extend_add(
    parent: _Level, members: np.ndarray, update: np.ndarray, to_parent: np.ndarray, fronts: np.ndarray
) -> None:
    """Add the updates to the parents' fronts; left children first, for siblings may share a target."""
    above, m = members >> 1, update.shape[1]
    offset, stride = parent.offset[above], parent.stride[above]
    to_parent = np.where(to_parent < 0, stride[:, None] - 1, to_parent)
    if m < _LARGE_BORDER:
        middle = int(np.count_nonzero(members & 1 == 0))
        for side in (slice(0, middle), slice(middle, len(members))):
            rows = offset[side, None] + to_parent[side] * stride[side, None]
            fronts[(rows[:, :, None] + to_parent[side, None, :]).reshape(-1)] += update[side].reshape(-1)
        return
    padded = np.zeros((m + 1, m + 1))  # its last row and column are what the other rows of the parent receive
    for i, (begin, size) in enumerate(zip(offset.tolist(), stride.tolist(), strict=True)):
        source = np.full(size, m)
        source[to_parent[i]] = np.arange(m)
        source[-1] = m
        padded[:m, :m] = update[i]
        target = fronts[begin:begin + size**2].reshape(size, size)
        target += padded.take(source, axis=0).take(source, axis=1)


def _substitute(stacks: list[_Stack], b: np.ndarray) -> None:
    """Solve in place for the rows of `b`, (r, n + 1), whose last column serves padding."""
    halfway = []
    for s in stacks:
        y = np.matmul(s.inverse[:, None], _gather(b, s.pivots))
        halfway.append(y)
        if s.border.size:
            spill = np.matmul(s.below[:, None], y)[..., 0]
            for i in range(len(b)):
                np.subtract.at(b[i], s.border.reshape(-1), spill[:, i].reshape(-1))
    b[:, -1] = 0.0
    for s, y in zip(reversed(stacks), reversed(halfway), strict=True):
        if s.border.size:
            y -= np.matmul(s.below.transpose(0, 2, 1)[:, None], _gather(b, s.border))
        x = np.matmul(s.inverse.transpose(0, 2, 1)[:, None], y)[..., 0]
        b[:, s.pivots] = x.transpose(1, 0, 2)
        b[:, -1] = 0.0


def _gather(b: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Columns of `b` as stacked vectors, (c, r, k, 1): BLAS is best at matrix times vector here."""
    return np.ascontiguousarray(b[:, rows].transpose(1, 0, 2))[..., None]
