"""Where a command reads and writes: files, and `-` for stdin and stdout."""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from argparse import Namespace
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from ... import samples
from ...errors import FileError, MeshError, import_optional
from ...io import Format, LoadedMesh, check_writable, format_of
from .arguments import WRITTEN
from .failures import UsageError

STREAM = "-"
_SAMPLE = "sample:"
_INPUTS = ("source", "sphere", "fixed", "fixed_sphere", "points", "to", "data", "image", "template")
_OUTPUTS = ("target", "surface", "table", "json", "plot")
_T = TypeVar("_T")


def read_stream(name: str, kind: str, read: Callable[[str | Path], LoadedMesh]) -> LoadedMesh:
    """Read a file, a sample:NAME, or stdin as a file of that kind where the name is `-`."""
    if name.startswith(_SAMPLE):
        try:
            return LoadedMesh(*samples.from_spec(name.removeprefix(_SAMPLE)))
        except ValueError as error:
            raise UsageError(str(error)) from None
    if name != STREAM:
        return read(name)
    if sys.stdin is None:
        raise FileError("can't read stdin: it is closed")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"stdin.{kind}"
        try:
            with path.open("wb") as copy:
                shutil.copyfileobj(sys.stdin.buffer, copy)  # in pieces: readers bound memory by the size of a file
        except OSError as error:
            raise FileError(f"can't copy stdin to {path}: {error.strerror}") from error
        try:
            return read(path)
        except (MeshError, FileError) as error:
            raise type(error)(str(error).replace(str(path), "stdin")) from None


def check_outputs(args: Namespace, surface: bool = False) -> None:
    """Raise an error before the work starts if an output can't be written, or would replace an input.

    A surface as OUT needs a format that is known, and may be stdout.
    """
    target = getattr(args, "target", None)
    if target == STREAM and not surface:
        raise UsageError("OUT must be a file here, not stdout")
    if target == STREAM and args.format not in WRITTEN:
        raise UsageError(f"stdout takes text: --format {' or '.join(WRITTEN)}, not {args.format}")
    if target == STREAM == args.json:
        raise UsageError("OUT and --json can't both be stdout")
    if STREAM in (target, args.json) and sys.stdout is None:
        raise FileError("can't write stdout: it is closed")
    if surface and (kind := target_format(args)).package:
        import_optional(kind.package, kind.name, "io")
    inputs = {os.path.realpath(path) for path in _inputs(args)}
    for path in _paths(args, _OUTPUTS):
        check_writable(path, force=getattr(args, "force", False) or path in (args.json, getattr(args, "plot", None)))
        if os.path.realpath(path) in inputs:
            raise UsageError(f"{path} is an input or another output, which would be lost; write another file")
        inputs.add(os.path.realpath(path))


def _inputs(args: Namespace) -> list[str]:
    """The files that the command reads; of --data FILE:NAME and --feature NAME=MOVING,FIXED those within."""
    features = [file for word in getattr(args, "feature", ()) for file in word.partition("=")[2].split(",")]
    named = [word.rpartition(":")[0] for word in (*_paths(args, ("data",)), *features)]
    return [*_paths(args, _INPUTS), *features, *named]


def _paths(args: Namespace, names: tuple[str, ...]) -> list[str]:
    return [path for name in names if (path := getattr(args, name, None)) not in (None, STREAM)]


def target_format(args: Namespace) -> Format:
    """The format of OUT: by its name, or for stdout by --format."""
    return format_of(f"stdout.{args.format}" if args.target == STREAM else args.target)


def write_target(args: Namespace, write: Callable[[str | Path], _T]) -> _T:
    """Write OUT by a function of a path, and return what that returns; OUT may be stdout."""
    args.progress.stage(f"writing {args.target}")
    if not target_format(args).ordered:
        args.progress.write(f"igl-spheremap: {args.target}: an STL file holds triangles and no vertices; their order "
                            "is lost, other formats keep it")
    if args.target != STREAM:
        return write(args.target)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"stdout.{args.format}"
        outcome = write(path)
        args.progress.close()
        sys.stdout.write(path.read_text(encoding="utf-8"))
        sys.stdout.flush()
    return outcome
