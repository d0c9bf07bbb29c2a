"""IN: a mesh from a file or a sample, mended at the door if asked."""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import samples
from ...errors import MeshError
from ...io import read_mesh
from ...mesh.check import check_mesh
from ...mesh.clean import repair_mesh
from .command import UsageError
from .streams import STREAM, add_format, read_stream

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
_SAMPLE = "sample:"


@dataclass(frozen=True, eq=False)
class Source:
    """A mesh that passed the gate.

    Attributes
    ----------
    name : str
        As it was given.
    v : (n, 3) float64 array
        Positions.
    f : (m, 3) int64 array
        Faces.
    metadata : dict
        What the file said beyond that.
    repairs : tuple of str
        What was mended at the door.
    """

    name: str
    v: FloatArray
    f: IntArray
    metadata: Mapping[str, Any]
    repairs: tuple[str, ...] = ()


def add_source(parser: ArgumentParser, name: str = "IN") -> None:
    """Add the argument IN and the flags that mend it.

    Parameters
    ----------
    parser : ArgumentParser
        Gains the arguments.
    name : str
        How help calls it.

    Returns
    -------
    None
    """
    parser.add_argument("source", metavar=name, help="a mesh file, sample:NAME[:key=value,...], or - for stdin")
    add_format(parser)
    add_repair(parser)


def add_repair(parser: ArgumentParser) -> None:
    """Add the flags that mend a mesh at the door.

    Parameters
    ----------
    parser : ArgumentParser
        Gains the flags.

    Returns
    -------
    None
    """
    parser.add_argument(
        "--repair",
        action="store_true",
        help="mend what needs no new geometry: weld open edges, triangulate, reorient, drop surplus",
    )
    parser.add_argument(
        "--keep-largest", action="store_true", help="with --repair: keep the largest component only"
    )


def load_source(args: Namespace) -> Source:
    """The mesh that the command line names.

    Parameters
    ----------
    args : Namespace
        With ``source``, ``repair``, ``keep_largest``, and ``format`` where the source is stdin.

    Returns
    -------
    Source
        Checked.

    Raises
    ------
    UsageError
        If there is no such sample.
    FileError, MeshError
        If the file can't be read, or holds no closed genus-0 mesh.
    """
    if args.keep_largest and not args.repair:
        raise UsageError("--keep-largest goes with --repair")
    name: str = args.source
    if name.startswith(_SAMPLE):
        try:
            v, f = samples.from_spec(name.removeprefix(_SAMPLE))
        except ValueError as error:
            raise UsageError(str(error)) from None
        return Source(name, v, f, {})
    mesh = read_stream(name, args, lambda path: read_mesh(path, triangulate=args.repair))
    name = "stdin" if name == STREAM else name
    try:
        if not args.repair:
            check_mesh(mesh.v, mesh.f)
            return Source(name, mesh.v, mesh.f, mesh.metadata)
        repaired = repair_mesh(mesh.v, mesh.f, keep_largest=args.keep_largest)
    except MeshError as error:
        raise MeshError(f"{name}: {error}") from None
    cut = (f"triangulated {mesh.triangulated} polygons",) if mesh.triangulated else ()
    return Source(name, repaired.v, repaired.f, mesh.metadata, cut + repaired.actions)


def tell_repairs(source: Source) -> None:
    """Say on stderr what was mended: the vertices may not be the file's any more.

    Parameters
    ----------
    source : Source
        The mesh.

    Returns
    -------
    None
    """
    if source.repairs:
        print(f"igl-spheremap: repaired {source.name}: {'; '.join(source.repairs)}", file=sys.stderr)
