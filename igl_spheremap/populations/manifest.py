"""The manifest of a population: what was asked for, and every result, in a file that only grows."""

from __future__ import annotations

import contextlib
import json
import os
import time
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from ..errors import FileError
from ..io.replacing import check_writable
from .fingerprint import Fingerprint, fingerprint
from .table import Row, from_plain, json_lines, plain

_INTERVAL = 1.0  # seconds between two flushes to the disk


class Manifest:
    """JSON lines that are appended: a run, its inputs, and a line for each result.

    A result is known by its key: a digest of the mesh file, the options, and the target's path from the manifest.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        check_writable(path, force=True)
        self.path = Path(os.path.realpath(path))
        self.inputs: dict[str, Fingerprint] = {}
        self._results: dict[str, tuple[Row, Fingerprint | None]] = {}
        self._read()
        self._file = self.path.open("a+b", buffering=0)  # what is written survives this process at once
        if self._file.tell() and not self._ends_with_a_line():
            self._file.write(b"\n")  # a run that was killed cut its last line off
        self._flushed = time.monotonic()
        self._dirty = False

    def _read(self) -> None:
        """Read the records of earlier runs; other lines are ignored."""
        if not self.path.exists():
            return
        with self.path.open(encoding="utf-8", errors="replace") as file:
            for entry in json_lines(file):
                try:
                    if "input" in entry:
                        self.inputs[entry["input"]["source"]] = Fingerprint(**entry["input"]["file"])
                    elif "row" in entry:
                        output = entry["output"] and Fingerprint(**entry["output"])
                        self._results[entry["key"]] = from_plain(entry["row"]), output
                except (KeyError, TypeError, ValueError):
                    continue

    def _ends_with_a_line(self) -> bool:
        self._file.seek(-1, os.SEEK_END)
        return self._file.read(1) == b"\n"

    def begin(self, run: Mapping[str, Any], inputs: Mapping[str, Fingerprint | None]) -> None:
        """Record a run, and the inputs that are not recorded yet."""
        self._append({"run": dict(run)})
        for source, file in inputs.items():
            if file is not None and self.inputs.get(source) != file:
                self.inputs[source] = file
                self._append({"input": {"source": source, "file": asdict(file)}})
        self.flush()

    def result(self, key: str, target: str) -> Row | None:
        """The row of that key, if its target is still the file that was written."""
        if key not in self._results:
            return None
        row, output = self._results[key]
        now = fingerprint(target, output)
        return row if (now and now.sha256) == (output and output.sha256) else None

    def add(self, key: str, row: Row, output: Fingerprint | None) -> None:
        """Append a result."""
        self._append({"key": key, "row": plain(row), "output": output and asdict(output)})
        self.flush(_INTERVAL)

    def _append(self, entry: Mapping[str, Any]) -> None:
        with self._writing():
            self._file.write(json.dumps(entry).encode("utf-8") + b"\n")
        self._dirty = True

    def flush(self, interval: float = 0.0) -> None:
        """Bring what was appended to the disk, unless that was done within the last seconds."""
        if not self._dirty or time.monotonic() - self._flushed < interval:
            return
        with self._writing():
            os.fsync(self._file.fileno())
        self._flushed, self._dirty = time.monotonic(), False

    @contextlib.contextmanager
    def _writing(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise FileError(f"can't write {self.path}: {error.strerror or error}") from error

    def __enter__(self) -> Manifest:
        return self

    def __exit__(self, *_: object) -> None:
        self.flush()
        self._file.close()
