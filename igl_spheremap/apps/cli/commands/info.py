"""`info`: what a mesh is."""

from argparse import Namespace

from ....errors import MeshError
from ....result.mesh_info import info, mesh_findings
from ..inputs import load_any
from ..output import Findings, check_outputs


def run_info(args: Namespace) -> None:
    """Measure any mesh: its parts, holes and handles, sizes and angles, and what --repair would do.

    igl-spheremap info sample:octopus
    igl-spheremap info scan.stl
    igl-spheremap info lh.pial --json -
    """
    check_outputs(args)
    source = load_any(args)
    args.progress.begin(f"measuring {source.name}")
    try:
        known, *findings = mesh_findings(info(source.v, source.f))
    except MeshError as error:
        raise MeshError(f"{source.name}: {error}") from None
    found = Findings(**known.numbers)
    found.source(source)
    if source.repairs:
        found.add("read", "; ".join(source.repairs))
    found.extend(findings)
    found.report(args)
