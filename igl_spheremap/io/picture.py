"""Pictures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..errors import FileError, import_optional
from .reading import check_regular
from .records import PathLike
from .replacing import replacing


def read_picture(path: PathLike) -> NDArray[np.uint8]:
    """An image (height, width, 3) of any format that pillow knows, rows from above."""
    pillow = import_optional("PIL.Image", "a picture", "io")
    try:
        check_regular(Path(path))
        with pillow.open(path) as image:
            return np.asarray(image.convert("RGB"))
    except FileError:
        raise
    except Exception as error:  # pillow raises many kinds on damaged or huge pictures
        raise FileError(f"can't read {path} as a picture: {getattr(error, 'strerror', None) or error}") from None


def write_picture(path: PathLike, image: NDArray[np.uint8], *, force: bool = False) -> None:
    """Write an image (height, width, 3), rows from above."""
    pillow = import_optional("PIL.Image", "writing a picture", "io")
    with replacing(path, force) as partial:
        pillow.fromarray(image).save(partial, format="png")
