"""The array of a NIfTI or MGH file, by nibabel."""

from __future__ import annotations

import math
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import import_optional
from .reading import check_complete


def array_behind(header: Any, content: bytes) -> NDArray[Any]:
    """The array that a header describes; nibabel would take memory for as much as it announces."""
    announced = math.prod(header.get_data_shape()) * header.get_data_dtype().itemsize
    check_complete(announced <= len(content), f"{len(content)} bytes", str(announced))
    proxy = import_optional("nibabel.arrayproxy", "images", "io").ArrayProxy
    return np.asanyarray(proxy(BytesIO(content), header))
