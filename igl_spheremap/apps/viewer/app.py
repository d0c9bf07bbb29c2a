"""What a program with a picture is, its panel, and the ways to run it: in a window, as a picture, as a video."""

from __future__ import annotations

import itertools
import math
import os
import traceback
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

from ...draw.palette import Ramp
from ...errors import DisplayError, FileError
from ...io.written_map import write_map
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.check import Mesh
from ...result.run import Iterate, Listener
from . import window
from .body import STRONGEST
from .choices import LENGTH, RATE, SIZE, SUBJECTS, Pictures
from .colouring import SCALES, SQUARES, Colouring, checkerboard, colouring, deepest_tips, poles_at, scale
from .grid import Grid, magnification
from .window import imgui, implot, ps

#: How a sentence begins that a window shows in place of a traceback.
FAILED = "Something went wrong here: "
#: Pixels of a line of a tooltip, and of the height of what says that something went wrong.
_TIP, _SAID = 360.0, 90.0
#: A menu lists at most this number of clusters; the button leads to all.
_LISTED = 200


class App:
    """A picture that has frames and a panel; the panel is drawn where the grid leaves room for it."""

    grid: Grid
    #: What is done between two pictures of a window, such as writing a file, and what came of it.
    pending: Callable[[], str] | None = None
    message = ""
    #: What went wrong in drawing a window, which goes on.
    failure = ""

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
        """What shows each picture of a video of about this many, and whether it is held for a second: a full turn."""
        return [(partial(self.grid.rotate, 2 * math.pi / length, 0.0), False)] * length

    def facts(self) -> dict[str, Any]:
        """Figures of what is shown, for JSON."""
        return {}

    def tick(self) -> None:
        """Move on, once for every picture of a window; never called without one."""

    def panel(self) -> None:
        """Draw what is not on the grid: widgets and plots."""

    def close(self) -> None:
        """End what runs in the background."""


class ColouredApp(App):
    """An app whose frames are what its colours can show, in the order of the menus."""

    subjects: tuple[str, ...] = SUBJECTS
    subject: str

    def show_subject(self, subject: str) -> None:
        """Colour what is shown by one of the subjects."""
        raise NotImplementedError

    def frames(self) -> int:
        return len(self.subjects)

    def last_frame(self) -> int:
        return self.subjects.index(self.subject)

    def go_to(self, frame: int) -> None:
        self.show_subject(self.subjects[frame])


def open_for(pictures: Pictures, instead: str = "--screenshot OUT.png, --video OUT.gif") -> None:
    """Start polyscope for a window or for pictures, or raise a DisplayError, before anything is computed.

    The error of a window names what writes a file `instead`: flags of the command line, or arguments.
    """
    if pictures.screenshot is not None:
        window.check_picture(pictures.screenshot)
    if pictures.video is not None:
        window.check_video(Path(pictures.video))
    try:
        window.open_window(pictures.size, pictures.offscreen)
    except DisplayError as error:
        hint = "" if pictures.offscreen else f" ({instead})"
        raise DisplayError(f"{error}{hint}") from None


def present(
    build: Callable[[], App],
    target: str | os.PathLike[str] | None = None,
    *,
    size: tuple[int, int] = SIZE,
    frame: int | None = None,
) -> list[dict[str, Any]]:
    """Open a window with an app, or write a picture of a frame or a video of all if `target` names one."""
    picture = target is not None and Path(target).suffix.lower() in window.PICTURES
    pictures = Pictures(target if picture else None, None if picture else target, size, frame)
    open_for(pictures, "screenshot(result, 'map.png'), play(v, f, out='run.gif')")
    return run_app(build(), pictures)


def run_app(app: App, pictures: Pictures, *, progress: Any = None,
            listener: Listener | None = None) -> list[dict[str, Any]]:
    """Run an app in a window, or write pictures of it and return the facts of each.

    `progress` shows how far a video is; `listener` hears the iterates of a run that is computed first.
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
            window.save(pictures.screenshot)
            shown.append(app.facts())
        if pictures.video is not None:
            shown += write_video(app, Path(pictures.video), pictures.length, pictures.fps, progress)
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
    for part in (app.tick, app.grid.mouse, app.grid.draw, app.panel):
        try:
            part()
        except Exception as error:  # shown in the window, which goes on
            where = traceback.extract_tb(error.__traceback__)[-1]
            app.failure = f"{type(error).__name__}: {error} ({Path(where.filename).name}, line {where.lineno})"
            _leave_open()
    if app.failure:
        _failure_widgets(app)
    if app.pending is not None:
        ps.set_hide_window_after_show(False)
        ps.unshow()


def _leave_open() -> None:
    """Let ImGui close what an error left open without a word: the window says what the error was."""
    io = imgui.GetIO()
    io.ConfigErrorRecoveryEnableDebugLog = io.ConfigErrorRecoveryEnableTooltip = False


def _failure_widgets(app: App) -> None:
    """Say what went wrong, at the lower edge, until it is read."""
    width, height = ps.get_window_size()
    with box("failure", (0.1 * width, height - _SAID), (0.8 * width, _SAID)):
        paragraph(FAILED + app.failure)
        if imgui.Button("close"):
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


def write_video(app: App, path: Path, length: int, rate: int, progress: Any = None) -> list[dict[str, Any]]:
    """Write a video of about this many pictures, `rate` a second, and return the facts of each."""
    film = app.film(length)
    advance = None if progress is None else progress.steps(f"drawing {path.name}", len(film))
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


@contextmanager
def box(title: str, place: tuple[float, float], size: tuple[float, float], *hints: str) -> Iterator[None]:
    """Widgets or plots at a place; hints are names of ImGui's flags, by default those of a box without decoration."""
    imgui.StyleColorsLight()  # polyscope gives every context its own colours
    implot.StyleColorsLight()
    imgui.SetNextWindowPos(place)
    imgui.SetNextWindowSize(size)
    flags = imgui.ImGuiWindowFlags_NoSavedSettings | imgui.ImGuiWindowFlags_NoFocusOnAppearing  # would close a menu
    for hint in hints or ("NoDecoration",):
        flags |= getattr(imgui, f"ImGuiWindowFlags_{hint}")
    imgui.Begin(title, flags)
    try:
        yield
    except Exception:
        _leave_open()
        raise
    finally:
        imgui.End()


@contextmanager
def panel(title: str, width: float) -> Iterator[None]:
    """A panel over the whole height of the left edge, with a title and a width in pixels; widgets are drawn inside."""
    with box(title, (0, 0), (width, ps.get_window_size()[1]), "NoMove", "NoResize", "NoCollapse"):
        imgui.PushItemWidth(0.55 * width)
        yield
        imgui.PopItemWidth()


def menu(label: str, shown: str, entries: Iterable[str]) -> str | None:
    """A menu of different entries, with what is `shown` while it is closed; the entry that was chosen just now."""
    chosen = None
    if imgui.BeginCombo(label, shown):
        for entry in entries:
            if imgui.Selectable(entry, entry == shown):
                chosen = entry
        imgui.EndCombo()
    return chosen


class Colours:
    """What colours show, with a scale and poles of squares that stay while maps change, and the widgets for them."""

    def __init__(self, subject: str) -> None:
        self.subject, self.squares = subject, SQUARES
        self._scales: dict[str, Ramp | None] = {}
        self._tips: IntArray | None = None

    def of(
        self, mesh: Mesh, x: FloatArray, folded: IntArray | None = None, like: FloatArray | None = None
    ) -> Colouring:
        """The colours of a map; scale and poles are those that fit the first map, or the one that it is `like`."""
        like = x if like is None else like
        if self.subject == "checkerboard":
            if self._tips is None:
                self._tips = deepest_tips(mesh, like)
            return checkerboard(mesh, x, poles_at(x, self._tips), self.squares, folded)
        if self.subject not in self._scales:
            self._scales[self.subject] = scale(mesh, like, self.subject)
        return colouring(mesh, x, self.subject, self._scales[self.subject], folded)

    @property
    def ramp(self) -> Ramp | None:
        """The scale of the subject, if it has one."""
        return self._scales.get(self.subject)

    @property
    def state(self) -> tuple[object, ...]:
        """What decides on the colours of a map."""
        return self.subject, self.squares, self.ramp

    def widgets(self) -> bool:
        """Choose a subject, its scale or the number of squares; whether one was chosen just now."""
        before = self.state
        self.subject = menu("colours", self.subject, SUBJECTS) or self.subject
        if self.subject == "checkerboard":  # an even number: with an odd one two squares of a colour would meet
            self.squares = 2 * round(imgui.SliderInt("squares", self.squares, 4, 96)[1] / 2)
        else:
            names = {" to ".join(ramp.ends): ramp for ramp in SCALES.get(self.subject, ())}
            imgui.BeginDisabled(not names)
            if chosen := menu("scale", " to ".join(self.ramp.ends) if self.ramp else "none", names):
                self._scales[self.subject] = names[chosen]
            imgui.EndDisabled()
            tip("It stays while the map changes. The legend says how much lies beyond its ends.")
        return before != self.state


def lens_widgets(power: float, sizes: IntArray, shown: int) -> tuple[float | None, int | None] | None:
    """Choose how much the lens magnifies, and the cluster of folded faces, of these sizes, that it shows.

    What was chosen just now: the power, None for what fits, and a cluster if it is another one.
    """
    moved, chosen = imgui.SliderFloat("lens", power, 1.0, STRONGEST, magnification(power),
                                      imgui.ImGuiSliderFlags_Logarithmic)
    tip("A Moebius map, which keeps angles, magnifies what the small sphere circles.")
    if moved:
        return min(max(float(chosen), 1.0), STRONGEST), None
    entries = [f"{k + 1}: {size:,} faces" for k, size in enumerate(sizes[:_LISTED])]
    here = entries[shown] if shown < len(entries) else f"{shown + 1} of {len(sizes):,}" if entries else "nothing folds"
    imgui.BeginDisabled(not entries)
    picked = menu("clusters", here, entries)
    imgui.EndDisabled()
    if imgui.Button("whole sphere"):
        return 1.0, None
    imgui.SameLine()
    if imgui.Button("fit"):
        return None, None
    tip("As strong as shows all of the cluster, or what is around the vertex that was picked.")
    imgui.SameLine()
    imgui.BeginDisabled(len(sizes) < 2)
    following = imgui.Button("next cluster")
    imgui.EndDisabled()
    if following or picked:
        return None, (shown + 1) % len(sizes) if picked is None else entries.index(picked)
    return None


def tip(text: str) -> None:
    """Say what the last widget does while the mouse is on it."""
    if imgui.BeginItemTooltip():
        imgui.PushTextWrapPos(_TIP)
        imgui.TextUnformatted(text)
        imgui.PopTextWrapPos()
        imgui.EndTooltip()


def paragraph(text: str) -> None:
    """Write text that wraps."""
    imgui.PushTextWrapPos(0.0)
    imgui.TextUnformatted(text)
    imgui.PopTextWrapPos()


class SaveWidgets:
    """A name and buttons that write what is shown: as a picture, as a video, and the map itself.

    Files that are there are replaced only after a question. The window goes on to show its panel.
    """

    def __init__(self, app: App, name: str, result: Callable[[], SphereMap | None]) -> None:
        self._app, self.name, self._result = app, name, result
        self._asked: tuple[Path, Callable[[], str]] | None = None

    def __call__(self) -> None:
        """Draw them."""
        _, self.name = imgui.InputText("##name", self.name)
        imgui.SameLine()
        imgui.TextUnformatted("save as")
        for label, ending, allowed, write in (
            ("picture", ".png", window.PICTURES, self._picture), ("video", ".gif", window.VIDEOS, self._video),
            ("map", ".npz", (Path(self.name).suffix,), self._map),
        ):  # fmt: skip
            if imgui.Button(label):
                self._ask(self._path(ending, allowed), write)
            imgui.SameLine()
        imgui.NewLine()
        if self._asked is not None:
            self._question(*self._asked)

    def _path(self, ending: str, allowed: Sequence[str]) -> Path:
        """The file by its name, with an ending if it has none of those that are allowed."""
        path = Path(self.name or "unnamed")
        if path.suffix.lower() in {*window.PICTURES, *window.VIDEOS} - {*allowed}:
            path = path.with_suffix("")
        return path if path.suffix and path.suffix.lower() in allowed else path.with_name(path.name + ending)

    def _ask(self, path: Path, write: Callable[[Path], str]) -> None:
        """Write a file, or first ask if there is one."""
        self._asked, self._app.message = None, ""
        if path.exists():
            self._asked = path, partial(write, path)
        else:
            self._app.pending = partial(write, path)

    def _question(self, path: Path, write: Callable[[], str]) -> None:
        paragraph(f"{path} is there already.")
        replace = imgui.Button("replace it")
        imgui.SameLine()
        if imgui.Button("keep it") or replace:
            self._asked = None
        if replace:
            self._app.pending = write

    def _picture(self, path: Path) -> str:
        with self._app.grid.bare():
            window.save(path)
        return f"wrote {path}"

    def _video(self, path: Path) -> str:
        window.check_video(path)
        shown = write_video(self._app, path, LENGTH, RATE, self)
        return f"wrote {path}, {len(shown)} pictures"

    def steps(self, name: str, total: int) -> Callable[[], object]:
        """Show in the window how far a video is; to be called for each picture."""
        done = itertools.count(1)

        def advance() -> None:
            self._app.message = f"{name}: {next(done)} of {total}"
            ps.frame_tick()

        return advance

    def _map(self, path: Path) -> str:
        """Write the map, certified as it is written; an .npz file holds the whole result."""
        found = self._result()
        if found is None:
            return "there is no result yet"
        return f"wrote {path}: {write_map(path, found, force=True)}"
