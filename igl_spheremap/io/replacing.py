"""Files appear whole or not at all."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from ..errors import FileError

PathLike = str | os.PathLike[str]


@contextlib.contextmanager
def replacing(path: PathLike, force: bool = False) -> Iterator[Path]:
    """A temporary path beside `path`, renamed to it when the block ends, and removed when it fails.

    Parameters
    ----------
    path : str or path-like
        Where the file shall be. A symbolic link is followed.
    force : bool
        Replace an existing file.

    Yields
    ------
    Path
        A name in the same folder, with the same suffixes.

    Raises
    ------
    FileError
        If a file is there and `force` is not set, or the folder is missing, or writing fails.
    """
    check_writable(path, force)
    final = Path(os.path.realpath(path))
    partial = final.with_name(f".part-{os.getpid()}-{final.name}")
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
    """Say early why a file could not be written.

    Parameters
    ----------
    path : str or path-like
        Where the file shall be.
    force : bool
        Replace an existing file.

    Returns
    -------
    None

    Raises
    ------
    FileError
        If a file is there and `force` is not set, or something else than a file, or there is no such folder.
    """
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
