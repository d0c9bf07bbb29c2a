"""The files of a registered hemisphere, by the names and signs of a convention."""

from __future__ import annotations

import os
from typing import Any

import igl
import numpy as np

from ...features.feature_surface import depth_potential
from ...io.hemispheres import Names
from ...io.records import Label, LoadedMesh
from ...io.scalars import write_scalars
from ...io.write_mesh import write_mesh
from ...io.written_map import write_sphere
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.measure import surface_area, vertex_areas

#: Widths of the depth potentials that are like FreeSurfer's sulc and curv, see `depth_potential`.
SULC, _CURV = 0.12, 0.05


class Writer:
    """Writes the files of one convention, with the source's metadata, and counts the foldings of the spheres."""

    def __init__(self, folder: str, names: Names, given: LoadedMesh, mark: str) -> None:
        self._folder, self._names, self._f, self._given = folder, names, given.f, given.metadata
        self._metadata = {"structure": names.hemisphere.structure, "mark": mark}
        # HCP's sulc and curvature are high on gyri
        self._turn = -1.0 if names.convention == "hcp" else 1.0
        self.foldings = self.moved = 0

    def sphere(self, x: FloatArray, what: str, space: str = "") -> None:
        """Write a sphere, with the volume's geometry; the coordinate system of the surface is not that of a sphere."""
        volume = {"volume": self._given["volume"]} if "volume" in self._given else {}
        path = self._path(what, space)
        written = write_sphere(path, x, self._f, force=True, metadata=self._metadata | volume)
        self.foldings += written.foldings
        self.moved += written.moved

    def surface(
        self,
        v: FloatArray,
        f: IntArray,
        what: str,
        space: str = "",
        structure: str | None = None,
        kind: str = "",
    ) -> None:
        """Write a surface in the coordinates of the source."""
        metadata = (
            dict(self._given) | self._metadata | ({"structure": structure} if structure else {})
        )
        path = self._path(what, space, kind=kind, vertices=len(v))
        write_mesh(path, v, f, force=True, metadata=metadata)

    def features(self, own: SphereMap, v: FloatArray) -> None:
        """Write FreeSurfer's sulc and curv, in mm and 1/mm, and the areas of the given surface's vertices."""
        unit = np.sqrt(surface_area(own.vertices, own.faces) / (4 * np.pi))
        sulc, curv = (
            -self._turn * depth_potential(own.vertices, own.faces, ell=ell) for ell in (SULC, _CURV)
        )
        self.scalars("sulc", unit * sulc, "sulc")
        # the potential is 2 H ell^2
        self.scalars("curv", curv / (2 * _CURV**2 * unit), "curv")
        self.scalars("area", vertex_areas(v, own.faces), "area")

    def scalars(self, quantity: str, values: FloatArray, what: str, name: str = "") -> None:
        """Write data at the vertices."""
        path = self._path(what, name)
        write_scalars(path, {quantity: values}, force=True, metadata=self._metadata)

    def labels(
        self,
        atlas: str,
        values: IntArray,
        table: tuple[Label, ...] | None,
        what: str,
        name: str = "",
    ) -> None:
        """Write labels with their table; labels that it lacks are added to it."""
        path = self._path(what, name)
        table = table or tuple(
            Label(key, str(key), _colour(key)) for key in np.unique(values).tolist()
        )
        if not path.endswith(".annot") and (values < 0).any():
            table = (*table, Label(-1, "???", (0.0, 0.0, 0.0, 0.0)))
        metadata = self._metadata | {"labels": table}
        write_scalars(path, {atlas: values.astype(np.float64)}, force=True, metadata=metadata)

    def _path(self, what: str, name: str = "", **about: Any) -> str:
        return os.path.join(self._folder, self._names.of(what, name, **about))


def thickness_of(white: FloatArray, pial: FloatArray, f: IntArray) -> FloatArray:
    """Average the distances of each vertex to the other surface, as FreeSurfer does (Fischl and Dale 2000)."""
    squares = [
        igl.point_mesh_squared_distance(p, q, f)[0] for p, q in ((white, pial), (pial, white))
    ]
    return np.asarray(np.sqrt(squares).mean(axis=0))


def _colour(key: int) -> tuple[float, float, float, float]:
    """Choose a colour for a label that has none: an odd factor gives each of 2^24 keys its own."""
    code = key * 0x9E3779B1 & 0xFFFFFF
    return (code >> 16) / 255, (code >> 8 & 255) / 255, (code & 255) / 255, 1.0
