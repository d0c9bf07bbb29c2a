"""Which exit status an error stands for, and its one line."""

from __future__ import annotations

from ...errors import (
    DisplayError,
    FactorisationFailed,
    FileError,
    FoldingsRemain,
    MapError,
    MeshError,
    WorkersUnavailable,
    one_line,
)
from .exits import Exit


class UsageError(Exception):
    """A contradiction in the command line; the message is one line."""


#: The first row that fits counts: `FileError` is an OSError.
_STATUS: tuple[tuple[type[BaseException], Exit], ...] = (
    (UsageError, Exit.USAGE),
    (MeshError, Exit.NO_MESH),
    (FoldingsRemain, Exit.UNCERTIFIED),
    (MapError, Exit.FAILED),
    (FileError, Exit.FILE),
    (OSError, Exit.FILE),
    (MemoryError, Exit.FAILED),
    (FactorisationFailed, Exit.FAILED),
    (DisplayError, Exit.FAILED),
    (WorkersUnavailable, Exit.UNAVAILABLE),
)

#: Calls and arguments that messages of the library name, and the flags in their place.
_FLAGS = {
    "repair_mesh(v, f, keep_largest=True)": "--repair --keep-largest",
    "repair_mesh(v, f)": "--repair",
    "read_mesh(path, triangulate=True)": "--repair",
    "force=True": "--force",
    "manifest=FILE": "--manifest FILE",
}

#: Errors that take one line; any other is a defect of the package and shows its traceback.
EXPECTED = tuple(kind for kind, _ in _STATUS)


def describe(error: BaseException) -> tuple[Exit, str]:
    """The exit status and the line of an error that is one of `EXPECTED`.

    >>> describe(MeshError("2 components (repair_mesh(v, f, keep_largest=True) does)"))
    (<Exit.NO_MESH: 2>, '2 components (--repair --keep-largest does)')
    """
    status = next(status for kind, status in _STATUS if isinstance(error, kind))
    return status, with_flags(one_line(error))


def with_flags(line: str) -> str:
    """A line of the library with flags in the place of its calls."""
    for call, flag in _FLAGS.items():
        line = line.replace(call, flag)
    return line
