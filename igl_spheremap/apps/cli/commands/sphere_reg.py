"""`sphere-reg`: cortical surfaces registered to templates, with all files that pipelines expect of them."""

import os
from argparse import Namespace
from typing import Any

from ....errors import MeshError
from ....populations.page import Sheet
from ....populations.run_many import run_many
from ....populations.table import RegistrationRow
from ....shapes.cortices.jobs import describe_datasets, hemisphere_jobs, registration_manifest
from ....shapes.cortices.page import registration_sheet
from ....shapes.cortices.task import SphereRegistration
from ..exits import Exit, UsageError
from .batch import check_files, list_sources, run_files


def run_sphere_reg(args: Namespace) -> Exit:
    """Register cortical surfaces to fsaverage or fsLR, and write the files that pipelines expect.

    igl-spheremap sphere-reg sub-01_hemi-L_white.surf.gii --to fsaverage --to fsLR --out derivatives
    igl-spheremap sphere-reg --subjects-dir subjects --out reg/{subject}/surf --names freesurfer --report quality
    igl-spheremap sphere-reg lh.white --to fsaverage5 --labels {hemi}.aparc.annot --out lh_on_right --reflect
    """
    sources = list_sources(args)
    args.progress.begin("looking for templates")
    task = SphereRegistration(reflect=args.reflect, force=args.force, folder=os.getcwd())
    try:
        jobs = hemisphere_jobs(sources, args.out, to=args.templates or ["fsaverage"], names=args.names or ["bids"],
                               labels=args.labels, reflect=args.reflect, hemisphere=args.hemi)
    except ValueError as error:
        if isinstance(error, MeshError):
            raise
        raise UsageError(f"--{error}") from None
    manifest = args.manifest or registration_manifest(args.out)
    check_files(args, [manifest, *(path for job in jobs for path in (*job.sources, *job.targets))])

    def run(**options: Any) -> list[RegistrationRow]:
        rows = run_many(jobs, task, manifest, **options)
        describe_datasets(jobs)
        return rows

    def sheet(rows: list[RegistrationRow]) -> Sheet:
        return registration_sheet(rows, jobs, task)

    return run_files(args, "registering", len(jobs), manifest, run, sheet)
