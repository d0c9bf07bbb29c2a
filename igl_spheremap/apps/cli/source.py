"""IN: a mesh from a file, stdin or a sample, repaired if asked."""

from __future__ import annotations

from argparse import Namespace
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from ...errors import MeshError
from ...io import read_mesh
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.check import check_mesh
from ...mesh.clean import repair_mesh
from .failures import UsageError
from .streams import STREAM, read_stream


@dataclass(frozen=True, eq=False)
class Source:
    """A checked mesh, its name as it was given, what else its file holds, and what repairing changed."""

    name: str
    v: FloatArray
    f: IntArray
    metadata: Mapping[str, Any]
    repairs: tuple[str, ...] = ()


def load_source(args: Namespace) -> Source:
    """The mesh that the command line names; repairs are reported on stderr, for they may renumber vertices."""
    source = read_source(
        args.source, repair=args.repair, keep_largest=args.keep_largest, kind=args.format, stage=args.progress.stage
    )
    if source.repairs:
        args.progress.write(f"igl-spheremap: repaired {source.name}: {'; '.join(source.repairs)}")
    return source


def read_source(
    name: str,
    *,
    repair: bool = False,
    keep_largest: bool = False,
    kind: str = "obj",
    stage: Callable[[str], None] = lambda name: None,
) -> Source:
    """A checked mesh; `kind` is the format of stdin.

    Raises UsageError for an unknown sample, FileError and MeshError for a file without a closed genus-0 mesh.
    """
    if keep_largest and not repair:
        raise UsageError("--keep-largest goes with --repair")
    stage(f"reading {name}")
    mesh = read_stream(name, kind, lambda path: read_mesh(path, triangulate=repair))
    name = "stdin" if name == STREAM else name
    stage(f"checking {name}")
    try:
        if not repair:
            check_mesh(mesh.v, mesh.f)
            return Source(name, mesh.v, mesh.f, mesh.metadata)
        repaired = repair_mesh(mesh.v, mesh.f, keep_largest=keep_largest)
    except MeshError as error:
        raise MeshError(f"{name}: {error}") from None
    cut = (f"triangulated {mesh.triangulated} polygons",) if mesh.triangulated else ()
    return Source(name, repaired.v, repaired.f, mesh.metadata, cut + repaired.actions)
