"""What a program with a picture is, its panel, and the ways to run it: in a window, as a picture, as a video."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...draw.palette import FOLDED
from ...errors import DisplayError, FileError, import_optional
from ...io.replacing import check_writable, replacing
from . import window
from .choices import SUBJECTS
from .stage import Stage
from .window import imgui, implot, ps

#: Frames a second of a video; a stop is shown for a whole second.
RATE = 20


class App:
    """A picture that has frames and a panel. Demos derive from it."""

    stage: Stage

    def prepare(self) -> None:
        """Finish what runs in the background, for pictures without a window."""

    def frames(self) -> int:
        """Number of frames that there are now."""
        return 1

    def last_frame(self) -> int:
        """The frame that a picture shows if none is asked for."""
        return self.frames() - 1

    def stops(self) -> list[int]:
        """Frames that a video holds for a second."""
        return []

    def go_to(self, frame: int) -> None:
        """Show a frame, from 0."""

    def facts(self) -> dict[str, Any]:
        """Figures of the frame that is shown, for JSON."""
        return {}

    def tick(self) -> None:
        """Move on, once for every picture of a window; never called without one."""

    def panel(self) -> None:
        """Draw what is not on the stage: widgets and plots."""

    def close(self) -> None:
        """End what runs in the background."""


def open_for(args: Namespace, title: str) -> None:
    """Start polyscope as the arguments ask, or raise a DisplayError, before anything is computed."""
    offscreen = bool(args.screenshot or args.video)
    if args.screenshot:
        window.check_picture(args.screenshot)
    if args.video:
        check_video(Path(args.video))
    try:
        window.open_window(title, tuple(args.size), offscreen)
    except DisplayError as error:
        hint = "" if offscreen else " (--screenshot OUT.png, --video OUT.gif)"
        raise DisplayError(f"{error}{hint}") from None


def run_app(app: App, args: Namespace) -> list[dict[str, Any]]:
    """Run an app as the arguments ask, and return the facts of each picture that was written."""
    try:
        if not (args.screenshot or args.video):
            show_app(app)
            return []
        app.prepare()
        ps.set_user_callback(lambda: draw_app(app))
        shown = []
        if args.screenshot:
            app.go_to(_frame(app, args.frame))
            window.save(args.screenshot)
            shown.append(app.facts())
        if args.video:
            shown += _video(app, Path(args.video), args.length)
        return shown
    finally:
        ps.clear_user_callback()
        app.close()


def show_app(app: App) -> None:
    """Run the window until it is closed."""
    window.show(lambda: _live(app))


def _live(app: App) -> None:
    app.tick()
    app.stage.mouse()
    draw_app(app)


def draw_app(app: App) -> None:
    """Draw the stage and the panel, for every picture."""
    app.stage.draw()
    app.panel()


def _frame(app: App, asked: int | None) -> int:
    if asked is None:
        return app.last_frame()
    if not -app.frames() <= asked < app.frames():
        raise DisplayError(f"there is no frame {asked}: the last is {app.frames() - 1}")
    return asked % app.frames()


def _video(app: App, path: Path, length: int) -> list[dict[str, Any]]:
    stops = app.stops()
    even = np.linspace(0, app.frames() - 1, max(1, min(length, app.frames()))).round().astype(int)
    shown = []
    with open_video(path, RATE) as write:
        for frame in np.union1d(even, np.array(stops, dtype=int)).tolist():
            app.go_to(frame)
            write(window.grab(), RATE if frame in stops else 1)
            shown.append(app.facts())
    return shown


_ZOOM = 30.0


@contextmanager
def panel(title: str, width: float) -> Iterator[None]:
    """A panel over the whole height of the left edge, with a title and a width in pixels; widgets are drawn inside."""
    imgui.StyleColorsLight()  # polyscope gives every context its own colours
    implot.StyleColorsLight()
    _, h = ps.get_window_size()
    imgui.SetNextWindowPos((0, 0))
    imgui.SetNextWindowSize((width, h))
    imgui.Begin(
        title,
        imgui.ImGuiWindowFlags_NoMove
        | imgui.ImGuiWindowFlags_NoResize
        | imgui.ImGuiWindowFlags_NoCollapse
        | imgui.ImGuiWindowFlags_NoSavedSettings,
    )
    imgui.PushItemWidth(0.55 * width)
    yield
    imgui.PopItemWidth()
    imgui.End()


def subject_combo(subject: str) -> str:
    """Choose what the colours show, one of `SUBJECTS`."""
    _, chosen = imgui.Combo("colours", SUBJECTS.index(subject), list(SUBJECTS))
    return SUBJECTS[chosen]


def zoom_slider(zoom: float) -> float:
    """Choose how many times more than by itself the lens magnifies; 1 / 30 and less is no lens on most maps."""
    flags = imgui.ImGuiSliderFlags_Logarithmic
    return float(imgui.SliderFloat("lens", zoom, 1 / _ZOOM, _ZOOM, "x%.2f", flags)[1])


def paragraph(text: str) -> None:
    """Write text that wraps."""
    imgui.PushTextWrapPos(0.0)
    imgui.TextUnformatted(text)
    imgui.PopTextWrapPos()


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
