"""The gate of public functions: what is given to them is of the kinds that they take, and a mesh stands for `v, f`."""

from __future__ import annotations

import difflib
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache, wraps
from inspect import signature
from numbers import Integral, Real
from typing import Any, Concatenate, ParamSpec, Protocol, TypeVar, cast, overload

import numpy as np
from numpy.typing import ArrayLike

from . import wings
from .errors import OfListener, shown

P = ParamSpec("P")
R = TypeVar("R")
R_co = TypeVar("R_co", covariant=True)
T = TypeVar("T")


class _Triangles(Protocol):
    @property
    def vertices(self) -> Any: ...
    @property
    def faces(self) -> Any: ...


class _Pair(Protocol):
    @property
    def v(self) -> Any: ...
    @property
    def f(self) -> Any: ...


class _Cells(Protocol):
    @property
    def points(self) -> Any: ...


class _Nilearn(Protocol):
    @property
    def coordinates(self) -> Any: ...
    @property
    def faces(self) -> Any: ...


#: What stands for `v, f`: a mesh of this package or of another one, the name of a file, or a pair.
MeshLike = (
    _Triangles | _Pair | _Cells | _Nilearn | str | os.PathLike[str] | tuple[ArrayLike, ArrayLike]
)


class TakesMesh(Protocol[P, R_co]):
    """A function of `v, f` and more, which takes a mesh object in their place."""

    @overload
    def __call__(self, v: ArrayLike, f: ArrayLike, *args: P.args, **kwargs: P.kwargs) -> R_co: ...
    @overload
    def __call__(self, v: MeshLike, *args: P.args, **kwargs: P.kwargs) -> R_co: ...
    def __call__(self, *args: Any, **kwargs: Any) -> R_co: ...


def takes_mesh(function: Callable[Concatenate[ArrayLike, ArrayLike, P], R]) -> TakesMesh[P, R]:
    """The `gate` of a public function of `v, f`, which lets it take a mesh object in their place, caps included.

    >>> @takes_mesh
    ... def count(v, f):
    ...     return len(v), len(f)
    >>> from igl_spheremap import samples
    >>> count(samples.sphere(42)) == count(*samples.sphere(42)) == (42, 80)
    True
    """
    parameters = signature(function).parameters
    names = list(parameters)
    places = sum(each.kind is each.POSITIONAL_OR_KEYWORD for each in parameters.values())

    def arrays(
        args: tuple[Any, ...], kwargs: dict[str, Any]
    ) -> tuple[tuple[Any, ...], dict[str, Any]]:
        if not (2 <= len(args) <= places and isinstance(args[0], np.ndarray)):
            args, kwargs = wings.arrays_of_mesh(names, places, args, kwargs)
        for name in kwargs:
            if name not in names:
                called = getattr(function, "__name__", "the function")
                close = difflib.get_close_matches(name, names[2:], n=1, cutoff=0.7)
                hint = f"did you mean {close[0]}?" if close else f"it takes {', '.join(names)}"
                raise TypeError(f"{called} takes no {name}; {hint}")
        return args, kwargs

    return cast("TakesMesh[P, R]", gate(function, arrays))


def gate(
    function: Callable[P, R], prepare: Callable[[Any, Any], tuple[Any, Any]] | None = None
) -> Callable[P, R]:
    """Check the kinds of a public function's arguments by its signature, and keep its caller's ``np.errstate`` out.

    The function ignores overflow, division by zero and the like, and checks its results wherever these matter. First of
    all `prepare` makes its arguments, positional ones and others, of those that are given.
    """
    hints = {name: str(one.annotation) for name, one in signature(function).parameters.items()}

    @wraps(function)
    def guarded(*args: P.args, **options: P.kwargs) -> R:
        if prepare is not None:
            args, options = prepare(args, options)
        check_kinds(hints, dict(zip(hints, args, strict=False)) | options)
        with _silent():
            try:
                return function(*args, **options)
            except OfListener as raised:
                raise raised.error from raised.error.__cause__

    return guarded


@contextmanager
def _silent() -> Iterator[None]:
    with np.errstate(all="ignore"):
        yield


def check_kinds(hints: Mapping[str, str], values: Mapping[str, object]) -> None:
    """Raise a TypeError that names the first value of another kind than its annotation says.

    Arrays, meshes and whatever else is not in `_KINDS` is checked where it is used.

    >>> check_kinds({"force": "bool"}, {"force": "no"})
    Traceback (most recent call last):
        ...
    TypeError: force is 'no'; give True or False
    """
    for name, value in values.items():
        if name in hints:
            check_kind(value, name, hints[name])


def check_kind(value: T, name: str, hint: str) -> T:
    """The value of an argument, if it is of the kind that an annotation says; else a TypeError that names it."""
    kinds = _kinds(hint)
    if kinds and not any(fits(value) for fits, _ in kinds):
        said = " or ".join(dict.fromkeys(said for _, said in kinds if said))
        raise TypeError(f"{name} is {shown(value)}; give {said}")
    return value


@cache
def _kinds(hint: str) -> tuple[tuple[Callable[[object], bool], str], ...]:
    """The tests of values that an annotation allows, each with its words; none if `_KINDS` lacks a word of it."""
    words = [word.strip().partition("[")[0] for word in hint.split(" | ")]
    return tuple(_KINDS[word] for word in words) if set(words) <= _KINDS.keys() else ()


def _of(*kinds: type) -> Callable[[object], bool]:
    return lambda value: (
        isinstance(value, kinds) and not (isinstance(value, bool) and bool not in kinds)
    )


def _record(name: str) -> Callable[[object], bool]:
    """Whether a value is of a class of that name, which need not be imported."""
    return lambda value: any(kind.__name__ == name for kind in type(value).__mro__)


def _several(value: object) -> bool:
    return isinstance(value, Iterable) and not isinstance(value, str | bytes | os.PathLike)


_TEXT = _of(str), "a text"
_PATH = _of(str, os.PathLike), "the name of a file"
_FUNCTION = callable, "a function"
#: A test of values for each word of annotations, and its words in messages; those of records say how to make one.
_KINDS: dict[str, tuple[Callable[[object], bool], str]] = {
    "None": (lambda value: value is None, ""),
    # numpy's, too
    "bool": (lambda value: type(value).__name__ in ("bool", "bool_"), "True or False"),
    "int": (_of(Integral), "a whole number"),
    "float": (_of(Real), "a number"),
    "Mapping": (_of(Mapping), "a dict"),
    "Metadata": (_of(Mapping), "a dict"),
    "PathLike": _PATH,
    "os.PathLike": _PATH,
    "Listener": _FUNCTION,
    "Callable": _FUNCTION,
    **dict.fromkeys(
        (
            "str",
            "Literal",
            "Gauge",
            "PaperGauge",
            "Polish",
            "Kind",
            "Basis",
            "Resampling",
            "Projection",
        ),
        _TEXT,
    ),
    **dict.fromkeys(("Sequence", "Iterable", "tuple", "list"), (_several, "a list")),
    **{
        name: (_record(name), said)
        for name, said in {
            "SphereMap": "a SphereMap, as balanced_spherical_map(v, f) makes one, "
            "and sphere_map(v, f, x) of positions x",
            "PlaneMap": "a map as flatten(v, f) makes one",
            "SurfaceMap": "a SurfaceMap, as shapes.match makes one",
            "Group": "a Group, as shapes.template makes one",
            "SphereLocator": "a SphereLocator",
            "SphericalHarmonics": "SphericalHarmonics, as shapes.spherical_harmonics makes them",
            "Method": "a record of options, such as Auto()",
            "Effort": "an Effort",
            "Engine": "an Engine",
        }.items()
    },
}
