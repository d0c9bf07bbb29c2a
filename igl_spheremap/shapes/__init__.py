"""Several surfaces in correspondence, and surfaces in spherical harmonics: matches, registrations, groups."""

from ..lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __path__[0])
del attach
