"""The player in a window: panel and plots beside a run that goes on; and `play`, which opens it."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from dataclasses import fields, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ... import samples
from ...draw import palette
from ...io.files import read_mesh
from ...maps.options import METHODS, Method
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.check import check_mesh
from ...mesh.objects import takes_mesh
from ...result.recording import linear_below, objective
from ...result.run import Step
from .app import SaveWidgets, menu, panel, paragraph, present, subject_combo, zoom_slider
from .background_run import Source
from .choices import PLAYER_SIZE
from .player import Player
from .stage import PANEL
from .window import imgui, implot

#: Points of a curve that are drawn at the most.
_POINTS = 500
#: The name of a surface that is given as arrays.
_GIVEN = "your mesh"
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
        self._save = SaveWidgets(self, "run", lambda: self.run.result)
        super().__init__(load, name, method, panel=PANEL, live=True, **layout)

    def tick(self) -> None:
        """Move on while playing, beside a computation now and then."""
        super().tick()
        cpu, now = time.process_time(), time.monotonic()
        if self._moved:
            self._rest_until = now + _REST * (cpu - self._cpu)
        self._cpu, self._moved = cpu, False
        if not self.playing or not self.run.frames or (self.run.running and now < self._rest_until):
            return
        before = self.after
        self._step_to(before + SPEEDS[self.speed] - 1)
        self._moved = self.after != before

    def panel(self) -> None:
        super().panel()
        if not self.stage.panel:
            return
        with panel("Player", self.stage.panel):
            self._run_widgets()
            if self.run.frames:
                for widgets in (self._play_widgets, self._stop_combo, self._view_widgets, self._save):
                    widgets()
                self._plots()

    def _plots(self) -> None:
        at = self.run.frames[self.after].index
        room = max(90.0, (imgui.GetContentRegionAvail()[1] - 6) / 2)
        frames = self.run.frames
        steps = np.array([frame.index for frame in frames])
        _energy_plot(self.run.history, at, room)
        _folding_plot(steps, np.array([frame.foldings for frame in frames]), at, room)

    def _run_widgets(self) -> None:
        _, self.name = imgui.InputText("##mesh", self.name)
        imgui.SameLine()
        self.name = menu("mesh", "", (f"sample:{name}" for name in samples.names())) or self.name
        if chosen := menu("method", self.method.name, METHODS):
            self.method = METHODS[chosen]()
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
            imgui.TextUnformatted(f"computing: {len(run.history):,} iterates")
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
        speeds = [f"x{speed}" for speed in SPEEDS]
        if chosen := menu("speed", speeds[self.speed], speeds):
            self.speed = speeds.index(chosen)
        imgui.PopItemWidth()
        moved, frame = imgui.SliderInt("step", max(at, 0), 0, last)
        if moved:
            self._leave_for(frame)

    def _stop_combo(self) -> None:
        marks = self.run.stops()
        here = [name for name, k in marks if k == self.after or k == 0 == self.before]
        if chosen := menu("stops", here[-1] if here else "", dict(marks)):
            self._leave_for(dict(marks)[chosen] - 1)

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


def _energy_plot(history: Sequence[Step], shown: int, height: float) -> None:
    """Plot what is minimised over the iterates, with its sign."""
    at, values, name = objective(history)
    linear = linear_below(values)
    if linear == 0:
        values = np.where(values > 0, values, np.nan)
        _curve(name, at, values, shown, height, implot.ImPlotScale_Log10, palette.LINES[0])
    elif np.isfinite(linear):
        powers = 10.0 ** np.arange(0, 9, 3)
        ticks = np.concatenate((-powers[::-1], [0.0], powers))
        _curve(name, at, values / linear, shown, height, implot.ImPlotScale_SymLog, palette.LINES[0], ticks, linear)
    else:
        _curve(name, at, values, shown, height, implot.ImPlotScale_Linear, palette.LINES[0])


def _folding_plot(at: IntArray, foldings: IntArray, shown: int, height: float) -> None:
    """Plot the number of folded faces over the iterates `at`."""
    scale = implot.ImPlotScale_SymLog if foldings.any() else implot.ImPlotScale_Linear
    ticks = np.array([0.0, 10.0, 1e3, 1e5]) if foldings.any() else np.zeros(1)
    _curve("folded faces", at, foldings.astype(np.float64), shown, height, scale, palette.FOLDED, ticks)


def _curve(
    title: str,
    x: IntArray,
    y: FloatArray,
    shown: int,
    height: float,
    scale: int,
    colour: palette.Colour,
    ticks: FloatArray | None = None,
    unit: float = 1.0,
) -> None:
    """A curve with a line at the iterate that is shown; `ticks` count in the unit of the axis."""
    flags = implot.ImPlotFlags_NoLegend | implot.ImPlotFlags_NoMouseText | implot.ImPlotFlags_NoMenus
    fit = implot.ImPlotAxisFlags_AutoFit | implot.ImPlotAxisFlags_NoLabel
    if not implot.BeginPlot(title.replace("π", "pi"), (-1, height), flags):
        return
    implot.SetupAxes("iterate", title, fit, fit)
    implot.SetupAxisScale(implot.ImAxis_Y1, scale)
    if ticks is not None:
        implot.SetupAxisTicks(implot.ImAxis_Y1, ticks, [f"{unit * tick:.3g}" for tick in ticks])
    if len(y):
        chosen = np.unique(np.linspace(0, len(y) - 1, _POINTS).astype(np.int64))
        implot.SetNextLineStyle((*colour, 1.0), 1.5)
        implot.PlotLine(title, x[chosen].astype(np.float64), np.ascontiguousarray(y[chosen]))
        if ticks is not None:  # so that 0 is always in sight
            implot.SetNextLineStyle((0.0, 0.0, 0.0, 0.0), 1.0)
            implot.PlotLine("none", np.array([x[0], x[-1]], dtype=np.float64), np.zeros(2))
        implot.SetNextLineStyle((*palette.INK, 0.6), 1.0)
        implot.PlotInfLines("shown", np.array([float(shown)]))
    implot.EndPlot()


@takes_mesh
def play(
    v: ArrayLike,
    f: ArrayLike,
    method: str | Method = "lai2014",
    target: str | os.PathLike[str] | None = None,
    *,
    up: str = "auto",
    size: tuple[int, int] = PLAYER_SIZE,
) -> list[dict[str, Any]]:
    """Show a map coming about: before and after each iteration, with its folded faces in red.

    The surface stands beside the sphere before and after an iteration. A Moebius map magnifies the largest cluster of
    folded faces, for on a sphere a limb is tiny, and so are its foldings. The map is computed in a process of its own:
    call this below ``if __name__ == "__main__":``, for that process imports the program anew.

    Parameters
    ----------
    v : (n, 3) array_like of float
        Vertices of a closed, oriented, connected mesh of genus 0.
    f : (m, 3) array_like of int
        Faces.
    method : str or options of a method
        What is watched, such as "lai2014", the paper's algorithms (the default), or "auto".
    target : path, optional
        Write a picture (.png, .jpg) of the last step with foldings and the end, or a video (.gif, .mp4, or a folder of
        pictures), in place of opening a window; needs no display.
    up : str
        Which way is up: "x", "-x", "y", "-y", "z", "-z", or "auto": so that the surface stands safely.
    size : (int, int)
        Width and height in pixels; 1400 by 640 by default.

    Returns
    -------
    list of dict
        What each picture shows: ``title``, ``stage``, ``round``, ``iteration`` and ``foldings`` after the step, and the
        same of the map ``before`` it.

    Raises
    ------
    DisplayError
        If there is no display for a window, or no OpenGL.
    FileError
        If the picture or the video can't be written.
    MeshError
        If the mesh is no closed surface of genus 0.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> ism.play(*ism.samples.make("dino"))                             # doctest: +SKIP
    >>> ism.play(*ism.samples.make("dino"), "lai2014", "foldings.gif")  # doctest: +SKIP
    """
    mesh = check_mesh(v, f)
    method = method if isinstance(method, Method) else METHODS[method]()
    kind = PlayerWindow if target is None else Player
    load = partial(_load, mesh.vertices, mesh.f)
    return present(lambda: kind(load, _GIVEN, method, up=up, size=size), target, size=size)


def _load(v: FloatArray, f: IntArray, name: str) -> Source:
    """Vertices and faces by the name that the window shows, in any process."""
    if name == _GIVEN:
        return v, f
    if name.startswith("sample:"):
        return samples.from_spec(name.removeprefix("sample:"))
    loaded = read_mesh(name)
    return loaded.v, loaded.f
