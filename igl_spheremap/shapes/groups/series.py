"""One body over time: its frames in correspondence, each registered to the one before."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ...draw.markup import table
from ...draw.shown import Drawing, Shown, place_drawing
from ...errors import MeshError, check_list, check_number, own_errstate, without_name
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray, IntArray, check_values
from ...mesh.measure import enclosed_volume, surface_area
from ...mesh.timings import counted
from ...resampling.transfer import resample, sphere_mesh, transfer
from ..correspondence.registration import register
from .features import check_features
from .placing import Source, at_points, carried, mapped, names_of, own_areas
from .procrustes import generalised_procrustes


@dataclass(frozen=True, eq=False)
class Series(Shown):
    """Frames of one body at corresponding points.

    Attributes
    ----------
    vertices : (frames, n, 3) float64 array
        The points in each frame, where the frames lie, in their units.
    faces : (m, 3) int64 array
        Faces of all frames, those of an icosphere.
    sphere : (n, 3) float64 array
        Where the maps have the points.
    areas : (frames, n) float64 array
        The frame's own area around each point, in the square of the frames' units.
    features : (frames, n, k) float64 array
        Data of the frames at the points; k is 0 without them.
    maps : tuple of SphereMap
        The frames with their maps, registered and certified.
    drift : (n,) float64 array
        Distance of the points of the last frame, which came there frame by frame, from those of its map that is
        registered to the first frame directly, in the frames' units.
    """

    vertices: FloatArray
    faces: IntArray
    sphere: FloatArray
    areas: FloatArray
    features: FloatArray
    maps: tuple[SphereMap, ...]
    drift: FloatArray

    def __repr__(self) -> str:
        return (f"Series({len(self.vertices)} frames, {self.vertices.shape[1]} vertices, drift "
                f"{np.sqrt((self.drift**2).mean()):.3g})")

    def _drawing(self) -> Drawing:
        return place_drawing((self.vertices[0], self.vertices[-1]), self.faces,
                             "The first frame and the last one. The same colour is the same point of the body.")

    def _figures(self) -> str:
        """Area and volume of the frames."""
        return table([(str(k), f"{area:.5g}", f"{volume:.5g}") for k, (area, volume) in enumerate(
            zip(self.surface_areas, self.volumes, strict=True))], ("frame", "area", "volume"))

    @property
    def aligned(self) -> FloatArray:
        """The points with the body's motion taken away, (frames, n, 3): moved and turned to agree best, not scaled."""
        return generalised_procrustes(self.vertices, self.areas.mean(axis=0), rigid=True).laid(self.vertices)

    @property
    def surface_areas(self) -> FloatArray:
        """Area of each frame, as it came, in the square of the frames' units."""
        return np.array([surface_area(each.vertices, each.faces) for each in self.maps])

    @property
    def volumes(self) -> FloatArray:
        """Volume of each frame, as it came, in the cube of the frames' units."""
        return np.array([enclosed_volume(each.vertices, each.faces) for each in self.maps])


@own_errstate
def series(
    sources: Sequence[Source],
    *,
    features: Sequence[ArrayLike] | None = None,
    target: str = "ico:4",
    balance: float = 1.0,
) -> Series:
    """Follow points of one body through its frames.

    Each frame is mapped to the sphere and registered to the one before it, from which it differs little.

    Parameters
    ----------
    sources : iterable of path-like, SphereMap or mesh objects
        The frames in their order, two or more, whose meshes may differ.
    features : sequence of (n,) or (n, k) array_like, optional
        Data over the vertices of each frame.
    target : str, default ``ico:4``
        The mesh whose points are followed.
    balance : float, default 1
        Of the maps: 0 is conformal, 1 preserves areas.

    Returns
    -------
    Series
        The points in all frames, areas and features there, and how far the chain drifted.

    Raises
    ------
    MeshError
        If a mesh is invalid, or there are fewer than two.
    FileError
        If a file can't be read.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("pear", n_vertices=100)
    >>> ism.shapes.series([(v * [1.3, 1, 1 + 0.1 * k], f) for k in range(2)], target="ico:2").vertices.shape
    (2, 162, 3)
    """
    check_number(balance, "balance", most=1)
    x, f = sphere_mesh(target)
    sources = check_list(sources, "sources")
    if len(sources) < 2:
        raise MeshError(f"{len(sources)} frames make no series; give two or more")
    names = names_of(sources)
    check_features(features, names)
    maps: list[SphereMap] = []
    before = first = None
    for name, source in zip(names, counted("frames", sources), strict=True):
        try:
            result = mapped(source, balance)
        except MeshError as error:
            raise MeshError(f"frame {name}: {without_name(error.fault, name)}", error.remedy) from error
        coarse = at_points(result, x, f)
        onto = coarse if before is None else register(coarse, before).map
        maps.append(result if before is None else carried(result, coarse, onto.sphere))
        before = at_points(maps[-1], x, f)
        first = first or before
    assert first is not None
    direct = carried(result, coarse, register(coarse, first).map.sphere)
    points = np.stack([resample(each, (x, f)).v for each in maps])
    data = [np.empty((len(each.sphere), 0)) for each in maps] if features is None else [
        check_values(values, len(each.sphere), f"features of frame {name}")
        for name, each, values in zip(names, maps, features, strict=True)]
    return Series(
        points, f, x, np.stack([own_areas(each, x, f) for each in maps]),
        np.stack([transfer(each, values, (x, f)) for each, values in zip(maps, data, strict=True)]), tuple(maps),
        np.linalg.norm(points[-1] - resample(direct, (x, f)).v, axis=1),
    )  # fmt: skip
