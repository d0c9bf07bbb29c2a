"""A conformal zoom: a Moebius map lets the sphere swell at one place and turns that place to the viewer."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from ...mesh.arrays import FloatArray, IntArray
from ...sphere.charts import from_chart, to_chart

#: Angle that most of a large cluster takes to each side of the place: the rest of the view shows what is around it.
_SPREAD = 0.6
#: Angle for one face; a cluster of k faces takes sqrt(k) as much, so that faces of all clusters look equally large.
_FACE = 0.1
#: Percentage of the corners of a cluster within that angle; the rest may be the ends of long faces.
_REACH = 95
#: Beyond this the rounding of float64 shows.
_STRONGEST = 1e9


@dataclass(frozen=True, eq=False)
class Lens:
    """Moebius map that magnifies angles at a unit vector `place` by `power`, with the place towards +z."""

    place: FloatArray = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    power: float = 1.0

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
        """Rows to the right, up and to the place: the shortest turn of the place to +z."""
        p, z = self.place, np.array([0.0, 0.0, 1.0])
        if p[2] < -1 + 1e-12:
            return np.diag([-1.0, 1.0, -1.0])
        return np.eye(3) - np.outer(p + z, p + z) / (1 + p[2]) + 2 * np.outer(z, p)


def follow(x: FloatArray, f: IntArray, folded: IntArray) -> Lens:
    """Lens on the largest cluster of folded faces; the plain view where there is none."""
    return look_at(x, f[folded[clusters(f[folded])[0]]]) if len(folded) else Lens()


def look_at(x: FloatArray, faces: IntArray) -> Lens:
    """Lens on faces of a map, given as rows of vertex indices."""
    corners = x[np.unique(faces)]
    place = corners[int(np.argmax(corners @ corners.mean(axis=0)))]
    radius = float(np.percentile(np.abs(to_chart(corners, place[None])), _REACH))  # 2 tan of half the angle
    spread = min(_SPREAD, _FACE * float(np.sqrt(len(faces))))
    return Lens(place, float(np.clip(2 * np.tan(spread / 2) / max(radius, 1e-300), 1.0, _STRONGEST)))


def clusters(faces: IntArray) -> list[IntArray]:
    """Indices of faces, given as rows of vertex indices, that are connected by shared vertices; the largest set first.

    >>> [one.tolist() for one in clusters(np.array([[5, 6, 7], [0, 1, 2], [2, 3, 4]]))]
    [[1, 2], [0]]
    """
    names, local = np.unique(faces, return_inverse=True)
    local = local.reshape(-1, 3)
    tail, head = local[:, [0, 1]].ravel(), local[:, [1, 2]].ravel()
    links = coo_matrix((np.ones(len(tail), dtype=bool), (tail, head)), shape=(len(names), len(names)))
    label = connected_components(links, directed=False)[1][local[:, 0]]
    return sorted((np.flatnonzero(label == one) for one in np.unique(label)), key=len, reverse=True)
