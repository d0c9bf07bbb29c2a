"""The methods of `spherical_conformal_map`, one file each, by the name that users give."""

from __future__ import annotations

from collections.abc import Callable

from .auto import auto
from .draft import Draft
from .gu_yau import gu_yau
from .lai2014 import lai2014
from .stereographic import stereographic

#: Each takes a checked mesh and a listener, then its own options by keyword.
METHODS: dict[str, Callable[..., Draft]] = {
    "auto": auto,
    "lai2014": lai2014,
    "gu-yau": gu_yau,
    "stereographic": stereographic,
}

__all__ = ["METHODS", "Draft", "auto", "gu_yau", "lai2014", "stereographic"]
