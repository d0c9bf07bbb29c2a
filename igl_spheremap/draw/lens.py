"""Moebius maps that magnify a place of the sphere, for pictures of tiny images."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..mesh.arrays import TINY, FloatArray, IntArray
from ..sphere.rows import from_chart, to_chart

#: Power of the strongest lens: beyond it the rounding of float64 shows.
STRONGEST = 1e9


@dataclass(frozen=True, eq=False)
class Lens:
    """Moebius map that magnifies angles at a unit vector `place` by `power`, with the place towards +z.

    A rotation `facing` then takes it to +z. At the power `limit` the lens' target fills the view.
    """

    place: FloatArray = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    power: float = 1.0
    facing: FloatArray = field(default_factory=lambda: np.eye(3))
    limit: float = 1.0

    def __call__(self, x: FloatArray) -> FloatArray:
        """Apply to unit rows: scale the stereographic chart that is centred at the place.

        >>> import numpy as np
        >>> Lens(power=3.0)(np.array([[0.0, 0.6, 0.8], [0.0, 0.0, -1.0]])).round(12)
        array([[ 0.,  1.,  0.],
               [ 0.,  0., -1.]])
        """
        pole = self.place[None]
        return from_chart(self.power * to_chart(x, pole), pole) @ self.axes().T

    def axes(self) -> FloatArray:
        """The shortest turn of the place to +z, in the frame in which the viewer is there."""
        p, z = self.facing @ self.place, np.array([0.0, 0.0, 1.0])
        turn = np.diag([-1.0, 1.0, -1.0])
        if p[2] >= -1 + 1e-12:
            turn = np.eye(3) - np.outer(p + z, p + z) / (1 + p[2]) + 2 * np.outer(z, p)
        return np.asarray(self.facing.T @ turn @ self.facing)


def follow(
    maps: Sequence[FloatArray], f: IntArray, faces: IntArray, aim: int = 0, power: float | None = None,
    facing: FloatArray | None = None,
) -> list[Lens]:  # fmt: skip
    """Lenses on the same faces of several maps, of one power: unless it is given, that which fits the map `aim`.

    No power is above the limit of that map. Without faces they are the plain view. The faces are in front after a
    rotation `facing`.
    """
    if not len(faces):
        return [Lens()] * len(maps)
    lenses = [look_at(x, f[faces]) for x in maps]
    limit = lenses[aim].limit
    if power is None:
        power = lenses[aim].power
    if facing is None:
        facing = np.eye(3)
    power = min(power, limit)
    return [replace(lens, power=power, facing=facing, limit=limit) for lens in lenses]


def follow_vertex(
    maps: Sequence[FloatArray],
    f: IntArray,
    vertex: int,
    aim: int = 0,
    power: float | None = None,
    facing: FloatArray | None = None,
) -> list[Lens]:
    """Lenses on a vertex of several maps, as strong as `follow` has them for the faces around it."""
    lenses = follow(maps, f, np.flatnonzero((f == vertex).any(axis=1)), aim, power, facing)
    return [replace(lens, place=x[vertex]) for lens, x in zip(lenses, maps, strict=True)]


def look_at(
    x: FloatArray, faces: IntArray, face: float = 0.1, most: float = 0.6, within: float = 95
) -> Lens:
    """Lens on faces of a map, given as rows of vertex indices.

    One face takes the angle `face` to each side of the place, k faces sqrt(k) as much, so that faces of all clusters
    look equally large, but no more than `most`. The rest of the view shows their surroundings. That percentage of the
    corners lies within; others may be the ends of long faces.
    """
    corners = x[np.unique(faces)]
    place = corners[int(np.argmax(corners @ corners.mean(axis=0)))]
    # 2 tan of half the angle
    radius = float(np.percentile(np.abs(to_chart(corners, place[None])), within))
    spread = min(most, face * float(np.sqrt(len(faces))))
    fitting, filling = (
        float(np.clip(2 * np.tan(angle / 2) / max(radius, TINY), 1.0, STRONGEST))
        for angle in (spread, np.pi / 2)
    )
    return Lens(place, fitting, limit=filling)
