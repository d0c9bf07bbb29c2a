"""Folded faces in connected clusters, and the clusters that a picture of some size does not show."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from ..mesh.arrays import BoolArray, FloatArray, IntArray
from ..mesh.measure import face_areas
from ..sphere.rows import row_crosses, row_lengths

#: A cluster of folded faces that colours fewer pixels than a square with this side gets a mark.
SEEN = 3
#: Folded faces that cover this share of a surface are seen as they are: marks, or they in front, would hide the rest.
MANY = 0.1
#: Folded faces of an image are drawn nearer to the viewer by this share of its radius: no face of it hides them.
NEARER = 0.1
#: Other folded faces, and all where they are many, are drawn nearer by this share: it keeps their colours from mixing
#: with those of faces at the same place.
ABOVE = 0.004


@dataclass(frozen=True, eq=False)
class Clusters:
    """Folded faces by clusters, that with the most faces first.

    ``faces`` (k,) are their indices, those of a cluster side by side; ``starts`` (c,) are the places of the first ones.
    """

    faces: IntArray
    starts: IntArray

    @classmethod
    def of(cls, f: IntArray, folded: IntArray) -> Clusters:
        """Clusters of faces of `f` whose indices are `folded`: those that share vertices belong together.

        >>> f = np.array([[5, 6, 7], [0, 1, 2], [8, 9, 0], [2, 3, 4]])
        >>> found = Clusters.of(f, np.array([0, 1, 3]))
        >>> [one.tolist() for one in found], found.sizes.tolist()
        ([[1, 3], [0]], [2, 1])
        """
        names, local = np.unique(f[folded], return_inverse=True)
        local = local.reshape(-1, 3)
        tail, head = local[:, [0, 1]].ravel(), local[:, [1, 2]].ravel()
        links = coo_matrix(
            (np.ones(len(tail), dtype=bool), (tail, head)), shape=(len(names), len(names))
        )
        label = connected_components(links, directed=False)[1][local[:, 0]]
        _, label, sizes = np.unique(label, return_inverse=True, return_counts=True)
        rank = np.empty(len(sizes), dtype=np.int64)
        rank[np.argsort(-sizes, kind="stable")] = np.arange(len(sizes))
        order = np.argsort(rank[label], kind="stable")
        return cls(
            folded[order], np.cumsum(np.append(0, np.sort(sizes)[::-1]))[:-1].astype(np.int64)
        )

    @property
    def sizes(self) -> IntArray:
        """Number of faces of each cluster."""
        return np.diff(self.starts, append=len(self.faces))

    def __len__(self) -> int:
        return len(self.starts)

    def __iter__(self) -> Iterator[IntArray]:
        return iter(np.split(self.faces, self.starts[1:])[: len(self)])

    def __getitem__(self, k: int) -> IntArray:
        """Indices of the faces of a cluster."""
        start = int(self.starts[k])
        return self.faces[start : start + int(self.sizes[k])]

    def sums(self, values: FloatArray) -> FloatArray:
        """Sums of values of the faces (k, ...) over each cluster (c, ...)."""
        if not len(self):
            return values
        return np.asarray(np.add.reduceat(values, self.starts, axis=0))


@dataclass(frozen=True, eq=False)
class Marks:
    """Clusters of folded faces as pictures mark them: their middles (c, 3), and vector areas (k, 3) and longest sides
    (k,) of their faces.

    If folded faces cover much of the surface, there are none. The vectors point out of the surface, whatever the
    orientation of the faces.
    """

    clusters: Clusters
    middles: FloatArray
    outward: FloatArray
    longest: FloatArray

    @classmethod
    def of(cls, x: FloatArray, f: IntArray, folded: IntArray, sphere: bool) -> Marks:
        """Marks of faces that are folded, on a map to the sphere or the plane z = 0, or on a surface."""
        areas = face_areas(x, f)
        if areas[folded].sum() >= MANY * areas.sum():
            folded = folded[:0]
        clusters = Clusters.of(f, folded)
        a, b, c = (x[f[clusters.faces, k]] for k in range(3))
        outward, middles = row_crosses(b - a, c - a) / 2, (a + b + c) / 3
        plane = not x[:, 2].any()
        if plane or sphere:  # of a map: a face that is flipped turns the other way
            way = middles / np.maximum(row_lengths(middles), 1e-300)[:, None]
            if plane:
                way = np.array([[0.0, 0.0, 1.0]])
            outward = row_lengths(outward)[:, None] * way
        longest = np.max(
            np.array([row_lengths(p - q) for p, q in ((a, b), (b, c), (c, a))]), axis=0
        )
        return cls(clusters, clusters.sums(middles) / clusters.sizes[:, None], outward, longest)

    def unseen(self, towards: FloatArray, pixels: float) -> tuple[FloatArray, BoolArray]:
        """Middles of the clusters that are too small or thin to be seen or turn away, and whether each faces the
        viewer.

        `towards` is the unit vector to the viewer; a unit of length takes `pixels` pixels.

        >>> x = np.array([[0.0, 0, 1], [0.1, 0, 1], [0, 0.1, 1], [-1, 0, 0], [0, -1, 0]])
        >>> marks = Marks.of(x, np.array([[0, 2, 1], [0, 3, 4]]), np.array([0]), sphere=True)
        >>> [len(marks.unseen(x[0], pixels)[0]) for pixels in (30, 300)], marks.unseen(-x[0], 300)[1].tolist()
        ([1, 0], [False])
        """
        facing = self.outward @ towards
        # at least a pixel: of thinner faces hardly any pixel is coloured
        wide = 2 * facing * pixels >= self.longest
        # the pixels whose middles it covers
        coloured = self.clusters.sums(np.where(wide, facing, 0)) * pixels**2
        front = self.clusters.sums(facing) >= 0
        small = coloured < SEEN**2
        return self.middles[small], front[small]
