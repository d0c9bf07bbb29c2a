"""The methods of `spherical_conformal_map`, one file each."""

from __future__ import annotations

from collections.abc import Callable

from numpy.typing import ArrayLike

from ...result.run import Listener
from ...result.sphere_map import SphereMap
from ...untangle.candidate import Candidate
from ..options import Auto, GuYau, Lai2014, Method, Stereographic
from ..run import run
from .auto import auto
from .gu_yau import gu_yau
from .lai2014 import lai2014
from .stereographic import stereographic

#: What maps a mesh, by the record of its options.
_SOLVERS: dict[type[Method], Callable[..., Candidate]] = {
    Auto: auto, Lai2014: lai2014, GuYau: gu_yau, Stereographic: stereographic}


def map_by_method(v: ArrayLike, f: ArrayLike, method: Method, listener: Listener | None = None) -> SphereMap:
    """Map a surface by a method and its options."""
    solve = _SOLVERS[type(method)]
    return run(v, f, lambda mesh, notify: solve(mesh, method, notify), method.name, method.settings(), listener)
