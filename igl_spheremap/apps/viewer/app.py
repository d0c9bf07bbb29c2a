"""Programs with a picture, their panels, and the ways to run them: in a window, as a picture, as a video."""

from __future__ import annotations

import itertools
import math
import re
import traceback
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from ...draw.palette import INK
from ...errors import DisplayError, FileError, check_list, check_whole, legible
from ...gate import PathLike
from ...io.written_map import write_map
from ...maps.sphere_map import SphereMap
from ...result.run import Iterate, Listener
from . import window
from .choices import LENGTH, RATE, SIZE, SUBJECTS, Pictures
from .grid import Grid, packed
from .widgets import FITTING, box, leave_open, menu_is_open, paragraph, tip
from .window import imgui, pressed, ps

#: Beginning of a sentence that a window shows in place of a traceback.
FAILED = "Something went wrong here: "


class App:
    """A picture that has frames and a panel; the panel is drawn in the grid's free strip."""

    grid: Grid
    #: Work between two pictures of a window, such as writing a file, and its result.
    pending: Callable[[], str] | None = None
    message = ""
    #: Whether Escape was pressed during that work.
    stopped = False
    #: Failure in drawing a window, which goes on.
    failure = ""

    def prepare(self, listener: Callable[[Iterate], None] | None = None) -> None:
        """Finish runs in the background, for pictures without a window."""

    def frames(self) -> int:
        """Present number of frames."""
        return 1

    def last_frame(self) -> int:
        """The frame of a picture by default."""
        return self.frames() - 1

    def go_to(self, frame: int) -> None:
        """Show a frame, from 0."""

    def film(self, length: int) -> list[tuple[Callable[[], None], bool]]:
        """Functions that show each picture of a video, and whether it is held for a second: a full turn."""
        return [(partial(self.grid.rotate, 2 * math.pi / length, 0.0), False)] * length

    def facts(self) -> dict[str, Any]:
        """Figures of the present picture, for JSON."""
        return {}

    def pick(self, vertex: int | None) -> None:
        """Mark a vertex on all bodies, or none."""
        self.grid.picked = vertex

    def tick(self) -> None:
        """Move on, and pick what was clicked, once for every picture of a window; never called without one."""
        pixel = self.grid.clicked()
        if pixel is not None:
            self.pick(self.grid.vertex_at(pixel))
        elif pressed("Escape") and not menu_is_open():
            self.pick(None)

    def panel(self) -> None:
        """Draw widgets and plots beside the grid."""

    def close(self) -> None:
        """End runs in the background."""


class ColouredApp(App):
    """An app whose frames are the subjects of its colours, in the order of the menus."""

    subjects: tuple[str, ...] = SUBJECTS
    subject: str

    def show_subject(self, subject: str) -> None:
        """Colour the picture by one of the subjects."""
        raise NotImplementedError

    def frames(self) -> int:
        return len(self.subjects)

    def last_frame(self) -> int:
        return self.subjects.index(self.subject)

    def go_to(self, frame: int) -> None:
        self.show_subject(self.subjects[frame])


def open_for(
    pictures: Pictures,
    instead: str = "--screenshot OUT.png, --video OUT.gif",
    title: str = window.TITLE,
    said: str = "",
) -> None:
    """Start polyscope for a window or for pictures, or raise a DisplayError, before anything is computed.

    The error of a window names flags or arguments that write a file `instead`. The text `said` stands in the empty
    window until there is more to see.
    """
    try:
        if pictures.screenshot is not None:
            window.check_picture(pictures.screenshot)
        if pictures.video is not None:
            window.check_video(Path(pictures.video))
        window.open_window(pictures.size, pictures.offscreen, title)
    except DisplayError as error:
        hint = ""
        if not pictures.offscreen:
            hint = f" ({instead})"
        raise DisplayError(f"{error}{hint}") from None
    if said:
        announce(pictures, said)


def announce(pictures: Pictures, text: str) -> None:
    """Say the cause of waiting in an empty window."""
    if pictures.offscreen:
        return

    text = legible(text)

    def draw() -> None:
        width, height = ps.get_window_size()
        left = (width - imgui.CalcTextSize(text)[0]) / 2
        imgui.GetBackgroundDrawList().AddText((left, height / 2), packed(INK), text)

    ps.set_user_callback(draw)
    for _ in range(2):  # the window appears with the first frame
        ps.frame_tick()
    ps.clear_user_callback()


def present(
    build: Callable[[], App],
    target: PathLike | None = None,
    *,
    size: tuple[int, int] = SIZE,
    frame: int | None = None,
) -> list[dict[str, Any]]:
    """Open a window with an app; if `target` names one, write a picture of a frame or a video of all."""
    width, height = (check_whole(side, "size", 1) for side in check_list(size, "size", 2))
    pictures = pictures_of(target, (width, height), frame)
    open_for(pictures, "screenshot(result, 'map.png'), play(v, f, out='run.gif')")
    return run_app(build(), pictures)


def pictures_of(
    target: PathLike | None, size: tuple[int, int] = SIZE, frame: int | None = None
) -> Pictures:
    """A picture or a video, by the ending of `target`; a window without one."""
    picture = target is not None and Path(target).suffix.lower() in window.PICTURES
    if picture:
        return Pictures(target, None, size, frame)
    return Pictures(None, target, size, frame)


def run_app(
    app: App, pictures: Pictures, *, progress: Any = None, listener: Listener | None = None
) -> list[dict[str, Any]]:
    """Run an app in a window, or write pictures of it and return the facts of each.

    `progress` shows the progress of a video; `listener` hears the iterates of a run that is computed first.
    """
    try:
        if not pictures.offscreen:
            show_app(app)
            return []
        app.prepare(listener)
        ps.set_user_callback(lambda: draw_app(app))
        shown = []
        if pictures.screenshot is not None:
            app.go_to(_frame(app, pictures.frame))
            with app.grid.bare():
                window.save(pictures.screenshot)
            shown.append(app.facts())
        if pictures.video is not None:
            shown += write_video(app, Path(pictures.video), pictures.length, pictures.fps, progress)
        return shown
    finally:
        ps.clear_user_callback()
        app.close()


def show_app(app: App) -> None:
    """Run the window until it is closed, with an app's work between two pictures."""
    while True:
        ps.set_hide_window_after_show(True)
        window.show(lambda: _live(app))
        if app.pending is None:
            return
        job, app.pending, app.stopped = app.pending, None, False
        ps.set_user_callback(lambda: _draw_at_work(app))
        try:
            app.message = job()
        except (DisplayError, FileError, OSError) as error:
            app.message = str(error)


def _draw_at_work(app: App) -> None:
    draw_app(app)
    app.stopped = app.stopped or pressed("Escape")


def _live(app: App) -> None:
    for part in (app.tick, app.grid.mouse, app.grid.draw, app.panel):
        try:
            part()
        except Exception as error:  # shown in the window, which goes on
            where = traceback.extract_tb(error.__traceback__)[-1]
            app.failure = f"{type(error).__name__}: {error} ({Path(where.filename).name}, line {where.lineno})"
            leave_open()
    if app.failure:
        _failure_widgets(app)
    if app.pending is not None:
        ps.set_hide_window_after_show(False)
        ps.unshow()


def _failure_widgets(app: App) -> None:
    """Show a failure in the middle, until it is read."""
    width, height = ps.get_window_size()
    with box("failure", (0.1 * width, 0.4 * height), (0.8 * width, FITTING)):
        paragraph(FAILED + app.failure)
        if imgui.Button("close") or pressed("Escape"):
            app.failure = ""


def draw_app(app: App) -> None:
    """Draw the grid and the panel, for every picture."""
    app.grid.draw()
    app.panel()


def _frame(app: App, asked: int | None) -> int:
    if asked is None:
        return app.last_frame()
    if not -app.frames() <= asked < app.frames():
        raise DisplayError(f"there is no frame {asked}: the last is {app.frames() - 1}")
    return asked % app.frames()


def write_video(
    app: App, path: Path, length: int, rate: int, progress: Any = None
) -> list[dict[str, Any]]:
    """Write a video of about this many pictures, `rate` a second, and return the facts of each."""
    film = app.film(length)
    advance = None
    if progress is not None:
        advance = progress.steps(f"drawing {path.name}", len(film))
    shown = []
    with window.open_video(path, rate) as write:
        for show, held in film:
            show()
            with app.grid.bare():
                picture = window.grab()
            write(picture, rate if held else 1)
            shown.append(app.facts())
            if advance is not None:
                advance()
    return shown


def file_stem(source: str, kind: str) -> str:
    """The name of a file of that kind on a surface.

    >>> file_stem("a/lh.pial", "map"), file_stem("sample:dino", "run"), file_stem("", "map")
    ('lh_map', 'sample_dino_run', 'map')
    """
    return re.sub(r"\W+", "_", f"{Path(source).stem}_{kind}").lstrip("_")


class SaveWidgets:
    """A name and buttons that write the view: as a picture, as a video, and, if it has one, the map itself.

    Existing files stay: a number is added to the name. The window keeps its panel.
    """

    def __init__(self, app: App, name: str, result: Callable[[], SphereMap | None] | None) -> None:
        self._app, self.name, self._result = app, name, result

    def __call__(self) -> None:
        """Draw them."""
        _, self.name = imgui.InputText("##name", self.name)
        tip(f"{Path(self.name).absolute()}, with an ending; a file that is there stays")
        imgui.SameLine()
        imgui.TextUnformatted("save as")
        self._button("picture", ".png", window.PICTURES, self._picture, key="S")
        tip("Or press S.")
        imgui.SameLine()
        self._button("video", ".gif", window.VIDEOS, self._video)
        if self._result is not None:
            imgui.SameLine()
            self._button("map", ".npz", (Path(self.name).suffix,), self._map)

    def _button(
        self,
        label: str,
        ending: str,
        allowed: Sequence[str],
        write: Callable[[Path], str],
        key: str | None = None,
    ) -> None:
        if imgui.Button(label) or (key is not None and pressed(key)):
            self._app.message = ""
            self._app.pending = partial(write, self._path(ending, allowed))

    def _path(self, ending: str, allowed: Sequence[str]) -> Path:
        """A free file by the name; if it has no allowed ending, with one."""
        path = Path(self.name or "unnamed")
        if not path.suffix or path.suffix.lower() not in allowed:
            path = path.with_name(path.name + ending)
        numbered = (path.with_stem(f"{path.stem}_{k}") for k in itertools.count(2))
        return next(one for one in itertools.chain([path], numbered) if not one.exists())

    def _picture(self, path: Path) -> str:
        with self._app.grid.bare():
            window.save(path)
        return f"wrote {path}"

    def _video(self, path: Path) -> str:
        window.check_video(path)
        shown = write_video(self._app, path, LENGTH, RATE, self)
        return f"wrote {path}, {len(shown)} pictures"

    def steps(self, name: str, total: int) -> Callable[[], object]:
        """Show the progress of a video in the window; to be called for each picture."""
        done = itertools.count(1)

        def advance() -> None:
            self._app.message = f"{name}: {next(done)} of {total}; Escape stops it"
            ps.frame_tick()
            if self._app.stopped or ps.window_requests_close():
                raise FileError(f"stopped {name}")

        return advance

    def _map(self, path: Path) -> str:
        """Write the map, certified as it is written; an .npz file holds the whole result."""
        if self._result is None or (found := self._result()) is None:
            return "there is no result yet"
        return f"wrote {path}: {write_map(path, found, force=True)}"
