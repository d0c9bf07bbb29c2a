"""All of polyscope: a window with a map in it, and the same picture without a screen."""

from .app import App, add_picture_arguments, open_for
from .app import run as run_app
from .body import Body
from .result_view import ResultView, screenshot, show
from .run import Run
from .stage import Stage

__all__ = [
    "App",
    "Body",
    "ResultView",
    "Run",
    "Stage",
    "add_picture_arguments",
    "open_for",
    "run_app",
    "screenshot",
    "show",
]
