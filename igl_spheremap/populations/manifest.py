"""The manifest of a population: every run and every result, in a file that only grows.

As long as its input and its output have the same content, a result is taken again. If size and time of the last change
are the same, or else the digest, a file counts as the same.
"""

from __future__ import annotations

import contextlib
import errno
import hashlib
import json
import os
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import IO, Any

from ..errors import FileError, Remedy, printable
from ..gate import PathLike
from ..io.replacing import check_writable, make_folder
from .table import MAPPED, ROW_ERRORS, JobRow, from_plain, json_lines, plain

_BEGIN = b'{"igl_spheremap run": '


@dataclass(frozen=True, slots=True)
class Fingerprint:
    """Size in bytes, time of the last change in nanoseconds, and SHA-256 of a regular file, which makes it equal."""

    size: int = field(compare=False)
    mtime_ns: int = field(compare=False)
    sha256: str


def fingerprint(path: str, known: Fingerprint | None = None) -> Fingerprint | None:
    """The fingerprint of a file, None if it is not a regular file that can be read.

    If size and time are still the same, the digest of a `known` one is taken without reading the file.
    """
    try:
        if not os.path.isfile(path):  # opening a pipe may wait forever, a device may have no end
            return None
        with open(path, "rb") as file:
            stat = os.fstat(file.fileno())
            found = stat.st_size, stat.st_mtime_ns
            if known is not None and (known.size, known.mtime_ns) == found:
                return known
            digest = hashlib.sha256()
            while block := file.read(1 << 20):
                digest.update(block)
    except OSError:
        return None
    return Fingerprint(*found, digest.hexdigest())


#: Fingerprints of files at several paths.
Fingerprints = tuple[Fingerprint | None, ...]


def fingerprints(paths: Sequence[str], known: Fingerprints | None = None) -> Fingerprints:
    """The fingerprints of several files."""
    if known is None:
        known = (None,) * len(paths)
    return tuple(map(fingerprint, paths, known))


def are_still(paths: Sequence[str], known: Fingerprints) -> bool:
    """Whether files have the contents of fingerprints; None is that of a file that can't be read."""
    return len(paths) == len(known) and fingerprints(paths, known) == known


@dataclass(frozen=True)
class JobResult:
    """A row, the files that were read for it, and those that are at its targets now.

    If another run of the same input may end in another way, ``read`` is None: such a result is not taken again.
    """

    row: JobRow
    read: Fingerprints | None
    written: Fingerprints


class Manifest:
    """JSON lines that are appended: a line for each run and for each result. One run writes at a time.

    A result is known by its key, see `igl_spheremap.populations.job.key_of`; the last one of a key counts.
    """

    def __init__(self, path: PathLike, run: Mapping[str, Any]) -> None:
        make_folder(Path(path).parent)
        check_writable(path, force=True)
        self.path = Path(os.path.realpath(path))
        self._results: dict[str, list[JobResult]] = {}
        with self._writing():
            # written lines survive this process at once
            self._file = self.path.open("a+b", buffering=0)
        try:
            self._check(path)
        except FileError:
            self._file.close()
            raise
        if self._file.seek(0, os.SEEK_END):
            self._file.seek(-1, os.SEEK_END)
            if self._file.read(1) != b"\n":
                self._file.write(b"\n")  # an earlier run was killed within its last line
        self._append({"igl_spheremap run": dict(run)})
        for key, result in self._earlier():
            self._results.setdefault(key, []).append(result)

    def _check(self, path: PathLike) -> None:
        """Raise a FileError if another run writes the file, or if it is not a manifest."""
        if not _lock(self._file):
            raise FileError(
                f"another run, {self._last_run()}, writes {path}; wait until it ends, or give "
                f"another {Remedy(options={'manifest': None})}"
            )
        self._file.seek(0)
        begin = self._file.read(len(_BEGIN))
        if begin != _BEGIN[: len(begin)]:
            raise FileError(
                f"{path} is not a manifest, and is kept; give another {Remedy(options={'manifest': None})}"
            )
        if begin != _BEGIN:
            self._file.truncate(0)  # its first run was killed as it began

    def _entries(self) -> Iterator[dict[str, Any]]:
        with self.path.open(encoding="utf-8", errors="replace") as file:
            yield from json_lines(file)

    def _last_run(self) -> str:
        """Host and process of the run that was recorded last."""
        runs = [
            entry["igl_spheremap run"] for entry in self._entries() if "igl_spheremap run" in entry
        ]
        if runs and isinstance(runs[-1], dict):
            return printable(str(runs[-1].get("by")))
        return "just begun"

    def _earlier(self) -> Iterator[tuple[str, JobResult]]:
        """Keys and results of earlier runs; other lines are ignored, and results that no file proves."""
        for entry in self._entries():
            with contextlib.suppress(*ROW_ERRORS):
                read, row = None, _printable(from_plain(entry["row"]))
                if entry["read"] is not None:
                    read = _unpacked(entry["read"])
                written = _unpacked(entry["written"])
                if row.status not in MAPPED or (len(written) > 0 and all(written)):
                    yield str(entry["key"]), JobResult(row, read, written)

    def result(self, key: str, sources: Sequence[str], targets: Sequence[str]) -> JobRow | None:
        """The row of that key, if the sources are the files that were read, and the targets those that were written."""
        for found in self._results.get(key, ())[-1:]:
            if found.read and are_still(sources, found.read) and are_still(targets, found.written):
                return found.row
        return None

    def made(self, key: str, targets: Sequence[str]) -> bool:
        """Whether an earlier run wrote the present files at the targets."""
        results = self._results.get(key, ())
        return any(
            each.row.status in MAPPED and are_still(targets, each.written) for each in results
        )

    def add(self, key: str, result: JobResult) -> None:
        """Append a result."""
        self._append({"key": key, **asdict(result), "row": plain(result.row)})

    def _append(self, entry: Mapping[str, Any]) -> None:
        line = json.dumps(entry).encode("utf-8") + b"\n"
        with self._writing():
            if self._file.write(line) < len(line):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    @contextlib.contextmanager
    def _writing(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            reason = error.strerror
            if not reason:
                reason = str(error)
            raise FileError(f"can't write {self.path}: {reason}") from error

    def __enter__(self) -> Manifest:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()


def _unpacked(files: Iterable[Any]) -> Fingerprints:
    """Fingerprints as JSON holds them."""
    found: list[Fingerprint | None] = []
    for file in files:
        if file is None:
            found.append(None)
        else:
            found.append(Fingerprint(**file))
    return tuple(found)


def _printable(row: JobRow) -> JobRow:
    """A row whose texts, which anybody may have put into the file, do nothing to a terminal."""
    texts: dict[str, Any] = {
        name: printable(getattr(row, name)) for name in ("status", "worker", "notes")
    }
    return replace(row, **texts)


def _lock(file: IO[bytes]) -> bool:
    """Lock a file until it is closed, as it is when the process ends; if another run has it, False.

    Without locks of the file system, True.
    """
    try:
        if sys.platform == "win32":
            import msvcrt

            file.seek(1 << 40)  # bytes are locked against reading, too: one that no file reaches
            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        return error.errno not in (errno.EWOULDBLOCK, errno.EACCES)
    return True
