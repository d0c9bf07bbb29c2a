"""A map that may become the result."""

from __future__ import annotations

from dataclasses import dataclass

from ..descent.iterate import Round, Status
from ..mesh.arrays import FloatArray
from ..verify.atlas import ChartAtlas
from ..verify.certificate import Certificate


@dataclass(frozen=True, eq=False)
class Candidate:
    """A map, and what is known of it."""

    #: (n, 3) unit rows.
    x: FloatArray
    #: Harmonic energy.
    energy: float
    #: How its minimisation ended.
    status: Status
    #: Foldings before and after each round, where there were rounds.
    rounds: tuple[Round, ...] = ()
    #: Of `x`, which is in its final gauge then and may not be moved any more.
    certificate: Certificate | None = None
    #: As of `SphereMap`.
    gauge: str = "centred"
    #: By how much limbs beyond the reach of float64 were lengthened, as a ratio of lengths; 1 if none was.
    stretch: float = 1.0
    #: The factorisation that was used, if one was.
    backend: str = ""
    #: What was done beyond the ordinary.
    notes: tuple[str, ...] = ()
    #: As of `SphereMap`.
    atlas: ChartAtlas | None = None
