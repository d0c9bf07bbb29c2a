"""A map between two surfaces: both and surfaces between them, in colours that are carried from one to the other."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np

from ...draw.palette import LINES, SURFACE, round_up, sizes
from ...draw.plot import fit, pose
from ...mesh.measure import vertex_areas
from ...resampling.transfer import interpolate
from ...shapes.correspondence.surface_map import SurfaceMap
from ...sphere.moebius import best_rotation
from ...sphere.rows import unit_rows
from .app import ColouredApp, SaveWidgets
from .choices import CARRIED
from .colouring import SQUARES, Colouring, deepest_tips, mercator_corners, places, poles_at
from .grid import MOUSE, Grid, Part
from .widgets import panel, paragraph, subject_menu
from .window import imgui

_DIRICHLET = "symmetric Dirichlet energy above an isometry's"


class CarriedView(ColouredApp):
    """Source, a surface on the way, and target: one mesh, the overlay, in the same colours.

    A film goes from the source to the target and back.
    """

    subjects = CARRIED

    def __init__(self, result: SurfaceMap, *, up: str = "auto", subject: str = CARRIED[0]) -> None:
        self.result, self.common = result, result.overlay()
        self.distortion = result.distortion()
        a, b, f = self.common.on_source, self.common.on_target, self.common.faces
        turn = pose(a, up)
        areas = vertex_areas(a, f)
        weights = areas / areas.sum()
        onto = best_rotation(b - weights @ b, a - weights @ a, weights)
        self.ends = fit(a, turn), fit(b @ onto, turn)
        self._x = unit_rows(
            interpolate(result.map.sphere, result.map.faces, self.common.source_location)
        )
        self.grid = Grid()
        self._save = SaveWidgets(self, "match", None)
        self.way = 0.5
        self._captions = []
        for name, each, over in (
            ("source", result.map, "over_source"),
            ("target", result.target, "over_target"),
        ):
            figures = self.distortion.figures[over]["symmetric_dirichlet"]
            self._captions.append(
                f"{name}: {len(each.vertices):,} vertices\ndistortion {figures['median']:.3g}, "
                f"95% below {figures['p95']:.3g} (4: isometry)"
            )
        self.show_subject(subject)

    def show_subject(self, subject: str) -> None:
        """Colour all three by one of `CARRIED`."""
        self.subject = subject
        mesh, faces = self.result.map.mesh, self.common.faces
        if subject == "checkerboard":
            sphere = self.result.map.sphere
            corners = SQUARES * mercator_corners(
                self._x, faces, poles_at(sphere, deepest_tips(mesh, sphere))
            )
            colours = Colouring(np.tile(SURFACE, (len(faces), 1)), checks=corners)
        elif subject == "places":
            colours = Colouring(places(mesh)[self.common.source_face])
        else:
            excess = self.distortion.symmetric_dirichlet - 4
            p95 = self.distortion.figures["over_source"]["symmetric_dirichlet"]["p95"] - 4
            ramp = sizes(_DIRICHLET, round_up(max(p95, 1e-9)))
            colours = Colouring(ramp.colours(np.clip(excess, 0, ramp.high)), legends=(ramp,))
        self._colours = colours
        self.show_way(self.way)

    def show_way(self, way: float, dot: float = 0.03) -> None:
        """Move the surface between to a share of the way from the source to the target, and the landmarks with it.

        Their dots have the radius `dot`.
        """
        self.way = way
        said = f"{100 * way:.0f}% of the way\n{len(self.common.faces):,} faces"
        between = (1 - way) * self.ends[0] + way * self.ends[1]
        shown = (
            (self._captions[0], self.ends[0], self._colours.legends),
            (said, between, ()),
            (self._captions[1], self.ends[1], ()),
        )
        self.grid.show([[
            Part(caption, x, self.common.faces, self._colours, legends=legends,
                 dots={f"landmark {k}": (x[[landmark]], LINES[k % len(LINES)], dot)
                       for k, landmark in enumerate(self.result.landmarks)})
            for caption, x, legends in shown
        ]])  # fmt: skip

    def film(self, length: int) -> list[tuple[Callable[[], None], bool]]:
        ways = (1 - np.cos(2 * math.pi * np.arange(length) / length)) / 2
        return [(partial(self.show_way, float(way)), False) for way in ways]

    def panel(self) -> None:
        if not self.grid.panel:
            return
        with panel("Match", self.grid.panel, MOUSE):
            if (chosen := subject_menu(self.subject, CARRIED)) != self.subject:
                self.show_subject(chosen)
            moved, way = imgui.SliderFloat("way", self.way, 0.0, 1.0, "%.2f")
            if moved:
                self.show_way(float(way))
            paragraph("0 is the source, 1 the target")
            self._save()
            imgui.Separator()
            for line in filter(None, (self.message, *self.result.notes)):
                paragraph(line)
