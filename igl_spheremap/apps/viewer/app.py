"""What a program with a picture is, and the ways to run it: in a window, as one picture, as a video."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import DisplayError
from . import window
from .lazy import ps
from .stage import Stage
from .video import check_video, open_video

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
