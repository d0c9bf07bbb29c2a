"""The plan of a repair: the maps that start, the least gain of steps, and why; it can be read before it runs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..mesh.arrays import FloatArray
from ..mesh.check import Mesh
from ..mesh.measure import surface_area
from ..timings import phase
from ..untangle.local_repair import has_few_foldings
from ..verify.certificate import Certificate
from ..verify.distortion import mean_angle_difference
from .effort import Effort
from .match_angles import is_worth_steps

#: Degrees: a map of larger mean angle difference is poor, and layouts start, too, until a candidate is not poor.
POOR = 2.4
#: Repair of a map with many folded faces: embed it ("embedded"); if several layouts start, embed it, since embedding
#: breaks symmetry ("laid out"); or leave it ("left").
Large = Literal["embedded", "laid out", "left"]


@dataclass(frozen=True)
class Plan:
    """The candidates and the price of a repair, and why.

    Attributes
    ----------
    why : str
        The measurement that decided.
    price : float
        Share of the mean angle difference that further steps have to gain; infinite if none are taken.
    use_map : bool
        The map is a candidate, repaired where it folds. If it is not but layouts are, its embedding comes last.
    layouts : int
        Number of layouts by closing angles that may start.
    holes : int
        Number of further faces, cut out in turn, around which the body may be laid out.
    embeds : bool
        Whether folded maps may be embedded.
    """

    why: str
    price: float = np.inf
    use_map: bool = False
    layouts: int = 0
    holes: int = 0
    embeds: bool = True

    @property
    def starts(self) -> int:
        """Number of candidates that may start; 0 if the map is to stay."""
        if self.use_map:
            return self.layouts + 1
        return self.layouts

    @property
    def compares(self) -> bool:
        """Whether candidates' angles decide anything."""
        return self.starts > 1 or bool(np.isfinite(self.price))

    def __str__(self) -> str:
        """The plan in a sentence."""
        if self.starts == 0:
            return f"{self.why}; so the map stays as it is"
        if np.isinf(self.price):
            return f"{self.why}; so the map is repaired where it folds"
        names = []
        if self.use_map:
            names.append("the map itself")
        if self.layouts == 1:
            names.append("1 layout by angles that close")
        elif self.layouts:
            names.append(f"up to {self.layouts} layouts by angles that close")
        return (
            f"{self.why}; so {' and '.join(names)} may start, and steps on angles go on while further ones "
            f"gain {100 * self.price:.2g} percent"
        )


@phase("plan")
def plan_repair(
    mesh: Mesh,
    x: FloatArray,
    energy: float,
    certificate: Certificate,
    polish: str | None,
    effort: Effort,
    large: Large = "embedded",
    conformal: float = 1.05,
) -> Plan:
    """The first row of `Auto`'s table whose condition a map of this harmonic energy meets.

    Harmonic energy over flat image area is 1 for a conformal map. Smooth bodies reach 1.01 and noisy scans 1.04; it
    begins at 1.07 on machine parts, whose long faces cut through the sphere or fold. Above `conformal`, or if more than
    few faces fold, angles are measured, and layouts may start.
    """
    n, few = len(x), has_few_foldings(certificate, mesh.f)
    folded = f"{certificate.foldings:,} of {len(mesh.f):,} faces fold"
    if certificate.folding_free:
        folded = "no face folds"
    price = effort.price(n)
    if polish == "angles":
        price = effort.polish_gain
    if not few and large == "left":
        return Plan(folded)
    coarse = energy > conformal * surface_area(x, mesh.f)
    mean = 0.0
    if coarse or not few:
        mean = mean_angle_difference(mesh, x)
    layouts, holes = effort.layouts(n), effort.holes_of(n)
    angles = f"{folded}, and angles are {mean:.3g} degrees off in the mean"
    if not few:  # row 1
        if mean <= POOR:
            layouts = 1
        layouts = max(1, layouts)
        if not coarse:
            holes = layouts - 1
        embeds = large == "embedded" or layouts > 1
        return Plan(angles, price, layouts=layouts, holes=holes, embeds=embeds)
    if mean > POOR:  # row 2
        return Plan(angles, price, use_map=True, layouts=layouts, holes=holes)
    if polish == "angles":  # row 3
        return Plan(folded, price, use_map=True)
    if polish == "auto":
        if is_worth_steps(mesh, x, price):  # row 4
            return Plan(f"{folded}, and steps on angles are predicted to pay", price, use_map=True)
        folded += f", and steps on angles are predicted to gain less than {100 * price:.2g} percent"
    return Plan(folded, use_map=not certificate.folding_free)  # rows 5 and 6
