"""Surfaces side by side: any parts in rows, and one surface by several methods."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ...draw.palette import INK, LINES, SURFACE
from ...draw.plot import fit, pose
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.check import Mesh
from ...mesh.disk import Disk
from ...plane.plane_map import in_space
from ...sphere.rows import unit_rows
from ...verify.certificate import Certificate
from ...verify.signs import folded_faces
from .app import App, present
from .body import Dots
from .choices import SIZE
from .colouring import SQUARES, Colouring, relief
from .grid import Grid, Part, Rows
from .map_view import MapView, count_foldings

#: Points of the line from a landmark to its target; radii of the dots of both and of the line, and how far landmarks
#: are lifted off the sphere: a target is larger, and seen around a landmark that has met it.
_STEPS, _DOT, _TARGET, _LINE, _LIFT = 40, 0.02, 0.032, 0.007, 1.02


class PartsView(App):
    """Parts in rows, which turn together."""

    def __init__(self, rows: Rows) -> None:
        self.grid = Grid(panel=0)
        self.grid.show(rows)


def show_parts(rows: Rows, target: str | os.PathLike[str] | None, *, size: tuple[int, int]) -> None:
    """Open a window with parts in rows, or write a picture of them or a video in which they turn."""
    present(lambda: PartsView(rows), target, size=size)


def plane_view(name: str, disk: Disk, p: FloatArray, up: str) -> PartsView:
    """A surface and its image in the plane, with a checkerboard of the plane on both."""
    certificate = Certificate.of_plane(p, disk.f, disk.rim)
    checks = SQUARES * p[disk.f].reshape(-1, 2) / np.ptp(p, axis=0).max()
    folded = np.sort(np.concatenate((certificate.flipped, certificate.degenerate)))
    grey = np.tile(SURFACE, (len(disk.f), 1))
    return PartsView([[
        Part(f"{name}\n{len(disk.v):,} vertices", fit(disk.unit, pose(disk.unit, up)), disk.f,
             Colouring(grey, checks=checks)),
        Part(f"in the plane\n{count_foldings(len(folded))}, {len(certificate.crossings):,} boundary edges that meet "
             "others", fit(in_space(p), np.eye(3)), disk.f, Colouring(grey, folded, checks=checks), image=True),
    ]])  # fmt: skip


def landmark_part(
    caption: str, mesh: Mesh, x: FloatArray, landmarks: IntArray, targets: FloatArray | None = None,
    turn: FloatArray | None = None,
) -> Part:  # fmt: skip
    """A surface, or a map before a turn, with its landmarks, their targets, and lines from one to the other."""
    colours = Colouring(np.array(SURFACE) * relief(mesh)[:, None])
    if targets is not None:  # before the turn, which rounds, and may fold
        colours = replace(colours, folded=np.flatnonzero(folded_faces(x, mesh.f)))
    if turn is not None:
        x = x @ turn.T
        if targets is not None:
            targets = targets @ turn.T
    dots: dict[str, Dots] = {"landmarks": (x[landmarks], LINES[0], _DOT)}
    if targets is not None:
        steps = np.linspace(0, 1, _STEPS)[:, None, None]
        line = unit_rows(((1 - steps) * x[landmarks] + steps * targets).reshape(-1, 3))
        dots |= {
            "targets": (targets, LINES[5], _TARGET),
            "way": (line, INK, _LINE),
            "landmarks": (_LIFT * x[landmarks], LINES[0], _DOT),
        }
    return Part(caption, x, mesh.f, colours, image=targets is not None, dots=dots)


def compare(
    mesh: Mesh, maps: Mapping[str, FloatArray], target: str | os.PathLike[str] | None = None, *, up: str = "auto",
    size: tuple[int, int] = SIZE,
) -> None:  # fmt: skip
    """Open a window with maps (n, 3) of a surface by their names, or write a picture of it."""
    present(
        lambda: MapView(mesh, maps, up=up, subject="angle differences", name="maps"),
        target,
        size=size,
    )
