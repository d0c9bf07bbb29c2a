"""A map that may become the result."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..descent.iterate import Round, Status
from ..verify.certificate import Certificate


@dataclass(frozen=True, eq=False)
class Candidate:
    """A map, and what is known of it.

    Attributes
    ----------
    x : (n, 3) float64 array
        Unit rows.
    energy : float
        Harmonic energy.
    status : Status
        How its minimisation ended.
    rounds : tuple of Round
        Foldings before and after each round, where there were rounds.
    certificate : Certificate, optional
        Of `x`, which is in its final gauge then and may not be moved any more.
    gauge : str
        "centred", or "poles".
    stretch : float
        By how much limbs beyond the reach of float64 were lengthened, as a ratio of lengths; 1 if none was.
    backend : str
        The factorisation that was used, if one was.
    notes : tuple of str
        What was done beyond the ordinary.
    """

    x: NDArray[np.float64]
    energy: float
    status: Status
    rounds: tuple[Round, ...] = ()
    certificate: Certificate | None = None
    gauge: str = "centred"
    stretch: float = 1.0
    backend: str = ""
    notes: tuple[str, ...] = ()
