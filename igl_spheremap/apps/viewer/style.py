"""Colours, legends and the light: chosen once, so that all pictures look like one family.

Folded faces are vermilion on everything. Scalars take viridis. The conformal factor u takes purple (shrunk)
over white (0) to green (magnified): red-green blindness leaves both apart from each other and from vermilion.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Colour = tuple[float, float, float]

BACKGROUND: Colour = (1.0, 1.0, 1.0)
INK: Colour = (0.13, 0.15, 0.18)
SURFACE: Colour = (0.82, 0.85, 0.88)
EDGES: Colour = (0.45, 0.50, 0.55)
FOLDED: Colour = (0.84, 0.24, 0.0)
CHECKS: tuple[Colour, Colour] = ((0.13, 0.32, 0.52), (0.95, 0.93, 0.86))
#: Okabe and Ito's palette without the colours taken above, for curves that are told apart by colour.
LINES: tuple[Colour, ...] = (
    (0.0, 0.45, 0.70),
    (0.0, 0.62, 0.45),
    (0.80, 0.47, 0.65),
    (0.34, 0.71, 0.91),
    (0.35, 0.35, 0.35),
    (0.90, 0.62, 0.0),
)

_VIRIDIS = (
    (68, 1, 84),
    (71, 44, 122),
    (59, 81, 139),
    (44, 113, 142),
    (33, 144, 141),
    (39, 173, 129),
    (92, 200, 99),
    (170, 220, 50),
    (253, 231, 37),
)
_PURPLE_GREEN = (
    (118, 42, 131),
    (153, 112, 171),
    (194, 165, 207),
    (231, 212, 232),
    (247, 247, 247),
    (217, 240, 211),
    (166, 219, 160),
    (90, 174, 97),
    (27, 120, 55),
)


@dataclass(frozen=True, eq=False)
class Ramp:
    """A colour map with the values at its ends.

    Attributes
    ----------
    label : str
        What it measures, with its unit.
    low, high : float
        Values at the ends; what lies beyond takes the colour of the end.
    stops : (k, 3) float64 array
        Colours, evenly spaced.
    """

    label: str
    low: float
    high: float
    stops: FloatArray

    def colours(self, values: FloatArray) -> FloatArray:
        """Colours of values.

        Parameters
        ----------
        values : (n,) float64 array
            Not finite ones count as the nearer end, NaN as the lower.

        Returns
        -------
        (n, 3) float64 array
            Between 0 and 1.
        """
        span = self.high - self.low
        t = np.clip((np.nan_to_num(values, nan=self.low) - self.low) / (span if span > 0 else 1), 0, 1)
        places = np.linspace(0, 1, len(self.stops))
        return np.column_stack([np.interp(t, places, self.stops[:, k]) for k in range(3)])


def sequential(label: str, low: float, high: float) -> Ramp:
    """Viridis between two values.

    Parameters
    ----------
    label : str
        What it measures.
    low, high : float
        Values at the ends.

    Returns
    -------
    Ramp
        Dark to light.
    """
    return Ramp(label, low, high, np.array(_VIRIDIS) / 255)


def diverging(label: str, reach: float) -> Ramp:
    """Purple over white to green, white at 0.

    Parameters
    ----------
    label : str
        What it measures.
    reach : float
        Value at the upper end; the lower is its negative.

    Returns
    -------
    Ramp
        Centred at 0.

    Examples
    --------
    >>> import numpy as np
    >>> diverging("u", 2.0).colours(np.array([0.0])).round(2)
    array([[0.97, 0.97, 0.97]])
    """
    return Ramp(label, -reach, reach, np.array(_PURPLE_GREEN) / 255)


def round_up(value: float) -> float:
    """The least of 1, 2, 5 times a power of ten that is not below `value`.

    Parameters
    ----------
    value : float
        Any; what is not positive and finite counts as 1.

    Returns
    -------
    float
        For the end of a legend.

    Examples
    --------
    >>> round_up(3.2), round_up(0.2), round_up(7.0)
    (5.0, 0.2, 10.0)
    """
    if not (value > 0 and math.isfinite(value)):
        return 1.0
    power = 10.0 ** math.floor(math.log10(value))
    return float(next(k * power for k in (1, 2, 5, 10) if k * power >= value * (1 - 1e-9)))


def matcaps() -> list[FloatArray]:
    """Images of a lit ball, as polyscope's blendable materials are made of: in red, green, blue, and black.

    The light comes from the viewer's upper left. A colour c is seen as c times the shade: polyscope's own
    materials would wash it out, and then no legend fits.

    Returns
    -------
    list of (256, 256, 3) float64 array
        Between 0 and 1, before polyscope's gamma.
    """
    y, x = np.mgrid[1 - 1 / 256 : -1 : -1 / 128, -1 + 1 / 256 : 1 : 1 / 128]
    size = np.maximum(np.hypot(x, y), 1)
    x, y = x / size, y / size
    z = np.sqrt(np.maximum(0, 1 - x * x - y * y))
    light = np.array([-0.35, 0.45, 0.82])
    light /= np.linalg.norm(light)
    shade = linear(np.minimum(1, 0.62 + 0.42 * np.maximum(0, x * light[0] + y * light[1] + z * light[2])))
    return [shade[..., None] * np.eye(4, 3)[k] for k in range(4)]


def linear(colours: FloatArray) -> FloatArray:
    """Colours as polyscope wants them to show as they are: it applies a gamma of 2.2 at the end.

    Parameters
    ----------
    colours : float64 array
        As they shall look, between 0 and 1.

    Returns
    -------
    float64 array
        The same shape.
    """
    return colours**2.2
