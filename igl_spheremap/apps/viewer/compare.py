"""Surfaces side by side: any parts in rows, and one surface by several methods."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ...draw.palette import INK, LINES, SURFACE, Colour
from ...draw.plot import angle_histogram, fit, pose
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.check import Mesh
from ...mesh.disk import Disk
from ...plane.plane_map import in_space
from ...sphere.rows import unit_rows
from ...verify.certificate import Certificate
from ...verify.distortion import angle_differences
from ...verify.signs import folded_faces
from .app import App, ColouredApp, Colours, box, present
from .body import Body, Legend, Lens
from .choices import COMPARISON_SIZE, SUBJECTS
from .colouring import FOLDED_MARKS, SQUARES, Colouring, relief
from .grid import Grid, LensedSphere, draw_legend, text_width
from .result_view import count_foldings, edge_width
from .window import imgui, implot, is_offscreen, ps

#: Degrees at the end of the histograms of methods: the same for all, to be compared.
_DEGREES = 20.0
_HEAD, _FOOT = 70, 150  # pixels above the surfaces, and of the histograms below
#: Points of the line from a landmark to its target; radii of the dots of both and of the line, and how far landmarks
#: are lifted off the sphere: a target is larger, and seen around a landmark that has met it.
_STEPS, _DOT, _TARGET, _LINE, _LIFT = 40, 0.02, 0.032, 0.007, 1.02


@dataclass(frozen=True, eq=False)
class Part:
    """A surface inside the unit ball, and what is shown on it.

    Its face colours (m, 3), or a checkerboard by the coordinates (3 m, 2) of the corners of faces; its folded faces;
    for a sphere, the lens through which it is seen, with a small sphere beside it that shows where; points by a label,
    with their colour and their radius; whether edges are drawn; and what stands below it.
    """

    caption: str
    x: FloatArray
    f: IntArray
    colours: FloatArray | None = None
    folded: IntArray | None = None
    checks: FloatArray | None = None
    dots: Mapping[str, tuple[FloatArray, Colour, float]] = field(default_factory=dict)
    edges: float = 0.0
    legend: Legend | None = None
    lens: Lens | None = None


Rows = Sequence[Sequence[Part]]


class PartsView(App):
    """Parts in rows, which turn together."""

    def __init__(self, rows: Rows) -> None:
        self.grid = Grid(len(rows), max(map(len, rows)), panel=0)
        self._spheres = []
        for i, row in enumerate(rows):
            for k, part in enumerate(row):
                colours = np.tile(SURFACE, (len(part.f), 1)) if part.colours is None else part.colours
                if part.lens is None:
                    body = self.grid.place(i, k, Body(f"part {i} {k}", part.x, part.f, lift=part.folded is not None))
                    body.paint(colours, part.folded, part.checks)
                    body.show_edges(part.edges)
                else:
                    folded = np.empty(0, dtype=np.int64) if part.folded is None else part.folded
                    self._spheres.append(LensedSphere(self.grid, i, k, part.f, part.x))
                    self._spheres[-1].show(part.x, part.lens, Colouring(colours, folded, (), part.checks), part.edges)
                    body = self._spheres[-1].body
                for label, dots in part.dots.items():
                    body.dots(label, *dots)
                body.caption, body.legends = part.caption, [part.legend] if part.legend else []

    def panel(self) -> None:
        for sphere in self._spheres:
            sphere.annotate()


def show_parts(rows: Rows, target: str | os.PathLike[str] | None, *, size: tuple[int, int]) -> None:
    """Open a window with parts in rows, or write a picture of them or a video in which they turn."""
    present(lambda: PartsView(rows), target, size=size)


def plane_view(name: str, disk: Disk, p: FloatArray, up: str) -> PartsView:
    """A surface and its image in the plane, with a checkerboard of the plane on both."""
    certificate = Certificate.of_plane(p, disk.f, disk.rim)
    checks = SQUARES * p[disk.f].reshape(-1, 2) / np.ptp(p, axis=0).max()
    folded = np.sort(np.concatenate((certificate.flipped, certificate.degenerate)))
    return PartsView([[
        Part(f"{name}\n{len(disk.v):,} vertices", fit(disk.unit, pose(disk.unit, up)), disk.f, checks=checks),
        Part(f"in the plane\n{count_foldings(len(folded))}, {len(certificate.crossings):,} boundary edges that meet "
             "others", fit(in_space(p), np.eye(3)), disk.f, folded=folded, checks=checks),
    ]])  # fmt: skip


def landmark_part(
    caption: str, mesh: Mesh, x: FloatArray, landmarks: IntArray, targets: FloatArray | None = None,
    turn: FloatArray | None = None,
) -> Part:  # fmt: skip
    """A surface, or a map before a turn, with its landmarks, their targets, and lines from one to the other."""
    folded = None if targets is None else np.flatnonzero(folded_faces(x, mesh.f))  # a turn rounds, and may fold
    if turn is not None:
        x, targets = x @ turn.T, None if targets is None else targets @ turn.T
    grey = np.array(SURFACE) * relief(mesh)[:, None]
    dots = {"landmarks": (x[landmarks], LINES[0], _DOT)}
    if targets is not None:
        steps = np.linspace(0, 1, _STEPS)[:, None, None]
        line = unit_rows(((1 - steps) * x[landmarks] + steps * targets).reshape(-1, 3))
        dots |= {"targets": (targets, LINES[5], _TARGET), "way": (line, INK, _LINE),
                 "landmarks": (_LIFT * x[landmarks], LINES[0], _DOT)}
    return Part(caption, x, mesh.f, grey, folded, dots=dots)


class Comparison(ColouredApp):
    """A column for each map of a surface: surface and image in the same colours, and a histogram of the angles."""

    def __init__(self, mesh: Mesh, maps: Mapping[str, FloatArray], *, up: str = "auto") -> None:
        self.mesh, self.maps = mesh, maps
        self.grid = Grid(2, len(maps), panel=0, head=_HEAD, foot=_FOOT)
        self.differences = {name: angle_differences(mesh.unit, mesh.f, x)[mesh.surface] for name, x in maps.items()}
        self._histograms = {name: angle_histogram(one, _DEGREES) for name, one in self.differences.items()}
        self._folds = False
        best = min(maps, key=lambda name: np.abs(self.differences[name]).mean())
        self.colours, self._best = Colours(SUBJECTS[2]), maps[best]
        turn = pose(mesh.unit, up)
        for k, (name, x) in enumerate(maps.items()):
            surface = self.grid.place(0, k, Body(f"surface {k}", fit(mesh.unit, turn), mesh.f))
            image = self.grid.place(1, k, Body(f"image {k}", x @ turn.T, mesh.f, lift=True))
            folded = int(folded_faces(x, mesh.f).sum())
            self._folds |= folded > 0
            surface.caption = f"{name}\n{count_foldings(folded)}"
            image.caption = f"angles differ by\n{np.abs(self.differences[name]).mean():.3g} degrees"
        self.show_subject(self.colours.subject)

    def show_subject(self, subject: str) -> None:
        self.subject = self.colours.subject = subject
        for k, x in enumerate(self.maps.values()):
            colours = self.colours.of(self.mesh, x, like=self._best)
            bodies = [self.grid.bodies[row, k] for row in (0, 1)]
            replace(colours, legends=()).apply(*bodies)
            bodies[1].show_edges(edge_width(self.mesh, self.subject))
        self._legends = [self.colours.ramp] if self.colours.ramp else colours.legends

    def panel(self) -> None:
        self._draw_histograms()
        width = ps.get_window_size()[0]
        canvas = imgui.GetBackgroundDrawList()
        for legend in self._legends[:1]:
            draw_legend(canvas, 0.5 * width, 8, 300, legend)
        if self._folds:
            draw_legend(canvas, 0.82 * width, 8, 0.34 * width, FOLDED_MARKS)
        if is_offscreen():
            return
        with box("show", (8, 4), (250, _HEAD)):
            imgui.PushItemWidth(160)
            if self.colours.widgets():
                self.show_subject(self.colours.subject)
            imgui.PopItemWidth()

    def _draw_histograms(self) -> None:
        """Angle differences of each map under its column, on the same axes; bars at the ends are cut off."""
        top = max(float(share[1:-1].max()) for _, share in self._histograms.values())
        flags = implot.ImPlotFlags_CanvasOnly | implot.ImPlotFlags_NoInputs
        ticks, labels = np.linspace(-_DEGREES, _DEGREES, 5), ("degrees, image minus source", "degrees")
        for k, (name, (edges, share)) in enumerate(self._histograms.items()):
            left, upper, width, height = self.grid.cell(1, k)
            place, size = (left, upper + height), (width, self.grid.foot)
            with box(f"##histogram {k}", place, size, "NoDecoration", "NoBackground"):
                label = next((label for label in labels if text_width(label) < 0.9 * width), labels[-1])
                implot.PushStyleVar(implot.ImPlotStyleVar_PlotMinSize, (50.0, 50.0))
                if implot.BeginPlot(f"##{k}", (-1, -1), flags):
                    implot.SetupAxes(label, "", 0, implot.ImPlotAxisFlags_NoDecorations)
                    implot.SetupAxesLimits(-1.2 * _DEGREES, 1.2 * _DEGREES, 0, 1.05 * top, implot.ImPlotCond_Always)
                    implot.SetupAxisTicks(implot.ImAxis_X1, ticks, [f"{tick:g}" for tick in ticks])
                    implot.SetNextFillStyle((*LINES[0], 1.0))
                    implot.PlotShaded(name, (edges[1:] + edges[:-1]) / 2, np.minimum(share, top))
                    implot.EndPlot()
                implot.PopStyleVar()


def compare(
    mesh: Mesh, maps: Mapping[str, FloatArray], target: str | os.PathLike[str] | None = None, *, up: str = "auto",
    size: tuple[int, int] = COMPARISON_SIZE,
) -> None:  # fmt: skip
    """Open a window with maps (n, 3) of a surface by their names, or write a picture of it."""
    present(lambda: Comparison(mesh, maps, up=up), target, size=size)
