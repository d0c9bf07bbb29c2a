"""A hand for windows: it finds widgets as a program draws them, and uses them through ImGui's events, as a person does.

A script that uses a window runs in a thread, in turns with the program: it goes on where the program would wait for the
next frame, and asks for frames. The window is drawn off screen, so that no display is needed.
"""

import threading
import time
from dataclasses import dataclass
from functools import partial

import polyscope as ps
import polyscope.imgui as imgui
import polyscope.implot as implot

from igl_spheremap.apps.viewer import window
from igl_spheremap.apps.viewer.app import FAILED

_CLICKED = (
    "Button",
    "SmallButton",
    "ArrowButton",
    "InvisibleButton",
    "Checkbox",
    "RadioButton",
    "Selectable",
)
_MENUS = ("BeginCombo",)
_OPENED = ("TreeNode", "CollapsingHeader")
_DRAGGED = ("SliderInt", "SliderFloat", "SliderAngle", "SliderFloat2", "SliderFloat3")
#: What is typed into a field unless a script says otherwise.
_TYPED = {"InputText": "typed", "InputInt": "3", "InputFloat": "0.5", "InputDouble": "0.5"}
_TEXTS = (
    "TextUnformatted",
    "Text",
    "TextWrapped",
    "TextColored",
    "TextDisabled",
    "BulletText",
    "SetTooltip",
)
#: Frames after which a window has answered to an event: ImGui acts on it in the next one, and lays out in one more.
_ANSWER = 2
#: Pixels at the border of a window in which nothing can be clicked.
_BORDER = 4
#: Notches of the wheel that are tried to bring a widget into sight.
_NOTCHES = 60


@dataclass(frozen=True)
class Widget:
    """What was drawn: its kind is the name of ImGui's function; rectangles are left, top, right, bottom in pixels."""

    kind: str
    label: str
    value: object
    rectangle: tuple[float, float, float, float]
    window: tuple[float, float, float, float]
    enabled: bool

    def at(self, share=0.5):
        """A point of its middle line."""
        left, top, right, bottom = self.rectangle
        return left + share * (right - left), (top + bottom) / 2


class Hand:
    """A script's hand on a window; `widgets` and `texts` are those of the last frame.

    While it is `strict`, it fails where the window says that something went wrong.
    """

    def __init__(self):
        self.widgets, self.texts, self.strict = [], [], True
        self._drawing, self._written, self._disabled = [], [], []
        self._frame_wanted, self._frame_drawn = threading.Semaphore(0), threading.Semaphore(0)
        self._error, self._done, self._left, self._begun = None, False, False, False

    # What the window is asked.

    def frame(self, count=1):
        """Let the window draw."""
        for _ in range(count):
            self._frame_wanted.release()
            self._frame_drawn.acquire()
            assert not (self.strict and self.failures()), self.failures()

    def failures(self):
        """The failure that the window shows."""
        return [text for text in self.texts if text.startswith(FAILED)]

    def wait(self, condition, seconds=60):
        """Draw until something is true."""
        until = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < until, f"not within {seconds} s; the window says {self.texts}"
            self.frame()
            time.sleep(0.03)  # leaves the processor to what is waited for

    def find(self, label, kind=None):
        """A widget by its label."""
        found = [w for w in self.widgets if w.label == label and kind in (None, w.kind)]
        assert found, f"there is no {label!r} among {[(w.kind, w.label) for w in self.widgets]}"
        return found[0]

    def has(self, label):
        """True if there is such a widget."""
        return any(w.label == label for w in self.widgets)

    def shows(self, words):
        """True if a text of the window has these words."""
        return any(words in text for text in self.texts)

    # What it does with the window.

    def resize(self, width, height):
        ps.set_window_size(width, height)
        self.frame(_ANSWER)

    def move(self, x, y):
        imgui.GetIO().AddMousePosEvent(x, y)
        self.frame()

    def press(self, down, button=0):
        imgui.GetIO().AddMouseButtonEvent(button, down)
        self.frame()

    def click_at(self, x, y, button=0):
        self.move(x, y)
        self.press(True, button)
        self.press(False, button)
        self.frame(_ANSWER - 1)

    def drag(self, start, end, button=0):
        """Drag from a point to another, by a point between them."""
        self.move(*start)
        self.press(True, button)
        self.move(*((a + b) / 2 for a, b in zip(start, end, strict=True)))
        self.move(*end)
        self.press(False, button)
        self.frame(_ANSWER - 1)

    def wheel(self, x, y, notches):
        self.move(x, y)
        imgui.GetIO().AddMouseWheelEvent(0, notches)
        self.frame(_ANSWER)

    def key(self, key, control=False):
        """Press a key and let it go."""
        for down in (True, False):
            if control:
                imgui.GetIO().AddKeyEvent(imgui.ImGuiMod_Ctrl, down)
            imgui.GetIO().AddKeyEvent(key, down)
            self.frame()

    def reach(self, label, kind=None):
        """Scroll until a widget is in sight, and wait until it stays where it is."""
        for _ in range(_NOTCHES):
            widget = self.find(label, kind)
            left, top, _, bottom = widget.window
            (_, y), beyond = widget.at(), ps.get_window_size()[1]
            if not max(top, 0) + _BORDER <= y <= min(bottom, beyond) - _BORDER:
                self.wheel(left + 3, (max(top, 0) + min(bottom, beyond)) / 2, 1 if y < top else -1)
                continue
            self.frame()
            if self.find(label, kind).rectangle == widget.rectangle:
                return widget
        raise AssertionError(f"{label!r} can't be reached: {widget}")

    def click(self, label, kind=None):
        """Click on a widget; on the arrow of what opens, and on the left of all others, where a short label ends."""
        self.click_at(*self.reach(label, kind).at(0.3))

    def slide(self, label, share):
        """Drag a slider from its middle to a share of its length."""
        slider = self.reach(label)
        self.drag(slider.at(), slider.at(share))

    def type(self, label, text, enter=True):
        """Replace the text of a field."""
        self.click(label)
        self.key(imgui.ImGuiKey_A, control=True)
        imgui.GetIO().AddInputCharactersUTF8(text)
        self.frame(_ANSWER)
        if enter:
            self.key(imgui.ImGuiKey_Enter)
        self.frame(_ANSWER)

    def open(self, label):
        """Open a menu, and return the labels of its entries."""
        before = [w.label for w in self.widgets if w.kind == "Selectable"]
        self.click(label, "BeginCombo")
        entries = [
            w.label for w in self.widgets if w.kind == "Selectable" and w.label not in before
        ]
        assert entries, f"{label!r} does not open"
        return entries

    def choose(self, label, entry):
        """Choose an entry of a menu."""
        self.open(label)
        self.click(entry, "Selectable")

    def everything(self, leave=(), typed=None, after=lambda: None):
        """Use every widget that there is and that appears, but those whose labels are to be left.

        `typed` says what is typed into a field; `after` is called after each use.
        """
        used = set()
        while new := [
            w
            for w in self.widgets
            if w.enabled
            and (w.kind, w.label) not in used
            and w.label not in (*leave, *map(str, used))
        ]:
            widget = new[0]
            used.add((widget.kind, widget.label))
            self._use(widget, typed or {})
            after()
        return {label for _, label in used}

    def _use(self, widget, typed):
        label = widget.label
        if widget.kind in _MENUS:
            for entry in self.open(label):
                if not any(w.kind == "Selectable" and w.label == entry for w in self.widgets):
                    self.open(label)
                self.click(entry, "Selectable")
            self.frame(_ANSWER)
        elif widget.kind in _DRAGGED:
            for share in (0.02, 0.98):
                self.slide(label, share)
        elif widget.kind in _TYPED:
            self.type(label, typed.get(label, _TYPED[widget.kind]))
        elif widget.kind == "BeginPlot":
            x, y = self.reach(label).at()
            self.wheel(x, y, 1)
            self.drag((x, y), (x + 20, y + 5))
        else:
            self.click(label, widget.kind)

    # What the program sees of it.

    def run(self, program, script):
        """Run a program that opens a window, and a script that uses it; the window closes when the script ends."""
        self._wrap()
        window.backend = lambda offscreen: "openGL3_egl"
        ps.show, ps.unshow = self._show, self._leave
        self._thread = threading.Thread(target=self._work, args=(script,), daemon=True)
        program()
        if self._error is not None:
            raise self._error
        assert self._done, "the program ended before the script"

    def _work(self, script):
        self._frame_drawn.acquire()
        try:
            self.frame(_ANSWER)
            script(self)
        except BaseException as error:  # raised in the program's thread
            self._error = error
        self._done = True
        self._frame_wanted.release()

    def _show(self, *_):
        ps.set_frame_tick_limit_fps_mode("ignore_limits")
        self._left = False
        if not self._thread.is_alive() and not self._done:
            self._thread.start()
        while not self._left:
            self._frame_drawn.release()
            self._frame_wanted.acquire()
            if self._done:
                return
            self._drawing, self._written, self._disabled = [], [], []
            ps.frame_tick()
            self.widgets, self.texts = self._drawing, self._written

    def _leave(self):
        self._left = True

    def _wrap(self):
        for module, names in (
            (imgui, (*_CLICKED, *_MENUS, *_OPENED, *_DRAGGED, *_TYPED)),
            (implot, ("BeginPlot",)),
        ):
            for name in names:
                setattr(module, name, partial(self._record, name, getattr(module, name)))
        for name in _TEXTS:
            setattr(imgui, name, partial(self._read, getattr(imgui, name)))
        imgui.BeginDisabled = partial(self._disable, imgui.BeginDisabled)
        imgui.EndDisabled = partial(self._enable, imgui.EndDisabled)

    def _record(self, kind, draw, label, *args, **options):
        width = imgui.CalcItemWidth()
        (x, y), (w, h) = imgui.GetWindowPos(), imgui.GetWindowSize()
        content = y + imgui.GetCursorStartPos()[1] + imgui.GetScrollY()  # below the title
        result = draw(label, *args, **options)
        (left, top), (right, bottom) = imgui.GetItemRectMin(), imgui.GetItemRectMax()
        if kind in (*_MENUS, *_DRAGGED, *_TYPED):  # else with the label, which takes no drag
            right = left + width
        rectangles = (left, top, right, bottom), (x, content, x + w, y + h)
        value = args[0] if args else None
        self._drawing.append(
            Widget(kind, label, value, *rectangles, enabled=not any(self._disabled))
        )
        return result

    def _read(self, draw, *args, **options):
        self._written.append(str(args[-1]))
        return draw(*args, **options)

    def _disable(self, begin, disabled=True):
        self._disabled.append(disabled)
        begin(disabled)

    def _enable(self, end):
        self._disabled.pop()
        end()
