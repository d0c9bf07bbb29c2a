"""Watch foldings go: each step of a run before and after, through one lens that follows the foldings."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ...draw.folds import Clusters
from ...draw.plot import fit, pose
from ...maps.options import Method
from ...maps.spherical_conformal_map import spherical_conformal_map
from ...mesh.check import Mesh
from ...result.recording import BUDGET, Frame
from ...result.run import Listener
from .app import App
from .background_run import BackgroundRun, Source
from .body import Body, Lens, look_at
from .choices import SUBJECTS
from .colouring import colouring
from .grid import Grid, Inset
from .result_view import count_foldings, edge_width

#: Edges are drawn where the lens magnifies more than this; elsewhere they would be all that is seen.
_NEAR = 2.0
_NONE = np.empty(0, dtype=np.int64)
#: Widths of the surface and of both spheres, in a window and in pictures, which have no panel.
_IN_WINDOWS, _IN_PICTURES = (0.3, 0.35, 0.35), (0.5, 0.25, 0.25)


class Player(App):
    """A run, and the step of it that is shown: an iterate and the next one.

    A step is called by the iteration that it starts from, counted from the Gauss map on, as in the curves.
    `load` takes a name to vertices and faces, in another process: it must be picklable.
    """

    mesh: Mesh | None
    run: BackgroundRun

    def __init__(
        self,
        load: Callable[[str], Source],
        name: str,
        method: Method,
        *,
        up: str = "auto",
        panel: int = 0,
        foot: int = 0,
        budget: int = BUDGET,
    ) -> None:
        self._load, self._up, self._budget = load, up, budget
        self.grid = Grid(1, 3, panel=panel, foot=foot, shares=_IN_WINDOWS if panel else _IN_PICTURES)
        self.subject, self.zoom = SUBJECTS[0], 1.0
        self._updated = time.monotonic()
        self.start(name, method)

    def start(self, name: str, method: Method) -> None:
        """Begin a run, and the picture anew."""
        self.name, self.mesh = name, None
        self.grid.clear()
        self.before: Frame | None = None
        self.after: Frame | None = None
        self._shown: object = None
        self.clusters = Clusters(_NONE, _NONE)
        self._followed = _NONE
        solve = partial(spherical_conformal_map, method=method)
        self.run = BackgroundRun(partial(self._load, name), solve, budget=self._budget)

    def prepare(self, listener: Listener | None = None) -> None:
        def notify(run: BackgroundRun) -> None:
            if listener is not None and run.frames:
                listener(run.frames[-1].iterate)

        self.run.wait(notify)
        if self.run.error is not None:
            raise self.run.error
        self._update()

    def frames(self) -> int:
        return max(1, self.run.frames[-1].index) if self.run.frames else 1

    def last_frame(self) -> int:
        """Before: the last stop with foldings. After: the end."""
        return self.frames()

    def go_to(self, frame: int) -> None:
        """Show the step from an iteration, or the last one before it that was kept; or what `last_frame` says."""
        frames = self.run.frames
        if frame == self.frames():
            folded = [k for _, k in self.run.stops()[:-1] if frames[k].foldings]
            self.show(frames[folded[-1] if folded else 0], frames[-1])
        elif len(frames) == 1:
            self.show(frames[0], None)
        else:
            k = int(self.run.steps[max(int(np.searchsorted(self.run.iterations, frame, "right")) - 1, 0)])
            self.show(frames[k], frames[k + 1])

    def film(self, length: int) -> list[tuple[Callable[[], None], bool]]:
        """Frames through the run, half of them evenly, half where foldings change; those at stops are held."""
        kept = self.run.iterations
        held = sorted({max(self.run.frames[k].index - 1, 0) for _, k in self.run.stops()})
        foldings = np.log1p(self.run.foldings[kept])
        change = np.abs(np.diff(foldings, prepend=foldings[0]))
        place = np.cumsum(change / (change.sum() or 1) + 1 / len(change))
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
        self.run.close()

    def panel(self) -> None:
        if self.before is not None:
            self.inset.annotate()

    def show(self, before: Frame, after: Frame | None) -> None:
        """Show two frames of the run through the same lens; where there is no second one yet, the first."""
        self.before, self.after = before, after
        state = before, after, self.run.result, self.subject, self.zoom
        if self.mesh is None or state == self._shown:
            return
        self._shown = state
        if not self.images:
            self._set_images()
        aim = after if after is not None and after.foldings and not before.foldings else before
        self.clusters = Clusters.of(self.mesh.f, aim.folded)
        self._followed = self.clusters[self.cluster] if aim.foldings else _NONE
        for frame, body, word in zip((before, after), self.images, ("Before", "After"), strict=True):
            body.visible = frame is not None
            if frame is None:
                body.caption = f"{word}\nbeing computed"
                continue
            x = frame.iterate.x @ self.turn.T
            lens = look_at(x, self.mesh.f[self._followed]) if aim.foldings else Lens()
            lens = Lens(lens.place, lens.power * self.zoom)
            body.set_positions(lens(x))
            body.magnified = lens.power > 1
            colours = colouring(self.mesh, frame.iterate.x, self.subject, folded=frame.folded)
            body.paint(colours.colours, colours.folded)
            body.show_edges(edge_width(self.mesh, self.subject) if lens.power > _NEAR else 0.0)
            body.caption = f"{word}\n{self.run.title(frame)}\n{count_foldings(frame.foldings)}"
            if frame is aim:
                colours.apply(self.source)
                self.inset.show(x, lens, colours)

    @property
    def cluster(self) -> int:
        """The cluster of folded faces that the lens shows: the one that goes on from what it showed, or the largest."""
        shared = np.isin(self.clusters.faces, self._followed)
        return int(np.argmax(self.clusters.sums(shared.astype(np.float64)))) if len(self.clusters) else 0

    def follow(self, cluster: int) -> None:
        """Show another cluster of folded faces through the lens."""
        assert self.before is not None
        self._followed, self._shown = self.clusters[cluster], None
        self.show(self.before, self.after)

    def _update(self) -> None:
        """Take over what the run has done since the last time."""
        began = time.monotonic()
        self.run.poll(began - self._updated)  # as long as all else took: the run waits for a window that is behind
        self._updated = time.monotonic()
        if self.run.mesh is not None and self.mesh is None:
            self._set_mesh(self.run.mesh)

    def _set_mesh(self, mesh: Mesh) -> None:
        self.mesh = mesh
        self.turn = pose(mesh.unit, self._up)
        self.source = self.grid.place(0, 0, Body("source", fit(mesh.unit, self.turn), mesh.f))
        self.source.caption = f"{Path(self.name).name}\n{len(mesh.v):,} vertices, {len(mesh.f):,} faces"
        self.images: list[Body] = []  # until there is a map to show

    def _set_images(self) -> None:
        assert self.mesh is not None
        assert self.before is not None
        x = self.before.iterate.x
        self.images = [
            self.grid.place(0, k, Body(name, x, self.mesh.f, lift=True)) for k, name in ((1, "before"), (2, "after"))
        ]
        self.inset = Inset(self.grid, 0, 1, self.mesh.f, x)
