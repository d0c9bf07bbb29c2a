"""Mesh objects, of this package and of others, and names of files, in the place of `v, f`."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..errors import MeshError
from .files import read_mesh, read_sphere

#: Attributes of meshes for vertices and faces: of trimesh and libraries like it; of results of checks, readers and
#: repairs; of nilearn; of LaPy.
_NAMES = (("vertices", "faces"), ("v", "f"), ("coordinates", "faces"), ("v", "t"))
#: Attributes of other objects that hold a mesh: of meshio and PyVista, nibabel, nilearn's PolyMesh, trimesh's scenes.
_HOLDERS = ("points", "agg_data", "parts", "to_mesh")
#: Triangles among the cells of meshio, by name, and of PyVista's grids, by VTK's number; and cells that are no surface.
_TRIANGLES, _NO_SURFACE = ("triangle", 5), ("vertex", "line", 1, 2, 3, 4)


def arrays_of_mesh(
    names: Sequence[str], places: int, args: tuple[Any, ...], options: dict[str, Any]
) -> tuple[tuple[Any, ...], dict[str, Any]]:
    """The arguments of a function of `v, f`, for which a mesh object, with its caps, or a reader's tuple may stand."""
    if len(args) > places:
        args = _of_reader(args)
    given = options.get("v")
    if args:
        given = args[0]
    if "f" not in options and (is_mesh(given) or (len(args) == 1 and "f" in names)):
        given = _opened(given)
        if "caps" in names and options.get("caps") is None:
            options["caps"] = getattr(given, "caps", None)
        options.pop("v", None)
        args = (*vertices_and_faces(given), *args[1:])
    return args, options


def sphere_and_faces(given: Any) -> tuple[ArrayLike, ArrayLike | None]:
    """The positions and the faces of a mesh object or of a sphere's file; anything else comes back, without faces."""
    if isinstance(given, str | os.PathLike):
        given = read_sphere(given)
    if not is_mesh(given):
        return given, None
    return vertices_and_faces(given)


def faces_of(given: Any) -> Any:
    """The faces of a mesh object or a file; anything else comes back."""
    if not is_mesh(given):
        return given
    return vertices_and_faces(given)[1]


def _of_reader(args: tuple[Any, ...]) -> tuple[Any, ...]:
    """Vertices and faces in a reader's result: six arrays by libigl's readOBJ, values as well by napari."""
    if len(args) == 6 and np.ndim(args[3]) == 2:
        return args[0], args[3]
    if len(args) == 3 and np.ndim(args[1]) == 2 and np.ndim(args[2]) == 1:
        return args[:2]
    return args


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
        return read_mesh(given)
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


def vertices_and_faces(mesh: Any) -> tuple[ArrayLike, ArrayLike]:
    """The arrays of a mesh object or of a file; a MeshError unless it holds triangles alone."""
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
        found = "none"
        if surface:
            found = ", ".join(f"{number} of type {name}" for name, number in surface.items())
        raise MeshError(
            f"the cells of the {kind} are not triangles alone ({found}); give its surface, triangulated"
        )
    return mesh.points, cells[next(iter(surface))]
