"""A surface at the points of a group's sphere, which is registered in its place; and its own map, carried by that."""

from __future__ import annotations

from ..maps.given_sphere import certified
from ..maps.sphere_map import SphereMap
from ..mesh.arrays import FloatArray, IntArray
from ..mesh.check import check_mesh
from ..shapes.locate import locator_of
from ..shapes.transfer import interpolate, resample
from ..sphere.rows import unit_rows
from ..untangle.local_repair import unfolded


def at_points(result: SphereMap, x: FloatArray, f: IntArray) -> SphereMap:
    """The surface whose vertices are those that a map has at points of the sphere."""
    return certified(check_mesh(resample(result, (x, f)).v, f), x)


def carried(result: SphereMap, coarse: SphereMap, y: FloatArray) -> SphereMap:
    """A map moved as its coarse one is that goes to y: free of foldings."""
    location = locator_of(coarse).locate(result.sphere)
    moved = unit_rows(interpolate(y, coarse.faces, location))
    return certified(result.mesh, unfolded(result.mesh, moved))
