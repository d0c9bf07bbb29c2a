"""Watch foldings go: every iterate of Algorithm 1 and every round of Algorithm 2, on surface and sphere.

Play, pause, step and scrub through a run, or start another one on another mesh with another method: it
computes while the window goes on. Folded faces are vermilion. Before each star map come the conformal factor
that weights its eigenproblem, and the eigenfunctions, whose image is an ellipsoid while that factor is wrong.

    python demos/folding_removal.py
    python demos/folding_removal.py dinosaur.obj --up y --method lai2014
    python demos/folding_removal.py sample:bird --screenshot bird.png --frame -1
"""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace
from dataclasses import fields, replace
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
from igl_spheremap.maps.options import METHODS
from igl_spheremap.mesh.check import Mesh

SPEEDS = (1, 2, 5, 10, 25)


#: Options that the panel and the command line offer, of methods that have them.
KNOBS = ("tolerance", "max_iterations", "rounds")


def knows(method: str, option: str) -> bool:
    """Whether a method has an option."""
    return option in {field.name for field in fields(METHODS[method])}


class FoldingRemoval(App):
    """A run and the place in it that is shown."""

    def __init__(self, args: Namespace, source: Source) -> None:
        self.stage = Stage(1, 2)
        self.up = args.up
        self.name = source.name
        chosen = {key: getattr(args, key) for key in KNOBS if getattr(args, key) is not None}
        self.method = METHODS[args.method](**{key: value for key, value in chosen.items() if knows(args.method, key)})
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
        return Run(load_mesh, self.method)

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
        changed, chosen = imgui.Combo("method", methods.index(self.method.name), methods)
        if changed:
            self.method = METHODS[methods[chosen]]()
        for key in KNOBS:
            if not knows(self.method.name, key):
                continue
            value = getattr(self.method, key)
            if isinstance(value, float):
                changed, value = imgui.InputDouble(key, value, format="%.1e")
            else:
                changed, value = imgui.InputInt(key.replace("_", " "), value)
            if changed:
                self.method = replace(self.method, **{key: max(value, 0)})
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
