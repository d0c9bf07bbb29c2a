"""The gate of public functions: arguments are of the kinds that they take, and a mesh stands for `v, f`."""

from __future__ import annotations

import difflib
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache, wraps
from inspect import signature
from numbers import Integral, Real
from sys import modules
from types import NoneType, SimpleNamespace, UnionType
from typing import (
    Any,
    Concatenate,
    Literal,
    ParamSpec,
    Protocol,
    TypeVar,
    Union,
    cast,
    get_args,
    get_origin,
    get_type_hints,
    overload,
)

import numpy as np
from numpy.typing import ArrayLike

from . import wings
from .errors import OfListener, shown

P = ParamSpec("P")
R = TypeVar("R")
R_co = TypeVar("R_co", covariant=True)


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


#: The name of a file.
PathLike = str | os.PathLike[str]
#: Stands for `v, f`: a mesh of this package or of another one, the name of a file, or a pair.
MeshLike = _Triangles | _Pair | _Cells | _Nilearn | PathLike | tuple[ArrayLike, ArrayLike]


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
                hint = f"it takes {', '.join(names)}"
                if close:
                    hint = f"did you mean {close[0]}?"
                raise TypeError(f"{called} takes no {name}; {hint}")
        return args, kwargs

    return cast("TakesMesh[P, R]", gate(function, arrays))


def gate(
    function: Callable[P, R], prepare: Callable[[Any, Any], tuple[Any, Any]] | None = None
) -> Callable[P, R]:
    """Check the kinds of a public function's arguments by its signature, and keep its caller's ``np.errstate`` out.

    The function ignores overflow, division by zero and the like, and checks its results wherever these matter. First
    `prepare` makes its arguments, positional ones and others, of the given ones.
    """
    names = list(signature(function).parameters)

    @wraps(function)
    def guarded(*args: P.args, **options: P.kwargs) -> R:
        if prepare is not None:
            args, options = prepare(args, options)
        check_kinds(function, dict(zip(names, args, strict=False)) | options)
        with np.errstate(all="ignore"):
            try:
                return function(*args, **options)
            except OfListener as raised:
                raise raised.error from raised.error.__cause__

    return guarded


def check_kinds(annotated: Any, values: Mapping[str, object]) -> None:
    """Raise a TypeError that names the first argument of a function, or field of a record, that has another kind.

    >>> def write(force: bool = False): ...
    >>> check_kinds(write, {"force": "no"})
    Traceback (most recent call last):
        ...
    TypeError: force is 'no'; give True or False
    """
    kinds = kinds_of(annotated)
    for name, value in values.items():
        taken = kinds.get(name, ())
        if taken and not any(fits(value) for fits, _ in taken):
            said = " or ".join(dict.fromkeys(said for _, said in taken if said))
            raise TypeError(f"{name} is {shown(value)}; give {said}")


@cache
def kinds_of(annotated: Any) -> dict[str, tuple[Kind, ...]]:
    """The kinds that each argument of a function, or field of a record, takes.

    Arrays, meshes, and others that are checked at their use have none.
    """
    hints = {name: hint for name, hint in annotated.__annotations__.items() if name != "return"}
    names = vars(modules[annotated.__module__])
    found = get_type_hints(SimpleNamespace(__annotations__=hints), names)
    return {name: _kinds(hint) for name, hint in found.items()}


def _kinds(hint: Any) -> tuple[Kind, ...]:
    """The kinds of an annotation; none if one of its alternatives is of no kind."""
    parts = (hint,)
    if get_origin(hint) in (Union, UnionType):
        parts = get_args(hint)
    kinds = []
    for part in parts:
        if part is str and os.PathLike in [get_origin(other) for other in parts]:
            continue  # both are the name of a file
        kind = _kind(part)
        if kind is None:
            return ()
        kinds.append(kind)
    return tuple(kinds)


def _kind(part: Any) -> Kind | None:
    """The kind of a class: one of `_KINDS`, or a record, whose class says `_in_words` how one is made."""
    for known in (part, get_origin(part)):
        if known in _KINDS:
            return _KINDS[known]
    if not isinstance(part, type) or "_in_words" not in vars(part):
        return None
    return lambda value: isinstance(value, part), vars(part)["_in_words"]


def _of(*kinds: type) -> Callable[[object], bool]:
    """Whether a value is of these classes; a bool is of none."""
    return lambda value: isinstance(value, kinds) and not isinstance(value, bool)


def _several(value: object) -> bool:
    return isinstance(value, Iterable) and not isinstance(value, str | bytes | os.PathLike)


#: A test of values, and its words in messages.
Kind = tuple[Callable[[object], bool], str]
_TEXT: Kind = (_of(str), "a text")
_DICT: Kind = (_of(Mapping), "a dict")
_LIST: Kind = (_several, "a list")
#: The kinds by the classes of annotations.
_KINDS: dict[Any, Kind] = {
    NoneType: (lambda value: value is None, ""),
    bool: (lambda value: isinstance(value, bool | np.bool_), "True or False"),
    int: (_of(Integral), "a whole number"),
    float: (_of(Real), "a number"),
    str: _TEXT,
    Literal: _TEXT,
    os.PathLike: (_of(str, os.PathLike), "the name of a file"),
    Callable: (callable, "a function"),
    Mapping: _DICT,
    dict: _DICT,
    Sequence: _LIST,
    Iterable: _LIST,
    tuple: _LIST,
    list: _LIST,
}
