"""Data over the vertices of a group's members, in files that are read where and when they are needed."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import MeshError
from ..io.scalars import read_named
from ..mesh.arrays import FloatArray


@dataclass(frozen=True)
class FeatureFiles:
    """Columns (n, k) over the vertices of one surface, a file each, which are read when an array is asked for.

    So they take the place of an array, and a worker reads those of its own member only.
    """

    paths: tuple[str, ...]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        columns = [_column(path) for path in self.paths]
        for path, column in zip(self.paths, columns, strict=True):
            if len(column) != len(columns[0]):
                raise MeshError(f"{path} has {len(column)} values and {self.paths[0]} has {len(columns[0])}; give "
                                "data of one mesh")
        return np.stack(columns, axis=1).astype(dtype or np.float64)


def file_of(path: str) -> str:
    """The file of FILE:NAME.

    >>> file_of("sub-01.npz:thickness")
    'sub-01.npz'
    """
    return path if Path(path).exists() else path.rpartition(":")[0] or path


def _column(path: str) -> FloatArray:
    maps = read_named(path)
    if len(maps) != 1:
        raise MeshError(f"{path} holds {len(maps)} maps ({', '.join(list(maps)[:5])}); take one of them by FILE:NAME")
    return next(iter(maps.values()))
