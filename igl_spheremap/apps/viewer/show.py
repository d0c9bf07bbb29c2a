"""A result in a window, or as a picture."""

from __future__ import annotations

from collections.abc import Mapping

from numpy.typing import ArrayLike

from ...gate import PathLike, gate
from ...maps.methods import check_start
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray
from ...mesh.check import Mesh
from . import window
from .app import present
from .choices import SIZE, SUBJECTS
from .map_view import MapView, caption_of


@gate
def show(
    result: SphereMap,
    *,
    up: str = "auto",
    subject: str = SUBJECTS[0],
    maps: Mapping[str, ArrayLike] | None = None,
) -> None:
    """Open a window with the source beside its sphere; returns when it is closed.

    Parameters
    ----------
    result : SphereMap
        A map.
    up : str
        Up direction: "x", "-x", "y", "-y", "z" or "-z"; "auto", the default, chooses the way in which the surface
        stands safely; "left" and "right" show it from that side, with z up.
    subject : str
        Subject of the colours when the window opens: "foldings", the default, "angle differences", "area distortion" or
        "checkerboard".
    maps : mapping of (n, 3) array_like, optional
        Maps of the surface by their names, folded or not, to be compared: they stand side by side, in the place of the
        result's own. Rows are scaled to unit length.

    Raises
    ------
    DisplayError
        If there is no display or no OpenGL.
    MeshError
        If one of `maps` has not one finite, nonzero row for each vertex.
    ValueError
        If `up` or `subject` is another word, or `maps` is empty.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> ism.show(ism.spherical_conformal_map(*ism.samples.make("dino")))  # doctest: +SKIP
    """
    if maps is None:
        shown = {caption_of(result): result.sphere}
        present(lambda: MapView(result.mesh, shown, up=up, subject=subject, result=result))
    else:
        compared = _checked(result, maps)
        present(lambda: MapView(result.mesh, compared, up=up, subject=subject, name="maps"))


@gate
def screenshot(
    result: SphereMap,
    path: PathLike,
    *,
    up: str = "auto",
    subject: str = SUBJECTS[0],
    maps: Mapping[str, ArrayLike] | None = None,
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
        Up direction: "x", "-x", "y", "-y", "z" or "-z"; "auto", the default, chooses the way in which the surface
        stands safely; "left" and "right" show it from that side, with z up.
    subject : str
        Subject of the colours: "foldings", the default, "angle differences", "area distortion" or "checkerboard".
    maps : mapping of (n, 3) array_like, optional
        As of `show`.
    size : (int, int)
        Width and height in pixels; 1280 by 760 by default.

    Raises
    ------
    DisplayError
        If there is no OpenGL.
    FileError
        If the picture can't be written.
    MeshError
        If one of `maps` has not one finite, nonzero row for each vertex.
    ValueError
        If `up` or `subject` is another word, or `maps` is empty.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> ism.screenshot(ism.spherical_conformal_map(*ism.samples.make("dino")), "dino.png")  # doctest: +SKIP
    """
    shown = {caption_of(result): result.sphere}
    if maps is not None:
        shown = _checked(result, maps)
    picture_of(result.mesh, shown, path, up=up, subject=subject, size=size)


def _checked(result: SphereMap, maps: Mapping[str, ArrayLike]) -> dict[str, FloatArray]:
    """Maps of the result's surface by their names."""
    if not maps:
        raise ValueError("maps has none; give maps of the surface by their names")
    return {name: check_start(x, len(result.mesh.v), name) for name, x in maps.items()}


def picture_of(
    mesh: Mesh,
    maps: Mapping[str, FloatArray],
    path: PathLike,
    *,
    up: str = "auto",
    subject: str = SUBJECTS[0],
    size: tuple[int, int] = SIZE,
) -> None:
    """`screenshot` of any maps by their captions."""
    window.check_picture(path)
    present(lambda: MapView(mesh, maps, up=up, subject=subject), path, size=size)
