"""A mesh's faces laid flat, and the linear maps from them to their images, by singular values."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import igl
import numpy as np

from ..mesh.arrays import TINY, FloatArray, IntArray
from ..operators.laplacian import mollified_edge_lengths
from ..sphere.rows import column_crosses


@dataclass(frozen=True, eq=False)
class FlatFaces:
    """A mesh's faces, each laid flat; their area is 4 pi, that of the unit sphere.

    Attributes
    ----------
    f : (m, 3) int64 array
        Faces.
    n : int
        Number of vertices.
    area : (m,) float64 array
        Areas of the faces, none zero.
    hats : (2, 2, m) float64 array
        Gradients (coordinate, corner, face) of the hat functions of corners 1 and 2 in the plane of the face.
    """

    f: IntArray
    n: int
    area: FloatArray
    hats: FloatArray
    _known: list[tuple[FloatArray, bool, FaceImages]] = field(
        default_factory=list, init=False, repr=False
    )

    @classmethod
    def of(cls, v: FloatArray, f: IntArray) -> FlatFaces:
        """Lay every face flat by its edge lengths, mollified so that no area is zero."""
        lengths = np.asarray(mollified_edge_lengths(v, f))
        area = np.asarray(igl.doublearea(l=lengths, nan_replacement=0.0)) / 2
        scale = np.sqrt(4 * np.pi / area.sum())
        c = lengths[:, 2] * scale  # between corners 0 and 1
        area = area * scale**2
        cot = 2 * np.asarray(igl.cotmatrix_entries(l=lengths))[:, 0]
        # Corner 0 lies at the origin, corner 1 at (c, 0), corner 2 at h (cot_0, 1) with h = 2 area / c.
        return cls(
            f, len(v), area, np.array([[1 / c, np.zeros_like(c)], [-cot / c, c / (2 * area)]])
        )

    @cached_property
    def corners(self) -> IntArray:
        """Vertices at the corners, (3, m)."""
        return np.ascontiguousarray(self.f.T)

    def images(self, x: FloatArray, spanned: bool = False) -> FaceImages:
        """Images of all faces, each in its own plane if `spanned`.

        The images of the last map are kept, so an array that was given as a map must not be changed.
        """
        for y, way, images in self._known:
            if y is x and way == spanned:
                return images
        if spanned:
            found = FaceImages.spanned(self, x)
        else:
            found = FaceImages.of(self, x)
        self._known[:] = [(x, spanned, found)]
        return found


@dataclass(frozen=True, eq=False)
class FaceImages:
    """Images of flat faces, and the singular values of the maps to them.

    Faces on the sphere, rows of three coordinates, are each projected along their centroid; faces in the plane, rows of
    two, are taken as they are.

    With corner 0 of both at the origin, a face's map is z -> (alpha z + beta conj(z)) / 2 in complex numbers::

        alpha = (s1 + s2) exp(i (left + right)),   beta = (s1 - s2) exp(i (left - right)),
        s1 = (|alpha| + |beta|) / 2,   s2 = b / (a s1),   map = turn(left) diag(s1, s2) turn(right)
    """

    s1: FloatArray
    s2: FloatArray
    hats: FloatArray
    heights: FloatArray  # of corners 1 and 2 above corner 0, over the length of the corners' sum
    plane: tuple[FloatArray, FloatArray]  # two directions, (3, m) or (2, m) each
    alpha: tuple[FloatArray, FloatArray, FloatArray]  # real and imaginary part, and size
    beta: tuple[FloatArray, FloatArray, FloatArray]

    @classmethod
    def of(
        cls, source: FlatFaces, x: FloatArray, faces: IntArray | slice = slice(None)
    ) -> FaceImages:
        """Images of some faces of a map."""
        # coordinate, corner, face
        p = np.ascontiguousarray(x.T).take(source.corners[:, faces], axis=1)
        hats, area = source.hats[:, :, faces], source.area[faces]
        sides = p[:, 1:] - p[:, :1]
        if len(p) == 2:  # in the plane
            u, heights, length = sides[:, 0].copy(), np.zeros_like(sides[0]), np.ones_like(area)
        else:
            outward = p.sum(axis=1)
            length = np.sqrt(_dots(outward, outward))
            outward /= np.where(length > 0, length, 1.0)
            heights = np.einsum("cim,cm->im", sides, outward)
            u = sides[:, 0] - heights[0] * outward
        first = np.sqrt(_dots(u, u))
        u /= np.where(first > 0, first, 1.0)
        if len(p) == 2:
            v = np.stack((-u[1], u[0]))
        else:
            v = column_crosses(outward, u)
        across, up = _dots(sides[:, 1], u), _dots(sides[:, 1], v)
        return cls._laid(
            hats, area, (first, across, up), heights / np.where(length > 0, length, 1.0), (u, v)
        )

    @classmethod
    def spanned(
        cls, source: FlatFaces, p: FloatArray, faces: IntArray | slice = slice(None)
    ) -> FaceImages:
        """Some faces as flat triangles with corners in a space of any dimension, (n, d), each seen in its own plane."""
        q = np.ascontiguousarray(p.T).take(source.corners[:, faces], axis=1)
        sides = q[:, 1:] - q[:, :1]
        u, v = sides[:, 0], sides[:, 1]
        first = np.sqrt(_dots(u, u))
        u = u / np.where(first > 0, first, 1.0)
        across = _dots(v, u)
        v = v - across * u
        up = np.sqrt(_dots(v, v))
        v /= np.where(up > 0, up, 1.0)
        return cls._laid(
            source.hats[:, :, faces],
            source.area[faces],
            (first, across, up),
            np.zeros((2, len(first))),
            (u, v),
        )

    @classmethod
    def _laid(
        cls,
        hats: FloatArray,
        area: FloatArray,
        corners: tuple[FloatArray, FloatArray, FloatArray],
        heights: FloatArray,
        plane: tuple[FloatArray, FloatArray],
    ) -> FaceImages:
        """Images whose corner 1 lies at (first, 0), and corner 2 at (across, up)."""
        first, across, up = corners
        straight, turned = first * hats[:, 0] + across * hats[:, 1], up * hats[:, 1]
        alpha = straight[0] + turned[1], turned[0] - straight[1]
        beta = straight[0] - turned[1], turned[0] + straight[1]
        sizes = [np.sqrt(real * real + imag * imag) for real, imag in (alpha, beta)]
        s1 = (sizes[0] + sizes[1]) / 2
        s2 = first * up / (2 * area * np.where(s1 > 0, s1, 1.0))  # balance (1)
        return cls(s1, s2, hats, heights, plane, (*alpha, sizes[0]), (*beta, sizes[1]))

    def some(self, faces: slice) -> FaceImages:
        """The images of some of the faces."""

        def cut(part: Any) -> Any:
            if isinstance(part, np.ndarray):
                return part[..., faces]
            return tuple(map(cut, part))

        return FaceImages(*map(cut, vars(self).values()))

    def frame(self) -> tuple[tuple[FloatArray, FloatArray], FloatArray]:
        """Directions of the two singular vectors in the image, (d, m) each, and corners' hats along those of the
        source, (2, 3, m)."""
        (ar, ai, a), (br, bi, b) = self.alpha, self.beta
        sizes = np.where(b > 0, a * b, 1.0)
        real, imag = np.where(b > 0, (ar * br + ai * bi) / sizes, 1.0), (ai * br - ar * bi) / sizes
        # exp(i right) is one of the square roots of real + i imag; both will do.
        near = real >= 0
        cos, sin = np.where(near, 1 + real, imag), np.where(near, imag, 1 - real)
        unit = np.sqrt(cos * cos + sin * sin)
        cos, sin = cos / unit, sin / unit
        left_cos, left_sin = (cos * ar + sin * ai) / a, (cos * ai - sin * ar) / a
        u, v = self.plane
        # The plane of projection turns with the corners, by their sum's share across it.
        turn = self.heights[0] * self.hats[:, 0] + self.heights[1] * self.hats[:, 1]
        one, two = self.hats[:, 0], self.hats[:, 1]
        hats = np.stack((-one - two, one, two), axis=1) - turn[:, None]
        right = np.stack((cos * hats[0] - sin * hats[1], cos * hats[1] + sin * hats[0]))
        return (left_cos * u + left_sin * v, left_cos * v - left_sin * u), right

    def modes(self, axes: FloatArray) -> FloatArray:
        """Stretch 1, stretch 2, twist and shear (mode, axis, corner, face) as corners move along axes (k, d, 3, m).

        A mode is the relative change of the map in the frame of its singular vectors.
        """
        left, right = self.frame()
        along = [np.einsum("acim,cm->aim", axes, direction) for direction in left]
        mean = np.sqrt(2 * self.s1 * self.s2)
        modes = np.empty((4, *along[0].shape))
        np.multiply(along[0], right[0] / self.s1, out=modes[0])
        np.multiply(along[1], right[1] / self.s2, out=modes[1])
        across, back = along[0] * (right[1] / mean), along[1] * (right[0] / mean)
        np.subtract(across, back, out=modes[2])
        np.add(across, back, out=modes[3])
        return modes


def log_areas(source: FlatFaces, x: FloatArray) -> FloatArray:
    """Logarithm p of image area over source area by face, of a map free of foldings."""
    images = source.images(x)
    return np.log(np.maximum(images.s1 * images.s2, TINY))


def _dots(a: FloatArray, b: FloatArray) -> FloatArray:
    """Inner products of columns."""
    return np.einsum("cm,cm->m", a, b)
