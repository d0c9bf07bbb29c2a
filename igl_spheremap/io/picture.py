"""Pictures as PNG files."""

from __future__ import annotations

import os

import numpy as np
from numpy.typing import NDArray

from ..errors import import_optional
from .replacing import replacing


def write_picture(path: str | os.PathLike[str], image: NDArray[np.uint8], *, force: bool = False) -> None:
    """Write an image (height, width, 3), rows from above."""
    pillow = import_optional("PIL.Image", "writing a picture", "io")
    with replacing(path, force) as partial:
        pillow.fromarray(image).save(partial, format="png")
