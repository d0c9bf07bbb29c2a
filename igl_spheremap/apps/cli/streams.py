"""`-`: a mesh from stdin as IN, a surface to stdout as OUT."""

from __future__ import annotations

import sys
import tempfile
from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from ...errors import FileError, MeshError
from ...io import FORMATS, Format, LoadedMesh, check_writable, format_of
from .command import UsageError

STREAM = "-"
_READ = tuple(entry.suffixes[0].lstrip(".") for entry in FORMATS)
_WRITTEN = ("obj", "off")  # text: nothing that would garble a terminal
_T = TypeVar("_T")


def add_format(parser: ArgumentParser) -> None:
    """Add the flag that says what a stream holds.

    Parameters
    ----------
    parser : ArgumentParser
        Gains it.

    Returns
    -------
    None
    """
    parser.add_argument(
        "--format",
        choices=_READ,
        default=_READ[0],
        metavar="FMT",
        help=f"of '-', which is stdin for a mesh and stdout for OUT: {', '.join(_READ)}; for OUT "
        f"{' or '.join(_WRITTEN)}; default: {_READ[0]}",
    )


def read_stream(name: str, args: Namespace, read: Callable[[str | Path], LoadedMesh]) -> LoadedMesh:
    """Read a file, or stdin where its name is `-`.

    Parameters
    ----------
    name : str
        As it was given.
    args : Namespace
        With ``format``, if the name is `-`.
    read : callable
        Takes a path.

    Returns
    -------
    LoadedMesh
        What `read` gives.

    Raises
    ------
    FileError, MeshError
        As `read` does.
    """
    if name != STREAM:
        return read(name)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"stdin.{args.format}"
        path.write_bytes(sys.stdin.buffer.read())
        try:
            return read(path)
        except (MeshError, FileError) as error:
            raise type(error)(str(error).replace(str(path), "stdin")) from None


def check_target(args: Namespace) -> None:
    """Say before the work starts if OUT can't be written.

    Parameters
    ----------
    args : Namespace
        With ``target``, ``force``, ``format`` and ``json``.

    Returns
    -------
    None

    Raises
    ------
    FileError, UsageError
        If it can't.
    """
    if args.target != STREAM:
        format_of(args.target)
        check_writable(args.target, args.force)
    elif args.json == STREAM:
        raise UsageError("OUT and --json can't both be stdout")
    elif args.format not in _WRITTEN:
        raise UsageError(f"stdout takes text: --format {' or '.join(_WRITTEN)}, not {args.format}")


def target_format(args: Namespace) -> Format:
    """The format of OUT.

    Parameters
    ----------
    args : Namespace
        With ``target`` and ``format``.

    Returns
    -------
    Format
        By its name, or of a stream as the flag says.
    """
    return format_of(f"stdout.{args.format}" if args.target == STREAM else args.target)


def write_target(args: Namespace, write: Callable[[str | Path], _T]) -> _T:
    """Write OUT, to stdout where it is `-`.

    Parameters
    ----------
    args : Namespace
        With ``target`` and ``format``.
    write : callable
        Takes a path, and writes a file there.

    Returns
    -------
    object
        What `write` gives.
    """
    if args.target != STREAM:
        return write(args.target)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"stdout.{args.format}"
        outcome = write(path)
        sys.stdout.write(path.read_text())
        sys.stdout.flush()
    return outcome
