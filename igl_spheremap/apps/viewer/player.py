"""Watch foldings go: each step of a run before and after, through one lens that follows the foldings."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ...draw.plot import fit, pose
from ...maps.options import Method
from ...maps.spherical_conformal_map import spherical_conformal_map
from ...mesh.check import Mesh
from ...result.run import Listener
from .app import App
from .background_run import BackgroundRun, Source
from .body import Body, Lens, follow
from .choices import PLAYER_SIZE, SUBJECTS
from .colouring import colouring
from .result_view import count_foldings, edge_width
from .stage import Inset, Stage

#: Seconds of each frame that a window spends on new iterates at the most.
_POLL = 0.02
#: Edges are drawn where the lens magnifies more than this; elsewhere they would be all that is seen.
_NEAR = 2.0


class Player(App):
    """A run, and the step of it that is shown: a frame and the one before it, or any earlier one.

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
        size: tuple[int, int] = PLAYER_SIZE,
        panel: int = 0,
        live: bool = False,
    ) -> None:
        self._load, self._up, self._live = load, up, live
        left = size[0] / 2 - panel
        self.stage = Stage(1, 3, panel=panel, shares=(max(left, 0.25 * size[0]), size[0] / 4, size[0] / 4))
        self.subject, self.zoom = SUBJECTS[0], 1.0
        self.start(name, method)

    def start(self, name: str, method: Method) -> None:
        """Begin a run, and the picture anew."""
        self.name, self.mesh = name, None
        self.before = self.after = 0
        self._shown: object = None
        solve = partial(spherical_conformal_map, method=method)
        self.run = BackgroundRun(partial(self._load, name), solve, live=self._live)

    def prepare(self, listener: Listener | None = None) -> None:
        def notify(run: BackgroundRun) -> None:
            if listener is not None and run.frames:
                listener(run.frames[-1].iterate)

        self.run.wait(notify)
        if self.run.error is not None:
            raise self.run.error
        self._update()

    def frames(self) -> int:
        return max(1, len(self.run.frames) - 1)

    def last_frame(self) -> int:
        """Before: the last stop with foldings. After: the end."""
        return self.frames()

    def go_to(self, frame: int) -> None:
        if frame == self.frames():
            folded = [k for _, k in self.run.stops()[:-1] if self.run.frames[k].foldings]
            self.show(folded[-1] if folded else 0, len(self.run.frames) - 1)
        else:
            self.show(frame, min(frame + 1, len(self.run.frames) - 1))

    def film(self, length: int) -> list[tuple[Callable[[], None], bool]]:
        """Frames through the run, half of them evenly, half where foldings change; those at stops are held."""
        held = sorted({max(k - 1, 0) for _, k in self.run.stops()})
        foldings = np.log1p([frame.foldings for frame in self.run.frames[: self.frames()]])
        change = np.abs(np.diff(foldings, prepend=foldings[0]))
        place = np.cumsum(change / (change.sum() or 1) + 1 / len(change))
        chosen = np.searchsorted(place, np.linspace(0, place[-1], length)).clip(0, len(place) - 1)
        return [(partial(self.go_to, k), k in held) for k in np.union1d(chosen, np.array(held, dtype=int)).tolist()]

    def facts(self) -> dict[str, Any]:
        return {**self._facts(self.after), "before": self._facts(self.before)}

    def _facts(self, k: int) -> dict[str, Any]:
        """What a picture of a frame shows, for JSON."""
        frame = self.run.frames[k]
        step = {name: getattr(frame.iterate, name) for name in ("stage", "round", "iteration")}
        return {"title": self.run.title(frame), **step, "foldings": frame.foldings}

    def tick(self) -> None:
        self._update()

    def close(self) -> None:
        self.run.close()

    def panel(self) -> None:
        if self.mesh is not None:
            self.inset.annotate()

    def show(self, before: int, after: int) -> None:
        """Show two frames of the run through the same lens."""
        self.before, self.after = before, after
        frames = self.run.frames
        state = frames[before], frames[after], self.subject, self.zoom
        if self.mesh is None or state == self._shown:
            return
        self._shown = state
        aim = next((frame for frame in state[:2] if frame.foldings), state[0])
        for frame, body, word in zip(state[:2], self.images, ("Before", "After"), strict=True):
            x = frame.iterate.x @ self.turn.T
            lens = follow(x, self.mesh.f, aim.folded)
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

    def _update(self) -> None:
        """Take over what the run has done since the last time."""
        self.run.poll(_POLL)
        if self.run.mesh is not None and self.mesh is None:
            self._set_mesh(self.run.mesh)

    def _set_mesh(self, mesh: Mesh) -> None:
        self.mesh = mesh
        self.stage.clear()
        self.turn = pose(mesh.v, self._up)
        v = fit(mesh.v, self.turn)
        self.source = self.stage.place(0, 0, Body("source", v, mesh.f))
        self.source.caption = f"{Path(self.name).name}\n{len(mesh.v):,} vertices, {len(mesh.f):,} faces"
        self.images = [
            self.stage.place(0, k, Body(name, v, mesh.f, lift=True)) for k, name in ((1, "before"), (2, "after"))
        ]
        self.inset = Inset(self.stage, 0, 1, mesh.f, v)
