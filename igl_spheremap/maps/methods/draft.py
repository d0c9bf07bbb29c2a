"""What a method hands back before it is put in the gauge and certified."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...descent.iterate import Round, Status
from ...verify.certificate import Certificate

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Draft:
    """A map as a method leaves it.

    Attributes
    ----------
    x : (n, 3) float64 array
        Unit rows.
    energy : float
        Harmonic energy.
    status : Status
        How it ended.
    rounds : tuple of Round
        Foldings before and after each round, where there were rounds.
    backend : str
        Factorisation that was used.
    notes : tuple of str
        What was done beyond the ordinary.
    certificate : Certificate, optional
        Of `x`, which is in its final gauge then and may not be moved any more.
    gauge : str
        Which gauge the result is in: "centred", or "poles".
    stretch : float
        How far limbs beyond the reach of float64 had to be drawn out; 1 if none had to.
    """

    x: FloatArray
    energy: float
    status: Status
    rounds: tuple[Round, ...] = ()
    backend: str = ""
    notes: tuple[str, ...] = ()
    certificate: Certificate | None = None
    gauge: str = "centred"
    stretch: float = 1.0
