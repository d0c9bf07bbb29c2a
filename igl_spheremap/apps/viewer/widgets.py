"""The vocabulary of all panels: boxes, menus, keys, texts, and subjects of colours."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager

from ...draw.palette import FOLDED
from ...errors import legible
from .choices import SUBJECTS
from .colouring import SCALES, Colours
from .window import imgui, implot, pressed, ps

#: Height of a box that is as high as its content.
FITTING = 0.0


@contextmanager
def box(
    title: str, place: tuple[float, float], size: tuple[float, float], *hints: str
) -> Iterator[None]:
    """Widgets or plots at a place; hints are names of ImGui's flags, by default those of a box without decoration."""
    imgui.StyleColorsLight()  # polyscope gives every context its own colours
    implot.StyleColorsLight()
    imgui.SetNextWindowPos(place)
    imgui.SetNextWindowSize(size)
    # would close a menu
    flags = imgui.ImGuiWindowFlags_NoSavedSettings | imgui.ImGuiWindowFlags_NoFocusOnAppearing
    for hint in hints or ("NoDecoration",):
        flags |= getattr(imgui, f"ImGuiWindowFlags_{hint}")
    imgui.Begin(title, flags)
    try:
        yield
    except Exception:
        leave_open()
        raise
    finally:
        imgui.End()


@contextmanager
def panel(title: str, width: float, keys: str) -> Iterator[None]:
    """A panel over the whole height of the left edge, with a title and a width in pixels; widgets are drawn inside.

    With the mouse on its first line, a tip explains `keys` and the mouse.
    """
    with box(title, (0, 0), (width, ps.get_window_size()[1]), "NoMove", "NoResize", "NoCollapse"):
        imgui.TextDisabled("(?) keys and mouse")
        tip(keys)
        imgui.PushItemWidth(0.55 * width)
        yield
        imgui.PopItemWidth()


def menu(label: str, shown: str, entries: Iterable[str]) -> str | None:
    """A menu of different entries, with the text `shown` while it is closed; the entry that was chosen just now."""
    chosen = None
    if imgui.BeginCombo(label, shown):
        for entry in entries:
            if imgui.Selectable(entry, entry == shown):
                chosen = entry
        if pressed("Escape"):
            imgui.CloseCurrentPopup()
        imgui.EndCombo()
    return chosen


def menu_is_open() -> bool:
    """Whether any menu is open: Escape then closes it, and nothing else."""
    return bool(imgui.IsPopupOpen("", imgui.ImGuiPopupFlags_AnyPopup))


def subject_menu(shown: str, subjects: Sequence[str]) -> str:
    """A menu of what colours can show, each of which has its number as a key; the one that is shown from now on."""
    for number, subject in enumerate(subjects, 1):
        if pressed(str(number)):
            return subject
    return menu("colours", shown, subjects) or shown


def leave_open() -> None:
    """Let ImGui silently close widgets that an error left open: the window shows the error."""
    io = imgui.GetIO()
    io.ConfigErrorRecoveryEnableDebugLog = io.ConfigErrorRecoveryEnableTooltip = False


def colour_widgets(colours: Colours) -> bool:
    """Choose a subject, its scale or the number of squares; whether one was chosen just now."""
    before = colours.state
    colours.subject = subject_menu(colours.subject, SUBJECTS)
    if colours.subject == "checkerboard":
        # an even number: with an odd one two squares of a colour would meet
        colours.squares = 2 * round(imgui.SliderInt("squares", colours.squares, 4, 96)[1] / 2)
        return before != colours.state
    names = {" to ".join(ramp.ends): ramp for ramp in SCALES.get(colours.subject, ())}
    shown = "none"
    if colours.subject in colours.scales:
        shown = " to ".join(colours.scales[colours.subject].ends)
    imgui.BeginDisabled(not names)
    if chosen := menu("scale", shown, names):
        colours.scales[colours.subject] = names[chosen]
    imgui.EndDisabled()
    tip("It stays while the map changes. The legend says how much lies beyond its ends.")
    return before != colours.state


def tip(text: str, width: float = 360.0) -> None:
    """Explain the last widget while the mouse rests on it."""
    if not imgui.IsItemActive() and imgui.BeginItemTooltip():
        imgui.PushTextWrapPos(width)
        imgui.TextUnformatted(legible(text))
        imgui.PopTextWrapPos()
        imgui.EndTooltip()


def warning(text: str) -> None:
    """Write text that wraps in the colour of warnings."""
    imgui.PushStyleColor(imgui.ImGuiCol_Text, (*FOLDED, 1.0))
    paragraph(text)
    imgui.PopStyleColor()


def paragraph(text: str) -> None:
    """Write text that wraps."""
    imgui.PushTextWrapPos(0.0)
    imgui.TextUnformatted(legible(text))
    imgui.PopTextWrapPos()
