"""Mending of foldings: progressive embedding, relaxation, and the ladder that says which is used when."""

from .ladder import Mended, climb
from .polish import polish_map
from .repair_foldings import repair_foldings
from .rounding import certified_float32

__all__ = ["Mended", "certified_float32", "climb", "polish_map", "repair_foldings"]
