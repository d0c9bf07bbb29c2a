"""A finished map: the source beside the sphere."""

from __future__ import annotations

import os

import numpy as np

from ...draw.plot import fit, pose
from ...maps.balanced import rebalance
from ...mesh.arrays import FloatArray
from ...mesh.check import Mesh
from ...result import findings
from ...result.sphere_map import SphereMap
from ...verify.certificate import certify_checked
from ...verify.distortion import mesh_angle_differences, mesh_area_distortion
from ...verify.signs import folded_faces
from . import window
from .app import App, draw_app, panel, paragraph, show_app, subject_combo, zoom_slider
from .body import Body, Lens, follow
from .choices import SIZE, SUBJECTS
from .colouring import colouring
from .stage import PANEL, Inset, Stage
from .window import imgui, ps

#: Edges are drawn on images of at most so many faces; beyond they would be all that is seen.
_EDGES = 15_000
_EDGE_WIDTH = 0.5


class ResultView(App):
    """Source and sphere side by side, the sphere through a lens on the foldings if there are any.

    The frames are the `SUBJECTS` that colours can show. With a `result` the panel has a slider for its balance.
    """

    def __init__(
        self,
        mesh: Mesh,
        x: FloatArray,
        caption: str = "map",
        *,
        up: str = "z",
        subject: str = SUBJECTS[0],
        panel: bool = True,
        lens: Lens | None = None,
        result: SphereMap | None = None,
    ) -> None:
        self.mesh, self.subject, self.zoom = mesh, subject, 1.0
        self.stage = Stage(1, 2, panel=PANEL if panel else 0)
        self._with_panel, self._result = panel, result
        self._balance = 0.0 if result is None else result.balance
        self._turn = pose(mesh.v, up)
        self.source = self.stage.place(0, 0, Body("source", fit(mesh.v, self._turn), mesh.f))
        self.image = self.stage.place(0, 1, Body("sphere", x @ self._turn.T, mesh.f, lift=True))
        self.inset = Inset(self.stage, 0, 1, mesh.f, x @ self._turn.T)
        self.source.caption = f"Source\n{len(mesh.v):,} vertices, {len(mesh.f):,} faces"
        self._show_map(x, caption, lens)

    def _show_map(self, x: FloatArray, caption: str, lens: Lens | None = None) -> None:
        self.x, self._map_caption = x, caption
        self._folded = np.flatnonzero(folded_faces(x, self.mesh.f))
        self._lens = lens or follow(x @ self._turn.T, self.mesh.f, self._folded)
        found = (
            findings.verdict(certify_checked(x, self.mesh.f)),
            findings.angles(mesh_angle_differences(self.mesh, x)),
            findings.areas(mesh_area_distortion(self.mesh, x)),
        )
        self._facts = "\n".join(f"{each.label}: {each.text}" for each in found)
        self.show_subject(self.subject)

    def show_subject(self, subject: str) -> None:
        """Colour both by one of `SUBJECTS`, and apply the lens."""
        self.subject = subject
        lens = Lens(self._lens.place, self._lens.power * self.zoom)
        x = self.x @ self._turn.T
        self.image.set_positions(lens(x))
        self.image.raised = lens.power > 1
        colours = colouring(self.mesh, self.x, subject, folded=self._folded)
        colours.apply(self.source, self.image)
        self.inset.show(x, lens, colours)
        self.image.show_edges(edge_width(self.mesh, subject))
        self.image.caption = f"{self._map_caption}\n{count_foldings(len(self._folded))}"

    def rebalance(self, balance: float) -> None:
        """Go on to the map of another balance."""
        assert self._result is not None
        self._result, self._balance = rebalance(self._result, balance), balance
        self._show_map(self._result.sphere, caption_of(self._result))

    def frames(self) -> int:
        return len(SUBJECTS)

    def last_frame(self) -> int:
        return SUBJECTS.index(self.subject)

    def go_to(self, frame: int) -> None:
        self.show_subject(SUBJECTS[frame])

    def panel(self) -> None:
        self.inset.annotate()
        if not self._with_panel:
            return
        with panel("Map", self.stage.panel):
            if self._result is not None and self._result.certificate.folding_free:
                _, self._balance = imgui.SliderFloat("balance", self._balance, 0.0, 1.0, "%.2f")
                if imgui.IsItemDeactivatedAfterEdit():
                    self.rebalance(min(max(self._balance, 0.0), 1.0))
            subject, zoom = subject_combo(self.subject), zoom_slider(self.zoom)
            if (subject, zoom) != (self.subject, self.zoom):
                self.zoom = zoom
                self.show_subject(subject)
            paragraph(self._facts)
            imgui.Separator()
            if self._result is not None:
                paragraph("Balance: 0 keeps angles, 1 keeps areas.")
            paragraph("Drag to turn both, drag with the right button to shift, scroll to zoom, double-click to reset.")


def edge_width(mesh: Mesh, subject: str) -> float:
    """Width of the edges on images; 0 where there are too many, or where they would hide a scale of colours."""
    return _EDGE_WIDTH if subject == SUBJECTS[0] and len(mesh.f) <= _EDGES else 0.0


def count_foldings(count: int) -> str:
    """A caption.

    >>> count_foldings(1), count_foldings(1200)
    ('1 folded face', '1,200 folded faces')
    """
    return f"{count:,} folded face{'s' * (count != 1)}"


def show(result: SphereMap, *, up: str = "z", subject: str = SUBJECTS[0]) -> None:
    """Open a window with the source beside its sphere; returns when it is closed.

    Parameters
    ----------
    result : SphereMap
        A map.
    up : str
        Which way is up: "x", "-x", "y", "-y", "z" or "-z".
    subject : str
        What the colours show at first: "foldings", "conformal factor", "angle differences" or "area distortion".

    Raises
    ------
    DisplayError
        If there is no display or no OpenGL.
    ValueError
        If there is no such direction or subject.
    """
    window.open_window()
    view = ResultView(result.mesh, result.sphere, caption_of(result), up=up, subject=subject, result=result)
    show_app(view)


def screenshot(
    result: SphereMap,
    path: str | os.PathLike[str],
    *,
    up: str = "z",
    subject: str = SUBJECTS[0],
    size: tuple[int, int] = SIZE,
) -> None:
    """Write a picture of the source beside its sphere; needs no display.

    Parameters
    ----------
    result : SphereMap
        A map.
    path : path
        Ends in .png or .jpg; an existing file is replaced.
    up : str
        Which way is up: "x", "-x", "y", "-y", "z" or "-z".
    subject : str
        What the colours show: "foldings", "conformal factor", "angle differences" or "area distortion".
    size : (int, int)
        Width and height in pixels.

    Raises
    ------
    DisplayError
        If there is no OpenGL.
    FileError
        If the picture can't be written.
    ValueError
        If there is no such direction or subject.
    """
    picture_of(result.mesh, result.sphere, path, caption=caption_of(result), up=up, subject=subject, size=size)


def picture_of(
    mesh: Mesh,
    x: FloatArray,
    path: str | os.PathLike[str],
    *,
    caption: str,
    up: str = "z",
    subject: str = SUBJECTS[0],
    size: tuple[int, int] = SIZE,
    lens: Lens | None = None,
) -> None:
    """`screenshot` of any map, through any lens."""
    window.check_picture(path)
    window.open_window(size=size, offscreen=True)
    view = ResultView(mesh, x, caption, up=up, subject=subject, panel=False, lens=lens)

    ps.set_user_callback(lambda: draw_app(view))
    window.save(path)


def caption_of(result: SphereMap) -> str:
    """How a map was made."""
    balance = f", balance {result.balance:g}" if result.balance else ""
    return f"map ({result.method}{balance})"
