"""One body over time: its frames in correspondence, each registered to the one before."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from ...balance import AREA_PRESERVING
from ...draw.markup import table
from ...draw.shown import Drawing, Shown, place_drawing
from ...errors import MeshError, check_list, check_number
from ...gate import PathLike, gate
from ...io import npz
from ...io.npz import read_arrays, save_arrays
from ...io.written_map import read_map
from ...maps.given_sphere import certified
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.check import check_mesh
from ...mesh.measure import enclosed_volume, surface_area
from ...populations.engine import USUAL, Engine
from ...resampling.transfer import resample, sphere_mesh
from .doubts import drift_doubts
from .features import check_features
from .member_files import Entry, member_files, stacked
from .procrustes import generalised_procrustes
from .sampling import SurfaceLike, carried, names_of
from .turns import NO_RESTARTS, Turns


@dataclass(frozen=True, eq=False)
class Series(Shown):
    """Frames of one body at corresponding points.

    Attributes
    ----------
    vertices : (frames, n, 3) float64 array
        The points in each frame, in its own position, in the frames' units.
    faces : (m, 3) int64 array
        Faces of all frames, those of an icosphere.
    sphere : (n, 3) float64 array
        The points under the maps.
    areas : (frames, n) float64 array
        The frame's own area around each point, in the square of the frames' units.
    features : (frames, n, k) float64 array
        Data of the frames at the points; k is 0 without them.
    maps : tuple of SphereMap
        The frames with their maps, registered and certified.
    drift : (n,) float64 array
        Distance of the points of the last frame, which came there frame by frame, from those by a direct registration
        to the first frame, in the frames' units.
    notes : tuple of str
        Reasons to doubt the drift.
    """

    vertices: FloatArray
    faces: IntArray
    sphere: FloatArray
    areas: FloatArray
    features: FloatArray
    maps: tuple[SphereMap, ...]
    drift: FloatArray
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return (
            f"Series({len(self.vertices)} frames, {self.vertices.shape[1]} vertices, drift "
            f"{np.sqrt((self.drift**2).mean()):.3g})"
        )

    def _drawing(self) -> Drawing:
        return place_drawing(
            (self.vertices[0], self.vertices[-1]),
            self.faces,
            "The first frame and the last one. The same colour is the same point of the body.",
        )

    def _figures(self) -> str:
        """Area and volume of the frames."""
        return table(
            [
                (str(k), f"{area:.5g}", f"{volume:.5g}")
                for k, (area, volume) in enumerate(
                    zip(self.surface_areas, self.volumes, strict=True)
                )
            ],
            ("frame", "area", "volume"),
        )

    @property
    def aligned(self) -> FloatArray:
        """The points without the body's motion, (frames, n, 3): moved and turned to agree best, not scaled."""
        return generalised_procrustes(self.vertices, self.areas.mean(axis=0), rigid=True).shapes

    @property
    def surface_areas(self) -> FloatArray:
        """Area of each frame, as it came, in the square of the frames' units."""
        return np.array([surface_area(each.vertices, each.faces) for each in self.maps])

    @property
    def volumes(self) -> FloatArray:
        """Volume of each frame, as it came, in the cube of the frames' units."""
        return np.array([enclosed_volume(each.vertices, each.faces) for each in self.maps])


@gate
def series(
    sources: Iterable[SurfaceLike],
    *,
    features: Sequence[ArrayLike] | None = None,
    target: str = "ico:4",
    balance: float = AREA_PRESERVING,
    out: PathLike | None = None,
    engine: Engine = USUAL,
) -> Series:
    """Follow points of one body through its frames.

    Each frame is mapped to the sphere and registered to the one before it, from which it differs little. Each pair of
    neighbouring frames is a job of its own; their results are put together.

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
    out : path-like, optional
        A folder for intermediate results, as of `template`, from which another call continues; the frames' maps are in
        its folder ``maps``. A temporary one by default.
    engine : Engine
        As of `igl_spheremap.map_many`.

    Returns
    -------
    Series
        The points in all frames, areas and features there, and the chain's drift.

    Raises
    ------
    MeshError
        If a frame can't be read or mapped, or there are fewer than two.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("pear", n_vertices=100)
    >>> ism.shapes.series([(v * [1.3, 1, 1 + 0.1 * k], f) for k in range(2)], target="ico:2").vertices.shape
    (2, 162, 3)
    """
    check_number(balance, "balance", most=1)
    mesh = sphere_mesh(target)
    sources = check_list(sources, "sources")
    if len(sources) < 2:
        raise MeshError(f"{len(sources)} frames make no series; give two or more")
    check_features(features, names_of(sources))
    with member_files(out, "maps", target, engine, least=len(sources)) as files:
        frames = files.mapped(sources, features, balance)
        paths = [files.of(frame, "points") for frame in frames]
        coarse = [
            certified(check_mesh(points, mesh[1]), mesh[0])
            for points in stacked(paths, "points")[0]
        ]
        last = replace(frames[-1])  # to the first frame directly
        files.registered(
            "pairs", [*frames[1:], last], [*paths[:-1], paths[0]], [NO_RESTARTS] * len(frames)
        )
        axis, restarts = Turns(mesh[0]).restarts(
            coarse[0].vertices, stacked([last.sphere], "points")[0]
        )
        files.registered("tried", [last], paths[:1], restarts)
        frames[0].sphere = files.path("work", "chain", "0.npz")
        save_arrays(frames[0].sphere, {"sphere": mesh[0]})
        # to the first sphere, through that of the one before
        for k, (before, frame) in enumerate(pairwise(frames)):
            onto = carried(
                certified(coarse[k + 1].mesh, _sphere(frame)), coarse[k], _sphere(before)
            )
            frame.sphere = files.path("work", "chain", f"{k + 1}.npz")
            save_arrays(frame.sphere, {"sphere": onto.sphere})
        _, (points, areas, data) = files.carried(frames, [np.eye(3)] * len(frames))
        onto = carried(npz.map_of(read_arrays(files.of(last, "map"))), coarse[-1], _sphere(last))
        return Series(
            points,
            mesh[1],
            mesh[0],
            areas,
            data,
            tuple(read_map(files.result(frame)) for frame in frames),
            np.linalg.norm(points[-1] - resample(onto, mesh).v, axis=1),
            tuple(drift_doubts(files.last_search(last), axis)),
        )


def _sphere(frame: Entry) -> FloatArray:
    """The points by the frame's last registration."""
    return read_arrays(frame.sphere)["sphere"]
