"""Packages that only some formats need."""

from __future__ import annotations

import importlib
from typing import Any

from ..errors import FileError


def need(module: str, what: str, extra: str = "io") -> Any:
    """Import a package that an extra installs.

    Parameters
    ----------
    module : str
        Its name.
    what : str
        What needs it, for the message.
    extra : str
        The extra of this package that installs it.

    Returns
    -------
    module
        The package.

    Raises
    ------
    FileError
        If it is not installed; the message says how to install it.
    """
    try:
        return importlib.import_module(module)
    except ImportError:
        raise FileError(
            f"{what} needs {module.partition('.')[0]}, which is not installed; "
            f"pip install 'igl_spheremap[{extra}]'"
        ) from None
