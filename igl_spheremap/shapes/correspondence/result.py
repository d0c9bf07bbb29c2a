"""Common to registrations and maps between surfaces: the source's map to the sphere in the target's frame."""

from __future__ import annotations

from dataclasses import replace

from ...draw.shown import Shown
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray
from ...result.result import Result
from ...result.run import Run
from ...verify.certificate import Certificate


class OfMap(Shown, Result):
    """A result whose certificate and run are those of a map, with notes of its own."""

    map: SphereMap
    notes: tuple[str, ...]

    @property
    def certificate(self) -> Certificate:
        """Of the source's map to the sphere."""
        return self.map.certificate

    @property
    def run(self) -> Run:
        """How the map came about."""
        return replace(self.map.run, notes=self.notes)

    @property
    def _images(self) -> FloatArray:
        return self.map.sphere
