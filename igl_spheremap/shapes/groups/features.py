"""Data over the vertices of a group's members, in files that are read when needed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...errors import MeshError, check_list
from ...io.scalars import read_named
from ...mesh.arrays import AnyArray, FloatArray, plain_array


@dataclass(frozen=True)
class FeatureFiles:
    """Columns (n, k) over the vertices of one surface, a file each, which conversion to an array reads.

    So they take the place of an array, and a worker reads those of its own member only.
    """

    paths: tuple[str, ...]

    def __array__(self, dtype: Any = np.float64, copy: bool | None = None) -> AnyArray:
        columns = [_column(path) for path in self.paths]
        for path, column in zip(self.paths, columns, strict=True):
            if len(column) != len(columns[0]):
                raise MeshError(
                    f"{path} has {len(column)} values and {self.paths[0]} has {len(columns[0])}; give "
                    "data of one mesh"
                )
        return np.stack(columns, axis=1).astype(dtype)


def check_features(features: Sequence[ArrayLike] | None, names: Sequence[str]) -> None:
    """Unless each of the surfaces has features, and all have the same columns, raise an error."""
    if features is None:
        return
    features = check_list(features, "features")
    if len(features) != len(names):
        raise ValueError(
            f"features are of {len(features)} surfaces, sources are {len(names)}; give one for each"
        )
    widths = []
    for name, each in zip(names, features, strict=True):
        shape: tuple[int, ...]
        if isinstance(each, FeatureFiles):
            shape = 0, len(each.paths)
        else:
            shape = plain_array(each, "features").shape
        if len(shape) not in (1, 2):
            raise MeshError(
                f"features of surface {name} have shape {shape}; give data over its vertices, (n,) or "
                "(n, k)"
            )
        widths.append((*shape, 1)[1])
        if widths[-1] != widths[0]:
            raise MeshError(
                f"features of surface {name} have {widths[-1]} columns, those of {names[0]} have "
                f"{widths[0]}; give the same ones of each"
            )


def _column(path: str) -> FloatArray:
    maps = read_named(path)
    if len(maps) != 1:
        raise MeshError(
            f"{path} holds {len(maps)} maps ({', '.join(list(maps)[:5])}); take one of them by FILE:NAME"
        )
    return next(iter(maps.values()))
