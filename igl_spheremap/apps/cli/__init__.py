"""The command line: one file per subcommand."""

from .main import main

__all__ = ["main"]
