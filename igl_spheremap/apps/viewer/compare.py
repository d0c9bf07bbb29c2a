"""Surfaces side by side: any parts in rows, and one surface by several methods."""

from __future__ import annotations

import numpy as np

from ...draw.palette import SURFACE
from ...draw.plot import fit, pose
from ...mesh.arrays import FloatArray
from ...mesh.disk import Disk
from ...plane.plane_map import in_space
from ...verify.certificate import Certificate
from .app import App
from .colouring import SQUARES, Colouring
from .grid import Grid, Part, Rows
from .map_view import count_foldings


class PartsView(App):
    """Parts in rows, which turn together."""

    def __init__(self, rows: Rows) -> None:
        self.grid = Grid(panel=0)
        self.grid.show(rows)

    def pick(self, vertex: int | None) -> None:
        """Mark a vertex on all parts, if they are of one surface."""
        first, *others = self.grid.parts.values()
        if all(part.f is first.f for part in others):
            super().pick(vertex)


def plane_view(name: str, disk: Disk, p: FloatArray, up: str) -> PartsView:
    """A surface and its image in the plane, with a checkerboard of the plane on both."""
    certificate = Certificate.of_plane(p, disk.f, disk.rim)
    checks = SQUARES * p[disk.f].reshape(-1, 2) / np.ptp(p, axis=0).max()
    folded = np.sort(np.concatenate((certificate.flipped, certificate.degenerate)))
    grey = np.tile(SURFACE, (len(disk.f), 1))
    return PartsView([[
        Part(f"{name}\n{len(disk.v):,} vertices", fit(disk.unit, pose(disk.unit, up)), disk.f,
             Colouring(grey, checks=checks)),
        Part(f"in the plane\n{count_foldings(len(folded))}, {len(certificate.crossings):,} boundary edges that cross",
             fit(in_space(p), np.eye(3)), disk.f, Colouring(grey, folded, checks=checks), image=True),
    ]])  # fmt: skip
