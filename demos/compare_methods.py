"""The same surface by the Gauss map and by every method: angle differences, foldings, histograms.

Each column is a method: the surface and its image in the same colours, and the histogram of its angle
differences.
Frames 0, 1, 2 of --screenshot are foldings, conformal factor and angle differences.

    python demos/compare_methods.py
    python demos/compare_methods.py sample:octopus --methods lai2014 auto
    python demos/compare_methods.py cortex.gii --screenshot compared.png --frame 2
"""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace
from dataclasses import dataclass, replace

import numpy as np
import polyscope as ps
from common import demo_parser, main
from polyscope import imgui, implot

import igl_spheremap as ism
from igl_spheremap.apps.cli.inputs import InputMesh
from igl_spheremap.apps.viewer.app import App, subject_combo
from igl_spheremap.apps.viewer.body import Body
from igl_spheremap.apps.viewer.choices import SUBJECTS
from igl_spheremap.apps.viewer.colouring import FOLDED_LEGEND, colouring
from igl_spheremap.apps.viewer.stage import Stage, draw_legend
from igl_spheremap.draw.palette import LINES
from igl_spheremap.draw.plot import angle_histogram, fit, pose
from igl_spheremap.maps.options import METHODS
from igl_spheremap.mesh.measure import vertex_normals
from igl_spheremap.verify.distortion import mesh_angle_differences
from igl_spheremap.verify.signs import folded_faces

HEAD, FOOT = 54, 150
#: Degrees at the end of the colours and of the histograms: the same for all methods, to be compared.
REACH = 20.0
_GAP = 12


@dataclass(frozen=True, eq=False)
class Contender:
    """A map and its figures."""

    name: str
    x: np.ndarray
    foldings: int
    mean: float
    edges: np.ndarray
    share: np.ndarray

    @classmethod
    def of(cls, mesh: ism.Mesh, name: str, x: np.ndarray) -> Contender:
        """Measure a map."""
        differences = mesh_angle_differences(mesh, x)
        edges, share = angle_histogram(differences, REACH)
        return cls(name, x, int(folded_faces(x, mesh.f).sum()), float(np.abs(differences).mean()), edges, share)


def contenders(mesh: ism.Mesh, methods: list[str]) -> list[Contender]:
    """The Gauss map, and the map by each method."""
    maps = [("Gauss map", vertex_normals(mesh.v, mesh.f))]
    for method in methods:
        maps.append((method, ism.spherical_conformal_map(mesh.vertices, mesh.f, method).sphere))
    return [Contender.of(mesh, name, x) for name, x in maps]


class CompareMethods(App):
    """A column for each method."""

    def __init__(self, args: Namespace, source: InputMesh) -> None:
        self.mesh = ism.check_mesh(source.v, source.f)
        self.contenders = contenders(self.mesh, args.methods)
        self.stage = Stage(2, len(self.contenders), panel=0, head=HEAD, foot=FOOT)
        turn = pose(self.mesh.v, args.up)
        self.pairs = []
        for k, contender in enumerate(self.contenders):
            surface = self.stage.place(0, k, Body(f"surface {k}", fit(self.mesh.v, turn), self.mesh.f))
            image = self.stage.place(1, k, Body(f"image {k}", contender.x @ turn.T, self.mesh.f, lift=True))
            surface.caption = f"{contender.name}\n{contender.foldings:,} folded faces"
            image.caption = f"mean angle difference {contender.mean:.3g}"
            self.pairs.append((contender, surface, image))
        self.go_to(SUBJECTS.index("angle differences"))

    def frames(self) -> int:
        return len(SUBJECTS)

    def last_frame(self) -> int:
        return SUBJECTS.index(self.subject)

    def go_to(self, frame: int) -> None:
        self.subject = SUBJECTS[frame]
        reach = {"conformal factor": 2.0, "angle differences": REACH, "area distortion": 10.0}.get(self.subject)
        for contender, surface, image in self.pairs:
            colours = colouring(self.mesh, contender.x, self.subject, reach)
            replace(colours, legend=None).apply(surface, image)
            self.legend = colours.legend

    def panel(self) -> None:
        self.histograms()
        width = ps.get_window_size()[0]
        canvas = imgui.GetBackgroundDrawList()
        if self.legend is not FOLDED_LEGEND:
            draw_legend(canvas, 0.58 * width, 8, 300, self.legend)
        draw_legend(canvas, 0.85 * width, 4, 300, FOLDED_LEGEND)
        imgui.SetNextWindowPos((8, 4))
        imgui.SetNextWindowSize((290, 44))
        imgui.Begin("show", imgui.ImGuiWindowFlags_NoDecoration | imgui.ImGuiWindowFlags_NoBackground)
        imgui.PushItemWidth(180)
        subject = subject_combo(self.subject)
        imgui.PopItemWidth()
        imgui.End()
        if subject != self.subject:
            self.go_to(SUBJECTS.index(subject))

    def histograms(self) -> None:
        """Angle differences of each method under its column, on the same axes."""
        top = max(float(c.share.max()) for c in self.contenders)
        implot.StyleColorsLight()
        imgui.StyleColorsLight()
        for k, contender in enumerate(self.contenders):
            left, upper, width, height = self.stage.cell(1, k)
            imgui.SetNextWindowPos((left, upper + height))
            imgui.SetNextWindowSize((width - _GAP, FOOT))
            imgui.Begin(
                f"##histogram {k}",
                imgui.ImGuiWindowFlags_NoDecoration
                | imgui.ImGuiWindowFlags_NoBackground
                | imgui.ImGuiWindowFlags_NoSavedSettings,
            )
            flags = implot.ImPlotFlags_NoLegend | implot.ImPlotFlags_NoMouseText | implot.ImPlotFlags_NoMenus
            if implot.BeginPlot(f"##{k}", (-1, -1), flags):
                implot.SetupAxes("angle differences", "", 0, implot.ImPlotAxisFlags_NoDecorations)
                implot.SetupAxesLimits(-REACH, REACH, 0, 1.05 * top, implot.ImPlotCond_Always)
                implot.SetNextFillStyle((*LINES[0], 1.0))
                middles = (contender.edges[1:] + contender.edges[:-1]) / 2
                implot.PlotShaded(contender.name, middles, contender.share)
                implot.EndPlot()
            imgui.End()


def parser() -> ArgumentParser:
    """The arguments of this demo."""
    arguments = demo_parser(__doc__, "sample:dino")
    arguments.set_defaults(size=(1000, 680))
    arguments.add_argument(
        "--methods",
        nargs="+",
        choices=tuple(METHODS),
        default=list(METHODS),
        help="besides the Gauss map; default: all",
    )
    return arguments


if __name__ == "__main__":
    sys.exit(main("Compare methods", parser(), CompareMethods))
