"""A source is mapped and sampled at the points of a group's sphere; these are registered, and carry its map along."""

from __future__ import annotations

import os
from collections.abc import Sequence

import numpy as np

from ...balance.balanced_spherical_map import balanced_spherical_map
from ...errors import MeshError, Remedy
from ...gate import MeshLike
from ...io.files import read_mesh
from ...maps.given_sphere import certified
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.check import check_mesh
from ...mesh.measure import inside_out
from ...resampling.locate import locator_of
from ...resampling.transfer import interpolate, resample
from ...resampling.weights import adaptive_area
from ...sphere.rows import unit_rows
from ...untangle.local_repair import unfolded

#: What members of groups are given as.
Source = str | os.PathLike[str] | SphereMap | MeshLike

# 1e48: products of six coordinates, or of their reciprocals, are float64 numbers
_LARGEST = 2.0**160


def names_of(sources: Sequence[Source]) -> list[str]:
    """The sources' files, or their numbers."""
    return [
        os.fspath(source) if isinstance(source, str | os.PathLike) else str(k)
        for k, source in enumerate(sources)
    ]


def mapped(source: Source, balance: float) -> SphereMap:
    """The map of a file or a mesh; a map is taken as it is."""
    given = read_mesh(source) if isinstance(source, str | os.PathLike) else source
    result = (
        given if isinstance(given, SphereMap) else balanced_spherical_map(given, balance=balance)
    )
    check_member(result)
    return result


def check_member(result: SphereMap) -> None:
    """Raise a MeshError if areas, variances or volumes of a surface in such units may not be float64 numbers.

    Or if it is inside out: only a mirror image of it could be laid on the others.
    """
    largest, least = np.abs(result.vertices).max(), np.ptp(result.vertices, axis=0).max()
    if largest > _LARGEST or least < 1 / _LARGEST:
        raise MeshError(
            f"its coordinates reach {largest:.3g}, its extent is {least:.3g}; choose units in which both "
            f"lie between {1 / _LARGEST:.0e} and {_LARGEST:.0e}, so that areas and volumes are numbers"
        )
    if inside_out(result.vertices, result.faces):
        raise MeshError("inside out: its faces point inwards; reverse them", Remedy("repair_mesh"))


def at_points(result: SphereMap, x: FloatArray, f: IntArray) -> SphereMap:
    """The surface whose vertices are those that a map has at points of the sphere."""
    return certified(check_mesh(resample(result, (x, f)).v, f), x)


def carried(result: SphereMap, coarse: SphereMap, y: FloatArray) -> SphereMap:
    """A map moved as the registration moves its coarse version, to y; it is free of foldings."""
    location = locator_of(coarse).locate(result.sphere)
    moved = unit_rows(interpolate(y, coarse.faces, location))
    return certified(result.mesh, unfolded(result.mesh, moved))


def own_areas(result: SphereMap, x: FloatArray, f: IntArray) -> FloatArray:
    """The surface's own area around each point of the sphere, its whole area together."""
    received = adaptive_area(result, (x, f)).received
    assert received is not None
    return received
