"""What the scripts of `demos/` share: their arguments, the progress, and errors of one sentence."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

from ..errors import one_line
from ..mesh.arrays import FloatArray, IntArray
from .cli.exits import EXPECTED, Exit, UsageError
from .cli.inputs import read_source
from .cli.progress import Progress
from .viewer import window
from .viewer.app import check_pictures, pictures_of

#: Takes vertices, faces, which way is up, the picture or video to write (a window if there is none), and the progress.
Demo = Callable[[FloatArray, IntArray, str, "str | None", Progress], object]

_PICTURES = (*window.PICTURES, *window.VIDEOS)


def run_demo(demo: Demo, surface: str) -> None:
    """Run a demo as its command line asks: ``[FILE|sample:NAME] [PICTURE.png]``, either or both.

    What ends as a picture or a video does is what the demo writes; without it a window opens. The surface is
    `surface` by default. A failure ends the program with one sentence, and ``-h`` prints what the demo's file says.
    """
    words = sys.argv[1:]
    if {"-h", "--help"} & set(words):
        print(demo.__globals__["__doc__"])
        return
    script = Path(demo.__code__.co_filename).name
    try:
        targets = [word for word in words if word.lower().endswith(_PICTURES)]
        sources = [word for word in words if word not in targets]
        if len(targets) > 1 or len(sources) > 1:
            raise UsageError(
                f"give at most one surface and one picture: {script} [FILE|sample:NAME] [PICTURE.png]"
            )
        target = targets[0] if targets else None
        check_pictures(pictures_of(target))
        with Progress() as progress:
            source = read_source(sources[0] if sources else surface)
            progress.begin("mapping")
            demo(source.v, source.f, source.up, target, progress)
    except KeyboardInterrupt:
        print(f"{script}: interrupted by you", file=sys.stderr)
        sys.exit(Exit.INTERRUPTED)
    except EXPECTED as error:
        print(f"{script}: {one_line(error)}", file=sys.stderr)
        sys.exit(1)
