"""A checkerboard of the sphere carried back to the surface: squares stay squares, for the map is conformal.

Conformal maps to the sphere are not unique: drag the white handle, or use the sliders, to follow this one by
a Moebius map. What is under the handle grows, and every square stays a square. The poles of the pattern are
where the map has the tips of the two limbs that it shrinks most: so limbs show squares down to the tip. Click
a vertex on either side to see its place on both.

    python demos/conformal_texture.py
    python demos/conformal_texture.py max_planck.obj --up y --squares 48
    python demos/conformal_texture.py sample:bird --screenshot bird.png --frame 4
"""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace

import numpy as np
import polyscope as ps
from checkerboard import deepest_tips, mercator_corners, show_squares
from common import demo_parser, main
from polyscope import imgui

import igl_spheremap as ism
from igl_spheremap.apps.cli.inputs import InputMesh
from igl_spheremap.apps.viewer.app import App, panel, paragraph
from igl_spheremap.apps.viewer.body import Body
from igl_spheremap.apps.viewer.colouring import colouring
from igl_spheremap.apps.viewer.stage import Stage, packed
from igl_spheremap.draw.palette import FOLDED, INK
from igl_spheremap.draw.plot import fit, pose
from igl_spheremap.sphere.moebius import moebius
from igl_spheremap.verify.distortion import mesh_conformal_factor

#: Frames of a video: the handle goes once around the equator at this strength.
TURN, STRENGTH = 24, 0.6
#: Strengths above this leave nothing to see.
STRONGEST = 0.95
_HANDLE = 9


class ConformalTexture(App):
    """A map, a Moebius map after it, and a checkerboard on both."""

    def __init__(self, args: Namespace, source: InputMesh) -> None:
        self.mesh = ism.check_mesh(source.v, source.f)
        self.x = ism.spherical_conformal_map(source.v, source.f).sphere
        self.poles = deepest_tips(self.mesh, self.x)
        self.squares = args.squares
        self.factor = False
        self.centre = np.zeros(3)
        self.picked: int | None = None
        self.held = False
        self.stage = Stage(1, 2)
        self.turn = pose(self.mesh.v, args.up)
        self.surface = self.stage.place(0, 0, Body("surface", fit(self.mesh.v, self.turn), self.mesh.f))
        self.image = self.stage.place(0, 1, Body("image", self.x @ self.turn.T, self.mesh.f))
        for body in (self.surface, self.image):
            body.mesh.set_selection_mode("vertices_only")
        self.update()

    def frames(self) -> int:
        return TURN + 1

    def last_frame(self) -> int:
        return 0

    def go_to(self, frame: int) -> None:
        angle = 2 * np.pi * (frame - 1) / TURN
        ahead = np.array([np.cos(angle), 0.0, np.sin(angle)]) @ self.turn
        self.centre = STRENGTH * ahead if frame else np.zeros(3)  # frame 0 is the map as it is
        self.update()

    def update(self) -> None:
        """Move the image, and carry its pattern to the surface."""
        self.y = moebius(self.x, self.centre)
        self.image.set_positions(self.y @ self.turn.T)
        strength = float(np.linalg.norm(self.centre))
        self.surface.caption = "Surface\nthe same pattern, carried back"
        moved = f"after a Moebius map of strength {strength:.2f}"
        self.image.caption = f"Sphere\n{moved if strength else 'the map'}"
        colours = colouring(self.mesh, self.y, "conformal factor", reach=2.0)
        corners = mercator_corners(self.y, self.mesh.f, self.poles) * self.squares
        for body in (self.surface, self.image):
            body.paint(colours.colours)
            body.legend = colours.legend if self.factor else None
            if not self.factor:
                show_squares(body, corners)
        self.mark()

    def mark(self) -> None:
        """Show the vertex that was picked, on both sides."""
        rows = [] if self.picked is None else [self.picked]
        for body in (self.surface, self.image):
            body.dots("picked", body.x[rows], FOLDED)

    def tick(self) -> None:
        if imgui.GetIO().WantCaptureMouse:
            return
        mouse = np.array(imgui.GetMousePos())
        if imgui.IsMouseClicked(0):
            self.held = bool(np.linalg.norm(mouse - self.handle()) < 2 * _HANDLE)
            if not self.held:
                self.pick(mouse)
        if imgui.IsMouseReleased(0):
            self.held = False
        self.stage.locked = self.held
        if self.held and imgui.IsMouseDragging(0, 0.0):
            self.drag_to(mouse)

    def pick(self, at: np.ndarray) -> None:
        """Pick the vertex under the mouse, on either side."""
        hit = ps.pick(screen_coords=tuple(at))
        if not hit.is_hit or hit.structure_name not in ("surface", "image"):
            return
        self.picked = int(hit.structure_data["index"])
        self.mark()

    def handle(self) -> np.ndarray:
        """Where the handle is, in pixels."""
        return self.stage.to_pixels(0, 1, self.turn @ self.centre)

    def drag_to(self, mouse: np.ndarray) -> None:
        """Put the handle under the mouse, as deep in the ball as it was."""
        place = self.stage.from_pixels(0, 1, mouse, self.turn @ self.centre)
        centre = self.turn.T @ place
        self.centre = centre * min(1.0, STRONGEST / max(float(np.linalg.norm(centre)), 1e-12))
        self.update()

    def panel(self) -> None:
        canvas = imgui.GetForegroundDrawList()
        x, y = self.handle()
        canvas.AddCircleFilled((x, y), _HANDLE, packed((1.0, 1.0, 1.0)))
        canvas.AddCircle((x, y), _HANDLE, packed(INK), 0, 2.0)
        with panel("Conformal texture", self.stage.panel):
            self.sliders()
            imgui.Separator()
            paragraph(
                "Drag the white handle: what is under it grows. Drag elsewhere to turn both, scroll to zoom, "
                "click a vertex to see where it goes."
            )
            imgui.Separator()
            self.numbers()

    def sliders(self) -> None:
        """Pattern, and the Moebius map in numbers."""
        more, self.squares = imgui.SliderInt("squares around", self.squares, 4, 96)
        factor, self.factor = imgui.Checkbox("conformal factor", self.factor)
        strength = float(np.linalg.norm(self.centre))
        ahead = self.centre / strength if strength > 1e-9 else np.array([0.0, 0.0, 1.0])
        longitude, latitude = np.arctan2(ahead[1], ahead[0]), np.arcsin(np.clip(ahead[2], -1, 1))
        a, strength = imgui.SliderFloat("strength", strength, 0.0, STRONGEST)
        b, longitude = imgui.SliderAngle("longitude", longitude, -180, 180)
        c, latitude = imgui.SliderAngle("latitude", latitude, -89, 89)
        if a or b or c:
            level = np.cos(latitude)
            ahead = np.array([level * np.cos(longitude), level * np.sin(longitude), np.sin(latitude)])
            self.centre = max(strength, 1e-3) * ahead
        if imgui.Button("reset"):
            self.centre, a = np.zeros(3), True
        if more or factor or a or b or c:
            self.update()

    def numbers(self) -> None:
        """Numbers of the vertex that was picked."""
        if self.picked is None:
            imgui.TextUnformatted("no vertex picked")
            return
        factor = mesh_conformal_factor(self.mesh, self.y)[self.picked]
        rows = {
            "vertex": f"{self.picked}",
            "surface": ", ".join(f"{c:.4g}" for c in self.mesh.vertices[self.picked]),
            "sphere": ", ".join(f"{c:.4f}" for c in self.y[self.picked]),
            "conformal factor": f"{factor:.4g} (mean 4 pi)",
        }
        for label, value in rows.items():
            paragraph(f"{label}: {value}")


def parser() -> ArgumentParser:
    """The arguments of this demo."""
    arguments = demo_parser(__doc__, "sample:dino")
    arguments.add_argument("--squares", type=int, default=24, metavar="N", help="around the equator (default 24)")
    return arguments


if __name__ == "__main__":
    sys.exit(main("Conformal texture", parser(), ConformalTexture))
