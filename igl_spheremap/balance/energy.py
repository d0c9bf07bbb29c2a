"""The balanced energy of a map, angles against areas face by face; margins carry the numbers of docs/balance.md."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..mesh.arrays import FloatArray, IntArray
from ..newton.system import PAIRS
from .flat_faces import FaceImages, FlatFaces, log_areas


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
        """Energies of the given faces; infinite for a folded one."""
        images = self.images(x, faces)
        free = images.s2 > 0
        s1, s2 = images.s1, np.where(free, images.s2, 1.0)
        with np.errstate(over="ignore", invalid="ignore"):  # a bad trial step
            angles, areas = self.phi(s1 / s2), self.phi(s1 * s2 / self.aim[faces])  # balance (2)
            # balance (3)
            value = self.area[faces] * ((1 - self.weight) * angles + self.weight * areas)
        return np.where(free, value, np.inf)

    def area_error(self, x: FloatArray) -> float:
        """Mean of |p - target| over the source's area."""
        return float(
            (self.area * np.abs(log_areas(self.source, x) - self.target)).sum() / self.area.sum()
        )

    def phi(self, ratio: FloatArray) -> FloatArray:
        """u^2, or 2 (cosh(k u) - 1) / k^2, of the logarithm u of a ratio, docs/balance.md (4)."""
        if self.power == 0:
            return np.log(ratio) ** 2
        power = ratio**self.power
        return np.asarray((power - 1) ** 2 / (power * self.power**2))  # balance (4)

    def slopes(self, ratio: FloatArray) -> tuple[FloatArray, FloatArray]:
        """First and second derivative of phi by u."""
        if self.power == 0:
            return 2.0 * np.log(ratio), np.full_like(ratio, 2.0)
        power = ratio**self.power
        return (power - 1 / power) / self.power, power + 1 / power

    def derivatives(
        self, x: FloatArray, axes: FloatArray, convex: bool = True
    ) -> tuple[FloatArray, FloatArray]:
        """Gradient (k, n) as vertices of a map without foldings move along axes (k, d, n), and the Hessian's blocks.

        The blocks (6, k, k, m) belong to the corner pairs `PAIRS`; `convex` projects the Hessian of each face. It is
        that of the flat triangles, without the turns of axes on the sphere.
        """
        m, corners, images = len(self.f), self.source.corners, self.images(x)
        gradient, blocks = np.empty((len(axes), 3, m)), np.empty((6, len(axes), len(axes), m))
        block = (
            8192  # faces at a time stay in the processor's cache: half of the time of a large mesh
        )
        for first in range(0, m, block):
            chunk = slice(first, first + block)
            moves = axes.take(corners[:, chunk], axis=2)
            modes, slopes, curvatures, mix = self._modes(images.some(chunk), moves, chunk, convex)
            np.einsum("km,kaim->aim", slopes, modes[:2], out=gradient[:, :, chunk])
            modes[0] += mix * modes[1]
            modes *= np.sqrt(np.abs(curvatures))[:, None, None]
            left = modes
            if not convex:
                left = np.sign(curvatures)[:, None, None] * modes
            for k, (i, j) in enumerate(PAIRS):
                np.einsum("kam,kbm->abm", left[:, :, i], modes[:, :, j], out=blocks[k, :, :, chunk])
        corner = corners.ravel()
        return np.stack(
            [np.bincount(corner, part.ravel(), self.source.n) for part in gradient]
        ), blocks

    def _modes(
        self,
        images: FaceImages,
        axes: FloatArray,
        chunk: slice,
        convex: bool,
        floor: float = 1e-3,
        twist_floor: float = 0.05,
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Modes of some faces, slopes along the two stretches, and the Hessian's curvatures (4, m) along the modes.

        The first curvature is that of mode 0 with `mix` times mode 1 added to it. Curvatures of a `convex` model are
        raised to a share of phi'', the `floor`. That of a twist is larger: a rotation costs no energy, but as vertices
        move along straight lines it strains faces by the square of its angle.
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
        round_face = half < 1e-6  # rounding decides the quotient in (8): the limit is taken
        twist = p1 - q1 * half  # balance (7)
        # balance (8)
        shear = np.where(round_face, 2 * q2, q1 / np.where(round_face, 1.0, half)) - p1
        if convex:
            h11, h22, h12 = _raised(h11, h22, h12, floor * (p2 + q2))
            twist = np.maximum(twist, twist_floor * (p2 + q2))
            shear = np.maximum(shear, floor * (p2 + q2))
        mix = h12 / h11
        return (
            images.modes(axes),
            area * np.stack((r1, r2)),
            area * np.stack((h11, h22 - mix * h12, twist, shear)),
            mix,
        )


def _raised(
    h11: FloatArray, h22: FloatArray, h12: FloatArray, least: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Symmetric 2 by 2 matrices, their eigenvalues raised to `least`."""
    mean, half = (h11 + h22) / 2, (h11 - h22) / 2
    radius = np.sqrt(half * half + h12 * h12)
    low, high = np.maximum(mean - radius, least), np.maximum(mean + radius, least)
    ratio = (high - low) / np.where(radius > 0, 2 * radius, 1.0)
    centre = (high + low) / 2
    return centre + ratio * half, centre - ratio * half, ratio * h12
