"""The player: each step of a run before and after, through one lens that follows the foldings; `play` opens it."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ... import samples
from ...draw.plot import fit, pose
from ...errors import check_number, legible
from ...gate import PathLike, takes_mesh
from ...io.files import read_mesh
from ...maps.options import METHODS, Method, method_of
from ...maps.spherical_conformal_map import spherical_conformal_map
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.check import Mesh, check_mesh
from ...result.recording import Frame
from ...result.run import Listener, Stage
from .app import SaveWidgets, file_stem, present
from .background_run import ShownRun, Source
from .choices import KEEP, SIZE, SUBJECTS, TIPS, guess_up
from .colouring import Colours
from .curves import energy_plot, folding_plot
from .grid import MOUSE, Grid, Part, text_width
from .lens_view import LensView
from .map_view import count_foldings, edge_width
from .widgets import FITTING, box, menu, panel, paragraph, tip, warning
from .window import imgui, pressed, ps

#: Begins a run by the name of a mesh, a method, and options of `repair_mesh` or None.
Start = Callable[[str, Method, "Mapping[str, Any] | None"], ShownRun]
#: The name of a surface that is given as arrays.
_GIVEN = "the given mesh"

_KEYS = (
    "The space bar plays, the arrow keys left and right step, up and down go to where foldings change much. "
    f"Drag the line in a curve. {MOUSE}"
)


def parameters(method: Method) -> dict[str, bool | int | float]:
    """The numbers and switches of a method.

    >>> parameters(METHODS["lai2014"]())["max_iterations"]
    5000
    """
    values = {field.name: getattr(method, field.name) for field in fields(method)}
    return {name: value for name, value in values.items() if type(value) in (bool, int, float)}


class Player(LensView):
    """A run, and the step of it that is shown: an iterate and the next one; below them, curves of the whole run.

    A step is called by the iterate that it starts from, counted from the Gauss map on, as in the curves. The last frame
    is a strip: the first and last maps of the run's stages. A panel runs others.
    """

    mesh: Mesh | None

    def __init__(
        self,
        start: Start,
        name: str,
        method: Method,
        *,
        up: str = "auto",
        always_up: bool = False,
    ) -> None:
        self._start = start
        self._first, self._first_up, self._always_up = name, up, always_up
        self.name, self.method = name, method
        #: Iterations that a picture goes on by.
        self.speed, self._refused = 1, ""
        self.colours = Colours(SUBJECTS[0])
        self._save = SaveWidgets(self, "", lambda: self.run.result)
        self._updated = self._ticked = time.monotonic()
        self._moved, self._rests_until = False, 0.0
        self._next: ShownRun | None = None
        self.grid = Grid(foot=170)  # of text and a hundred pixels of curves
        #: Why the last requested mesh is not shown.
        self.refusal: Exception | None = None
        run = start(name, method, None)
        run.name = name
        self._begin(run)

    def _begin(self, run: ShownRun) -> None:
        """Begin the picture anew, with another run."""
        self.run, self.mesh, self._save.name = run, None, file_stem(run.name, "run")
        self.playing = True
        self.before: Frame | None = None
        self.after: Frame | None = None
        self.leave_lens()
        self.colours = Colours(self.colours.subject)
        #: What is shown, and the iterate that the curves mark.
        self._shown: tuple[object, ...] = ()
        self._marked = -1

    def start(self, name: str, method: Method, repair: Mapping[str, Any] | None = None) -> None:
        """Begin a run, which is shown once its mesh is read; until then the last one stays.

        With options of `repair_mesh` the mesh is repaired first.
        """
        if self._next is not None:
            self._next.close()
        self._next = self._start(name, method, repair)
        self._next.name, self.message, self.refusal = name, "", None

    def prepare(self, listener: Listener | None = None) -> None:
        def notify(run: ShownRun) -> None:
            if listener is not None and run.frames:
                listener(run.frames[-1].iterate)

        run = self.run
        if self._next is not None:
            run = self._next
        run.wait(notify)
        if self.run.error is not None:
            raise self.run.error
        self._update()

    def frames(self) -> int:
        if not self.run.frames:
            return 1
        return max(1, self.run.frames[-1].index)

    def last_frame(self) -> int:
        """The strip of all stages."""
        return self.frames()

    def go_to(self, frame: int) -> None:
        """Show the step from an iterate, or from the last kept one before it; or the strip of `last_frame`."""
        frames = self.run.frames
        if self.mesh is None:
            return
        if frame == self.frames():
            self._show_strip(self.mesh)
        elif len(frames) == 1:
            self.show(frames[0], None)
        else:
            k = int(
                self.run.steps[
                    max(int(np.searchsorted(self.run.iterations, frame, "right")) - 1, 0)
                ]
            )
            self.show(frames[k], frames[k + 1])

    def film(self, length: int) -> list[tuple[Callable[[], None], bool]]:
        """Frames through the run, where the map moves or the number of its foldings changes; those at stops are held.

        Half of them divide the map's whole movement evenly, half the changes of foldings.
        """
        frames, kept = self.run.frames, self.run.iterations
        held = sorted({max(frames[k].index - 1, 0) for _, k in self.run.stops()})
        moved = np.array(
            [np.abs(frames[k + 1].iterate.x - frames[k].iterate.x).mean() for k in self.run.steps]
        )
        change = np.abs(np.diff(np.log1p(self.run.foldings))[kept])
        place = np.cumsum(change / (change.sum() or 1) + moved / (moved.sum() or 1))
        chosen = kept[
            np.searchsorted(place, np.linspace(0, place[-1], length)).clip(0, len(place) - 1)
        ]
        return [
            (partial(self.go_to, k), k in held)
            for k in np.union1d(chosen, np.array(held, dtype=int)).tolist()
        ]

    def facts(self) -> dict[str, Any]:
        assert self.before is not None
        assert self.after is not None
        return {**self._facts(self.after), "before": self._facts(self.before)}

    def _facts(self, frame: Frame) -> dict[str, Any]:
        """Facts of a frame's picture, for JSON."""
        step = frame.iterate.step
        return {
            "title": self.run.title(frame),
            "stage": str(step.stage),
            "round": step.round,
            "iteration": step.iteration,
            "foldings": frame.foldings,
        }

    def tick(self, rest: float = 2) -> None:
        """Take over computed iterates, and move on while playing.

        During a computation the next picture waits `rest` times the last one's time: they share processors.
        """
        began = time.monotonic()
        if self._moved:
            self._rests_until = began + rest * (began - self._ticked)
        self._ticked, self._moved = began, False
        self._update()
        super().tick()
        if not self.run.frames:
            return
        if self.before is None or self.after is None:
            self.go_to(0)
        elif self.playing and not (self.run.running and began < self._rests_until):
            before = self.before.index
            ahead = self.run.beside(before, self.speed)
            change = self.run.change(before, 1)
            if change is not None:
                ahead = min(ahead, change)  # slower where foldings change much
            self.go_to(ahead)
            self._moved = self.before.index > before
            self.playing = self._moved or self.run.running

    def close(self) -> None:
        for run in (self.run, self._next):
            if run is not None:
                run.close()

    def show(self, before: Frame, after: Frame | None) -> None:
        """Show two frames of the run through the same lens; without a second one yet, the first."""
        self.before, self.after = before, after
        state = before, after, self.run.result, self.colours.state, self.power
        if self.mesh is None or state == self._shown:
            return
        shown = before, after or before
        aim = int(shown[1].foldings > 0 and not before.foldings)
        self.find_clusters(self.mesh.f, shown[aim].folded)
        self._shown, self._marked = state, before.index
        first, second = self._spheres(self.mesh, shown, aim)
        source = Part(
            f"{Path(self.run.name).name}\n{len(self.mesh.v):,} vertices, {len(self.mesh.f):,} faces",
            self.source,
            self.mesh.f,
            (first, second)[aim].colours,
            legends=(first, second)[aim].legends,
        )
        said = "being computed"
        if after is not None:
            said = second.caption
        self.grid.show([[
            source, replace(first, caption=f"Before\n{first.caption}", legends=()),
            replace(second, caption=f"After\n{said}", legends=(), visible=after is not None),
        ]])  # fmt: skip

    def _show_strip(self, mesh: Mesh) -> None:
        """Show the Gauss map, an iteration on the way, both sides of the first star map, and the result.

        Each is a surface and a sphere. A lens on the foldings before the star map magnifies the last three.
        On the way half of the fall of the foldings' logarithm is done.
        """
        frames, end = self.run.frames, len(self.run.frames) - 1
        stars = [k for k, each in enumerate(frames[:-1]) if each.iterate.stage is Stage.STAR_MAP]
        star = min([*stars, end])
        before = max(star - 1, 0)
        counts = np.log1p([frame.foldings for frame in frames[: before + 1]])
        halfway = int(np.argmax(counts <= (counts[0] + counts[-1]) / 2))
        chosen = sorted({0, halfway, before, star, end})
        self.before, self.after, self._shown = frames[before], frames[-1], ()
        self.find_clusters(mesh.f, self.before.folded)
        spheres = self._spheres(mesh, [frames[k] for k in chosen], chosen.index(before))
        sources = [
            Part(part.caption, self.source, mesh.f, part.colours, legends=() if k else part.legends)
            for k, part in enumerate(spheres)
        ]
        below = []
        for k, part in zip(chosen, spheres, strict=True):
            if k < before:  # folds are all over it
                part = replace(part, caption="the whole sphere", lens=None)
            else:
                part = replace(part, caption="")
            below.append(replace(part, legends=()))
        self.grid.show([sources, below])

    def _spheres(self, mesh: Mesh, shown: Sequence[Frame], aim: int) -> list[Part]:
        """Frames on spheres through one lens, as strong as fits one of them."""
        maps = [frame.iterate.x @ self.turn.T for frame in shown]
        lenses = self.lenses(maps, mesh.f, aim)
        edges = 0.0
        if self.lens.power > 2:  # elsewhere they would be all that is seen
            edges = edge_width(mesh, self.colours.subject)
        parts = []
        for frame, x, lens in zip(shown, maps, lenses, strict=True):
            colours = self.colours.of(
                mesh, frame.iterate.x, frame.folded, self.run.frames[-1].iterate.x
            )
            parts.append(
                Part(
                    f"{self.run.title(frame)}\n{count_foldings(frame.foldings)}",
                    x,
                    mesh.f,
                    colours,
                    image=True,
                    lens=lens,
                    legends=colours.legends,
                    edges=edges,
                )
            )
        return parts

    def refresh(self) -> None:
        self._shown = ()
        if self.before is not None:
            self.show(self.before, self.after)

    def _update(self) -> None:
        """Take over the runs' progress since the last time."""
        began = time.monotonic()
        # as long as all else took: a run waits for a window that is behind
        spent = began - self._updated
        self.run.poll(spent)
        if self._next is not None:
            self._next.poll(spent)
            if self._next.mesh is not None:
                self.run.close()
                self._begin(self._next)
            if self._next.mesh is not None or self._next.error is not None:
                self.refusal, self._next = self._next.error, None
        self._updated = time.monotonic()
        if self.run.mesh is not None and self.mesh is None:
            self.mesh, self.turn = self.run.mesh, pose(self.run.mesh.unit, self._up())
            self.source = fit(self.mesh.unit, self.turn)

    def _up(self) -> str:
        """The up direction of the present surface."""
        if self._always_up or self.run.name == self._first:
            return self._first_up
        return guess_up(self.run.name)

    def panel(self) -> None:
        if self.before is not None:
            iterate = self._curves()
            if iterate is not None and self.grid.panel:
                self._leave_for(round(iterate))
        if not self.grid.panel:
            return
        with panel("Player", self.grid.panel, _KEYS):
            self._run_widgets()
            imgui.Separator()
            if self.before is not None:
                for widgets in (self._play_widgets, self.view_widgets, self._save):
                    widgets()
                    imgui.Separator()
                self.show(self.before, self.after)
            # What changes its height is below what is clicked.
            if imgui.TreeNode("parameters"):
                self._parameter_widgets()
                imgui.TreePop()
            if self._refused:
                warning(self._refused)
            for line in filter(None, (self.message, *self._state())):
                paragraph(line)
        if self.refusal is not None:
            self._refusal_widgets(self.refusal)
        self._keys()

    def _refusal_widgets(self, refusal: Exception) -> None:
        """Say beside the name of a mesh why it is not shown, above a button that repairs it."""
        width, left = ps.get_window_size()[0], self.grid.panel
        with box("refusal", (left, 0.0), (width - left, FITTING)):
            warning(f"{refusal}. Still shown: {self.run.name}")
            remedy = getattr(refusal, "remedy", None)
            if remedy is not None and remedy.function == "repair_mesh":
                if imgui.Button("repair and run"):
                    self.start(self.name, self.method, remedy.options)
                imgui.SameLine()
            if imgui.Button("close") or pressed("Escape"):
                self.refusal = None

    def _curves(self) -> float | None:
        """The curves of the run below the spheres, and the iterate at which one is pressed."""
        (width, height), left, high = ps.get_window_size(), self.grid.panel, self.grid.foot
        with box("curves", (left, height - high), (width - left, high)):
            size = (width - left) / 2 - 16, high - 16
            iterate = energy_plot(self.run.history, self._marked, size)
            imgui.SameLine()
            folding = folding_plot(self.run.history, self.run.foldings, self._marked, size)
        if folding is None:
            return iterate
        return folding

    def _run_widgets(self) -> None:
        changed, name = imgui.InputText("mesh", legible(self.name))
        if changed:
            self.name = name
        tip(f"{self.name}: a file, or a sample. The run before stays until this one is read.")
        names = [f"sample:{name}" for name in samples.names()]
        self.name = (
            menu("samples", self.name if self.name in names else "choose one", names) or self.name
        )
        if chosen := menu("method", self.method.name, METHODS):
            self.method, self._refused = METHODS[chosen](), ""
        if imgui.Button("run"):
            self.start(self.name, self.method)
        imgui.SameLine()
        imgui.BeginDisabled(not self.run.running)
        if imgui.Button("stop"):
            self.run.stop()
        imgui.EndDisabled()

    def _parameter_widgets(self) -> None:
        values = parameters(self.method)
        widest = max(map(text_width, values), default=0.0)
        for name, value in values.items():
            imgui.SetNextItemWidth(imgui.GetContentRegionAvail()[0] - widest - 8)
            label = name.replace("_", " ")
            if isinstance(value, bool):
                changed, value = imgui.Checkbox(label, value)
            elif isinstance(value, int):
                changed, value = imgui.InputInt(label, value)
            else:
                changed, value = imgui.InputDouble(label, value, format="%.1e")
            tip(TIPS[name])
            if not changed:
                continue
            try:
                self.method, self._refused = replace(self.method, **{name: value}), ""
            except ValueError as error:
                self._refused = str(error)

    def _state(self) -> list[str]:
        """Lines on the run's progress, memory, and notes."""
        run = self.run
        if run.error is not None:
            return [f"{type(run.error).__name__}: {run.error}"]
        if not run.frames:
            seconds = f"{time.monotonic() - run.began:.0f} s"
            if run.mesh is None:
                return [f"reading {run.name}, {seconds}"]
            return [f"making the first map of {len(run.mesh.v):,} vertices, {seconds}"]
        if run.result is None:
            count = sum(step.iteration > 0 for step in run.history)
            return [
                f"computing: {count:,} iterations, {count / max(run.seconds, 1e-3):,.0f} a second",
                run.memory,
            ]
        notes = (f"note: {note}" for note in run.result.notes)
        return [f"{run.result.iterations:,} iterations in {run.seconds:.3g} s", run.memory, *notes]

    def _play_widgets(self) -> None:
        assert self.before is not None
        at, last = self.before.index, self.frames() - 1
        label = "play "
        if self.playing:
            label = "pause"
        if imgui.Button(label, (50.0, 0.0)):
            self._toggle()
        for label, way in (("<", -1), (">", 1)):
            imgui.SameLine()
            if imgui.Button(label):
                self._leave_for(self.run.beside(at, way))
        imgui.SameLine()
        imgui.SetNextItemWidth(70)
        speeds = {f"x{speed}": speed for speed in (1, 2, 5, 10, 25, 100)}
        if chosen := menu("speed", f"x{self.speed}", speeds):
            self.speed = speeds[chosen]
        imgui.SetNextItemWidth(-1)
        moved, iteration = imgui.SliderInt("##iteration", at, 0, last, "iterate %d")
        tip("Of the whole run, from 0, the Gauss map; captions count within a stage.")
        if moved:
            self._leave_for(iteration)
        for label, way in (("previous", -1), ("next", 1)):
            change = self.run.change(at, way)
            imgui.BeginDisabled(change is None)
            if imgui.Button(label):
                self._leave_for(change)
            imgui.EndDisabled()
            tip(
                "To the next place where foldings halve or double; if there are many, to the largest changes."
            )
            imgui.SameLine()
        imgui.TextUnformatted("change of foldings")
        marks = dict(self.run.stops())
        here = [name for name, k in marks.items() if self.run.frames[k] is self.after]
        if chosen := menu("stops", here[-1] if here else "go to", marks):
            self._leave_for(self.run.frames[marks[chosen]].index - 1)

    def _keys(self) -> None:
        if self.before is None:
            return
        if pressed("Space"):
            self._toggle()
        for key, find, way in (
            ("LeftArrow", self.run.beside, -1),
            ("RightArrow", self.run.beside, 1),
            ("UpArrow", self.run.change, -1),
            ("DownArrow", self.run.change, 1),
        ):
            if pressed(key, again=True):
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


@takes_mesh
def play(
    v: ArrayLike,
    f: ArrayLike,
    *,
    method: str | Method = "lai2014",
    out: PathLike | None = None,
    up: str = "auto",
    size: tuple[int, int] = SIZE,
    keep: float = KEEP,
) -> list[dict[str, Any]]:
    """Show a map coming about: before and after each iteration, with its folded faces in red.

    The surface stands beside the sphere before and after an iteration. A Moebius map magnifies a cluster of folded
    faces, since on a sphere a limb is tiny, and so are its foldings. The map is computed in a process of its own, which
    imports the program anew: call this below ``if __name__ == "__main__":``.

    Parameters
    ----------
    v : (n, 3) array_like of float
        Vertex positions, any units, of a closed, oriented, connected mesh of genus 0.
    f : (m, 3) array_like of int
        Faces.
    method : str or options of a method
        Method to watch, such as "lai2014", the paper's algorithms (the default), or "auto".
    out : path, optional
        Write a picture (.png, .jpg) of the last step with foldings and the end, or a video (.gif, .mp4), in place of
        opening a window; needs no display.
    up : str
        Up direction: "x", "-x", "y", "-y", "z" or "-z"; "auto", the default, chooses that in which the surface stands
        safely; "left" and "right" show it from that side, with z up.
    size : (int, int)
        Width and height in pixels; 1280 by 760 by default.
    keep : float
        Megabytes of positions to keep, 400 by default. If those of all iterations take more, the window says which it
        keeps: those at starts, ends, star maps and changes of the number of foldings first.

    Returns
    -------
    list of dict
        Facts of each picture: ``title``, ``stage``, ``round``, ``iteration`` of the stage, and ``foldings`` after the
        step, and the same of the map ``before`` it.

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
    chosen = method_of(method)
    start = partial(
        in_background, partial(_load, mesh.v, mesh.f), round(1e6 * check_number(keep, "keep"))
    )
    return present(lambda: Player(start, _GIVEN, chosen, up=up), out, size=size)


def in_background(
    load: Callable[[str], Source],
    budget: int,
    name: str,
    method: Method,
    repair: Mapping[str, Any] | None = None,
) -> ShownRun:
    """Begin a run in another process; `load`, which must be picklable, takes a name to vertices and faces."""
    return ShownRun(budget).begin(
        partial(load, name), partial(spherical_conformal_map, method=method), repair
    )


def _load(v: FloatArray, f: IntArray, name: str) -> Source:
    """Vertices and faces by the name that the window shows, in any process."""
    if name == _GIVEN:
        return v, f
    if name.startswith("sample:"):
        return samples.from_spec(name.removeprefix("sample:"))
    loaded = read_mesh(name)
    return loaded.v, loaded.f
