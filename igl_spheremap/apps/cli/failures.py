"""Which exit status an error stands for, and its one line."""

from __future__ import annotations

from ...errors import DisplayError, FactorisationFailed, FileError, FoldingsRemain, MeshError
from ...mesh.explain import REPAIR, REPAIR_LARGEST
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

#: Calls and arguments that messages of the library name, and the flags that stand for them in a shell.
_FLAGS = {
    REPAIR_LARGEST: "--repair --keep-largest",
    REPAIR: "--repair",
    "read_mesh(path, triangulate=True)": "--repair",
    "force=True": "--force",
}

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
    >>> told(MeshError("2 components (repair_mesh(v, f, keep_largest=True) does)"))
    (<Exit.NO_MESH: 2>, '2 components (--repair --keep-largest does)')
    """
    status = next(status for kind, status in _STATUS if isinstance(error, kind))
    if isinstance(error, MemoryError):
        return status, "out of memory; try a smaller mesh or more memory"
    words = error.strerror if isinstance(error, OSError) and error.strerror else error
    line = " ".join(str(words).split())
    for call, flag in _FLAGS.items():
        line = line.replace(call, flag)
    return status, line
