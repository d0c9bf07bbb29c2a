"""A map that may become the result."""

from __future__ import annotations

from dataclasses import dataclass

from ..mesh.arrays import FloatArray
from ..result.run import Round, Status
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
    #: Of `x`; if given, `x` is in its final gauge and must not be moved any more.
    certificate: Certificate | None = None
    #: As of `SphereMap`.
    gauge: str = "centred"
    #: As of `SphereMap`.
    stretch: float = 1.0
    #: The factorisation that was used, if one was.
    backend: str = ""
    #: Remarks on the run.
    notes: tuple[str, ...] = ()
