"""An open file that one process has at a time; the system frees it when the process ends, however it ends."""

from __future__ import annotations

import errno
import sys
from typing import IO

_BEYOND = 1 << 40  # Windows locks bytes against reading, too: one that no file reaches


def lock(file: IO[bytes]) -> bool:
    """Lock a file until it is closed; False if another run has it. Where the file system has no locks, True."""
    try:
        if sys.platform == "win32":
            import msvcrt

            file.seek(_BEYOND)
            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        return error.errno not in (errno.EWOULDBLOCK, errno.EACCES)
    return True
