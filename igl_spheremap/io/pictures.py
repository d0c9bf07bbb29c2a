"""Pictures in files: read as pictures only and bounded in pixels, written as PNG."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

import numpy as np

from ..draw.markup import png
from ..errors import FileError, import_optional
from ..gate import PathLike
from ..mesh.arrays import PixelArray
from .reading import PARSER_ERRORS, opening
from .replacing import replacing

#: The formats that hold pictures and nothing else: for EPS pillow would start Ghostscript.
_FORMATS = ("PNG", "JPEG", "WEBP", "TIFF", "BMP", "GIF", "PPM", "TGA")
#: Pixels, as of 8192 x 8192: a picture of one colour takes a few kB in its file and this 3 times in memory.
MOST_PIXELS = 1 << 26


def read_picture(path: PathLike) -> PixelArray:
    """An image (height, width, 3) of PNG, JPEG, WebP, TIFF, BMP, GIF, PPM or TGA, rows from above."""
    with opening(path):
        return picture(Path(path).read_bytes(), str(path))


def picture(content: bytes, name: str) -> PixelArray:
    """The image that a file holds; an error says `name`."""
    pillow = import_optional("PIL.Image", "a picture", "io")
    try:
        with pillow.open(BytesIO(content), formats=_FORMATS) as image:
            if image.width * image.height > MOST_PIXELS:
                raise FileError(
                    f"can't read {name}: {image.width} x {image.height} pixels, where {MOST_PIXELS:,} are "
                    "the most; make it smaller"
                )
            return np.asarray(image.convert("RGB"))
    except (FileError, TimeoutError):
        raise
    except (pillow.DecompressionBombError, *PARSER_ERRORS) as error:
        raise FileError(f"can't read {name} as a picture: {error}") from None


def write_picture(path: PathLike, image: PixelArray, *, force: bool = False) -> None:
    """Write an image (height, width, 3), rows from above; `force` as of `replacing`."""
    with replacing(path, force) as partial:
        partial.write_bytes(png(image))
