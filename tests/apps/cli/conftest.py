"""Fixtures of all commands."""

from shell import sphere

__all__ = ["sphere"]
