"""SOURCE and SPHERE: a mesh and a map of it."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace

import numpy as np
from numpy.typing import NDArray

from ...errors import MeshError
from ...io import read_sphere
from .command import UsageError
from .source import Source, add_source, load_source, tell_repairs
from .streams import STREAM, read_stream

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


def add_pair(parser: ArgumentParser, source: str, optional: bool = False) -> None:
    """Add the arguments that name a mesh and its map.

    Parameters
    ----------
    parser : ArgumentParser
        Gains them.
    source : str
        How help calls the mesh.
    optional : bool
        The map may be left out where the mesh's archive holds it.

    Returns
    -------
    None
    """
    add_source(parser, source)
    left_out = f"; may be left out where {source} is an .npz that holds the map" if optional else ""
    parser.add_argument(
        "sphere",
        metavar="SPHERE",
        nargs="?" if optional else None,
        help="its map: the same faces, vertices on a sphere of any radius about the origin; - for stdin" + left_out,
    )


def load_pair(args: Namespace) -> tuple[Source, str, FloatArray]:
    """The mesh and its map, whose vertices and faces must be those of the mesh.

    Parameters
    ----------
    args : Namespace
        With ``source``, ``sphere``, ``repair`` and ``keep_largest``.

    Returns
    -------
    source : Source
        The mesh.
    name : str
        Of the map's file.
    x : (n, 3) float64 array
        The map as stored.

    Raises
    ------
    FileError, MeshError, UsageError
        If one of them can't be read, or they do not fit.
    """
    if args.source == STREAM and args.sphere in (None, STREAM):
        raise UsageError("stdin is read once: give the mesh or its map as a file")
    source = load_source(args)
    tell_repairs(source)
    name = args.sphere or source.name
    x, f = read_stream(name, args, read_sphere)
    name = "stdin" if name == STREAM else name
    check_fits(source, name, x, f)
    return source, name, x


def check_fits(source: Source, name: str, x: FloatArray, f: IntArray) -> None:
    """Refuse what is no map of the mesh, or one in another order.

    Parameters
    ----------
    source : Source
        The mesh.
    name : str
        Of the map's file, for messages.
    x : (n, 3) float64 array
        The map as stored.
    f : (m, 3) int64 array
        Faces as stored.

    Returns
    -------
    None

    Raises
    ------
    MeshError
        If vertices or faces differ.
    """
    if len(x) != len(source.v):
        raise MeshError(
            f"{name} has {len(x)} vertices but {source.name} has {len(source.v)}; give a map of this mesh"
        )
    if len(f) != len(source.f) or not np.array_equal(_face_set(f), _face_set(source.f)):
        raise MeshError(
            f"{name} has other faces than {source.name}: not the same vertex order; give a map of this mesh "
            "in a format that keeps the order (not .stl)"
        )


def _face_set(f: IntArray) -> IntArray:
    """Faces in an order of their own, whichever way they turn."""
    f = np.sort(f, axis=1)
    return f[np.lexsort(f.T)]
