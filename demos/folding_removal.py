"""Watch foldings go: every iterate of Algorithm 1 and every round of Algorithm 2, on surface and sphere.

Play, pause, step and scrub through a run, or start another one on another mesh with another method: it
computes while the window goes on. Folded faces are vermilion. Before each star map come the conformal factor
that weights its eigenproblem, and the eigenfunctions, whose image is an ellipsoid while that factor is wrong.

    python demos/folding_removal.py
    python demos/folding_removal.py dinosaur.obj --up y --method lai2014
    python demos/folding_removal.py sample:bird --screenshot bird.png --frame -1
"""

from __future__ import annotations

import inspect
import sys
from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import Any

from common import demo_parser, main
from polyscope import imgui

from igl_spheremap import samples
from igl_spheremap.apps.cli.source import Source, read_source
from igl_spheremap.apps.viewer import App, Body, Run, Stage
from igl_spheremap.apps.viewer.colouring import SUBJECTS, colouring
from igl_spheremap.apps.viewer.curves import energy_plot, folding_plot
from igl_spheremap.apps.viewer.panel import begin_panel, end_panel, paragraph, subject_combo
from igl_spheremap.apps.viewer.pose import fit, pose
from igl_spheremap.apps.viewer.result_view import edge_width
from igl_spheremap.apps.viewer.timeline import Slide, final_slide, slides
from igl_spheremap.maps.methods import METHODS
from igl_spheremap.mesh.check import Mesh

SPEEDS = (1, 2, 5, 10, 25)


class FoldingRemoval(App):
    """A run and the place in it that is shown."""

    def __init__(self, args: Namespace, source: Source) -> None:
        self.stage = Stage(1, 2)
        self.up = args.up
        self.name = source.name
        self.method = args.method
        self.options = {
            "tolerance": args.tolerance,
            "max_iterations": args.max_iterations,
            "rounds": args.rounds,
        }
        self.at, self.shown = 0, -1
        self.playing, self.speed = True, 2
        self.subject, self.edges = SUBJECTS[0], True
        self.slides: list[Slide] = []
        self.run = self.start(lambda: (source.v, source.f))

    def start(self, load_mesh: Any) -> Run:
        """Begin a run, and the picture anew."""
        self.slides, self.at, self.shown = [], 0, -1
        self.mesh: Mesh | None = None
        self._complete = False
        known = inspect.signature(METHODS[self.method]).parameters
        options = {key: value for key, value in self.options.items() if value is not None and key in known}
        return Run(load_mesh, self.method, **options)

    def prepare(self) -> None:
        self.run.wait()
        if self.run.error is not None:
            raise self.run.error
        self.update()

    def frames(self) -> int:
        return len(self.slides)

    def go_to(self, frame: int) -> None:
        self.at = frame
        self.draw_slide()

    def tick(self) -> None:
        self.update()
        if self.playing and self.slides:
            self.at = min(self.at + SPEEDS[self.speed], len(self.slides) - 1)
        if self.slides:
            self.draw_slide()

    def close(self) -> None:
        self.run.stop()

    def update(self) -> None:
        """Take over what the run has done since the last time."""
        if self.run.mesh is None or self._complete:
            return
        if self.mesh is None:
            self.set_mesh(self.run.mesh)
        self._complete = not self.run.running  # before the frames are read, so that none is missed
        assert self.run.recording is not None
        self.slides = slides(self.run.recording.frames)
        if self.run.result is not None and self.slides:
            self.slides.append(final_slide(self.run.result, self.slides[-1].frame))

    def set_mesh(self, mesh: Mesh) -> None:
        """Put a mesh on the stage."""
        self.mesh = mesh
        self.stage.clear()
        self.turn = pose(mesh.v, self.up)
        self.source = self.stage.place(0, 0, Body("source", fit(mesh.v, self.turn), mesh.f))
        self.source.caption = f"Source: {Path(self.name).name}\n{len(mesh.v):,} vertices, {len(mesh.f):,} faces"
        self.image = self.stage.place(0, 1, Body("image", fit(mesh.v, self.turn), mesh.f, lift=True))

    def draw_slide(self) -> None:
        """Show where the run is."""
        if self.at == self.shown:
            return
        self.shown = self.at
        slide = self.slides[self.at]
        assert self.mesh is not None
        self.image.set_positions(slide.x @ self.turn.T)
        subject = slide.subject or self.subject
        colouring(self.mesh, slide.image, subject).apply(self.source, self.image)
        self.image.show_edges(edge_width(self.mesh, subject))
        foldings = slide.frame.foldings
        self.image.caption = f"{slide.title}\n{foldings:,} folded face{'s' * (foldings != 1)}"

    def panel(self) -> None:
        begin_panel("Folding removal", self.stage.panel)
        self.run_widgets()
        imgui.Separator()
        self.player_widgets()
        self.plots()
        end_panel()

    def run_widgets(self) -> None:
        """Which mesh, which method, and go."""
        names = [f"sample:{name}" for name in samples.names()]
        if imgui.BeginCombo("sample", self.name):
            for name in names:
                if imgui.Selectable(name, name == self.name)[0]:
                    self.name = name
            imgui.EndCombo()
        _, self.name = imgui.InputText("mesh", self.name)
        methods = list(METHODS)
        _, chosen = imgui.Combo("method", methods.index(self.method), methods)
        self.method = methods[chosen]
        known = inspect.signature(METHODS[self.method]).parameters
        for key, default in (("tolerance", 1e-3), ("max_iterations", 5000), ("rounds", 3)):
            if key not in known:
                continue
            value = self.options[key] if self.options[key] is not None else known[key].default
            if isinstance(default, float):
                changed, value = imgui.InputDouble(key, value, format="%.1e")
            else:
                changed, value = imgui.InputInt(key.replace("_", " "), value)
            if changed:
                self.options[key] = max(value, 0)
        if self.run.running:
            if imgui.Button("stop"):
                self.run.stop()
            imgui.SameLine()
            imgui.TextUnformatted(f"computing: {len(self.slides):,} pictures so far")
        elif imgui.Button("run"):
            name = self.name

            def load_mesh() -> Any:
                source = read_source(name)
                return source.v, source.f

            self.run = self.start(load_mesh)
        if self.run.error is not None:
            paragraph(f"{type(self.run.error).__name__}: {self.run.error}")

    def player_widgets(self) -> None:
        """Play, pause, step, scrub."""
        last = max(len(self.slides) - 1, 0)
        if imgui.Button("pause" if self.playing else "play "):
            if not self.playing and self.at == last:
                self.at = 0
            self.playing = not self.playing
        for label, step in (("<", -1), (">", 1)):
            imgui.SameLine()
            if imgui.Button(label):
                self.playing, self.at = False, min(max(self.at + step, 0), last)
        imgui.SameLine()
        imgui.PushItemWidth(70)
        _, self.speed = imgui.Combo("speed", self.speed, [f"x{speed}" for speed in SPEEDS])
        imgui.PopItemWidth()
        moved, at = imgui.SliderInt("picture", self.at, 0, last)
        if moved:
            self.playing, self.at = False, min(max(at, 0), last)
        subject = subject_combo(self.subject)
        if subject != self.subject:
            self.subject, self.shown = subject, -1

    def plots(self) -> None:
        """Energy and foldings of all iterates, with the one that is shown."""
        recording = self.run.recording
        if recording is None or not self.slides:
            return
        at = self.slides[min(self.at, len(self.slides) - 1)].frame.index
        room = max(90.0, (imgui.GetContentRegionAvail()[1] - 6) / 2)
        energy_plot(recording.history, at, room)
        folding_plot(recording.foldings, at, room)


def parser() -> ArgumentParser:
    """The arguments of this demo."""
    arguments = demo_parser(__doc__, "sample:dino")
    arguments.add_argument("--method", choices=tuple(METHODS), default="lai2014", help="default: lai2014, the paper")
    arguments.add_argument("--tolerance", type=float, metavar="T", help="of the stopping rule; default: the method's")
    arguments.add_argument("--max-iterations", type=int, metavar="N", help="default: the method's")
    arguments.add_argument("--rounds", type=int, metavar="N", help="of Algorithm 2 at the most; default: the method's")
    return arguments


if __name__ == "__main__":
    sys.exit(main("Folding removal", parser(), FoldingRemoval))
