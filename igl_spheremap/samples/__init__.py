"""Shapes that the package makes itself: closed genus-0 meshes at any resolution, without data files.

Each is a function of ``n_vertices``, the approximate number of vertices, and of parameters of its shape. It returns
``(v, f)``: (n, 3) float64 positions and (m, 3) int64 faces, oriented outwards. A value out of range raises a
ValueError, one that is no number a TypeError. The same call gives the same mesh, bit for bit.

Examples
--------
>>> import igl_spheremap as ism
>>> v, f = ism.samples.make("octopus", n_vertices=1300)
>>> v, f = ism.samples.octopus(n_vertices=1300, arm_length=1)  # the same with its own parameters
"""

from __future__ import annotations

import inspect
import math
from typing import TYPE_CHECKING, Any

from ..lazy import attach

# names for type checkers; at run time a module is imported when its shape is made
if TYPE_CHECKING:
    from ..mesh.arrays import FloatArray, IntArray
    from .animals import bird as bird
    from .animals import bunny as bunny
    from .animals import dino as dino
    from .animals import octopus as octopus
    from .cortex import brain as brain
    from .icosphere import sphere as sphere
    from .revolution import SurfaceOfRevolution
    from .revolution import dumbbell as dumbbell
    from .revolution import pear as pear
    from .revolution import spheroid as spheroid
    from .rings import spring as spring

    Arrays = tuple[FloatArray, IntArray]

_SHAPES = {
    "bird": "animals",
    "brain": "cortex",
    "bunny": "animals",
    "dino": "animals",
    "dumbbell": "revolution",
    "octopus": "animals",
    "pear": "revolution",
    "sphere": "icosphere",
    "spheroid": "revolution",
    "spring": "rings",
}

__all__ = ["SurfaceOfRevolution", "from_spec", "make", "names", *_SHAPES]
__getattr__ = attach(__name__, _SHAPES | {"SurfaceOfRevolution": "revolution"})[0]


def names() -> tuple[str, ...]:
    """Names of the samples, in alphabetical order.

    Examples
    --------
    >>> from igl_spheremap import samples
    >>> "dino" in samples.names()
    True
    """
    return tuple(sorted(_SHAPES))


def make(name: str, **parameters: Any) -> Arrays:
    """Make a sample by its name.

    Parameters
    ----------
    name : str
        One of `names`.
    **parameters
        Passed to the function of that name; all have ``n_vertices``, the approximate number of vertices.

    Returns
    -------
    v : (n, 3) float64 ndarray
    f : (m, 3) int64 ndarray

    Raises
    ------
    ValueError
        If there is no such sample, or it has no such parameter, or a value makes no sense.

    Examples
    --------
    >>> from igl_spheremap import samples
    >>> v, f = samples.make("dino", n_vertices=1500)
    >>> len(v) - len(f) // 2
    2
    """
    if name not in _SHAPES:
        first, comma, _ = name.partition(",")
        if comma and first in _SHAPES:
            raise ValueError(f"parameters follow a colon: {first}:{name[len(first) + 1 :]}")
        raise ValueError(f"no sample is called {name!r}; there are: {', '.join(names())}")
    shape: Any = __getattr__(name)
    known = inspect.signature(shape).parameters
    for key in parameters:
        if key not in known:
            raise ValueError(f"sample {name} has no parameter {key!r}; it has: {', '.join(known)}")
    v, f = shape(**parameters)
    return v, f


def from_spec(spec: str) -> Arrays:
    """Make a sample from one string, as the command line takes it after ``sample:``.

    Parameters
    ----------
    spec : str
        ``NAME`` or ``NAME:key=value,key=value``.

    Returns
    -------
    v, f
        As of `make`.

    Raises
    ------
    ValueError
        As for `make`; and if the string has another form, or a value is not a number.

    Examples
    --------
    >>> from igl_spheremap import samples
    >>> v, f = samples.from_spec("spring:turns=2,n_vertices=1000")
    >>> samples.from_spec("unicorn")
    Traceback (most recent call last):
        ...
    ValueError: no sample is called 'unicorn'; there are: bird, brain, ...
    """
    name, _, rest = spec.partition(":")
    parameters: dict[str, float] = {}
    for item in filter(None, rest.split(",")):
        key, equals, text = (part.strip() for part in item.partition("="))
        if not equals:
            raise ValueError(f"sample parameters are given as key=value, not {item!r}")
        parameters[key] = _number(key, text)
    return make(name.strip(), **parameters)


def _number(key: str, text: str) -> float:
    """The number that the text means, an int if it is whole."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(f"sample parameter {key} takes a number, not {text!r}")
    if value.is_integer():
        return int(value)
    return value
