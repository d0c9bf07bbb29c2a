"""`info`: description of a mesh."""

from argparse import Namespace
from typing import Any

from ....errors import naming
from ....io.files import parts_in
from ....io.write_mesh import write_mesh
from ....mesh_repair.info import info, mesh_findings
from ....timings import counted
from ..arguments import repair_of
from ..exits import UsageError
from ..inputs import load_source, read_source
from ..output import LISTED, Findings, check_outputs


def run_info(args: Namespace) -> None:
    check_outputs(args)
    if args.parts:
        if args.write is not None:
            raise UsageError("--write: --parts measures many surfaces; write one, as FILE:K")
        _measure_parts(args)
        return
    source = load_source(args, check=False)
    args.progress.begin(f"measuring {source.name}")
    with naming(source.name):
        known, *findings = mesh_findings(info(source.v, source.f))
    found = Findings(**known.numbers)
    found.source(source)
    found.extend(findings)
    if args.write is not None:
        write_mesh(args.write, source.v, source.f, metadata=source.metadata)
        found.add("written", f"{args.write}: {len(source.v)} vertices, {len(source.f)} faces")
    found.report(args)


def _measure_parts(args: Namespace) -> None:
    """Measure each closed part of a file by itself."""
    found, parts = Findings(source=args.source), list[dict[str, Any]]()
    for name in counted("parts", parts_in(args.source)):
        part = read_source(name, repair=repair_of(args), check=False)
        known, topology, *_ = mesh_findings(info(part.v, part.f))
        parts.append({"source": name, "repairs": part.repairs, **known.numbers})
        if len(parts) <= LISTED:
            found.add(f"part {name.rpartition(':')[2]}", f"{known.text}; {topology.text}")
    ready = sum(part["maps_to"] == "sphere" for part in parts)
    found.add(
        "parts",
        f"{len(parts)} closed ones, {ready} of which can be mapped to the sphere",
        parts=parts,
    )
    found.report(args)
