"""A source is mapped and sampled at the points of a group's sphere; these are registered, and carry its map along."""

from __future__ import annotations

import os
from collections.abc import Sequence

import numpy as np

from ...errors import MeshError, Remedy
from ...gate import MeshLike, PathLike
from ...maps.given_sphere import certified
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.check import check_mesh
from ...mesh.measure import inside_out
from ...resampling.locate import locator_of
from ...resampling.transfer import interpolate, resample
from ...sphere.rows import unit_rows
from ...untangle.local_repair import unfolded

#: Kinds of given members.
SurfaceLike = PathLike | SphereMap | MeshLike


def names_of(sources: Sequence[SurfaceLike]) -> list[str]:
    """The sources' files, or their numbers."""
    names = []
    for k, source in enumerate(sources):
        if isinstance(source, str | os.PathLike):
            names.append(os.fspath(source))
        else:
            names.append(str(k))
    return names


def check_member(result: SphereMap, most: float = 2.0**160) -> None:
    """Raise a MeshError if a surface is inside out, or its areas, variances or volumes may not be float64 numbers.

    Products of six coordinates up to 1e48, or of their reciprocals, are such numbers. Of a surface inside out only a
    mirror image could be aligned with the others.
    """
    largest, least = np.abs(result.vertices).max(), np.ptp(result.vertices, axis=0).max()
    if largest > most or least < 1 / most:
        raise MeshError(
            f"its coordinates reach {largest:.3g}, its extent is {least:.3g}; choose units in which both "
            f"lie between {1 / most:.0e} and {most:.0e}, so that areas and volumes are numbers"
        )
    if inside_out(result.vertices, result.faces):
        raise MeshError("inside out: its faces point inwards; reverse them", Remedy("repair_mesh"))


def at_points(result: SphereMap, x: FloatArray, f: IntArray) -> SphereMap:
    """The surface whose vertices are a map's at points of the sphere."""
    return certified(check_mesh(resample(result, (x, f)).v, f), x)


def carried(result: SphereMap, coarse: SphereMap, y: FloatArray) -> SphereMap:
    """A map moved as the registration moves its coarse version, to y; it is free of foldings."""
    location = locator_of(coarse).locate(result.sphere)
    moved = unit_rows(interpolate(y, coarse.faces, location))
    return certified(result.mesh, unfolded(result.mesh, moved))
