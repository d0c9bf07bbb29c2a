"""Files appear whole or not at all."""

from __future__ import annotations

import contextlib
import itertools
import os
from collections.abc import Iterator
from pathlib import Path

from ..errors import FileError
from .records import PathLike

_COUNT = itertools.count()  # next() is atomic: no two threads of a process get the same number
_TAIL = 32  # characters of the name that hold its suffixes; with the rest they fit into the 255 bytes of a name


@contextlib.contextmanager
def replacing(path: PathLike, force: bool = False) -> Iterator[Path]:
    """A temporary path in the same folder, with the same suffixes, renamed to `path` when the block ends.

    It is removed where the block fails. A symbolic link at `path` is followed.
    """
    check_writable(path, force)
    final = Path(os.path.realpath(path))
    partial = final.with_name(f".part-{os.getpid()}-{next(_COUNT)}-{final.name[-_TAIL:]}")
    try:
        yield partial
        if final.exists():
            check_writable(path, force)
            os.chmod(partial, final.stat().st_mode & 0o777)
        os.replace(partial, final)
    except FileError:
        raise
    except OSError as error:
        raise FileError(f"can't write {path}: {error.strerror or error}") from error
    finally:
        with contextlib.suppress(OSError):
            partial.unlink(missing_ok=True)


def check_writable(path: PathLike, force: bool = False) -> None:
    """Raise a FileError before the work starts if a file could not be written, or replaced without `force`."""
    final = Path(os.path.realpath(path))
    if final.is_dir():
        raise FileError(f"can't write {path}: it is a directory")
    if final.exists() and not final.is_file():
        raise FileError(f"can't write {path}: it is no regular file")
    if final.exists() and not force:
        raise FileError(f"{path} exists already; force=True replaces it")
    if not final.parent.is_dir():
        raise FileError(f"can't write {path}: there is no folder {final.parent}")
    if not os.access(final.parent, os.W_OK):
        raise FileError(f"can't write {path}: no permission to write in {final.parent}")
