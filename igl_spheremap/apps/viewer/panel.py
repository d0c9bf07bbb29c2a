"""The panel at the left edge, and the widgets that more than one demo has."""

from __future__ import annotations

from .choices import SUBJECTS

_ZOOM = 30.0


def begin_panel(title: str, width: float) -> None:
    """Begin a panel over the whole height of the right edge, with a title and a width in pixels."""
    import polyscope as ps
    from polyscope import imgui, implot

    imgui.StyleColorsLight()  # polyscope dresses every context anew in its own colours
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


def end_panel() -> None:
    """End the panel."""
    from polyscope import imgui

    imgui.PopItemWidth()
    imgui.End()


def subject_combo(subject: str) -> str:
    """Choose what the colours show, one of `SUBJECTS`."""
    from polyscope import imgui

    _, chosen = imgui.Combo("colours", SUBJECTS.index(subject), list(SUBJECTS))
    return SUBJECTS[chosen]


def zoom_slider(zoom: float) -> float:
    """Choose how many times more than by itself the lens magnifies; 1 / 30 and less is no lens on most maps."""
    from polyscope import imgui

    flags = imgui.ImGuiSliderFlags_Logarithmic
    return float(imgui.SliderFloat("lens", zoom, 1 / _ZOOM, _ZOOM, "x%.2f", flags)[1])


def paragraph(text: str) -> None:
    """Write text that wraps."""
    from polyscope import imgui

    imgui.PushTextWrapPos(0.0)
    imgui.TextUnformatted(text)
    imgui.PopTextWrapPos()
