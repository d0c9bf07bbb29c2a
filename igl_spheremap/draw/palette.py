"""The colours of every picture: of surfaces, folded faces and curves, and scales for numbers.

Folded faces are vermilion everywhere. Scalars take viridis. The conformal factor u takes purple (shrunk) over
white (0) to green (magnified): red-green blindness leaves both apart from each other and from vermilion.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..mesh.arrays import FloatArray

Colour = tuple[float, float, float]


def _stops(colours: str) -> FloatArray:
    """Colours (k, 3) between 0 and 1 from their hexadecimal names."""
    return np.frombuffer(bytes.fromhex(colours), np.uint8).reshape(-1, 3) / 255


def _colour(name: str) -> Colour:
    r, g, b = _stops(name)[0].tolist()
    return r, g, b


INK = _colour("21262e")
SURFACE = _colour("d1d9e0")
FOLDED = _colour("d63d00")
GUIDE = _colour("99a3ab")  # lines that only guide the eye
BACKGROUND = _colour("ffffff")
EDGES = _colour("73808c")
FOLDED_EDGES = _colour("a81f00")
#: A vertex that is marked: magenta, which no scale has and which isn't the red of foldings.
PICKED = _colour("d9008c")
#: Squares of a checkerboard.
CHECKS: tuple[Colour, Colour] = ((0.13, 0.32, 0.52), (0.95, 0.93, 0.86))
#: Okabe and Ito's palette without the colours taken above, for curves that differ by colour alone.
LINES: tuple[Colour, ...] = (
    (0.0, 0.45, 0.70),
    (0.0, 0.62, 0.45),
    (0.80, 0.47, 0.65),
    (0.34, 0.71, 0.91),
    (0.35, 0.35, 0.35),
    (0.90, 0.62, 0.0),
)

_VIRIDIS = "440154 472c7a 3b518b 2c718e 21908d 27ad81 5cc863 aadc32 fde725"
_LIGHT_BLUE = "ffffd9 edf8b1 c7e9b4 7fcdbb 41b6c4 1d91c0 225ea8 253494 081d58"
_PURPLE_GREEN = "762a83 9970ab c2a5cf e7d4e8 f7f7f7 d9f0d3 a6dba0 5aae61 1b7837"


@dataclass(frozen=True, eq=False)
class Ramp:
    """A colour scale from `low` to `high`: evenly spaced colours (k, 3) between 0 and 1, and a label with the unit.

    `names` are names of the ends in place of their values.
    """

    label: str
    low: float
    high: float
    stops: FloatArray
    names: tuple[str, str] | None = None

    @property
    def ends(self) -> tuple[str, str]:
        """The texts at the ends of the scale."""
        if self.names:
            return self.names
        return f"{self.low:.3g}", f"{self.high:.3g}"

    def colours(self, values: FloatArray) -> FloatArray:
        """Colours (n, 3) of values (n,), clamped to the ends; NaN counts as the lower end."""
        span = self.high - self.low
        if not span > 0:
            span = 1
        t = (np.clip(np.nan_to_num(values, nan=self.low), self.low, self.high) - self.low) / span
        places = np.linspace(0, 1, len(self.stops))
        return np.column_stack([np.interp(t, places, self.stops[:, k]) for k in range(3)])


def sequential(label: str, low: float, high: float) -> Ramp:
    """Viridis, dark to light."""
    return Ramp(label, low, high, _stops(_VIRIDIS))


def sizes(label: str, high: float) -> Ramp:
    """Light yellow over green to dark blue, from 0: for sizes of errors."""
    return Ramp(label, 0.0, high, _stops(_LIGHT_BLUE))


def pale(label: str, low: float, high: float) -> Ramp:
    """Viridis mixed with white, for surfaces below other things."""
    return Ramp(label, low, high, 0.35 + 0.65 * _stops(_VIRIDIS))


def diverging(label: str, reach: float) -> Ramp:
    """Purple over white to green from `-reach` to `reach`.

    >>> diverging("u", 2.0).colours(np.array([0.0])).round(2)
    array([[0.97, 0.97, 0.97]])
    """
    return Ramp(label, -reach, reach, _stops(_PURPLE_GREEN))


def areas(factor: float) -> Ramp:
    """The scale of logarithms of area ratios up to a factor, which names its ends; shrunk areas are purple.

    >>> areas(10000).ends
    ('1/10000', '10000')
    """
    return replace(
        diverging("image area / source area", math.log(factor)),
        names=(f"1/{factor:g}", f"{factor:g}"),
    )


def fitting(ramps: Sequence[Ramp], values: FloatArray) -> Ramp:
    """The first of some scales, from fine to coarse, within which most finite values lie, or the last.

    Most are 95 percent of errors, and three fifths of ratios: limbs shrink by powers of ten, and a scale that holds
    their tips would show all else pale.

    >>> [fitting(AREAS, np.array(values)).ends[1] for values in ([0.0, -0.3, 0.4, 0.1, 9.0], [-9.0, 8.0], [-2000.0])]
    ['2', '10000', '10000']
    """
    finite = np.abs(values[np.isfinite(values)])
    share, reach = 95, 0.0
    if ramps[0].low:
        share = 60
    if len(finite):
        reach = float(np.percentile(finite, share))
    return next((ramp for ramp in ramps if reach <= ramp.high), ramps[-1])


#: Scales of a measure, from fine to coarse: of angle differences, and of logarithms of area ratios and of conformal
#: factors. Good maps are pale in all. Few steps, so that pictures can be compared.
ANGLES = tuple(sizes("angle difference in degrees", high) for high in (5, 20, 90))
AREAS = tuple(areas(factor) for factor in (2, 10, 100, 10_000))
FACTORS = tuple(diverging("log factor u (purple: shrunk)", reach) for reach in (0.5, 1, 2, 5))


def round_up(value: float) -> float:
    """The least of 1, 2, 5 times a power of ten that is not below `value`, for the end of a scale.

    >>> round_up(3.2), round_up(0.2), round_up(7.0), round_up(float("nan"))
    (5.0, 0.2, 10.0, 1.0)
    """
    if not (value > 0 and math.isfinite(value)):
        return 1.0
    power = 10.0 ** math.floor(math.log10(value))
    return float(next(k * power for k in (1, 2, 5, 10) if k * power >= value * (1 - 1e-9)))


def colours(values: FloatArray) -> dict[str, NDArray[np.uint8]]:
    """Vertex colours of a scalar map, on viridis from its 1st to its 99th percentile.

    Parameters
    ----------
    values : (n,) float64 array
        The map; non-finite values are shown as an end of the scale.

    Returns
    -------
    dict of (n,) uint8 arrays
        ``red``, ``green`` and ``blue``, as PLY files name them.

    Examples
    --------
    >>> colours(np.array([0.0, 1.0]))["red"].tolist()
    [68, 253]
    """
    finite = values[np.isfinite(values)]
    low, high = 0.0, 1.0
    if len(finite):
        low, high = np.percentile(finite, [1, 99]).tolist()
    rgb = np.rint(255 * sequential("", low, high).colours(values)).astype(np.uint8)
    return dict(zip(("red", "green", "blue"), rgb.T, strict=True))
