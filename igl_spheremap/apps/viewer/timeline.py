"""A recorded run as a sequence of slides, as Fig. 9 of Lai et al. tells it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...descent.iterate import Iterate
from ...descent.recording import Frame
from ...maps.sphere_map import SphereMap

FloatArray = NDArray[np.float64]

_NAMES = {"harmonic": "Algorithm 1", "sobolev": "preconditioned Cayley steps"}


@dataclass(frozen=True, eq=False)
class Slide:
    """One picture of a run.

    Attributes
    ----------
    title : str
        What is shown.
    x : (n, 3) float64 array
        Positions to draw: a map, or the eigenfunctions.
    image : (n, 3) float64 array
        The map that colours and foldings are of.
    frame : Frame
        The iterate that it belongs to.
    subject : str or None
        What the colours must tell here; None leaves it to the viewer.
    """

    title: str
    x: FloatArray
    image: FloatArray
    frame: Frame
    subject: str | None = None


def slides(frames: Sequence[Frame]) -> list[Slide]:
    """Slides of a run: one for every iterate, and two more before each star map.

    Before a star map come the conformal factor of the map that it is made from, and its eigenfunctions Phi^u,
    drawn so that they would be the unit sphere if that factor were right.

    Parameters
    ----------
    frames : sequence of Frame
        Of a `Recording`.

    Returns
    -------
    list of Slide
        In order.
    """
    told: list[Slide] = []
    for k, frame in enumerate(frames):
        iterate = frame.iterate
        details = iterate.details or {}
        if k and "phi" in details:
            before = frames[k - 1]
            told.append(
                Slide(
                    "Conformal factor of the last map",
                    before.iterate.x,
                    before.iterate.x,
                    before,
                    "conformal factor",
                )
            )
            phi = np.asarray(details["phi"])
            # eigenfunctions on the unit sphere: |phi|^2 = 3 / (4 pi)
            told.append(
                Slide(
                    "Eigenfunctions Phi^u",
                    phi * np.sqrt(4 * np.pi / 3),
                    before.iterate.x,
                    before,
                    "conformal factor",
                )
            )
        told.append(Slide(title_of(iterate), iterate.x, iterate.x, frame))
    return told


def final_slide(result: SphereMap, last: Frame) -> Slide:
    """The result, which is put into the gauge after the last iterate, and may be an earlier round's map.

    Parameters
    ----------
    result : SphereMap
        Of the run.
    last : Frame
        Its last frame.

    Returns
    -------
    Slide
        To end with.
    """
    verdict = "certified folding-free" if result.certificate.folding_free else "not folding-free"
    iterate = replace(last.iterate, x=result.sphere, energy=result.energy)
    frame = Frame(last.index, iterate, result.certificate.foldings)
    return Slide(f"Result: {verdict}", result.sphere, result.sphere, frame)


def title_of(iterate: Iterate) -> str:
    """What an iterate is, in words.

    Parameters
    ----------
    iterate : Iterate
        Any.

    Returns
    -------
    str
        Such as "Algorithm 1, round 1, iteration 20".

    Examples
    --------
    >>> import numpy as np
    >>> title_of(Iterate("gauss map", 0, 0, np.eye(3), 0.0))
    'Gauss map'
    """
    name = _NAMES.get(iterate.stage, iterate.stage)
    name = name[0].upper() + name[1:]
    if iterate.stage == "star map":
        return f"{name} of round {iterate.round}"
    if iterate.stage == "gauss map":
        return "Gauss map"
    where = f", round {iterate.round}" if iterate.round else ""
    return f"{name}{where}, iteration {iterate.iteration}"
