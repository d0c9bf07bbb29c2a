"""The panel at the left edge, and the widgets that more than one demo has."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from .choices import SUBJECTS
from .lazy import imgui, implot, ps

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
