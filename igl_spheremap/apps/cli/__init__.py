"""The command line: `main` runs it, `parser` lists its commands."""

from .program import main as main
