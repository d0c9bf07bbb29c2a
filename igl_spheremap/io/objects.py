"""Mesh objects, of this package and of others, in the place of `v, f`: the gate of every public function of both."""

from __future__ import annotations

import difflib
import inspect
import os
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any, Concatenate, ParamSpec, Protocol, TypeVar, cast, overload

import numpy as np
from numpy.typing import ArrayLike

from ..errors import MeshError, gate

P = ParamSpec("P")
R = TypeVar("R")
R_co = TypeVar("R_co", covariant=True)

#: Where meshes keep their vertices and faces: trimesh and libraries like it; what checks, readers and repairs return;
#: nilearn; LaPy.
_NAMES = (("vertices", "faces"), ("v", "f"), ("coordinates", "faces"), ("v", "t"))
#: Attributes of other objects that hold a mesh: of meshio and PyVista, nibabel, nilearn's PolyMesh, trimesh's scenes.
_HOLDERS = ("points", "agg_data", "parts", "to_mesh")
#: Triangles among the cells of meshio, by name, and of PyVista's grids, by VTK's number; and cells that are no surface.
_TRIANGLES, _NO_SURFACE = ("triangle", 5), ("vertex", "line", 1, 2, 3, 4)


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

    Options that the function does not have are refused by a TypeError that names the call that has them.

    >>> @takes_mesh
    ... def count(v, f):
    ...     return len(v), len(f)
    >>> from igl_spheremap import samples
    >>> count(samples.sphere(42)) == count(*samples.sphere(42)) == (42, 80)
    True
    """
    parameters = inspect.signature(function).parameters
    names, places = (
        list(parameters),
        sum(each.kind is each.POSITIONAL_OR_KEYWORD for each in parameters.values()),
    )

    def arrays(
        args: tuple[Any, ...], kwargs: dict[str, Any]
    ) -> tuple[tuple[Any, ...], dict[str, Any]]:
        args = _of_reader(args) if len(args) > places else args
        given = args[0] if args else kwargs.get("v")
        if "f" not in kwargs and (is_mesh(given) or (len(args) == 1 and "f" in names)):
            given = _opened(given)
            if "caps" in names and (caps := getattr(given, "caps", None)) is not None:
                kwargs.setdefault("caps", caps)
            kwargs.pop("v", None)
            args = (*vertices_and_faces(given), *args[1:])
        for name in kwargs:
            if name not in names:
                raise TypeError(_unknown(function, names, name))
        return args, kwargs

    return cast("TakesMesh[P, R]", gate(function, arrays))


def _of_reader(args: tuple[Any, ...]) -> tuple[Any, ...]:
    """Vertices and faces among what a reader returned: six arrays by libigl's readOBJ, values as well by napari."""
    if len(args) == 6 and np.ndim(args[3]) == 2:
        return args[0], args[3]
    return args[:2] if len(args) == 3 and np.ndim(args[1]) == 2 and np.ndim(args[2]) == 1 else args


def is_mesh(given: object) -> bool:
    """Whether something holds vertices and faces, or is the name of a file."""
    if isinstance(given, tuple | list):  # no mesh has two vertices
        given = _of_reader(tuple(given))
        return (
            len(given) == 2
            and isinstance(given[1], tuple | list | np.ndarray)
            and np.ndim(given[1][:1]) == 2
        )
    return (
        isinstance(given, str | os.PathLike)
        or any(hasattr(given, name) for name in _HOLDERS)
        or any(hasattr(given, v) and hasattr(given, f) for v, f in _NAMES)
    )


def _opened(given: Any) -> Any:
    """The mesh in a file, in a scene of trimesh, or in a PolyMesh of one part; anything else as it is."""
    if isinstance(given, str | os.PathLike):
        return from_file(given, "read_mesh")
    if hasattr(given, "geometry") and hasattr(given, "to_mesh"):
        return given.to_mesh()
    if isinstance(parts := getattr(given, "parts", None), Mapping):
        if len(parts) != 1:
            raise MeshError(
                f"the {type(given).__name__} has the parts {', '.join(parts)}; give one of them, as "
                f"parts[{next(iter(parts), '')!r}]"
            )
        return next(iter(parts.values()))
    return given


def from_file(path: str | os.PathLike[str], reader: str) -> Any:
    """What a reader of `io.files`, which stands on this room, makes of a file."""
    return getattr(import_module("..io.files", __package__), reader)(path)


def vertices_and_faces(mesh: Any) -> tuple[ArrayLike, ArrayLike]:
    """The arrays of a mesh object or of a file; a MeshError where it holds no triangles alone."""
    if isinstance(mesh, tuple | list):
        v, f = _of_reader(tuple(mesh))
        return v, f
    kind, mesh = type(mesh).__name__, _opened(mesh)
    if hasattr(mesh, "sphere"):
        raise MeshError(f"v, f are a {kind}; give its vertices, its faces or its sphere")
    for v, f in _NAMES:
        if hasattr(mesh, v) and hasattr(mesh, f):
            return getattr(mesh, v), getattr(mesh, f)
    if hasattr(mesh, "agg_data"):  # nibabel's GiftiImage
        arrays: tuple[Any, ...] = mesh.agg_data(("pointset", "triangle"))
        if any(isinstance(array, tuple) for array in arrays):  # of none, or of several
            raise MeshError(
                f"the {kind} has not one array of points and one of triangles; give a surface"
            )
        return arrays[0], arrays[1]
    if not hasattr(mesh, "points"):
        raise TypeError(
            f"{kind} is given without faces; give vertices and faces, the name of a file, or a mesh of "
            "trimesh, PyVista, meshio, nibabel, nilearn or LaPy"
        )
    if hasattr(mesh, "is_all_triangles"):  # PyVista's PolyData
        if not mesh.is_all_triangles:
            raise MeshError(
                f"the {kind} has cells that are not triangles; call triangulate() of it first"
            )
        return mesh.points, mesh.regular_faces
    cells = getattr(mesh, "cells_dict", {})
    surface = {name: len(cells[name]) for name in cells if name not in _NO_SURFACE}
    if len(surface) != 1 or not {*surface} & {*_TRIANGLES}:
        found = ", ".join(f"{number} of type {name}" for name, number in surface.items()) or "none"
        raise MeshError(
            f"the cells of the {kind} are not triangles alone ({found}); give its surface, triangulated"
        )
    return mesh.points, cells[next(iter(surface))]


def _unknown(function: Callable[..., Any], names: list[str], name: str) -> str:
    """Why an option is refused, and which call takes it: a method's record, or another function of the same room."""
    called = getattr(function, "__name__", "the function")
    what = f"{called} takes no {name}"
    if close := difflib.get_close_matches(name, names[2:], n=1, cutoff=0.7):
        return f"{what}; did you mean {close[0]}?"
    front = import_module(__name__.partition(".")[0])
    room = function.__module__.rpartition(".")[0]
    calls: list[str] = []
    for word in front.__all__:
        one = getattr(front, word)
        is_method = isinstance(one, type) and "Method" in [base.__name__ for base in one.__mro__]
        if not is_method and not (callable(one) and one.__module__.startswith(f"{room}.")):
            continue
        parameters = list(inspect.signature(one).parameters)
        if name in parameters and parameters[:2] == ["v", "f"]:
            calls.append(f"{word}(v, f, {name}=...)")
        elif name in parameters and "method" in names and is_method:
            calls.insert(0, f"method={word}({name}=...)")
    return f"{what}; " + (f"{calls[0]} does" if calls else f"it takes {', '.join(names)}")
