"""The balanced energy of a map, angles against areas face by face; margins carry the numbers of docs/balance.md."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import igl
import numpy as np

from ..mesh.arrays import FloatArray, IntArray
from ..newton.system import PAIRS
from ..operators.laplacian import mollified_edge_lengths
from ..sphere.rows import column_crosses

#: Faces at a time: what they need stays in the processor's cache, which halves the time of a large mesh.
_CHUNK = 8192
#: Eigenvalues of a face's Hessian, in logarithms of stretches, are raised to this share of phi''.
_FLOOR = 1e-3
#: A twist's curvature is raised to this share: a rotation costs no energy, but as vertices move along straight lines
#: it strains faces by the square of its angle.
_TWIST_FLOOR = 0.05
#: Where tanh(q / 2) is below this, rounding decides the quotient in (8), and the limit for round faces is taken.
_ROUND = 1e-6


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
    _known: list[tuple[FloatArray, FaceImages]] = field(default_factory=list, init=False, repr=False)

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
        return cls(f, len(v), area, np.array([[1 / c, np.zeros_like(c)], [-cot / c, c / (2 * area)]]))

    @cached_property
    def corners(self) -> IntArray:
        """Vertices at the corners, (3, m)."""
        return np.ascontiguousarray(self.f.T)

    def images(self, x: FloatArray) -> FaceImages:
        """Images of all faces; those of the last map are known, so that an array that was a map must not change."""
        for y, images in self._known:
            if y is x:
                return images
        self._known[:] = [(x, FaceImages.of(self, x))]
        return self._known[0][1]


@dataclass(frozen=True, eq=False)
class BalancedEnergy:
    """Sum over the faces of a [(1 - w) phi(q) + w phi(p - target)], docs/balance.md (3).

    Attributes
    ----------
    source : FlatFaces
        The mesh.
    weight : float
        w in [0, 1]: 0 counts angles only, 1 areas only.
    power : float
        k of phi: 0 for squares of logarithms, 1 for MIPS and J + 1/J; above 0 a fold costs infinitely much.
    target : (m,) float64 array
        Logarithm of image area over source area that each face is to have.
    """

    source: FlatFaces
    weight: float
    power: float
    target: FloatArray

    @property
    def f(self) -> IntArray:
        """Faces."""
        return self.source.f

    @property
    def area(self) -> FloatArray:
        """Areas of the source's faces."""
        return self.source.area

    @cached_property
    def aim(self) -> FloatArray:
        """Share of its source area that each face is to have in the image."""
        return np.exp(self.target)

    def evaluate(self, x: FloatArray) -> tuple[float, FloatArray]:
        """Value at `x` and the array of its derivatives by the coordinates, of its shape."""
        d = x.shape[1]
        identity = np.broadcast_to(np.eye(d)[:, :, None], (d, d, len(x)))
        return float(self.by_face(x).sum()), self.derivatives(x, identity)[0].T

    def images(self, x: FloatArray, faces: IntArray | slice = slice(None)) -> FaceImages:
        """Images of the given faces."""
        if isinstance(faces, slice):
            return self.source.images(x).some(faces)
        return FaceImages.of(self.source, x, faces)

    def by_face(self, x: FloatArray, faces: IntArray | slice = slice(None)) -> FloatArray:
        """Energies of the given faces; infinite where one is folded."""
        images = self.images(x, faces)
        free = images.s2 > 0
        s1, s2 = images.s1, np.where(free, images.s2, 1.0)
        with np.errstate(over="ignore", invalid="ignore"):  # a bad trial step
            angles, areas = self.phi(s1 / s2), self.phi(s1 * s2 / self.aim[faces])  # balance (2)
            value = self.area[faces] * ((1 - self.weight) * angles + self.weight * areas)  # balance (3)
        return np.where(free, value, np.inf)

    def area_error(self, x: FloatArray) -> float:
        """Mean of |p - target| over the source's area."""
        return float((self.area * np.abs(log_areas(self.source, x) - self.target)).sum() / self.area.sum())

    def phi(self, ratio: FloatArray) -> FloatArray:
        """u^2, or 2 (cosh(k u) - 1) / k^2, of the logarithm u of a ratio, docs/balance.md (4)."""
        if self.power == 0:
            return np.asarray(np.log(ratio) ** 2)
        power = ratio**self.power
        return np.asarray((power - 1) ** 2 / (power * self.power**2))  # balance (4)

    def slopes(self, ratio: FloatArray) -> tuple[FloatArray, FloatArray]:
        """First and second derivative of phi by u."""
        if self.power == 0:
            return 2.0 * np.log(ratio), np.full_like(ratio, 2.0)
        power = ratio**self.power
        return (power - 1 / power) / self.power, power + 1 / power

    def derivatives(self, x: FloatArray, axes: FloatArray, convex: bool = True) -> tuple[FloatArray, FloatArray]:
        """Gradient (k, n) as vertices of a map without foldings move along axes (k, d, n), and the Hessian's blocks.

        The blocks (6, k, k, m) belong to the corner pairs `PAIRS`; `convex` projects the Hessian of each face. It is
        that of the flat triangles: it leaves out how axes turn on the sphere.
        """
        m, corners, images = len(self.f), self.source.corners, self.images(x)
        gradient, blocks = np.empty((len(axes), 3, m)), np.empty((6, len(axes), len(axes), m))
        for first in range(0, m, _CHUNK):
            chunk = slice(first, first + _CHUNK)
            moves = axes.take(corners[:, chunk], axis=2)
            modes, slopes, curvatures, mix = self._modes(images.some(chunk), moves, chunk, convex)
            np.einsum("km,kaim->aim", slopes, modes[:2], out=gradient[:, :, chunk])
            modes[0] += mix * modes[1]
            modes *= np.sqrt(np.abs(curvatures))[:, None, None]
            left = modes if convex else np.sign(curvatures)[:, None, None] * modes
            for k, (i, j) in enumerate(PAIRS):
                np.einsum("kam,kbm->abm", left[:, :, i], modes[:, :, j], out=blocks[k, :, :, chunk])
        corner = corners.ravel()
        return np.stack([np.bincount(corner, part.ravel(), self.source.n) for part in gradient]), blocks

    def _modes(self, images: FaceImages, axes: FloatArray, chunk: slice,
               convex: bool) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Modes of some faces, slopes along the two stretches, and the Hessian's curvatures (4, m) along the modes.

        The first curvature is that of mode 0 with `mix` times mode 1 added to it.
        """
        area = self.area[chunk]
        s1, s2, w = images.s1, images.s2, self.weight
        q1, q2 = ((1 - w) * slope for slope in self.slopes(s1 / s2))
        p1, p2 = (w * slope for slope in self.slopes(s1 * s2 / self.aim[chunk]))
        r1, r2 = p1 + q1, p1 - q1  # balance (5)
        h11, h22, h12 = p2 + q2, p2 + q2, p2 - q2  # balance (6)
        if self.power or not convex:
            h11, h22 = h11 - r1, h22 - r2
        half = (s1 - s2) / (s1 + s2)  # tanh(q / 2)
        round_face = half < _ROUND
        twist = p1 - q1 * half  # balance (7)
        shear = np.where(round_face, 2 * q2, q1 / np.where(round_face, 1.0, half)) - p1  # balance (8)
        if convex:
            h11, h22, h12 = _raised(h11, h22, h12, _FLOOR * (p2 + q2))
            twist = np.maximum(twist, _TWIST_FLOOR * (p2 + q2))
            shear = np.maximum(shear, _FLOOR * (p2 + q2))
        mix = h12 / h11
        return (images.modes(axes), area * np.stack((r1, r2)), area * np.stack((h11, h22 - mix * h12, twist, shear)),
                mix)


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
    def of(cls, source: FlatFaces, x: FloatArray, faces: IntArray | slice = slice(None)) -> FaceImages:
        """Images of some faces of a map."""
        p = np.ascontiguousarray(x.T).take(source.corners[:, faces], axis=1)  # coordinate, corner, face
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
        v = np.stack((-u[1], u[0])) if len(p) == 2 else column_crosses(outward, u)
        across, up = _dots(sides[:, 1], u), _dots(sides[:, 1], v)
        return cls._laid(hats, area, (first, across, up), heights / np.where(length > 0, length, 1.0), (u, v))

    @classmethod
    def spanned(cls, source: FlatFaces, p: FloatArray, faces: IntArray | slice = slice(None)) -> FaceImages:
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
        return cls._laid(source.hats[:, :, faces], source.area[faces], (first, across, up),
                         np.zeros((2, len(first))), (u, v))

    @classmethod
    def _laid(cls, hats: FloatArray, area: FloatArray, corners: tuple[FloatArray, FloatArray, FloatArray],
              heights: FloatArray, plane: tuple[FloatArray, FloatArray]) -> FaceImages:
        """Images whose corner 1 lies at (first, 0), and corner 2 at (across, up)."""
        first, across, up = corners
        straight, turned = first * hats[:, 0] + across * hats[:, 1], up * hats[:, 1]
        alpha, beta = ((straight[0] + turned[1], turned[0] - straight[1]),
                       (straight[0] - turned[1], turned[0] + straight[1]))
        sizes = [np.sqrt(real * real + imag * imag) for real, imag in (alpha, beta)]
        s1 = (sizes[0] + sizes[1]) / 2
        s2 = first * up / (2 * area * np.where(s1 > 0, s1, 1.0))  # balance (1)
        return cls(s1, s2, hats, heights, plane, (*alpha, sizes[0]), (*beta, sizes[1]))

    def some(self, faces: slice) -> FaceImages:
        """Those of some faces."""
        def cut(part: Any) -> Any:
            return part[..., faces] if isinstance(part, np.ndarray) else tuple(map(cut, part))

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
        hats = np.stack((-self.hats[:, 0] - self.hats[:, 1], self.hats[:, 0], self.hats[:, 1]), axis=1) - turn[:, None]
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
    return np.asarray(np.log(np.maximum(images.s1 * images.s2, np.finfo(float).tiny)))


def _dots(a: FloatArray, b: FloatArray) -> FloatArray:
    """Inner products of columns."""
    return np.einsum("cm,cm->m", a, b)


def _raised(h11: FloatArray, h22: FloatArray, h12: FloatArray,
            least: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Symmetric 2 by 2 matrices, their eigenvalues raised to `least`."""
    mean, half = (h11 + h22) / 2, (h11 - h22) / 2
    radius = np.sqrt(half * half + h12 * h12)
    low, high = np.maximum(mean - radius, least), np.maximum(mean + radius, least)
    ratio = (high - low) / np.where(radius > 0, 2 * radius, 1.0)
    centre = (high + low) / 2
    return centre + ratio * half, centre - ratio * half, ratio * h12
