"""Common parts of readers: a regular file, memory bounded by the file's size, and one line for any failure."""

from __future__ import annotations

import contextlib
import gzip
import lzma
import os
import stat
import struct
import tokenize
import zipfile
import zlib
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path, PureWindowsPath
from xml.parsers.expat import ExpatError

import numpy as np
from numpy.typing import DTypeLike

from ..errors import FileError, MeshError, shown, within
from ..gate import PathLike
from ..mesh.arrays import AnyArray
from .formats import GZIP

#: Folders of files that the system makes up when they are read: some have no end, or hold secrets of the process.
_OF_THE_SYSTEM = ("/proc/", "/sys/")
#: Errors of parsers on damaged files, OSErrors of their own among them. All others, such as a caller's time limit, end
#: the call. Errors of a library's own classes are named where it is called.
PARSER_ERRORS = (
    OSError,
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


@contextlib.contextmanager
def reading(path: Path) -> Iterator[None]:
    """Turn a parser's exceptions into a MeshError or FileError of one line that names the file."""
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
    except PARSER_ERRORS as error:
        raise MeshError(
            f"{path}: damaged, or of another format than its name says; write it anew"
        ) from error


@contextlib.contextmanager
def opening(path: PathLike, pipes: bool = False) -> Iterator[None]:
    """Turn the system's refusals into a FileError of one line; parsers' own OSErrors have no `strerror`."""
    try:
        if not pipes:
            check_regular(Path(path))
        yield
    except OSError as error:
        if isinstance(error, FileError) or error.strerror is None:
            raise
        raise FileError(f"can't read {error.filename or path}: {error.strerror}") from error


def check_regular(path: Path) -> None:
    """Refuse folders, and files without a size to bound memory by: devices, pipes, sockets, and files of the system."""
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
    folder = os.path.realpath(path.parent)
    leaves = not os.path.realpath(path.parent / name).startswith(os.path.join(folder, ""))
    if place.anchor or ".." in place.parts or leaves:
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


def expansion_limit(stored: int, times: int = 64, least: int = 1 << 20) -> int:
    """Bytes that a file of that size may expand to.

    Structured grids take 8 times their size, repeated bytes 1,000 times; the shortest files are mostly header.
    """
    return max(times * stored, least)


def unpacked(path: Path, times: int = 64) -> bytes:
    """The bytes of a file, or those that it packs by gzip, up to some times its size."""
    data = path.read_bytes()
    if not data.startswith(GZIP):
        return data
    with gzip.open(BytesIO(data)) as file:
        content = file.read(expansion_limit(len(data), times) + 1)
    check_expansion(len(content), len(data), times)
    return content


def check_expansion(expanded: int, stored: int, times: int = 64) -> None:
    """Refuse content that would take far more memory than a mesh in a file of that size."""
    if expanded > expansion_limit(stored, times):
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


class Bytes:
    """Bytes of a file, taken from a place on; a MeshError if fewer follow than are announced."""

    def __init__(self, data: bytes, at: int = 0) -> None:
        self.data, self.at = data, at

    def take(self, size: int) -> bytes:
        """The next bytes."""
        rest = max(len(self.data) - self.at, 0)
        check_complete(self.at >= 0 and 0 <= size <= rest, f"{rest} bytes", str(size))
        self.at += size
        return self.data[self.at - size : self.at]

    def array(self, kind: DTypeLike, count: int) -> AnyArray:
        """The next numbers of a type."""
        dtype = np.dtype(kind)
        return np.frombuffer(self.take(count * dtype.itemsize), dtype)

    def number(self, kind: DTypeLike) -> int:
        """The next number of a type, a whole one."""
        return int(self.array(kind, 1)[0])
