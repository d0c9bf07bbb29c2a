"""polyscope and its widgets, imported at their first use: a program that draws nothing does not need them."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from ...errors import DisplayError

#: Packages of Debian and Ubuntu that polyscope needs.
PACKAGES = "libegl1 libegl-mesa0 libgl1 libgl1-mesa-dri libx11-6"


class _Lazy:
    """A module that is imported at its first use, which raises a DisplayError if it can't be."""

    def __init__(self, module: str) -> None:
        self._module = module

    def __getattr__(self, name: str) -> Any:
        try:
            return getattr(import_module(self._module), name)
        except ImportError as error:
            hint = f"Debian and Ubuntu: apt install {PACKAGES}"
            raise DisplayError(f"polyscope can't be loaded ({error}); {hint}") from None


ps, imgui, implot = (_Lazy(module) for module in ("polyscope", "polyscope.imgui", "polyscope.implot"))
