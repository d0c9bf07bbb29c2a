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
    """Register cortical surfaces to fsaverage or fsLR, and write the files that pipelines expect.

    igl-spheremap sphere-reg sub-01_hemi-L_white.surf.gii --to fsaverage --to fsLR --out derivatives
    igl-spheremap sphere-reg "subjects/*/surf/?h.white" --out reg/{subject}/surf --names freesurfer --report quality
    igl-spheremap sphere-reg lh.white --to fsaverage5 --labels {hemi}.aparc.annot --out lh_on_right --reflect
    """
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
        )
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
