"""How a file is known again: by its size and time, or else by its digest."""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Fingerprint:
    """Size in bytes, time of the last change in nanoseconds, and SHA-256 of a regular file."""

    size: int
    mtime_ns: int
    sha256: str


def fingerprint(path: str, known: Fingerprint | None = None) -> Fingerprint | None:
    """The fingerprint of a file, None if it is no regular file that can be read.

    The digest of a `known` one is taken without reading the file if size and time are still the same.
    """
    try:
        if not os.path.isfile(path):  # opening a pipe may wait forever, a device may have no end
            return None
        with open(path, "rb") as file:
            stat = os.fstat(file.fileno())
            if known is not None and (known.size, known.mtime_ns) == (stat.st_size, stat.st_mtime_ns):
                return known
            digest = hashlib.sha256()
            while block := file.read(1 << 20):
                digest.update(block)
    except OSError:
        return None
    return Fingerprint(stat.st_size, stat.st_mtime_ns, digest.hexdigest())
