"""All of polyscope: a window with a map in it, and the same picture without a screen."""

from .app import App, add_picture_arguments, open_for
from .app import run as run_app
from .body import Body
from .colouring import SUBJECTS
from .pose import UPS, guess_up
from .result_view import ResultView, picture_of, screenshot, show
from .row_view import Part, RowView, registration_view
from .run import Run
from .stage import Stage

__all__ = [
    "SUBJECTS",
    "UPS",
    "App",
    "Body",
    "Part",
    "ResultView",
    "RowView",
    "Run",
    "Stage",
    "add_picture_arguments",
    "guess_up",
    "open_for",
    "picture_of",
    "registration_view",
    "run_app",
    "screenshot",
    "show",
]
