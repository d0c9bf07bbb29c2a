"""`sphere-reg`: cortical surfaces registered to templates, with all files that pipelines expect of them."""

import os
from argparse import Namespace

from ....populations.map_many import manifest_of
from ....shapes.cortices.jobs import describe_datasets, hemisphere_jobs
from ....shapes.cortices.page import registration_sheet
from ....shapes.cortices.task import SphereRegistration
from ..exits import Exit, usage
from .batch import list_sources, run_files


def run_sphere_reg(args: Namespace) -> Exit:
    sources = list_sources(args)
    args.progress.begin("looking for templates")
    task = SphereRegistration(reflect=args.reflect, force=args.force, folder=os.getcwd())
    with usage("--"):
        jobs = hemisphere_jobs(
            sources,
            args.out,
            to=args.templates or ["fsaverage"],
            names=args.names or ["bids"],
            labels=args.labels,
            reflect=args.reflect,
            hemisphere=args.hemi,
            pial=args.pial,
        )
    alone = [job for job in jobs if job.alone]
    if alone:
        more = ""
        if len(alone) > 1:
            more = f" and {len(alone) - 1} more"
        args.progress.write(f"igl-spheremap: {alone[0].source}{more}: {alone[0].alone}")
    status = run_files(
        args,
        "registering",
        jobs,
        task,
        manifest_of(f"{args.out}/", "sphere-reg"),
        lambda rows: registration_sheet(rows, jobs, task),
    )
    describe_datasets(jobs)
    return status
