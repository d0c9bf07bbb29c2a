"""A source mapped, at the points of a group's sphere, which are registered in its place, and carried by them."""

from __future__ import annotations

import os

from ..io.files import read_mesh
from ..maps.balanced import balanced_spherical_map
from ..maps.given_sphere import certified
from ..maps.sphere_map import SphereMap
from ..mesh.arrays import FloatArray, IntArray
from ..mesh.check import check_mesh
from ..mesh.objects import MeshLike
from ..shapes.locate import locator_of
from ..shapes.transfer import interpolate, resample
from ..shapes.weights import adaptive_area
from ..sphere.rows import unit_rows
from ..untangle.local_repair import unfolded

#: What members of groups are given as.
Source = str | os.PathLike[str] | SphereMap | MeshLike


def mapped(source: Source, balance: float) -> SphereMap:
    """The map of a file or a mesh; a map is taken as it is."""
    given = read_mesh(source) if isinstance(source, str | os.PathLike) else source
    return given if isinstance(given, SphereMap) else balanced_spherical_map(given, balance=balance)


def at_points(result: SphereMap, x: FloatArray, f: IntArray) -> SphereMap:
    """The surface whose vertices are those that a map has at points of the sphere."""
    return certified(check_mesh(resample(result, (x, f)).v, f), x)


def carried(result: SphereMap, coarse: SphereMap, y: FloatArray) -> SphereMap:
    """A map moved as its coarse one is that goes to y: free of foldings."""
    location = locator_of(coarse).locate(result.sphere)
    moved = unit_rows(interpolate(y, coarse.faces, location))
    return certified(result.mesh, unfolded(result.mesh, moved))


def own_areas(result: SphereMap, x: FloatArray, f: IntArray) -> FloatArray:
    """The surface's own area around each point of the sphere, its whole area together."""
    received = adaptive_area(result, (x, f)).received
    assert received is not None
    return received
