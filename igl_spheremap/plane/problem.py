"""Newton steps over maps of a disk to the plane: on a circle, or with a free boundary."""

from __future__ import annotations

import numpy as np

from ..mesh.arrays import BoolArray, FloatArray, IntArray
from ..mesh.disk import Disk
from ..mesh.edges import half_edges_from
from ..newton.faces import FaceEnergy, FaceProblem
from ..newton.loop import CONDITIONS, Model, Trial
from ..verify.rim import plane_signs, rim_crossings, rim_meetings

#: Radius of the disk whose area is that of `FlatFaces`, 4 pi.
RADIUS = 2.0


class CircleProblem(FaceProblem):
    """Lower an energy over maps to the disk of radius 2, whose boundary vertices move along the circle."""

    def __init__(self, energy: FaceEnergy, disk: Disk) -> None:
        super().__init__(energy)
        self._rim = np.zeros(len(disk.v), dtype=bool)
        self._rim[disk.rim] = True

    def axes(self, x: FloatArray) -> FloatArray:
        """The two coordinate axes; at the boundary the circle's tangent, and a zero vector."""
        axes = _coordinates(len(x))
        axes[0][:, self._rim] = np.stack((-x[self._rim, 1], x[self._rim, 0])) / RADIUS
        axes[1][:, self._rim] = 0
        return axes

    def model(self, x: FloatArray) -> Model:
        """The model of the plane, with an entry for the unknowns that move nothing."""
        model = super().model(x)
        at_vertices = np.zeros((2, 2, len(x)))
        at_vertices[1, 1, self._rim] = 1
        return Model(model.value, model.axes, model.gradient, model.blocks, at_vertices)

    def onto(self, points: FloatArray, rows: BoolArray | slice) -> FloatArray:
        """Boundary vertices back on the circle."""
        rim = self._rim[rows]
        points[rim] *= RADIUS / np.hypot(points[rim, 0], points[rim, 1])[:, None]
        return points

    def folded(self, x: FloatArray, faces: IntArray | slice) -> BoolArray:
        """Faces that are not positive."""
        return np.asarray(plane_signs(x, self.energy.f[faces]) <= 0)


class FreeProblem(FaceProblem):
    """Lower an energy over maps to the plane whose boundary is free, and crosses itself nowhere."""

    def __init__(self, energy: FaceEnergy, disk: Disk) -> None:
        super().__init__(energy)
        self._rim = disk.rim
        # The face of each edge of the boundary, in its order.
        self._at_rim = half_edges_from(disk.f, len(disk.v), disk.rim, np.roll(disk.rim, -1)) // 3

    def axes(self, x: FloatArray) -> FloatArray:
        """The two coordinates."""
        return _coordinates(len(x))

    def onto(self, points: FloatArray, rows: BoolArray | slice) -> FloatArray:
        """The points themselves."""
        return points

    def folded(self, x: FloatArray, faces: IntArray | slice) -> BoolArray:
        """Faces that are not positive, and those at edges where the boundary crosses itself."""
        folded = np.zeros(len(self.energy.f), dtype=bool)
        folded[faces] = plane_signs(x, self.energy.f[faces]) <= 0
        folded[self._at_rim[rim_crossings(x, self._rim)]] = True
        return folded[faces]

    def accept(self, x: FloatArray, move: FloatArray) -> Trial:
        """That of all faces; if it fails, with the speeds of separation of edges that would meet."""
        trial = super().accept(x, move)
        if np.isfinite(trial.value):
            return trial
        meetings = rim_meetings(x + move, self._rim)
        if not 0 < len(meetings) <= CONDITIONS:
            return trial
        return trial._replace(apart=np.array([self._apart(x, i, j) for i, j in meetings]))

    def _apart(self, x: FloatArray, i: int, j: int) -> FloatArray:
        """The speed (2, n) at which the nearest points of two edges of the boundary move apart."""
        rim, k = self._rim, len(self._rim)
        least, speed = np.inf, np.zeros((2, len(x)))
        for corner, edge in ((i, j), (i + 1, j), (j, i), (j + 1, i)):
            v, a, b = rim[corner % k], rim[edge], rim[(edge + 1) % k]
            if v in (a, b):
                continue
            along = x[b] - x[a]
            t = np.clip((x[v] - x[a]) @ along / (along @ along), 0, 1)
            gap = x[v] - x[a] - t * along
            distance = np.hypot(*gap)
            if distance < least:
                least, speed = distance, np.zeros((2, len(x)))
                speed[:, [v, a, b]] = gap[:, None] / distance * [1, t - 1, -t]
        return speed


def _coordinates(n: int) -> FloatArray:
    return np.repeat(np.eye(2)[:, :, None], n, axis=2)
