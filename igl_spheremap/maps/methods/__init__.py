"""The methods of `spherical_conformal_map`: each a record of its options, in a file of its own."""

from __future__ import annotations

from .auto import Auto
from .gu_yau import GuYau
from .lai2014 import Lai2014
from .method import Method
from .stereographic import Stereographic

#: By the name that users give.
METHODS: dict[str, type[Method]] = {method.name: method for method in (Auto, Lai2014, GuYau, Stereographic)}

__all__ = ["METHODS", "Auto", "GuYau", "Lai2014", "Method", "Stereographic"]
