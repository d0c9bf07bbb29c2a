"""Conformal maps of genus-0 triangle meshes to the unit sphere, proved free of foldings."""

from ._version import __version__ as __version__
from .lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __path__[0])
del attach
