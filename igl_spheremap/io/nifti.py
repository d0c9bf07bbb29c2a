"""NIfTI and MGH files, by nibabel."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator
from io import BytesIO
from typing import Any

import numpy as np

from ..errors import import_optional
from ..mesh.arrays import AnyArray
from .reading import check_complete


@contextlib.contextmanager
def nibabel_for(user: str) -> Iterator[Any]:
    """The package, whose own errors on damaged headers become those that all parsers raise."""
    nibabel = import_optional("nibabel", user, "io")
    try:
        yield nibabel
    except (
        nibabel.spatialimages.HeaderDataError,
        nibabel.wrapstruct.WrapStructError,
        nibabel.cifti2.Cifti2HeaderError,
    ) as error:
        raise ValueError(str(error)) from error


def array_behind(header: Any, content: bytes) -> AnyArray:
    """The array that a header describes; nibabel would take memory for as much as it announces."""
    announced = math.prod(header.get_data_shape()) * header.get_data_dtype().itemsize
    check_complete(announced <= len(content), f"{len(content)} bytes", str(announced))
    proxy = import_optional("nibabel.arrayproxy", "images", "io").ArrayProxy
    return np.asanyarray(proxy(BytesIO(content), header))
