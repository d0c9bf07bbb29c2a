"""The player in a window: panel and plots beside a run that goes on; and `play`, which opens it."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from dataclasses import fields, replace
from functools import partial
from typing import Any

from numpy.typing import ArrayLike

from ... import samples
from ...io.files import read_mesh
from ...maps.options import METHODS, Method
from ...maps.sphere_map import SphereMap
from ...maps.spherical_conformal_map import spherical_conformal_map
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.check import check_mesh
from ...mesh.objects import takes_mesh
from ...result.recording import Recording
from .app import SaveWidgets, lens_widgets, menu, panel, paragraph, present, tip
from .background_run import BackgroundRun, ShownRun, Source
from .choices import KEEP, SIZE
from .grid import PANEL, text_width
from .player import Player
from .window import imgui

#: The name of a surface that is given as arrays.
_GIVEN = "the given mesh"
#: Pixels of the button that plays, whatever it says.
_PLAY = 50.0
#: Iterations that a picture goes on by.
SPEEDS = (1, 2, 5, 10, 25, 100)

_HINT = (
    "The space bar plays, the arrow keys left and right step, up and down go to where foldings have halved or doubled. "
    "Drag the line in a curve. Drag to turn all, drag with the right button to shift, scroll to zoom, double-click to "
    "reset."
)


def parameters(method: Method) -> dict[str, bool | int | float]:
    """The numbers and switches of a method.

    >>> parameters(METHODS["lai2014"]())["max_iterations"]
    5000
    """
    values = {field.name: getattr(method, field.name) for field in fields(method)}
    return {name: value for name, value in values.items() if type(value) in (bool, int, float)}


def descriptions(method: Method) -> dict[str, str]:
    """What each option of a method does, from its documentation.

    >>> descriptions(METHODS["lai2014"]())["delta"]
    'Factor by which a refused step is shortened.'
    """
    found = re.findall(r"^    (\w+) : .*\n((?: {8}.*\n)+)", type(method).__doc__ or "", re.MULTILINE)
    return {name: " ".join(text.split()) for name, text in found}


class PlayerWindow(Player):
    """A player with a panel while the run goes on; with one that has ended there is nothing to run."""

    def __init__(
        self, start: Callable[[str, Method], ShownRun], name: str, method: Method, *, up: str = "auto"
    ) -> None:
        self.playing, self.speed, self._refused = True, SPEEDS[0], ""
        self._save = SaveWidgets(self, "run", lambda: self.run.result)
        super().__init__(start, name, method, up=up, panel=PANEL)

    def tick(self) -> None:
        """Move on while playing."""
        super().tick()
        if not self.run.frames:
            return
        if self.before is None or self.after is None:
            self.go_to(0)
        elif self.playing:
            before = self.before.index
            self.go_to(self.run.beside(before, self.speed))
            self.playing = self.before.index > before or self.run.running

    def panel(self) -> None:
        super().panel()
        if not self.grid.panel:
            return
        with panel("Player", self.grid.panel):
            if isinstance(self.run, BackgroundRun):
                self._run_widgets()
                imgui.Separator()
            if self.before is not None:
                for widgets in (self._play_widgets, self._view_widgets, self._save):
                    widgets()
                    imgui.Separator()
            # What changes its height is below what is clicked.
            if isinstance(self.run, BackgroundRun) and imgui.TreeNode("parameters"):
                self._parameter_widgets()
                imgui.TreePop()
            for line in filter(None, (self.message, *self._state(), self._refused, _HINT)):
                paragraph(line)
        self._keys()

    def _curves(self) -> float | None:
        place = super()._curves()
        if place is not None and self.grid.panel:
            self._leave_for(round(place))
        return place

    def _run_widgets(self) -> None:
        _, self.name = imgui.InputText("mesh", self.name)
        tip("A file, or a sample. The run before stays until this one is read.")
        names = [f"sample:{name}" for name in samples.names()]
        self.name = menu("samples", self.name if self.name in names else "choose one", names) or self.name
        if chosen := menu("method", self.method.name, METHODS):
            self.method, self._refused = METHODS[chosen](), ""
        if imgui.Button("run"):
            self.start(self.name, self.method)
            self.playing = True
        imgui.SameLine()
        imgui.BeginDisabled(not self.run.running)
        if imgui.Button("stop"):
            self.run.stop()
        imgui.EndDisabled()

    def _parameter_widgets(self) -> None:
        values, described = parameters(self.method), descriptions(self.method)
        widest = max(text_width(name) for name in values)
        for name, value in values.items():
            imgui.SetNextItemWidth(imgui.GetContentRegionAvail()[0] - widest - 8)
            label = name.replace("_", " ")
            if isinstance(value, bool):
                changed, value = imgui.Checkbox(label, value)
            elif isinstance(value, int):
                changed, value = imgui.InputInt(label, value)
            else:
                changed, value = imgui.InputDouble(label, value, format="%.1e")
            tip(described.get(name, ""))
            if not changed:
                continue
            try:
                self.method, self._refused = replace(self.method, **{name: value}), ""
            except ValueError as error:
                self._refused = str(error)

    def _state(self) -> list[str]:
        """How far the run is, what it takes, and what there is to say of it."""
        run = self.run
        if run.error is not None:
            return [f"{type(run.error).__name__}: {run.error}"]
        if not run.frames:
            return [f"reading {run.name}" if run.mesh is None else "making the first map"]
        count = len(run.foldings) - 1
        if run.result is None:
            return [f"computing: {count:,} iterations, {count / max(run.seconds, 1e-3):,.0f} a second", run.memory]
        notes = (f"note: {note}" for note in run.result.notes)
        return [f"{count:,} iterations in {run.seconds:.3g} s", run.memory, *notes]

    def _play_widgets(self) -> None:
        assert self.before is not None
        at, last = self.before.index, self.frames() - 1
        if imgui.Button("pause" if self.playing else "play ", (_PLAY, 0.0)):
            self._toggle()
        for label, way in (("<", -1), (">", 1)):
            imgui.SameLine()
            if imgui.Button(label):
                self._leave_for(self.run.beside(at, way))
        imgui.SameLine()
        imgui.SetNextItemWidth(70)
        speeds = {f"x{speed}": speed for speed in SPEEDS}
        if chosen := menu("speed", f"x{self.speed}", speeds):
            self.speed = speeds[chosen]
        imgui.SetNextItemWidth(-1)
        moved, iteration = imgui.SliderInt("##iteration", at, 0, last, "iteration %d")
        if moved:
            self._leave_for(iteration)
        for label, way in (("previous", -1), ("next", 1)):
            change = self.run.change(at, way)
            imgui.BeginDisabled(change is None)
            if imgui.Button(label):
                self._leave_for(change)
            imgui.EndDisabled()
            tip("To where there are half or twice as many foldings, none, or some.")
            imgui.SameLine()
        imgui.TextUnformatted("change of foldings")
        marks = dict(self.run.stops())
        here = [name for name, k in marks.items() if self.run.frames[k] is self.after]
        if chosen := menu("stops", here[-1] if here else "go to", marks):
            self._leave_for(self.run.frames[marks[chosen]].index - 1)

    def _keys(self) -> None:
        if imgui.GetIO().WantTextInput or self.before is None:
            return
        if imgui.IsKeyPressed(imgui.ImGuiKey_Space, False):
            self._toggle()
        for key, find, way in (
            (imgui.ImGuiKey_LeftArrow, self.run.beside, -1), (imgui.ImGuiKey_RightArrow, self.run.beside, 1),
            (imgui.ImGuiKey_UpArrow, self.run.change, -1), (imgui.ImGuiKey_DownArrow, self.run.change, 1),
        ):  # fmt: skip
            if imgui.IsKeyPressed(key):
                self._leave_for(find(self.before.index, way))

    def _toggle(self) -> None:
        """Play or pause; at the end, play from the beginning."""
        assert self.before is not None
        if not self.playing and self.before.index >= self.run.iterations[-1]:
            self.go_to(0)
        self.playing = not self.playing

    def _leave_for(self, iteration: int | None) -> None:
        """Stop playing, and show an iteration if there is one."""
        if iteration is not None:
            self.playing = False
            self.go_to(min(max(iteration, 0), self.frames() - 1))

    def _view_widgets(self) -> None:
        assert self.before is not None
        self.colours.widgets()
        if chosen := lens_widgets(self.spheres[0].lens.power, self.clusters.sizes, self.cluster):
            self.look(*chosen)
        self.show(self.before, self.after)


@takes_mesh
def play(
    v: ArrayLike,
    f: ArrayLike,
    *,
    method: str | Method = "lai2014",
    out: str | os.PathLike[str] | None = None,
    up: str = "auto",
    size: tuple[int, int] = SIZE,
    keep: float = KEEP,
) -> list[dict[str, Any]]:
    """Show a map coming about: before and after each iteration, with its folded faces in red.

    The surface stands beside the sphere before and after an iteration. A Moebius map magnifies a cluster of folded
    faces, for on a sphere a limb is tiny, and so are its foldings. The map is computed in a process of its own: call
    this below ``if __name__ == "__main__":``, for that process imports the program anew.

    Parameters
    ----------
    v : (n, 3) array_like of float
        Vertex positions, any units, of a closed, oriented, connected mesh of genus 0.
    f : (m, 3) array_like of int
        Faces.
    method : str or options of a method
        What is watched, such as "lai2014", the paper's algorithms (the default), or "auto".
    out : path, optional
        Write a picture (.png, .jpg) of the last step with foldings and the end, or a video (.gif, .mp4, or a folder of
        pictures), in place of opening a window; needs no display.
    up : str
        Which way is up: "x", "-x", "y", "-y", "z" or "-z"; "auto", the default, chooses the way in which the surface
        stands safely; "left" and "right" show it from that side, with z up.
    size : (int, int)
        Width and height in pixels; 1280 by 760 by default.
    keep : float
        Megabytes of positions to keep, 400 by default. Where those of all iterations take more, the window says which
        it keeps: those at starts, ends, star maps and changes of the number of foldings first.

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
        If the mesh is not a closed surface of genus 0.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> ism.play(*ism.samples.make("dino"))                             # doctest: +SKIP
    >>> ism.play(*ism.samples.make("dino"), method="lai2014", out="foldings.gif")  # doctest: +SKIP
    """
    mesh = check_mesh(v, f)
    method = method if isinstance(method, Method) else METHODS[method]()
    kind = PlayerWindow if out is None else Player
    start = partial(in_background, partial(_load, mesh.v, mesh.f), round(1e6 * keep))
    return present(lambda: kind(start, _GIVEN, method, up=up), out, size=size)


def play_recording(result: SphereMap, recording: Recording, out: str | None, *, up: str = "auto") -> None:
    """Open a window with a run that was recorded, or write its picture: the last step that changed the foldings."""
    run = ShownRun.of(recording, result)
    last = run.change(int(run.iterations[-1]), -1) or 0
    kind = PlayerWindow if out is None else Player
    present(lambda: kind(lambda name, method: run, "", METHODS[result.method](), up=up), out, frame=last)


def in_background(load: Callable[[str], Source], budget: int, name: str, method: Method) -> BackgroundRun:
    """Begin a run in another process; `load`, which must be picklable, takes a name to vertices and faces."""
    return BackgroundRun(partial(load, name), partial(spherical_conformal_map, method=method), budget=budget)


def _load(v: FloatArray, f: IntArray, name: str) -> Source:
    """Vertices and faces by the name that the window shows, in any process."""
    if name == _GIVEN:
        return v, f
    if name.startswith("sample:"):
        return samples.from_spec(name.removeprefix("sample:"))
    loaded = read_mesh(name)
    return loaded.v, loaded.f
