"""The inputs of a batch: files, globs, lists of files, and the subjects of a FreeSurfer folder."""

from __future__ import annotations

import glob
import os
from collections.abc import Iterable
from pathlib import Path

from ...errors import FileError
from .failures import UsageError
from .streams import STREAM


def expand(words: Iterable[str]) -> list[str]:
    """Files in the order given; of a list `@FILE` one a line, of a glob in alphabetical order."""
    names: list[str] = []
    for word in words:
        if word == STREAM:
            raise UsageError("a batch reads files, not stdin")
        if word.startswith("@") and not os.path.exists(word):
            names += expand(_lines(word[1:]))
        elif glob.has_magic(word) and not os.path.exists(word):
            found = sorted(glob.glob(word, recursive=True))
            if not found:
                raise UsageError(f"no file is called {word}")
            names += found
        else:
            names.append(word)
    return names


def _lines(path: str) -> list[str]:
    """The lines of a file but empty ones and comments."""
    try:
        lines = Path(path).read_text(encoding="utf-8", errors="surrogateescape").splitlines()
    except OSError as error:
        raise FileError(f"can't read the list {path}: {error.strerror}") from None
    return [line.strip() for line in lines if line.strip() and not line.startswith("#")]


def subjects(folder: str, surfaces: str) -> list[str]:
    """Surfaces, named with commas between them, of each subject in a FreeSurfer folder, there or missing."""
    found = sorted(str(path) for path in Path(folder).glob("*/surf") if path.is_dir())
    if not found:
        raise UsageError(f"--subjects-dir {folder} holds no subject: no folder */surf")
    return [os.path.join(surf, name) for surf in found for name in surfaces.split(",")]
