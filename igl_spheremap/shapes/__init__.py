"""What is known of several surfaces, or of one in a basis: matches, registrations, groups, harmonics."""

from ..lazy import attach

__getattr__, __dir__, __all__ = attach(__name__, __path__[0])
del attach
