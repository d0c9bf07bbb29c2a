"""Pictures."""

from __future__ import annotations

import os

import numpy as np
from numpy.typing import NDArray

from ..errors import FileError, import_optional
from .replacing import replacing


def read_picture(path: str | os.PathLike[str]) -> NDArray[np.uint8]:
    """An image (height, width, 3) of any format that pillow knows, rows from above."""
    pillow = import_optional("PIL.Image", "a picture", "io")
    try:
        with pillow.open(path) as image:
            return np.asarray(image.convert("RGB"))
    except OSError as error:  # an unknown format, too
        raise FileError(f"can't read {path} as a picture: {error.strerror or error}") from None


def write_picture(path: str | os.PathLike[str], image: NDArray[np.uint8], *, force: bool = False) -> None:
    """Write an image (height, width, 3), rows from above."""
    pillow = import_optional("PIL.Image", "writing a picture", "io")
    with replacing(path, force) as partial:
        pillow.fromarray(image).save(partial, format="png")
