"""What a program with a picture is, its panel, and the ways to run it: in a window, as a picture, as a video."""

from __future__ import annotations

import math
import os
from argparse import Namespace
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...draw.palette import FOLDED
from ...errors import DisplayError, FileError, import_optional
from ...io.replacing import check_writable, replacing
from ...result.run import Iterate
from . import window
from .choices import LENGTH, RATE, SIZE, SUBJECTS
from .stage import Stage
from .window import imgui, implot, ps

Picture = NDArray[np.uint8]
#: Takes a picture and how often it is shown.
Write = Callable[[Picture, int], None]
#: Files that hold a video; any other name is that of a folder.
_VIDEOS = (".gif", ".mp4")
#: The least and the greatest of the slider for the lens, which magnifies by so many times more than by itself.
_ZOOM = 30.0


class App:
    """A picture that has frames and a panel; `drawing` is False while a picture without the panel is taken."""

    stage: Stage
    #: What is done between two pictures of a window, such as writing a file, and what came of it.
    pending: Callable[[], str] | None = None
    message = ""

    def prepare(self, listener: Callable[[Iterate], None] | None = None) -> None:
        """Finish what runs in the background, for pictures without a window."""

    def frames(self) -> int:
        """Number of frames that there are now."""
        return 1

    def last_frame(self) -> int:
        """The frame that a picture shows if none is asked for."""
        return self.frames() - 1

    def go_to(self, frame: int) -> None:
        """Show a frame, from 0."""

    def film(self, length: int) -> list[tuple[Callable[[], None], bool]]:
        """What shows each picture of a video of about so many, and whether it is held for a second: a full turn."""
        return [(partial(self.stage.rotate, 2 * math.pi / length, 0.0), False)] * length

    def facts(self) -> dict[str, Any]:
        """Figures of what is shown, for JSON."""
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


def present(
    build: Callable[[], App],
    target: str | os.PathLike[str] | None = None,
    *,
    title: str = "igl_spheremap",
    size: tuple[int, int] = SIZE,
) -> list[dict[str, Any]]:
    """Open a window with an app, or write a picture or a video of it if `target` names one."""
    picture = target is not None and Path(target).suffix.lower() in window.PICTURES
    video = target is not None and not picture
    args = Namespace(
        screenshot=target if picture else None, video=target if video else None, size=size, frame=None, length=LENGTH,
        fps=RATE,
    )  # fmt: skip
    open_for(args, title)
    return run_app(build(), args)


def run_app(app: App, args: Namespace) -> list[dict[str, Any]]:
    """Run an app as the arguments ask, and return the facts of each picture that was written."""
    progress = getattr(args, "progress", None)
    try:
        if not (args.screenshot or args.video):
            show_app(app)
            return []
        app.prepare(getattr(args, "listener", None))
        ps.set_user_callback(lambda: draw_app(app))
        shown = []
        if args.screenshot:
            app.go_to(_frame(app, args.frame))
            window.save(args.screenshot)
            shown.append(app.facts())
        if args.video:
            shown += write_video(app, Path(args.video), args.length, args.fps, progress)
        return shown
    finally:
        ps.clear_user_callback()
        app.close()


def show_app(app: App) -> None:
    """Run the window until it is closed; what an app wants done between two pictures is done then."""
    while True:
        ps.set_hide_window_after_show(True)
        window.show(lambda: _live(app))
        if app.pending is None:
            return
        job, app.pending = app.pending, None
        ps.set_user_callback(lambda: draw_app(app))
        try:
            app.message = job()
        except (DisplayError, FileError, OSError) as error:
            app.message = str(error)


def _live(app: App) -> None:
    app.tick()
    app.stage.mouse()
    draw_app(app)
    if app.pending is not None:
        ps.set_hide_window_after_show(False)
        ps.unshow()


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


def write_video(app: App, path: Path, length: int, rate: int, progress: Any = None) -> list[dict[str, Any]]:
    """Write a video of about so many pictures, `rate` a second, and return the facts of each."""
    film = app.film(length)
    advance = None if progress is None else progress.steps(f"drawing {path.name}", len(film))
    shown = []
    with open_video(path, rate) as write:
        for show, held in film:
            show()
            write(window.grab(), rate if held else 1)
            shown.append(app.facts())
            if advance is not None:
                advance()
    return shown


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


class SaveWidgets:
    """A name and buttons that write what is shown: as a picture, as a video, and the map itself."""

    def __init__(self, app: App, name: str, write_map: Callable[[str], str] | None = None) -> None:
        self._app, self.name, self._write_map = app, name, write_map

    def __call__(self) -> None:
        """Draw them."""
        app = self._app
        _, self.name = imgui.InputText("##name", self.name)
        imgui.SameLine()
        imgui.TextUnformatted("save as")
        if imgui.Button("picture"):
            app.pending = self._picture
        imgui.SameLine()
        if imgui.Button("video"):
            app.pending = self._video
        if self._write_map is not None:
            imgui.SameLine()
            if imgui.Button("map"):
                write = self._write_map
                app.pending = lambda: write(self.name)
        if app.message:
            paragraph(app.message)

    def _picture(self) -> str:
        path = Path(self.name)
        path = path if path.suffix.lower() in window.PICTURES else path.with_suffix(".png")
        with self._app.stage.bare():
            window.save(path)
        return f"wrote {path}"

    def _video(self) -> str:
        path = Path(self.name)
        path = path if path.suffix.lower() in _VIDEOS else path.with_suffix(".gif")
        check_video(path)
        with self._app.stage.bare():
            shown = write_video(self._app, path, LENGTH, RATE)
        return f"wrote {path}, {len(shown)} pictures"


def check_video(path: Path) -> None:
    """Raise a FileError before the work starts if a video can't be written."""
    if path.suffix.lower() in _VIDEOS:
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
