"""Solvers: frozen records of their knobs, each with one generator method that yields iterates."""

from .cayley_bb import CayleyBB

__all__ = ["CayleyBB"]
