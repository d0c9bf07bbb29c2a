"""The player with widgets: what to compute, where in the run to be, and the curves of the run."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import fields, replace
from typing import Any

import numpy as np

from ... import samples
from ...maps.options import METHODS, Method
from .curves import energy_plot, folding_plot
from .lazy import imgui
from .panel import panel, paragraph, subject_combo, zoom_slider
from .player import Player
from .run import Source
from .stage import PANEL
from .timeline import stops

SPEEDS = (1, 2, 5, 10, 25)
#: Beside a computation, drawing rests for so many times as long as the last picture took.
_REST = 4


def parameters(method: Method) -> dict[str, int | float]:
    """The numbers of a method.

    >>> parameters(METHODS["lai2014"]())["max_iterations"]
    5000
    """
    values = {field.name: getattr(method, field.name) for field in fields(method)}
    return {name: value for name, value in values.items() if type(value) in (int, float)}


class PlayerWindow(Player):
    """A player with a panel; the run is live."""

    def __init__(self, load: Callable[[str], Source], name: str, method: Method, **layout: Any) -> None:
        self.method = method
        self.playing, self.speed = True, 0
        self._cpu, self._rest_until, self._moved = 0.0, 0.0, False
        super().__init__(load, name, method, panel=PANEL, live=True, **layout)

    def tick(self) -> None:
        """Move on while playing, beside a computation now and then."""
        super().tick()
        cpu, now = time.process_time(), time.monotonic()
        if self._moved:
            self._rest_until = now + _REST * (cpu - self._cpu)
        self._cpu, self._moved = cpu, False
        if not self.playing or not self.run.slides or (self.run.running and now < self._rest_until):
            return
        before = self.after
        self._step_to(before + SPEEDS[self.speed] - 1)
        self._moved = self.after != before

    def panel(self) -> None:
        super().panel()
        with panel("Player", self.stage.panel):
            self._run_widgets()
            if self.run.slides:
                for widgets in (self._play_widgets, self._stop_combo, self._view_widgets):
                    widgets()
                self._plots()

    def _plots(self) -> None:
        at = self.run.slides[self.after].index
        room = max(90.0, (imgui.GetContentRegionAvail()[1] - 6) / 2)
        steps = np.array([slide.index for slide in self.run.slides])
        energy_plot(steps, np.array([slide.step.energy for slide in self.run.slides]), at, room)
        folding_plot(steps, np.array([slide.foldings for slide in self.run.slides]), at, room)

    def _run_widgets(self) -> None:
        _, self.name = imgui.InputText("##mesh", self.name)
        imgui.SameLine()
        if imgui.BeginCombo("mesh", "", imgui.ImGuiComboFlags_NoPreview):
            for name in samples.names():
                if imgui.Selectable(f"sample:{name}", False)[0]:
                    self.name = f"sample:{name}"
            imgui.EndCombo()
        methods = list(METHODS)
        changed, chosen = imgui.Combo("method", methods.index(self.method.name), methods)
        if changed:
            self.method = METHODS[methods[chosen]]()
        if imgui.TreeNode("parameters"):
            for name, value in parameters(self.method).items():
                enter = imgui.InputInt if isinstance(value, int) else _enter_number
                changed, value = enter(name.replace("_", " "), value)
                if changed:
                    self.method = replace(self.method, **{name: max(value, 0)})
            imgui.TreePop()
        run = self.run
        if run.running:
            if imgui.Button("stop"):
                run.stop()
            imgui.SameLine()
            imgui.TextUnformatted(f"computing: {run.iterates:,} iterates")
        elif imgui.Button("run"):
            run.close()
            self.start(self.name, self.method)
            self.playing = True
        if run.error is not None:
            paragraph(f"{type(run.error).__name__}: {run.error}")

    def _play_widgets(self) -> None:
        at, last = self.after - 1, self.frames() - 1
        if imgui.Button("pause" if self.playing else "play "):
            if not self.playing and at >= last:
                self._step_to(0)
            self.playing = not self.playing
        for label, step in (("<", -1), (">", 1)):
            imgui.SameLine()
            if imgui.Button(label):
                self._leave_for(at + step)
        imgui.SameLine()
        imgui.PushItemWidth(70)
        _, self.speed = imgui.Combo("speed", self.speed, [f"x{speed}" for speed in SPEEDS])
        imgui.PopItemWidth()
        moved, frame = imgui.SliderInt("step", max(at, 0), 0, last)
        if moved:
            self._leave_for(frame)

    def _stop_combo(self) -> None:
        marks = stops(self.run.slides)
        here = [name for name, k in marks if k == self.after or k == 0 == self.before]
        if not imgui.BeginCombo("stops", here[-1] if here else ""):
            return
        for name, k in marks:
            if imgui.Selectable(name, name in here)[0]:
                self._leave_for(k - 1)
        imgui.EndCombo()

    def _leave_for(self, frame: int) -> None:
        self.playing = False
        self._step_to(frame)

    def _step_to(self, frame: int) -> None:
        self.go_to(min(max(frame, 0), self.frames() - 1))

    def _view_widgets(self) -> None:
        self.subject, self.zoom = subject_combo(self.subject), zoom_slider(self.zoom)
        self.show(self.before, self.after)


def _enter_number(label: str, value: float) -> tuple[bool, float]:
    changed, value = imgui.InputDouble(label, value, format="%.1e")
    return bool(changed), float(value)
