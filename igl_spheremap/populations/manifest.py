"""The manifest of a population: options, inputs and every result, in a file that only grows."""

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
from .lock import lock
from .table import Row, from_plain, json_lines, plain

_INTERVAL = 1.0  # seconds between two flushes to the disk
_BEGIN = b'{"run": '


class Manifest:
    """JSON lines that are appended: a run, its inputs, and a line for each result. One run writes at a time.

    A result is known by its key: a digest of the mesh file, the options, and the target's path from the manifest.
    """

    def __init__(self, path: str | os.PathLike[str], run: Mapping[str, Any]) -> None:
        check_writable(path, force=True)
        self.path = Path(os.path.realpath(path))
        self.inputs: dict[str, Fingerprint] = {}
        self._results: dict[str, tuple[Row, Fingerprint | None]] = {}
        with self._writing():
            self._file = self.path.open("a+b", buffering=0)  # what is written survives this process at once
        if not lock(self._file):
            self._file.close()
            raise FileError(f"another run, {self._last_run()}, writes {path}; wait until it ends, or give "
                            "manifest=FILE")
        self._file.seek(0)
        if not _BEGIN.startswith(self._file.read(len(_BEGIN)).partition(b"\n")[0]):  # its first line may be cut off
            self._file.close()
            raise FileError(f"{path} is no manifest, and is kept; give manifest=FILE")
        if self._file.seek(0, os.SEEK_END) and not self._ends_with_a_line():
            self._file.write(b"\n")  # a run that was killed cut its last line off
        self._flushed = time.monotonic()
        self._append({"run": dict(run)})
        self._read()

    def _entries(self) -> Iterator[dict[str, Any]]:
        """What the lines hold; those that are cut off are left out."""
        with self.path.open(encoding="utf-8", errors="replace") as file:
            yield from json_lines(file)

    def _last_run(self) -> str:
        """Host and process of the run that was recorded last."""
        return next((entry["run"]["by"] for entry in reversed(list(self._entries())) if "run" in entry), "just begun")

    def _read(self) -> None:
        """Read the records of earlier runs; other lines are ignored."""
        for entry in self._entries():
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

    def add_inputs(self, inputs: Mapping[str, Fingerprint | None]) -> None:
        """Record the inputs that are not recorded yet."""
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
