"""The plan of a repair: which maps start, what steps have to gain, and why; it can be read before it runs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..mesh.arrays import FloatArray
from ..mesh.check import Mesh
from ..mesh.measure import surface_area
from ..start.punctured import is_coarse
from ..timings import phase
from ..untangle.local_repair import has_few_foldings
from ..verify.certificate import Certificate
from ..verify.distortion import mean_angle_difference
from .effort import Effort
from .match_angles import is_worth_steps

#: Degrees: a map of a coarse mesh, or one that folds, is poor if its mean angle difference is above. No candidate
#: starts after one that is not poor. A short trial on 30 random parts of the set tune: with 4.8 the sum of means is 1.0
#: percent higher (3 worse, 1 better), with 1.2 the same for 1.1 of the time (`python -m benchmarks versions .
#: FOLDER/tune --set angles.plan.POOR=4.8`).
POOR = 2.4
#: What the first row of `Auto`'s table, for maps with many foldings, does with them: it embeds what folds ("embedded");
#: it embeds only where several layouts may start, as embedding spoils the symmetry that a map is to have ("laid out");
#: or it leaves the map as it is ("left").
Large = Literal["embedded", "laid out", "left"]


@dataclass(frozen=True)
class Plan:
    """What a repair will try, and why.

    Attributes
    ----------
    why : str
        What decided.
    price : float
        Share of the mean angle difference that further steps have to gain; infinite if none are taken.
    itself : bool
        Whether the map starts, repaired where it folds. If layouts start and it does not, it is embedded, and comes
        after them.
    layouts : int
        How many layouts by angles that close may start.
    holes : int
        How many faces more are cut out in turn at most, to lay the body out around them.
    embeds : bool
        Whether what folds may be embedded.
    """

    why: str
    price: float = np.inf
    itself: bool = False
    layouts: int = 0
    holes: int = 0
    embeds: bool = True

    @property
    def starts(self) -> int:
        """How many candidates may start; 0 if the map is to stay as it is."""
        return self.itself + self.layouts

    @property
    def compares(self) -> bool:
        """Whether angles of candidates decide anything."""
        return self.starts > 1 or bool(np.isfinite(self.price))

    def __str__(self) -> str:
        """The plan in a sentence."""
        several = "1 layout" if self.layouts == 1 else f"up to {self.layouts} layouts"
        names = ["the map itself"] * self.itself + [f"{several} by angles that close"] * (
            self.layouts > 0
        )
        if np.isinf(self.price):
            return f"{self.why}; so the map {'is repaired where it folds' if self.itself else 'stays as it is'}"
        percent = f"{100 * self.price:.2g} percent"
        return (
            f"{self.why}; so {' and '.join(names)} may start, and steps on angles go on while further ones "
            f"gain {percent}"
        )


@phase("plan")
def plan_repair(
    mesh: Mesh,
    x: FloatArray,
    certificate: Certificate,
    polish: str | None,
    effort: Effort,
    large: Large = "embedded",
) -> Plan:
    """The first row of `Auto`'s table whose condition a map meets."""
    few, free, n = has_few_foldings(certificate, mesh.f), certificate.folding_free, len(x)
    folded = "no face folds" if free else f"{certificate.foldings:,} of {len(mesh.f):,} faces fold"
    price = effort.polish_gain if polish == "angles" else effort.price(n)
    if not few and large == "left":
        return Plan(folded)
    coarse = is_coarse(surface_area(x, mesh.f))
    mean = mean_angle_difference(mesh, x) if coarse or not few else 0.0
    poor, angles = mean > POOR, f"{folded}, and angles are {mean:.3g} degrees off in the mean"
    if not few:  # row 1
        layouts = max(1, effort.layouts(n)) if poor else 1
        # On coarse meshes embedding spoils angles: layouts follow each other until one does not fold.
        return Plan(
            angles,
            price,
            layouts=layouts,
            holes=effort.holes if coarse else layouts - 1,
            embeds=large == "embedded" or layouts > 1,
        )
    if poor:  # row 2
        return Plan(angles, price, itself=True, layouts=effort.layouts(n), holes=effort.holes)
    if polish == "angles":  # row 3
        return Plan(folded, price, itself=True)
    if polish == "auto" and is_worth_steps(mesh, x, price):  # row 4
        return Plan(f"{folded}, and steps on angles are predicted to pay", price, itself=True)
    little = f", and steps on angles are predicted to gain less than {100 * price:.2g} percent"
    return Plan(folded + little * (polish == "auto"), itself=not free)  # rows 5 and 6
