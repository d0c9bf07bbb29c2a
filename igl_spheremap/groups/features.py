"""Data over the vertices of a group's members, in files that are read where and when they are needed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import MeshError
from ..io.scalars import read_named
from ..mesh.arrays import FloatArray


class FeatureFiles:
    """Columns (n, k) over the vertices of one surface, a file each, which are read when an array is asked for.

    So they take the place of an array, and a worker reads those of its own member only.
    """

    def __init__(self, paths: Sequence[str]) -> None:
        self._paths = tuple(paths)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        columns = [_column(path) for path in self._paths]
        for path, column in zip(self._paths, columns, strict=True):
            if len(column) != len(columns[0]):
                raise MeshError(f"{path} has {len(column)} values and {self._paths[0]} has {len(columns[0])}; give "
                                "data of one mesh")
        return np.stack(columns, axis=1).astype(dtype or np.float64)


def _column(path: str) -> FloatArray:
    maps = read_named(path)
    if len(maps) != 1:
        raise MeshError(f"{path} holds {len(maps)} maps ({', '.join(list(maps)[:5])}); take one of them by FILE:NAME")
    return next(iter(maps.values()))
