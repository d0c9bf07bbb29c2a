"""A stand-in for the work of a population, in a module that other processes can import."""

import errands

from igl_spheremap.populations.manifest import JobResult
from igl_spheremap.populations.table import Row


def run_job(job, options):
    """Certify everything at once, except what kills the process or waits for long."""
    if "deadly" in job.source:
        errands.die()
    if "slow" in job.source:
        errands.wait()
    return JobResult(Row(job.source, job.target), None, (None,))
