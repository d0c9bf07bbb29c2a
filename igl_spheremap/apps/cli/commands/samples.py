"""List the shapes that the package makes itself.

    igl-spheremap samples
"""

from __future__ import annotations

import inspect
from argparse import Namespace

from .... import samples
from ..output import Findings
from ..streams import check_outputs


def run(args: Namespace) -> None:
    """Print names, what they are, and their parameters with defaults."""
    check_outputs(args)
    found = Findings()
    for name in samples.names():
        shape = getattr(samples, name)
        line = (inspect.getdoc(shape) or "").partition("\n")[0]
        parameters = {key: entry.default for key, entry in inspect.signature(shape).parameters.items()}
        listed = ", ".join(f"{key}={value}" for key, value in parameters.items())
        found.add(name, f"{line} ({listed})", **{name: {"is": line, "parameters": parameters}})
    found.report(args)
