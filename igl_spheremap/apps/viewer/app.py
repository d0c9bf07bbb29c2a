"""What a demo is, and the three ways to run it: in a window, as one picture, as a folder of pictures."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path

import numpy as np

from ...errors import DisplayError
from . import window
from .stage import Stage

#: Pictures that `--video` makes at the most, unless it is told otherwise.
LENGTH = 120


class App:
    """A picture that has frames and a panel. Demos derive from it.

    Attributes
    ----------
    stage : Stage
        What is drawn.
    """

    stage: Stage

    def prepare(self) -> None:
        """Finish what runs in the background, for pictures without a window."""

    def frames(self) -> int:
        """Number of frames that there are now."""
        return 1

    def last_frame(self) -> int:
        """The frame that a picture shows if none is asked for."""
        return self.frames() - 1

    def go_to(self, frame: int) -> None:
        """Show a frame.

        Parameters
        ----------
        frame : int
            From 0.

        Returns
        -------
        None
        """

    def tick(self) -> None:
        """Move on, once for every picture of a window; never called without one."""

    def panel(self) -> None:
        """Draw what is not on the stage: widgets and plots."""

    def close(self) -> None:
        """End what runs in the background."""


def add_picture_arguments(parser: ArgumentParser) -> None:
    """Add the arguments that all demos share.

    Parameters
    ----------
    parser : ArgumentParser
        Gains them.

    Returns
    -------
    None
    """
    parser.add_argument("--screenshot", metavar="OUT.png", help="write one picture; needs no display")
    parser.add_argument("--frame", type=int, metavar="K", help="of --screenshot, from 0; -1 is the last")
    parser.add_argument("--video", metavar="DIR", help="write numbered PNGs of the whole run; needs no display")
    parser.add_argument(
        "--length",
        type=int,
        default=LENGTH,
        metavar="N",
        help=f"of --video: so many pictures at the most, evenly chosen (default {LENGTH})",
    )
    parser.add_argument(
        "--size",
        type=int,
        nargs=2,
        default=window.SIZE,
        metavar=("W", "H"),
        help="of the window in pixels (default {} {})".format(*window.SIZE),
    )


def open_for(args: Namespace, title: str) -> None:
    """Start polyscope as the arguments ask.

    Parameters
    ----------
    args : Namespace
        With those of `add_picture_arguments`.
    title : str
        Of the window.

    Returns
    -------
    None

    Raises
    ------
    DisplayError
        If it can't be; in time, before anything is computed.
    """
    offscreen = bool(args.screenshot or args.video)
    if min(args.size) < 200:
        raise DisplayError("a picture needs 200 pixels each way")
    try:
        window.open_window(title, tuple(args.size), offscreen)
    except DisplayError as error:
        hint = "" if offscreen else " (--screenshot OUT.png, --video DIR)"
        raise DisplayError(f"{error}{hint}") from None


def run(app: App, args: Namespace) -> None:
    """Run an app as the arguments ask.

    Parameters
    ----------
    app : App
        On the stage already.
    args : Namespace
        With those of `add_picture_arguments`.

    Returns
    -------
    None

    Raises
    ------
    DisplayError
        If there is no such frame.
    """
    import polyscope as ps

    try:
        if not (args.screenshot or args.video):
            window.show(lambda: _live(app))
            return
        app.prepare()
        ps.set_user_callback(lambda: _still(app))
        if args.screenshot:
            app.go_to(_frame(app, args.frame))
            window.save(args.screenshot)
        if args.video:
            _video(app, Path(args.video), args.length)
    finally:
        ps.clear_user_callback()
        app.close()


def _live(app: App) -> None:
    app.tick()
    app.stage.mouse()
    _still(app)


def _still(app: App) -> None:
    app.stage.draw()
    app.panel()


def _frame(app: App, asked: int | None) -> int:
    if asked is None:
        return app.last_frame()
    if not -app.frames() <= asked < app.frames():
        raise DisplayError(f"there is no frame {asked}: the last is {app.frames() - 1}")
    return asked % app.frames()


def _video(app: App, folder: Path, length: int) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    chosen = np.unique(np.linspace(0, app.frames() - 1, max(1, min(length, app.frames()))).round().astype(int))
    for number, frame in enumerate(chosen.tolist()):
        app.go_to(frame)
        window.save(folder / f"{number:05d}.png")
