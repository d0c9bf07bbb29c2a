"""What all readers share: a regular file, memory bounded by the file's size, and one line for any failure."""

from __future__ import annotations

import contextlib
import lzma
import os
import stat
import struct
import tokenize
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path, PureWindowsPath
from xml.parsers.expat import ExpatError

import numpy as np

from ..errors import FileError, MeshError, shown, within
from .formats import PathLike

#: How many times its size a file may expand to: structured grids take 8 times, repeated bytes 1,000 times.
_EXPANSION = 64
#: Bytes that any file may expand to: the shortest ones are mostly header.
_ALWAYS = 1 << 20
#: Folders of files that the system makes up when they are read: some have no end, or hold secrets of the process.
_OF_THE_SYSTEM = ("/proc/", "/sys/")
#: What parsers raise on damaged files. All else, such as a caller's time limit, ends the call.
_OF_PARSERS = (
    ValueError,
    LookupError,
    TypeError,
    AttributeError,
    ArithmeticError,
    AssertionError,
    EOFError,
    RuntimeError,
    StopIteration,
    SyntaxError,
    ExpatError,
    lzma.LZMAError,
    struct.error,
    tokenize.TokenError,
    zipfile.BadZipFile,
    zlib.error,
)
#: Packages whose own exceptions are of that kind, too.
_PARSERS = ("nibabel.", "trimesh.")


@contextlib.contextmanager
def reading(path: Path) -> Iterator[None]:
    """Turn whatever a parser raises into a MeshError or FileError of one line that names the file."""
    try:
        with opening(path), np.errstate(all="ignore"):
            if path.stat().st_size == 0:
                raise MeshError("the file is empty (0 bytes); write it anew")
            yield
    except (FileError, TimeoutError):
        raise
    except MeshError as error:
        raise within(error, f"{path}: ") from None
    except MemoryError as error:
        raise FileError(f"can't read {path}: out of memory") from error
    except Exception as error:
        of_parsers = isinstance(
            error, (*_OF_PARSERS, OSError)
        )  # parsers have OSErrors of their own
        if not of_parsers and not type(error).__module__.startswith(_PARSERS):
            raise
        raise MeshError(
            f"{path}: damaged, or of another format than its name says; write it anew"
        ) from error


@contextlib.contextmanager
def opening(path: PathLike, pipes: bool = False) -> Iterator[None]:
    """Turn what the system refuses into a FileError of one line; parsers' own OSErrors have no `strerror`."""
    try:
        if not pipes:
            check_regular(Path(path))
        yield
    except OSError as error:
        if isinstance(error, FileError) or error.strerror is None:
            raise
        raise FileError(f"can't read {error.filename or path}: {error.strerror}") from error


def check_regular(path: Path) -> None:
    """Refuse folders, and what has no size to bound memory by: devices, pipes, sockets, and what the system shows."""
    mode = path.stat().st_mode
    if stat.S_ISDIR(mode):
        raise FileError(f"can't read {path}: it is a directory; give a file in it")
    if not stat.S_ISREG(mode):
        raise FileError(
            f"can't read {path}: it is a device or a pipe; write its content to a file first"
        )
    if os.path.realpath(path).startswith(_OF_THE_SYSTEM):
        raise FileError(
            f"can't read {path}: the system makes it up and it has no size; copy it first"
        )


def beside(path: Path, name: str) -> Path:
    """The regular file that another file names; a FileError unless it is in the folder of that one, or below."""
    place = PureWindowsPath(name)  # which knows both kinds of separators
    if place.anchor or ".." in place.parts:
        raise FileError(
            f"can't read {path}: it names {shown(name)}, which is not in its folder; put that file beside it"
        )
    check_regular(path.parent / name)
    return path.parent / name


def read_lines(path: PathLike, *, pipes: bool = False) -> list[str]:
    """Lines of a small text file in UTF-8; bytes that can't be decoded become surrogates, as in names of files.

    With `pipes` it may be one, as `<(find ...)` of a shell is.
    """
    with opening(path, pipes):
        return Path(path).read_text(encoding="utf-8", errors="surrogateescape").splitlines()


def expansion_limit(stored: int) -> int:
    """Bytes that a file of that size may expand to."""
    return max(_EXPANSION * stored, _ALWAYS)


def check_expansion(expanded: int, stored: int) -> None:
    """Refuse what would take far more memory than a mesh in a file of that size."""
    if expanded > expansion_limit(stored):
        raise MeshError(
            f"its {stored} bytes expand to {expanded} or more, which no mesh does; write it anew"
        )


def check_complete(complete: bool, found: str, announced: str) -> None:
    """Refuse a file that holds less than its header announces."""
    if not complete:
        raise MeshError(
            f"damaged: {found} follow where {announced} are announced; the file seems cut off, "
            "write it anew"
        )
