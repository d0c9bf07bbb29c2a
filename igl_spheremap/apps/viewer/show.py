"""A result in a window, or as a picture."""

from __future__ import annotations

import os

from ...gate import gate
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray
from ...mesh.check import Mesh
from . import window
from .app import present
from .choices import SIZE, SUBJECTS
from .map_view import MapView, caption_of


@gate
def show(result: SphereMap, *, up: str = "auto", subject: str = SUBJECTS[0]) -> None:
    """Open a window with the source beside its sphere; returns when it is closed.

    Parameters
    ----------
    result : SphereMap
        A map.
    up : str
        Which way is up: "x", "-x", "y", "-y", "z" or "-z"; "auto", the default, chooses the way in which the surface
        stands safely; "left" and "right" show it from that side, with z up.
    subject : str
        What the colours show when the window opens: "foldings", the default, "angle differences", "area distortion"
        or "checkerboard".

    Raises
    ------
    DisplayError
        If there is no display or no OpenGL.
    ValueError
        If `up` or `subject` is another word.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> ism.show(ism.spherical_conformal_map(*ism.samples.make("dino")))  # doctest: +SKIP
    """
    maps = {caption_of(result): result.sphere}
    present(lambda: MapView(result.mesh, maps, up=up, subject=subject, result=result))


@gate
def screenshot(
    result: SphereMap,
    path: str | os.PathLike[str],
    *,
    up: str = "auto",
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
        Which way is up: "x", "-x", "y", "-y", "z" or "-z"; "auto", the default, chooses the way in which the surface
        stands safely; "left" and "right" show it from that side, with z up.
    subject : str
        What the colours show: "foldings", the default, "angle differences", "area distortion" or "checkerboard".
    size : (int, int)
        Width and height in pixels; 1280 by 760 by default.

    Raises
    ------
    DisplayError
        If there is no OpenGL.
    FileError
        If the picture can't be written.
    ValueError
        If `up` or `subject` is another word.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> ism.screenshot(ism.spherical_conformal_map(*ism.samples.make("dino")), "dino.png")  # doctest: +SKIP
    """
    picture_of(
        result.mesh,
        result.sphere,
        path,
        caption=caption_of(result),
        up=up,
        subject=subject,
        size=size,
    )


def picture_of(
    mesh: Mesh,
    x: FloatArray,
    path: str | os.PathLike[str],
    *,
    caption: str,
    up: str = "auto",
    subject: str = SUBJECTS[0],
    size: tuple[int, int] = SIZE,
) -> None:
    """`screenshot` of any map."""
    window.check_picture(path)
    present(lambda: MapView(mesh, {caption: x}, up=up, subject=subject), path, size=size)
