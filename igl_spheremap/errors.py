"""Errors that the package raises, each with a sentence a user can act on.

A message names calls and arguments of this library; the command line prints its own flags in their place.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from importlib import import_module
from numbers import Integral, Real
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")

#: Control characters, ends of lines, and marks that turn the direction of writing.
_CONTROL = re.compile("[\x00-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069]")
_PACKAGES = {"PIL": "pillow"}  # where the name to install is not the name to import
#: Options of repairs, in the order in which these are made.
_REPAIRS = ("weld", "keep_largest", "holes", "handles", "cut")


@dataclass(frozen=True)
class Remedy:
    """A repair and its options, which correct a mesh. A front end says the call, or the flags that stand for it.

    >>> Remedy().with_options(holes="fill", handles=None).call
    "repair_mesh(v, f, holes='fill')"
    """

    function: str = "repair_mesh"
    options: Mapping[str, Any] = field(default_factory=dict)

    def with_options(self, **options: Any) -> Remedy:
        """The repair with further options, where they are set."""
        known = {**self.options, **{name: value for name, value in options.items() if value}}
        return replace(self, options={name: known[name] for name in _REPAIRS if name in known})

    @property
    def call(self) -> str:
        """The call with these options."""
        words = ("v", "f", *(f"{name}={value!r}" for name, value in self.options.items()))
        return f"{self.function}({', '.join(words)})"


class MeshError(ValueError):
    """A mesh, or an array that goes with it, is not what a call takes; most take a closed genus-0 triangle mesh.

    The message is one line: what is wrong, where (the first indices), and what repairs it.

    Attributes
    ----------
    remedy : dict or None
        Options with which `repair_mesh` makes such a mesh of it: ``repair_mesh(v, f, **error.remedy)``; of errors of
        disks those of `repair_disk`. None, the default, where it can't, or the error is of something else.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.sphere(42)
    >>> try:
    ...     ism.check_mesh(v, f[1:])
    ... except ism.MeshError as error:
    ...     error.remedy
    {'holes': 'fill'}
    """

    def __init__(self, message: object = "", remedy: Mapping[str, Any] | None = None) -> None:
        super().__init__(message)
        self.remedy = remedy


class FileError(OSError):
    """A file can't be read or written; the message is one line that says why.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> ism.read_mesh("nowhere.ply")
    Traceback (most recent call last):
        ...
    igl_spheremap.errors.FileError: ...nowhere.ply...
    """


class MapError(RuntimeError):
    """A map was computed but can't be accepted.

    Attributes
    ----------
    result : SphereMap or None
        The map as far as it came, with its certificate, so that nothing is lost; None, the default, if there is none.
    """

    def __init__(self, message: str, result: Any = None) -> None:
        super().__init__(message)
        self.result = result


class NotConverged(MapError):
    """The iteration ended before its stopping rule was met."""


class FoldingsRemain(MapError):
    """The map is not certified folding-free.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> x, f = ism.samples.sphere(42)
    >>> folded = x.copy()
    >>> folded[0] = -x[0]
    >>> try:
    ...     ism.sphere_map(x, f, folded)
    ... except ism.FoldingsRemain as error:
    ...     print(len(error.result.certificate.flipped))
    5
    """


class FactorisationFailed(RuntimeError):
    """A matrix is not numerically positive definite, or the backend gave up on it.

    Another Laplacian of the same surface, with mollified or intrinsic Delaunay weights, may work.
    """


class DisplayError(RuntimeError):
    """Nothing can be drawn here; the message is one line that says what is missing."""


class WorkersUnavailable(RuntimeError):
    """No worker, or none of the right version, runs the jobs of `igl_spheremap.map_many`."""


def check_number(value: object, name: str, least: float = 0.0, most: float = math.inf) -> float:
    """The value of an option; a TypeError unless it is a number, a ValueError unless it is in range.

    >>> check_number(float("nan"), "tolerance")
    Traceback (most recent call last):
        ...
    ValueError: tolerance is nan; give a number of at least 0
    """
    if not isinstance(value, Real) or isinstance(value, bool):
        raise TypeError(f"{name} is {value!r}; give a number")
    number = float(value)
    if not least <= number <= most:
        limits = f"of at least {least:g}" if most == math.inf else f"from {least:g} to {most:g}"
        raise ValueError(f"{name} is {number:g}; give a number {limits}")
    return number


def check_whole(value: object, name: str, least: int = 0) -> int:
    """The value of an option; a TypeError unless it is a whole number, a ValueError if it is too small."""
    if not isinstance(value, Integral) or isinstance(value, bool):
        raise TypeError(f"{name} is {value!r}; give a whole number")
    if value < least:
        raise ValueError(f"{name} is {value}; give {least} or more")
    return int(value)


def check_listener(listener: object) -> None:
    """Raise a TypeError unless a listener can be called, or is None."""
    if listener is not None and not callable(listener):
        raise TypeError(f"listener is {listener!r}; give a function that takes one argument")


def printable(text: str) -> str:
    """A text with its control characters as escapes, so that a name from a file changes no line and no terminal.

    >>> printable("sulc\\n\\x1b[31m")
    'sulc\\\\n\\\\x1b[31m'
    """
    return _CONTROL.sub(lambda found: found[0].encode("unicode_escape").decode("ascii"), text)


def one_line(error: BaseException) -> str:
    """The message of an error in one line.

    >>> one_line(FileNotFoundError(2, "No such file", "a.ply")), one_line(MemoryError())
    ('a.ply: No such file', 'out of memory; try a smaller mesh or more memory')
    """
    words: object = error
    if isinstance(error, MemoryError):
        words = "out of memory; try a smaller mesh or more memory"
    elif isinstance(error, OSError) and error.strerror:
        words = f"{error.filename}: {error.strerror}" if error.filename else error.strerror
    return printable(" ".join(str(words).split())) or type(error).__name__


def without_name(line: str, name: str) -> str:
    """A message without the name of its file, for where that stands already.

    >>> without_name("a.ply: no faces", "a.ply"), without_name("can't read a.ply: No such file", "a.ply")
    ('no faces', "can't read it: No such file")
    """
    return f" {line.removeprefix(f'{name}: ')}".replace(f" {name}", " it")[1:]


def import_optional(module: str, user: str, extra: str = "") -> Any:
    """Import a module that `user` needs; if it is not installed, raise a FileError that says how to install it."""
    try:
        return import_module(module)
    except ImportError:
        name = module.partition(".")[0]
        package = _PACKAGES.get(name, name)
        hint = f" (the extra {extra!r} of igl_spheremap includes it)" if extra else ""
        raise FileError(f"{user} needs {package}, which is not installed: pip install {package}{hint}") from None


def own_errstate(function: Callable[P, R]) -> Callable[P, R]:
    """Shield a public function from its caller's ``np.errstate``: it ignores overflow, division by zero and the like.

    Functions check their results wherever these matter.
    """
    return _silent()(function)


@contextmanager
def _silent() -> Iterator[None]:
    import numpy as np  # only here: the command line prints its help without it

    with np.errstate(all="ignore"):
        yield
