"""Which exit status an error stands for, and its one line."""

from __future__ import annotations

from ...errors import DisplayError, FactorisationFailed, FileError, FoldingsRemain, MeshError
from .command import UsageError
from .exits import Exit

#: The first row that fits counts: `FileError` is an OSError.
_STATUS: tuple[tuple[type[BaseException], Exit], ...] = (
    (UsageError, Exit.USAGE),
    (MeshError, Exit.NO_MESH),
    (FoldingsRemain, Exit.FOLDINGS),
    (FileError, Exit.FILE),
    (OSError, Exit.FILE),
    (MemoryError, Exit.FAILED),
    (FactorisationFailed, Exit.FAILED),
    (DisplayError, Exit.FAILED),
)

#: All that is told in one line; anything else is a defect of the package, and shows its traceback.
EXPECTED = tuple(kind for kind, _ in _STATUS)


def told(error: BaseException) -> tuple[Exit, str]:
    """The exit status of an expected error, and its line.

    Parameters
    ----------
    error : Exception
        One of `EXPECTED`.

    Returns
    -------
    status : Exit
        What the command says to the shell.
    line : str
        What it says to people.

    Examples
    --------
    >>> told(MeshError("open surface"))
    (<Exit.NO_MESH: 2>, 'open surface')
    """
    status = next(status for kind, status in _STATUS if isinstance(error, kind))
    if isinstance(error, MemoryError):
        return status, "out of memory; try a smaller mesh or more memory"
    words = error.strerror if isinstance(error, OSError) and error.strerror else error
    return status, " ".join(str(words).split())
