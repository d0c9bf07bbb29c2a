"""What the repair of a map may cost, as a record of options; no solver is imported here."""

from __future__ import annotations

from dataclasses import dataclass
from numbers import Integral, Real


@dataclass(frozen=True)
class Effort:
    """What the steps may cost that lower the angle differences of a map, after a repair or as a polish.

    Less effort gives a map that is certified all the same: a repair ends without foldings before these steps begin.

    Parameters
    ----------
    systems : int, default 20
        Linear systems with two unknowns a vertex that are solved at the most in a run of Newton steps, one for each
        step that is tried. Only bodies with limbs of 60 nepers and more take 20. Maps that came good take fewer: one to
        four from 1,000 vertices on.
    holes : int, default 5
        Faces that are cut out in turn, where the map of a coarse mesh is poor, to lay it out by angles that close,
        until three in a row gain nothing. Above 1,000 vertices fewer layouts take steps.
    least_gain : float, default 0.025
        Steps end when all further ones together would lower the mean angle difference by less than this share; so do
        runs, of which meshes up to 1,000 vertices and poor maps take several.
    polish_gain : float, default 0.004
        The same for a polish.

    Raises
    ------
    TypeError
        If a number is none.
    ValueError
        If a number is negative, or a gain not below 1.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("octopus", n_vertices=3000)
    >>> quick = ism.Auto(effort=ism.Effort(systems=2))
    >>> ism.spherical_conformal_map(v, f, quick).certificate.folding_free
    True
    """

    systems: int = 20
    holes: int = 5
    least_gain: float = 0.025
    polish_gain: float = 0.004

    def __post_init__(self) -> None:
        """Refuse what is no count and no share."""
        for name, value in (("systems", self.systems), ("holes", self.holes)):
            if not isinstance(value, Integral) or isinstance(value, bool):
                raise TypeError(f"effort: {name} is {value!r}; give a whole number")
            if value < 0:
                raise ValueError(f"effort: {name} is {value}; give 0 or more")
        for name, gain in (("least_gain", self.least_gain), ("polish_gain", self.polish_gain)):
            if not isinstance(gain, Real) or isinstance(gain, bool):
                raise TypeError(f"effort: {name} is {gain!r}; give a number")
            if not 0 <= gain < 1:
                raise ValueError(f"effort: {name} is {gain:g}; give 0 or more, below 1")
