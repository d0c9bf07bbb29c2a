"""Errors that the package raises, each with a sentence a user can act on."""

from __future__ import annotations

from typing import Any


class MeshError(ValueError):
    """The input is no closed, oriented, connected genus-0 triangle mesh.

    The message is one line: what is wrong, where (a few indices), and what would mend it.
    """


class FileError(OSError):
    """A file can't be read or written; the message is one line that says why."""


class MapError(RuntimeError):
    """A map was computed but can't be accepted.

    Attributes
    ----------
    result : SphereMap or None
        The map as far as it came, with its certificate, so that nothing is lost.
    """

    def __init__(self, message: str, result: Any = None) -> None:
        super().__init__(message)
        self.result = result


class NotConverged(MapError):
    """The iteration ended before its stopping rule was met."""


class FoldingsRemain(MapError):
    """The map is not certified folding-free."""


class FactorisationFailed(RuntimeError):
    """A matrix is not numerically positive definite, or the backend gave up on it.

    Another Laplacian of the same surface, with mollified or intrinsic Delaunay weights, may do.
    """


class DisplayError(RuntimeError):
    """Nothing can be drawn here; the message is one line that says what is missing."""
