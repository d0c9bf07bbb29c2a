"""Watch foldings go: each step of a run before and after, through one lens that follows the foldings."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from ...maps.options import Method
from ...mesh.check import Mesh
from .app import App
from .body import Body
from .choices import PLAYER_SIZE, SUBJECTS
from .colouring import Colouring, colouring
from .inset import Inset
from .lens import Lens, follow
from .pose import fit, pose
from .result_view import count_foldings, edge_width
from .run import Run, Source
from .stage import Stage
from .timeline import Slide, stops

#: Seconds of each frame that a window spends on new iterates at the most.
_POLL = 0.02
#: Edges are drawn where the lens magnifies more than this; elsewhere they would be all that is seen.
_NEAR = 2.0


class Player(App):
    """A run, and the step of it that is shown: a slide and the one before it, or any earlier one.

    `load` takes a name to vertices and faces, in another process: it must be picklable.
    """

    def __init__(
        self,
        load: Callable[[str], Source],
        name: str,
        method: Method,
        *,
        up: str = "z",
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
        self.run = Run(partial(self._load, name), method, live=self._live)

    mesh: Mesh | None
    run: Run

    def prepare(self) -> None:
        self.run.wait()
        if self.run.error is not None:
            raise self.run.error
        self._update()

    def frames(self) -> int:
        return max(1, len(self.run.slides) - 1)

    def last_frame(self) -> int:
        """Before: the last stop with foldings. After: the end."""
        return self.frames()

    def stops(self) -> list[int]:
        return sorted({max(k - 1, 0) for _, k in stops(self.run.slides)})

    def go_to(self, frame: int) -> None:
        if frame == self.frames():
            folded = [k for _, k in stops(self.run.slides)[:-1] if self.run.slides[k].foldings]
            self.show(folded[-1] if folded else 0, len(self.run.slides) - 1)
        else:
            self.show(frame, min(frame + 1, len(self.run.slides) - 1))

    def facts(self) -> dict[str, Any]:
        before, after = (self.run.slides[k] for k in (self.before, self.after))
        return {**after.facts(), "before": before.facts()}

    def tick(self) -> None:
        self._update()

    def close(self) -> None:
        self.run.close()

    def panel(self) -> None:
        if self.mesh is not None:
            self.inset.annotate()

    def show(self, before: int, after: int) -> None:
        """Show two slides through the same lens."""
        self.before, self.after = before, after
        slides = self.run.slides
        state = slides[before], slides[after], self.subject, self.zoom
        if self.mesh is None or state == self._shown:
            return
        self._shown = state
        aim = next((slide for slide in state[:2] if slide.foldings), state[0])
        for slide, body, word in zip(state[:2], self.images, ("Before", "After"), strict=True):
            x = slide.x @ self.turn.T
            lens = follow(x, self.mesh.f, aim.folded)
            lens = Lens(lens.place, lens.power * self.zoom)
            body.set_positions(lens(x))
            body.raised = lens.power > 1
            colours = self._colours(slide)
            body.paint(colours.colours, colours.folded)
            body.show_edges(edge_width(self.mesh, self.subject) if lens.power > _NEAR else 0.0)
            body.caption = f"{word}: {slide.title}\n{count_foldings(slide.foldings)}"
            if slide is aim:
                colours.apply(self.source)
                self.inset.show(x, lens, colours)

    def _colours(self, slide: Slide) -> Colouring:
        assert self.mesh is not None
        return colouring(self.mesh, slide.x, self.subject, folded=slide.folded)

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
