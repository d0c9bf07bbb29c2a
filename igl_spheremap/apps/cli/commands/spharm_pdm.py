"""`spharm-pdm`: a folder of shapes under the names of SPHARM-PDM's files."""

import os
from argparse import Namespace

from ....maps.options import Auto
from ....populations.map_many import manifest_of
from ....populations.mapping import SphereMapping
from ....populations.page import map_sheet
from ....shapes.harmonics.spharm_pdm import ShapeExpansion, shape_jobs
from ..exits import Exit, usage
from .batch import list_sources, run_files


def run_spharm_pdm(args: Namespace) -> Exit:
    sources = list_sources(args)
    where = {"force": args.force, "folder": os.getcwd()}
    mapping = SphereMapping(Auto(polish=None), args.balance, None, **where)
    task = ShapeExpansion(mapping, args.degree, args.subdivision, **where)
    with usage("--"):
        jobs = shape_jobs(sources, args.out, args.template)
    return run_files(
        args,
        "expanding",
        jobs,
        task,
        manifest_of(f"{args.out}/", "spharm-pdm"),
        lambda rows: map_sheet(rows, mapping),
    )
