"""Pictures one after another: an animated GIF, an MP4, or a folder of PNGs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...draw.palette import FOLDED
from ...errors import FileError, import_optional
from ...io.replacing import check_writable, replacing

Picture = NDArray[np.uint8]
#: Takes a picture and how often it is shown.
Write = Callable[[Picture, int], None]


def check_video(path: Path) -> None:
    """Raise a FileError before the work starts if a video can't be written."""
    if path.suffix.lower() in (".gif", ".mp4"):
        check_writable(path, force=True)
    elif path.exists() and not path.is_dir():
        raise FileError(f"{path}: a video is a .gif or .mp4 file, or a folder")
    if path.suffix.lower() == ".mp4":
        import_optional("imageio_ffmpeg", "an MP4 video", "video")
    else:
        import_optional("PIL.Image", "a video", "io")


@contextmanager
def open_video(path: Path, rate: int) -> Iterator[Write]:
    """A function that adds pictures to a file, at `rate` a second; the ending of `path` chooses the format."""
    formats = {".gif": _gif, ".mp4": _mp4}
    kind = formats.get(path.suffix.lower())
    if kind is None:
        with _folder(path) as write:
            yield write
    else:
        with replacing(path, force=True) as partial, kind(partial, rate) as write:
            yield write


@contextmanager
def _gif(path: Path, rate: int) -> Iterator[Write]:
    images = import_optional("PIL.Image", "a video", "io")
    frames: list[Any] = []
    durations: list[int] = []

    def write(picture: Picture, times: int) -> None:
        frames.append(_reduced(images, picture))
        durations.append(times * 1000 // rate)

    yield write
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=durations, loop=0, disposal=1)


def _reduced(images: Any, picture: Picture) -> Any:
    """A picture in 255 colours and that of folded faces, which a palette chosen by area would lose."""
    image = images.fromarray(picture)
    chosen = image.quantize(255, method=images.Quantize.FASTOCTREE, dither=images.Dither.NONE).getpalette()
    palette = images.new("P", (1, 1))
    palette.putpalette([*chosen[: 3 * 255], *(round(255 * c) for c in FOLDED)])
    return image.quantize(palette=palette, dither=images.Dither.NONE)


@contextmanager
def _mp4(path: Path, rate: int) -> Iterator[Write]:
    ffmpeg = import_optional("imageio_ffmpeg", "an MP4 video", "video")
    stream: Any = None

    def write(picture: Picture, times: int) -> None:
        nonlocal stream
        even = np.ascontiguousarray(picture[: picture.shape[0] // 2 * 2, : picture.shape[1] // 2 * 2])
        if stream is None:
            stream = ffmpeg.write_frames(str(path), even.shape[1::-1], fps=rate, macro_block_size=2)
            stream.send(None)
        for _ in range(times):
            stream.send(even)

    yield write
    if stream is not None:
        stream.close()


@contextmanager
def _folder(path: Path) -> Iterator[Write]:
    images = import_optional("PIL.Image", "a video", "io")
    path.mkdir(parents=True, exist_ok=True)
    count = 0

    def write(picture: Picture, times: int) -> None:
        nonlocal count
        images.fromarray(picture).save(path / f"{count:05d}.png")
        count += 1

    yield write
    for left in path.glob("[0-9][0-9][0-9][0-9][0-9].png"):
        if int(left.stem) >= count:  # of a longer video that was here
            left.unlink()
