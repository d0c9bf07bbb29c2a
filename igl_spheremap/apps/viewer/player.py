"""Watch foldings go: each step of a run before and after, through one lens that follows the foldings."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ...draw.folds import Clusters
from ...draw.plot import fit, pose
from ...maps.options import Method
from ...mesh.check import Mesh
from ...result.recording import Frame
from ...result.run import Listener
from .app import App, Colours, box
from .background_run import ShownRun
from .body import Body, Lens, follow
from .choices import SUBJECTS
from .colouring import Colouring
from .curves import energy_plot, folding_plot
from .grid import Grid, LensedSphere, magnification
from .result_view import count_foldings, edge_width
from .window import imgui, ps

#: Edges are drawn where the lens magnifies more than this; elsewhere they would be all that is seen.
_NEAR = 2.0
_NONE = np.empty(0, dtype=np.int64)
#: Widths of the surface and of both spheres, in a window and in pictures, which have no panel.
_IN_WINDOWS, _IN_PICTURES = (0.3, 0.35, 0.35), (0.5, 0.25, 0.25)
#: Height in pixels of the curves below the spheres: text and a hundred pixels of curve.
_CURVES = 170


class Player(App):
    """A run, and the step of it that is shown: an iterate and the next one; below them, curves of the whole run.

    A step is called by the iteration that it starts from, counted from the Gauss map on, as in the curves. The last
    frame is a strip: what each stage of the run began and ended with.
    """

    mesh: Mesh | None

    def __init__(
        self, start: Callable[[str, Method], ShownRun], name: str, method: Method, *, up: str = "auto", panel: int = 0
    ) -> None:
        self._start, self._up, self._panel = start, up, panel
        self.name, self.method = name, method
        self.colours = Colours(SUBJECTS[0])
        #: How much the lens magnifies; None: as fits what it is on.
        self.power: float | None = None
        self._updated = time.monotonic()
        self._next: ShownRun | None = None
        self.grid = self._new_grid()
        run = start(name, method)
        run.name = name
        self._begin(run)

    def _begin(self, run: ShownRun) -> None:
        """Begin the picture anew, with another run."""
        self.run, self.mesh = run, None
        self.before: Frame | None = None
        self.after: Frame | None = None
        self.clusters = Clusters(_NONE, _NONE)
        self._followed, self._facing = _NONE, np.eye(3)
        self.colours = Colours(self.colours.subject)

    def _new_grid(self, rows: int = 1, columns: int = 3) -> Grid:
        """A grid without bodies, in place of the one that there is."""
        shares = () if rows > 1 else _IN_WINDOWS if self._panel else _IN_PICTURES
        #: The spheres of the grid, what they show, and the iteration that the curves mark.
        self.spheres: list[LensedSphere] = []
        self._shown, self._marked = object(), -1
        return Grid(rows, columns, panel=self._panel, foot=_CURVES, shares=shares)

    def start(self, name: str, method: Method) -> None:
        """Begin a run, which is shown once its mesh is read: until then the one before stays."""
        if self._next is not None:
            self._next.close()
        self._next = self._start(name, method)
        self._next.name, self.message = name, ""

    def prepare(self, listener: Listener | None = None) -> None:
        def notify(run: ShownRun) -> None:
            if listener is not None and run.frames:
                listener(run.frames[-1].iterate)

        (self._next or self.run).wait(notify)
        if self.run.error is not None:
            raise self.run.error
        self._update()

    def frames(self) -> int:
        return max(1, self.run.frames[-1].index) if self.run.frames else 1

    def last_frame(self) -> int:
        """The strip of all stages."""
        return self.frames()

    def go_to(self, frame: int) -> None:
        """Show the step from an iteration, or the last one before it that was kept; or what `last_frame` says."""
        frames = self.run.frames
        if frame == self.frames() and self.mesh is not None and not self._panel:
            self._show_strip(self.mesh)
        elif len(frames) == 1:
            self.show(frames[0], None)
        else:
            k = int(self.run.steps[max(int(np.searchsorted(self.run.iterations, frame, "right")) - 1, 0)])
            self.show(frames[k], frames[k + 1])

    def film(self, length: int) -> list[tuple[Callable[[], None], bool]]:
        """Frames through the run, where the map moves or the number of its foldings changes; those at stops are held.

        Half of them lie where half of all that the map moves is done, half where foldings change.
        """
        frames, kept = self.run.frames, self.run.iterations
        held = sorted({max(frames[k].index - 1, 0) for _, k in self.run.stops()})
        moved = np.array([np.abs(frames[k + 1].iterate.x - frames[k].iterate.x).mean() for k in self.run.steps])
        change = np.abs(np.diff(np.log1p(self.run.foldings))[kept])
        place = np.cumsum(change / (change.sum() or 1) + moved / (moved.sum() or 1))
        chosen = kept[np.searchsorted(place, np.linspace(0, place[-1], length)).clip(0, len(place) - 1)]
        return [(partial(self.go_to, k), k in held) for k in np.union1d(chosen, np.array(held, dtype=int)).tolist()]

    def facts(self) -> dict[str, Any]:
        assert self.before is not None
        assert self.after is not None
        return {**self._facts(self.after), "before": self._facts(self.before)}

    def _facts(self, frame: Frame) -> dict[str, Any]:
        """What a picture of a frame shows, for JSON."""
        step = frame.iterate.step
        return {"title": self.run.title(frame), "stage": step.stage, "round": step.round, "iteration": frame.index,
                "foldings": frame.foldings}

    def tick(self) -> None:
        self._update()

    def close(self) -> None:
        for run in (self.run, self._next):
            if run is not None:
                run.close()

    def panel(self) -> None:
        for sphere in self.spheres:
            sphere.annotate()
        if self.before is not None:
            self._curves()

    def _curves(self) -> float | None:
        """The curves of the run below the spheres, and the iteration at which one is pressed."""
        (width, height), left, high = ps.get_window_size(), self.grid.panel, self.grid.foot
        with box("curves", (left, height - high), (width - left, high)):
            size = (width - left) / (1 + (left > 0)) - 16, high - 16
            pressed = energy_plot(self.run.history, self._marked, size) if left else None
            imgui.SameLine()
            folding = folding_plot(self.run.history, self.run.foldings, self._marked, size)
        return pressed if folding is None else folding

    def show(self, before: Frame, after: Frame | None) -> None:
        """Show two frames of the run through the same lens; where there is no second one yet, the first."""
        self.before, self.after = before, after
        state = before, after, self.run.result, self.colours.state, self.power
        if self.mesh is None or state == self._shown:
            return
        if self.grid.rows > 1:
            self._place(self.mesh)
        if not self.spheres:
            self.spheres = [LensedSphere(self.grid, 0, k, self.mesh.f, before.iterate.x) for k in (1, 2)]
        self._shown, self._marked = state, before.index
        shown = before, after or before
        aim = int(shown[1].foldings > 0 and not before.foldings)
        self._follow(shown[aim])
        self._show_spheres(self.mesh, shown, aim)[aim].apply(self.source)
        for word, sphere in zip(("Before", "After"), self.spheres, strict=True):
            sphere.body.caption = f"{word}\n{sphere.body.caption}"
        self.spheres[1].small.visible = False  # the lens is that of the first
        self.spheres[1].body.visible = after is not None
        if after is None:
            self.spheres[1].body.caption = "After\nbeing computed"

    def _show_strip(self, mesh: Mesh) -> None:
        """Show how the stages end: the surface and the sphere of the Gauss map, of both sides of the first star map, of
        the last iterate and of the result, all but the first through a lens on what folded before the star map.
        """
        frames = self.run.frames
        star = next((k for k, frame in enumerate(frames[:-1]) if frame.iterate.stage == "star map"), len(frames) - 1)
        chosen = sorted({0, star - 1, star, len(frames) - 2, len(frames) - 1} & {*range(len(frames))})
        self.before, self.after = frames[max(star - 1, 0)], frames[-1]
        self.grid.clear()
        self.grid = self._new_grid(2, len(chosen))
        self.spheres = [LensedSphere(self.grid, 1, k, mesh.f, mesh.unit) for k in range(len(chosen))]
        self._follow(self.before)
        painted = self._show_spheres(mesh, [frames[k] for k in chosen], chosen.index(max(star - 1, 0)))
        for k, (colours, sphere) in enumerate(zip(painted, self.spheres, strict=True)):
            body = self.grid.place(0, k, Body(f"surface {k}", fit(mesh.unit, self.turn), mesh.f))
            colours.apply(body)
            body.legends = colours.legends if k == 0 else ()
            body.caption, sphere.body.caption = sphere.body.caption, "" if k else magnification(1.0)
        self.spheres[0].show(self.spheres[0].small.x, Lens(), painted[0])  # its folds are all over it

    def _show_spheres(self, mesh: Mesh, shown: Sequence[Frame], aim: int) -> list[Colouring]:
        """Show frames on the spheres through one lens, as strong as fits one of them, and how they are coloured."""
        maps = [frame.iterate.x @ self.turn.T for frame in shown]
        lenses = follow(maps, mesh.f, self._followed, aim, self.power, self._facing)
        painted = []
        for frame, sphere, x, lens in zip(shown, self.spheres, maps, lenses, strict=True):
            painted.append(self.colours.of(mesh, frame.iterate.x, frame.folded, self.run.frames[-1].iterate.x))
            edges = edge_width(mesh, self.colours.subject) if lens.power > _NEAR else 0.0
            sphere.show(x, lens, painted[-1], edges)
            sphere.body.caption = f"{self.run.title(frame)}\n{count_foldings(frame.foldings)}"
        return painted

    def _follow(self, frame: Frame) -> None:
        """Follow the cluster of folded faces that goes on from the one before, or the largest."""
        assert self.mesh is not None
        self.clusters = Clusters.of(self.mesh.f, frame.folded)
        self._followed = self.clusters[self.cluster] if self.clusters else _NONE

    @property
    def cluster(self) -> int:
        """The cluster of folded faces that the lens shows: the one that goes on from what it showed, or the largest."""
        shared = np.isin(self.clusters.faces, self._followed)
        return int(np.argmax(self.clusters.sums(shared.astype(np.float64)))) if len(self.clusters) else 0

    def look(self, power: float | None, cluster: int | None = None) -> None:
        """Magnify by a power, None by what fits; another cluster of folded faces if it is given."""
        assert self.before is not None
        self.power, self._facing, self._shown = power, self.grid.turn, object()
        if cluster is not None:
            self._followed = self.clusters[cluster]
        self.show(self.before, self.after)

    def _update(self) -> None:
        """Take over what the runs have done since the last time."""
        began = time.monotonic()
        spent = began - self._updated  # as long as all else took: a run waits for a window that is behind
        self.run.poll(spent)
        if self._next is not None:
            self._next.poll(spent)
            if self._next.mesh is not None:
                self.run.close()
                self._begin(self._next)
            if self._next.mesh is not None or self._next.error is not None:
                self.message, self._next = str(self._next.error or ""), None
        self._updated = time.monotonic()
        if self.run.mesh is not None and self.mesh is None:
            self.mesh, self.turn = self.run.mesh, pose(self.run.mesh.unit, self._up)
            self._place(self.mesh)

    def _place(self, mesh: Mesh) -> None:
        """Put the surface on a new grid."""
        self.grid.clear()
        self.grid = self._new_grid()
        self.source = self.grid.place(0, 0, Body("source", fit(mesh.unit, self.turn), mesh.f))
        self.source.caption = f"{Path(self.run.name).name}\n{len(mesh.v):,} vertices, {len(mesh.f):,} faces"
