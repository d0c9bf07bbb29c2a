"""The command line: `main` runs it, `parser` lists what it can do."""

from .program import main as main
