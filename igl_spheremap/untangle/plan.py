"""The plan of a repair: which maps start, what steps have to gain, and why; it can be read before it runs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..mesh.arrays import FloatArray
from ..mesh.check import Mesh
from ..mesh.measure import surface_area
from ..mesh.timings import stage
from ..start.punctured import is_coarse
from ..verify.certificate import Certificate
from ..verify.distortion import mean_angle_difference
from .effort import Effort
from .local_repair import has_few_foldings
from .match_angles import is_worth_steps

#: Degrees: a map of a coarse mesh, or one that folds, is poor if its mean angle difference is above. No candidate
#: starts after one that is not poor. A short trial on 30 random parts of the set tune: with 4.8 the sum of means is 1.0
#: percent higher (3 worse, 1 better), with 1.2 the same for 1.1 of the time (`python -m benchmarks versions .
#: FOLDER/tune --set untangle.plan.POOR=4.8`).
POOR = 2.4
#: What may start where more than a percent of the faces fold: all that there is; of a mesh with a symmetry that its map
#: is to have, layouts alone, as embedding spoils it, unless the mesh is so small that several may start; or nothing.
Large = Literal["embedded", "laid out", "left"]


@dataclass(frozen=True)
class Plan:
    """What a repair will try, and why.

    Attributes
    ----------
    itself : bool
        Whether the map starts, repaired where it folds; if not, and layouts do, it is embedded where there is room
        after them.
    layouts : int
        How many layouts by angles that close may start.
    holes : int
        Around how many more faces the body is laid out at most; more than may start on coarse meshes, where
        embedding spoils angles, until a layout does not fold.
    price : float
        Share of the mean angle difference that further steps have to gain; infinite if none are taken.
    why : str
        What decided.
    embeds : bool
        Whether what folds may be embedded.
    """

    itself: bool
    layouts: int
    holes: int
    price: float
    why: str
    embeds: bool = True

    @property
    def starts(self) -> int:
        """How many candidates may start; 0 if the map is to stay as it is."""
        return self.itself + self.layouts

    def __str__(self) -> str:
        """The plan in a sentence."""
        several = "1 layout" if self.layouts == 1 else f"up to {self.layouts} layouts"
        names = ["the map itself"] * self.itself + [f"{several} by angles that close"] * (self.layouts > 0)
        if np.isinf(self.price):
            repaired = "the map is repaired where it folds, and " if self.itself else ""
            return f"{self.why}; so {repaired}no steps are taken"
        percent = f"{100 * self.price:.2g} percent"
        return f"{self.why}; so {' and '.join(names)} may start, and steps go on while further ones gain {percent}"


@stage("plan")
def plan_repair(mesh: Mesh, x: FloatArray, certificate: Certificate, polish: str | None, effort: Effort,
                large: Large = "embedded") -> Plan:
    """The plan for a map, by what folds, its angles, and what steps are predicted to gain."""
    free, few, n = certificate.folding_free, has_few_foldings(certificate, mesh.f), len(x)
    price = effort.polish_gain if polish == "angles" else effort.price(n)
    folded = "no face folds" if free else f"{certificate.foldings:,} of {len(mesh.f):,} faces fold"
    if large == "left" and not few:
        return Plan(False, 0, 0, np.inf, folded)
    coarse = is_coarse(surface_area(x, mesh.f))
    if coarse or not few:
        mean = mean_angle_difference(mesh, x)
        if mean > POOR or not few:
            layouts = effort.layouts(n) if mean > POOR else 0
            why = f"{folded}, and angles are {mean:.3g} degrees off in the mean"
            holes = effort.holes if coarse else max(0, layouts - 1)
            embeds = few or layouts > 1 or large == "embedded"
            return Plan(few, layouts if few else max(1, layouts), holes, price, why, embeds)
    if polish is None:
        return Plan(not free, 0, 0, np.inf, folded)
    if polish == "angles" or is_worth_steps(mesh, x, price, harmonic=True):
        return Plan(True, 0, 0, price, f"{folded}, and steps are predicted to pay" if polish == "auto" else folded)
    why = f"{folded}, and steps are predicted to gain less than {100 * price:.2g} percent"
    return Plan(not free, 0, 0, np.inf, why)
