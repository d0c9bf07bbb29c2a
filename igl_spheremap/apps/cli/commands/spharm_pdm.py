"""`spharm-pdm`: a folder of shapes under the names of SPHARM-PDM's files."""

import os
from argparse import Namespace
from pathlib import Path
from typing import Any

from ....io.replacing import make_folder
from ....maps.options import Auto
from ....populations.mapping import SphereMapping
from ....populations.page import Sheet, map_sheet
from ....populations.run_many import run_many
from ....populations.table import Row
from ....shapes.harmonics.spharm_pdm import ShapeExpansion, shape_jobs
from ..exits import Exit, UsageError
from .batch import check_files, list_sources, run_files


def run_spharm_pdm(args: Namespace) -> Exit:
    """Map and expand surfaces into the files that SPHARM-PDM's programs write, one process each.

    igl-spheremap spharm-pdm "surfaces/*_surf.vtk" --out shapes
    igl-spheremap spharm-pdm "surfaces/*.ply" --out shapes --template shapes/first_surf_SPHARM_ellalign.coef
    """
    sources = list_sources(args)
    where = {"force": args.force, "folder": os.getcwd()}
    mapping = SphereMapping(Auto(polish=None), args.balance, None, **where)
    task = ShapeExpansion(mapping, args.degree, args.subdivision, **where)
    try:
        jobs = shape_jobs(sources, args.out, args.template)
    except ValueError as error:
        raise UsageError(f"--{error}") from None
    for job in jobs:
        make_folder(Path(job.target).parent)
    manifest = args.manifest or str(Path(args.out.partition("{")[0]) / "spharm_pdm.manifest.jsonl")
    check_files(args, [manifest, *(path for job in jobs for path in (*job.sources, *job.targets))])

    def run(**options: Any) -> list[Row]:
        return run_many(jobs, task, manifest, **options)

    def sheet(rows: list[Row]) -> Sheet:
        return map_sheet(rows, mapping)

    return run_files(args, "expanding", len(jobs), manifest, run, sheet)
