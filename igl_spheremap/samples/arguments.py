"""Check the numbers that shape a sample."""

from __future__ import annotations

import math


def number(name: str, value: float, least: float, most: float = math.inf) -> None:
    """Raise ValueError, which names the limits, unless ``least <= value <= most``."""
    if not (least <= value <= most and math.isfinite(value)):
        limits = f"at least {least:g}" if most == math.inf else f"between {least:g} and {most:g}"
        raise ValueError(f"{name} must be {limits}, not {value:g}")
