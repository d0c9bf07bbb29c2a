"""A finished map: the source beside the sphere."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...mesh.check import Mesh, check_mesh
from ...verify.certificate import certify_checked
from ...verify.distortion import mesh_angle_differences
from ...verify.figures import angle_figures
from . import window
from .app import App
from .body import Body
from .colouring import SUBJECTS, colouring, folded_faces
from .inset import Inset
from .lens import Lens, follow
from .panel import begin_panel, end_panel, paragraph, subject_combo, zoom_slider
from .pose import fit, pose
from .stage import PANEL, Stage

if TYPE_CHECKING:
    from ...maps.sphere_map import SphereMap

FloatArray = NDArray[np.float64]

#: Edges are drawn on images of at most so many faces; beyond they would be all that is seen.
_EDGES = 15_000
_EDGE_WIDTH = 0.5


class ResultView(App):
    """Source and sphere side by side, the sphere through a lens on the foldings if there are any.

    The frames are the `SUBJECTS` that colours can show.
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
    ) -> None:
        self.mesh, self.x, self.subject, self.zoom = mesh, x, subject, 1.0
        self.stage = Stage(1, 2, panel=PANEL if panel else 0)
        self._with_panel = panel
        self._turn = pose(mesh.v, up)
        self.source = self.stage.place(0, 0, Body("source", fit(mesh.v, self._turn), mesh.f))
        self.image = self.stage.place(0, 1, Body("sphere", x @ self._turn.T, mesh.f, lift=True))
        self.inset = Inset(self.stage, 0, 1, mesh.f, x @ self._turn.T)
        self.source.caption = f"Source\n{len(mesh.v):,} vertices, {len(mesh.f):,} faces"
        self._folded = folded_faces(mesh, x)
        self._lens = lens or follow(x @ self._turn.T, mesh.f, self._folded)
        self._map_caption = caption
        angles = angle_figures(mesh_angle_differences(mesh, x))
        self._facts = (
            f"{certify_checked(x, mesh.f)}.\n"
            "Angles differ by {mean:.3g} degrees on average; 99% by less than {p99:.3g}, none by more than "
            "{max:.3g}.".format(**angles)
        )
        self.show_subject(subject)

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
        from polyscope import imgui

        begin_panel("Map", self.stage.panel)
        subject, zoom = subject_combo(self.subject), zoom_slider(self.zoom)
        if (subject, zoom) != (self.subject, self.zoom):
            self.zoom = zoom
            self.show_subject(subject)
        paragraph(self._facts)
        imgui.Separator()
        paragraph("Drag to turn both, drag with the right button to shift, scroll to zoom, double-click to reset.")
        end_panel()


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
        What the colours show at first: "foldings", "conformal factor" or "angle differences".

    Returns
    -------
    None

    Raises
    ------
    DisplayError
        If there is no display or no OpenGL.
    """
    window.open_window()
    mesh = check_mesh(result.vertices, result.faces)
    view = ResultView(mesh, result.sphere, _caption(result), up=up, subject=subject)

    def frame() -> None:
        view.stage.mouse()
        view.stage.draw()
        view.panel()

    window.show(frame)


def screenshot(
    result: SphereMap,
    path: str | os.PathLike[str],
    *,
    up: str = "z",
    subject: str = SUBJECTS[0],
    size: tuple[int, int] = window.SIZE,
) -> None:
    """Write a picture of the source beside its sphere; needs no display.

    Parameters
    ----------
    result : SphereMap
        A map.
    path : path
        Ends in .png or .jpg.
    up : str
        Which way is up: "x", "-x", "y", "-y", "z" or "-z".
    subject : str
        What the colours show: "foldings", "conformal factor" or "angle differences".
    size : (int, int)
        Width and height in pixels.

    Returns
    -------
    None

    Raises
    ------
    DisplayError
        If there is no OpenGL.
    """
    mesh = check_mesh(result.vertices, result.faces)
    picture_of(mesh, result.sphere, path, caption=_caption(result), up=up, subject=subject, size=size)


def picture_of(
    mesh: Mesh,
    x: FloatArray,
    path: str | os.PathLike[str],
    *,
    caption: str,
    up: str = "z",
    subject: str = SUBJECTS[0],
    size: tuple[int, int] = window.SIZE,
    lens: Lens | None = None,
) -> None:
    """`screenshot` of any map, through any lens."""
    import polyscope as ps

    window.check_picture(path)
    window.open_window(size=size, offscreen=True)
    view = ResultView(mesh, x, caption, up=up, subject=subject, panel=False, lens=lens)

    def draw() -> None:
        view.stage.draw()
        view.panel()

    ps.set_user_callback(draw)
    window.save(path)


def _caption(result: SphereMap) -> str:
    return f"map ({result.method})"
