"""`info`: what a mesh is."""

from argparse import Namespace

from ....errors import naming
from ....result.mesh_info import info, mesh_findings
from ..inputs import load_source
from ..output import Findings, check_outputs


def run_info(args: Namespace) -> None:
    """Measure any mesh: its parts, holes and handles, sizes and angles, and what --repair would do.

    igl-spheremap info sample:octopus
    igl-spheremap info scan.stl
    igl-spheremap info lh.pial --json -
    """
    check_outputs(args)
    source = load_source(args, check=False)
    args.progress.begin(f"measuring {source.name}")
    with naming(source.name):
        known, *findings = mesh_findings(info(source.v, source.f))
    found = Findings(**known.numbers)
    found.source(source)
    found.extend(findings)
    found.report(args)
