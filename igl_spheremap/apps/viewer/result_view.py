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
from .colouring import SUBJECTS, colouring
from .panel import begin_panel, end_panel, paragraph, subject_combo
from .pose import fit, pose
from .stage import PANEL, Stage

if TYPE_CHECKING:
    from ...maps.sphere_map import SphereMap

FloatArray = NDArray[np.float64]

#: Edges are drawn on images of at most so many faces; beyond they would be all that is seen.
_EDGES = 15_000
_EDGE_WIDTH = 0.5


class ResultView(App):
    """Source and sphere side by side; the frames are the `SUBJECTS` that colours can show.

    Parameters
    ----------
    mesh : Mesh
        The checked source.
    x : (n, 3) float64 array
        The map.
    caption : str
        Over the sphere.
    up : str
        Which way is up.
    subject : str
        What the colours tell at first.
    panel : bool
        Keep room for widgets.
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
    ) -> None:
        self.mesh, self.x, self.subject = mesh, x, subject
        self.stage = Stage(1, 2, panel=PANEL if panel else 0)
        self._with_panel = panel
        turn = pose(mesh.v, up)
        self.source = self.stage.place(0, 0, Body("source", fit(mesh.v, turn), mesh.f))
        self.image = self.stage.place(0, 1, Body("sphere", x @ turn.T, mesh.f, lift=True))
        self.source.caption = f"Source\n{len(mesh.v):,} vertices, {len(mesh.f):,} faces"
        self._map_caption = caption
        angles = angle_figures(mesh_angle_differences(mesh, x))
        self._facts = (
            f"{certify_checked(x, mesh.f)}.\n"
            "Angles differ by {mean:.3g} degrees on average; 99% by less than {p99:.3g}, none by more than "
            "{max:.3g}.".format(**angles)
        )
        self.show_subject(subject)

    def show_subject(self, subject: str) -> None:
        """Colour both by a subject.

        Parameters
        ----------
        subject : str
            One of `SUBJECTS`.

        Returns
        -------
        None
        """
        self.subject = subject
        colours = colouring(self.mesh, self.x, subject)
        colours.apply(self.source, self.image)
        self.image.show_edges(edge_width(self.mesh, subject))
        count = len(colours.folded)
        self.image.caption = f"{self._map_caption}\n{count:,} folded faces"

    def frames(self) -> int:
        return len(SUBJECTS)

    def last_frame(self) -> int:
        return SUBJECTS.index(self.subject)

    def go_to(self, frame: int) -> None:
        self.show_subject(SUBJECTS[frame])

    def panel(self) -> None:
        if not self._with_panel:
            return
        from polyscope import imgui

        begin_panel("Map", self.stage.panel)
        subject = subject_combo(self.subject)
        if subject != self.subject:
            self.show_subject(subject)
        paragraph(self._facts)
        imgui.Separator()
        paragraph("Drag to turn both, drag with the right button to shift, scroll to zoom, double-click to reset.")
        end_panel()


def edge_width(mesh: Mesh, subject: str) -> float:
    """Width of the edges on images of a mesh.

    Parameters
    ----------
    mesh : Mesh
        The checked source.
    subject : str
        What the colours tell.

    Returns
    -------
    float
        0 where there are too many, or where they would hide a scale of colours.
    """
    return _EDGE_WIDTH if subject == SUBJECTS[0] and len(mesh.f) <= _EDGES else 0.0


def show(result: SphereMap, *, up: str = "z", subject: str = SUBJECTS[0]) -> None:
    """Open a window with the source beside its sphere; returns when it is closed.

    Parameters
    ----------
    result : SphereMap
        A map.
    up : str
        Which way is up: "x", "-x", "y", "-y", "z" or "-z".
    subject : str
        What the colours tell at first: "foldings", "conformal factor" or "angle differences".

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
        What the colours tell: "foldings", "conformal factor" or "angle differences".
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
) -> None:
    """`screenshot` of any map.

    Parameters
    ----------
    mesh : Mesh
        The checked source.
    x : (n, 3) float64 array
        A map to the unit sphere.
    path : path
        Ends in .png or .jpg.
    caption : str
        Over the sphere.
    up, subject, size
        As in `screenshot`.

    Returns
    -------
    None
    """
    import polyscope as ps

    window.open_window(size=size, offscreen=True)
    view = ResultView(mesh, x, caption, up=up, subject=subject, panel=False)
    ps.set_user_callback(view.stage.draw)
    window.save(path)


def _caption(result: SphereMap) -> str:
    return f"map ({result.method})"
