"""The files of a registered hemisphere, by the names and signs of a convention."""

from __future__ import annotations

import os

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

    def sphere(self, name: str, x: FloatArray) -> None:
        """Write a sphere, with the volume's geometry; the coordinate system of the surface is not that of a sphere."""
        volume = {"volume": self._given["volume"]} if "volume" in self._given else {}
        written = write_sphere(
            self._path(name), x, self._f, force=True, metadata=self._metadata | volume
        )
        self.foldings += written.foldings
        self.moved += written.moved

    def surface(self, name: str, v: FloatArray, f: IntArray, structure: str | None = None) -> None:
        """Write a surface in the coordinates of the source."""
        metadata = (
            dict(self._given) | self._metadata | ({"structure": structure} if structure else {})
        )
        write_mesh(self._path(name), v, f, force=True, metadata=metadata)

    def features(self, own: SphereMap, v: FloatArray) -> None:
        """Write FreeSurfer's sulc and curv, in mm and 1/mm, and the areas of the given surface's vertices."""
        unit = np.sqrt(surface_area(own.vertices, own.faces) / (4 * np.pi))
        sulc, curv = (
            -self._turn * depth_potential(own.vertices, own.faces, ell=ell) for ell in (SULC, _CURV)
        )
        self.scalars(self._names.of("sulc"), "sulc", unit * sulc)
        # the potential is 2 H ell^2
        self.scalars(self._names.of("curv"), "curv", curv / (2 * _CURV**2 * unit))
        self.scalars(self._names.of("area"), "area", vertex_areas(v, own.faces))

    def scalars(self, name: str, quantity: str, values: FloatArray) -> None:
        """Write data at the vertices."""
        write_scalars(self._path(name), {quantity: values}, force=True, metadata=self._metadata)

    def labels(
        self, name: str, atlas: str, values: IntArray, table: tuple[Label, ...] | None
    ) -> None:
        """Write labels with their table; labels that it lacks are added to it."""
        table = table or tuple(
            Label(key, str(key), _colour(key)) for key in np.unique(values).tolist()
        )
        if not name.endswith(".annot") and (values < 0).any():
            table = (*table, Label(-1, "???", (0.0, 0.0, 0.0, 0.0)))
        whole = values.astype(np.float64)
        write_scalars(
            self._path(name),
            {atlas: whole},
            force=True,
            metadata=self._metadata | {"labels": table},
        )

    def _path(self, name: str) -> str:
        return os.path.join(self._folder, name)


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
