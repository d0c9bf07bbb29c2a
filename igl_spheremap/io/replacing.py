"""Files appear whole or not at all."""

from __future__ import annotations

import contextlib
import glob
import os
import re
import secrets
import socket
from collections.abc import Iterator
from pathlib import Path

from ..errors import FileError, Remedy
from ..gate import PathLike
from .formats import READ_ONLY, suffix_of

#: The need of an existing file.
REPLACE = Remedy(options={"force": True})


@contextlib.contextmanager
def replacing(path: PathLike, force: bool = False) -> Iterator[Path]:
    """A temporary path in the same folder, with the same suffixes, renamed to `path` when the block ends.

    If the block fails, it is removed. A symbolic link at `path` is replaced, not followed: somebody may have planted it
    at a known name.
    """
    check_writable(path, force)
    final = _place(path)
    # 32 characters hold the suffixes, and with the rest they fit into the 255 bytes of a name
    partial = final.with_name(f"{_partial(os.getpid())}{secrets.token_hex(8)}-{final.name[-32:]}")
    try:
        # neither a file nor a link is followed, and the replacement of a private file is private from the first byte
        mode = 0o600 if final.exists() else 0o666
        os.close(os.open(partial, os.O_CREAT | os.O_EXCL | os.O_WRONLY, mode))
        try:
            yield partial
            if final.exists():
                check_writable(path, force)
                os.chmod(partial, final.stat().st_mode & 0o777)
            os.replace(partial, final)
        finally:
            with contextlib.suppress(OSError):
                partial.unlink(missing_ok=True)
    except FileError:
        raise
    except OSError as error:
        raise FileError(f"can't write {path}: {error.strerror or error}") from error


def _place(path: PathLike) -> Path:
    """A path whose folder is no link."""
    return Path(os.path.realpath(Path(path).parent)) / Path(path).name


def make_folder(path: PathLike, follow: bool = True) -> Path:
    """A folder, made with those above it if it is missing; a FileError says why it can't be.

    `follow` is for names that the user gave: a link to a folder may have been planted at others.
    """
    folder = Path(path)
    if not follow and folder.is_symlink():
        raise FileError(f"{folder} is a link, in which nothing is written; remove it")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(f"can't make the folder {folder}: {error.strerror or error}") from error
    return folder


def remove_partial_files(path: PathLike, process: int) -> None:
    """Remove the partial files of an ended process of this machine from the folder of a file."""
    for left in _place(path).parent.glob(f"{glob.escape(_partial(process))}*"):
        with contextlib.suppress(OSError):
            left.unlink()


def _partial(process: int) -> str:
    """Make the prefix of a process's partial files, with the host: processes of other machines may have its number."""
    host = re.sub(r"[^A-Za-z0-9.]", "-", socket.gethostname())[:64]
    return f".part-{host}-{process}-"


def check_writable(path: PathLike, force: bool = False) -> None:
    """Raise a FileError before the work starts if a file could not be written, or replaced without `force`."""
    final = _place(path)
    end = suffix_of(final)
    if end in READ_ONLY:
        raise FileError(f"can't write {path}: {end} files are read only; write {READ_ONLY[end]}")
    if final.is_dir():
        raise FileError(f"can't write {path}: it is a directory; give the name of a file")
    if final.exists() and not final.is_file():
        raise FileError(f"can't write {path}: it is not a regular file; give another name")
    if os.path.lexists(final) and not force:
        raise FileError(f"{path} exists already; {REPLACE} replaces it")
    if not final.parent.is_dir():
        raise FileError(f"can't write {path}: there is no folder {final.parent}; make it first")
    if not os.access(final.parent, os.W_OK):
        raise FileError(
            f"can't write {path}: no permission to write in {final.parent}; give another folder"
        )
