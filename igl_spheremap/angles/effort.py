"""The effort of a repair, as a record of options; no solver is imported here."""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import check_number, check_whole


@dataclass(frozen=True)
class Effort:
    """The cost allowed to steps that lower the angle differences of a map, after a repair or as a polish.

    Less effort gives a certified map all the same: a repair ends without foldings before these steps begin.

    Parameters
    ----------
    systems : int, default 20
        At most this many linear systems, with two unknowns a vertex, are solved in a round of Newton steps, one for
        each step that is tried. Only bodies with limbs of 60 nepers and more take 20.
    holes : int, default 5
        If a map is poor, at most this many faces are cut out in turn, to lay the mesh out in the plane around each.
        Large meshes take fewer (`holes_of`), and fewer still take steps (`layouts`).
    least_gain : float, default 0.015
        Steps end when all further ones together would lower the mean angle difference by less than this share, on
        small meshes; on large ones, where a step costs more, by up to eight times as much (`price`).
    polish_gain : float, default 0.004
        The share at which a polish ends, on meshes of all sizes.

    Raises
    ------
    TypeError
        If a value is not a number.
    ValueError
        If a number is negative, or a gain above 1.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("octopus", n_vertices=3000)
    >>> quick = ism.Auto(effort=ism.Effort(systems=2))
    >>> ism.spherical_conformal_map(v, f, method=quick).certificate.folding_free
    True
    """

    _in_words = "an Effort"

    systems: int = 20
    holes: int = 5
    least_gain: float = 0.015
    polish_gain: float = 0.004

    def __post_init__(self) -> None:
        """Refuse fields that are not counts or shares."""
        for name in ("systems", "holes"):
            check_whole(getattr(self, name), f"effort: {name}")
        for name in ("least_gain", "polish_gain"):
            check_number(getattr(self, name), f"effort: {name}", most=1)

    def layouts(self, n: int) -> int:
        """Number of layouts of a mesh of n vertices that may start: 3,000 vertices together, the same cost for every
        mesh.

        >>> [Effort().layouts(n) for n in (100, 500, 1000, 10_000)]
        [5, 5, 3, 1]
        """
        return min(self.holes, max(1, round(3000 / n)))

    def holes_of(self, n: int) -> int:
        """Number of faces around which a mesh of n vertices may be laid out, to choose the layouts that start.

        All layouts have 30,000 vertices together at most.

        >>> [Effort().holes_of(n) for n in (100, 6000, 10_000, 40_000)]
        [5, 5, 3, 0]
        """
        return min(self.holes, 30_000 // n)

    def price(self, n: int) -> float:
        """Share of the mean angle difference that further steps have to gain on a mesh of n vertices.

        It grows to eight times `least_gain`, as factors take more than proportional time, and is halfway at 3,000.

        >>> [round(Effort().price(n), 3) for n in (0, 1000, 3000, 100_000)]
        [0.015, 0.041, 0.068, 0.117]
        """
        return self.least_gain * (1 + 7 * n / (n + 3000))
