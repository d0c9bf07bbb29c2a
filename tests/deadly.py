"""A stand-in for the batch's work whose process dies on some meshes; in a module that the processes can import."""

import os
import signal
from dataclasses import replace

from igl_spheremap.apps.cli.exits import Exit


def map_one(job, method, repair, keep_largest, force, balance=0.0):
    """Certify everything at once, except what kills."""
    if "deadly" in job.source:
        os.kill(os.getpid(), signal.SIGKILL)
    return replace(job, status=Exit.OK)
