"""Pictures of a surface and its sphere from their files, for pages with many of them."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from ..draw.palette import FOLDED, diverging
from ..draw.plot import raster, shading, view_of
from ..io import read_mesh, read_sphere, write_picture
from ..mesh.check import check_mesh
from ..mesh.clean import repair_mesh
from ..verify.distortion import mesh_area_distortion
from ..verify.signs import folded_faces
from .job import Options, place
from .table import MAPPED, Row

SIZE = 180  # pixels of each of the four views
REACH = 2.0  # logarithm of an area ratio at the ends of the colours
_AMBIENT = 0.6
_BEHIND = np.array([-1.0, 1.0, -1.0])  # half a turn about the vertical


def draw_row(row: Row, path: str, options: Options) -> bool:
    """Draw surface and sphere from the front, then both from behind, unless the picture is newer than the map.

    Purple shrinks, green grows, folded faces are vermilion. False where the files hold no map.
    """
    source, target = place(row.source, options), place(row.target, options)
    if row.status not in MAPPED:
        return False
    if Path(path).exists() and os.stat(path).st_mtime_ns > os.stat(target).st_mtime_ns:
        return True
    v, f = read_mesh(source, triangulate=options.repair)
    if options.repair:
        repaired = repair_mesh(v, f, keep_largest=options.keep_largest)
        v, f = repaired.v, repaired.f
    x, _ = read_sphere(target)
    mesh, view = check_mesh(v, f), view_of(v)
    colours = diverging("", REACH).colours(mesh_area_distortion(mesh, x))
    folded = folded_faces(x, mesh.f)
    tiles = []
    for turn in (view, view * _BEHIND):
        for y in (v, x):
            shaded = colours * shading(y, mesh.f, turn, _AMBIENT)[:, None]
            shaded[folded] = FOLDED
            tiles.append(raster(y @ turn, mesh.f, shaded, SIZE))
    write_picture(path, np.concatenate(tiles, axis=1), force=True)
    return True
