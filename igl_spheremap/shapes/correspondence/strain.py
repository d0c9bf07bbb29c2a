"""The strain of a map from one surface to another, as an energy of maps to the other one's sphere."""

from __future__ import annotations

from typing import TypeVar

import numpy as np

from ...balance.energy import BalancedEnergy
from ...balance.flat_faces import FaceImages, FlatFaces
from ...mesh.arrays import FloatArray, IntArray
from ...newton.system import PAIRS
from ...sphere.rows import row_crosses, row_dots
from .fits import SphereFunction
from .levels import Level

E = TypeVar("E", bound=BalancedEnergy)


def linear_function(level: Level, values: FloatArray) -> SphereFunction:
    """Make a function on the sphere of values (n, d) over a surface, linear in its faces, as are its gradients."""

    def at(y: FloatArray) -> tuple[FloatArray, FloatArray]:
        there, corners = level.at(y, values), level.map.faces[level.locate(y).face]
        # With a' = det(y, b, c) / det(a, b, c) and so on for b and c, weights are these over their sum. Differences
        # from y keep digits in faces of any size.
        a, b, c = (level.map.sphere[corners[:, k]] - y for k in range(3))
        normal = row_crosses(b - a, c - a)
        total = row_dots(normal, y)  # det(a, b, c) times the sum of the a'
        changes = np.stack(
            [row_crosses(y, q - p) + row_crosses(p, q) for p, q in ((b, c), (c, a), (a, b))], axis=1
        )
        changes /= total[:, None, None]
        return there, np.einsum("nkd,nkj->ndj", values[corners] - there[:, None], changes)

    return at


class SpaceStrain(BalancedEnergy):
    """The balanced energy of triangles in a space of any dimension, `x` the positions (n, d) of their corners."""

    def images(self, x: FloatArray, faces: IntArray | slice = slice(None)) -> FaceImages:
        """Images of the given faces, each in its plane."""
        if isinstance(faces, slice):
            return self.source.images(x, spanned=True).some(faces)
        return FaceImages.spanned(self.source, x, faces)

    def derivatives(
        self, x: FloatArray, axes: FloatArray, convex: bool = True
    ) -> tuple[FloatArray, FloatArray]:
        """Gradient (k, n) as vertices move along axes (k, d, n), and the Hessian's blocks.

        To those within the plane come moves across it, which stretch a face by their squares.
        """
        gradient, blocks = super().derivatives(x, axes, convex)
        images = self.images(x)
        (left, right), s = images.frame(), np.stack((images.s1, images.s2))
        q, p = (self.weight * self.slopes(each)[0] for each in (s[0] / s[1], s[0] * s[1]))
        tension = self.area * np.maximum(np.stack((p + q, p - q)), 0.0) / s**2
        moves = axes.take(self.source.corners, axis=2)
        for direction in left:
            moves = (
                moves - np.einsum("acim,cm->aim", moves, direction)[:, None] * direction[:, None]
            )
        for k, (i, j) in enumerate(PAIRS):
            share = (tension * right[:, i] * right[:, j]).sum(axis=0)
            blocks[k] += share * np.einsum("acm,bcm->abm", moves[:, :, i], moves[:, :, j])
        return gradient, blocks


def sphere_strain(level: Level) -> BalancedEnergy:
    """Make the strain of maps of a level's sphere to itself."""
    return _strain(BalancedEnergy, level.map.sphere, level.map.faces)


def _strain(kind: type[E], p: FloatArray, f: IntArray, power: int = 1) -> E:
    """An energy of maps of faces in which angles and areas count alike, by MIPS and J + 1/J."""
    return kind(FlatFaces.of(p, f), 0.5, power, np.zeros(len(f)))


class ComposedStrain:
    """Strain of the source's faces on the target, plus a share of the strain of its sphere.

    The first one can't tell a face from its mirror image; the second one is infinite for a folded face. Metrics of
    sphere and surface are blended on either side.

    Parameters
    ----------
    source, target : Level
        The surfaces.
    share : float
        Of the surfaces' metrics: at 0 rotations are minima, at 1 the spheres have no part.
    guard : float
        Weight of the sphere's own strain.
    """

    def __init__(self, source: Level, target: Level, share: float, guard: float) -> None:
        self.f, self._guard = source.map.faces, guard
        self._strain = _strain(SpaceStrain, _blended(source, share), source.map.faces)
        self._sphere = sphere_strain(source)
        self._target, self._there = target, _scaled(_blended(target, share), target.map.faces)

    @property
    def area(self) -> FloatArray:
        """Areas of the source's faces, 4 pi together."""
        return self._strain.area

    def by_face(self, y: FloatArray, faces: IntArray | slice = slice(None)) -> FloatArray:
        """Energies of the given faces; infinite for a folded one."""
        if isinstance(faces, slice):
            everywhere = self._target.at(y, self._there)
        else:
            used = np.unique(self.f[faces])
            there = self._target.at(y[used], self._there)
            everywhere = np.zeros((len(y), there.shape[1]))
            everywhere[used] = there
        own = self._sphere.by_face(y, faces)
        return self._strain.by_face(everywhere, faces) + self._guard * own

    def derivatives(self, y: FloatArray, axes: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Gradient (2, n) and positive semidefinite blocks (6, 2, 2, m) along the vertices' axes (2, 3, n)."""
        there, gradients = linear_function(self._target, self._there)(y)
        gradient, blocks = self._strain.derivatives(
            there, np.einsum("ndj,ajn->adn", gradients, axes)
        )
        own = self._sphere.derivatives(y, axes)
        return gradient + self._guard * own[0], blocks + self._guard * own[1]


def log_strain(source: Level, target: Level, y: FloatArray) -> float:
    """Sum the squared logarithms of stretches from source to target: single faces of high strain count little."""
    strain = _strain(SpaceStrain, source.metric, source.map.faces, power=0)
    return float(strain.by_face(target.at(y, _scaled(target.metric, target.map.faces))).sum())


def _blended(level: Level, share: float) -> FloatArray:
    """Return positions whose squared lengths are the weighted mean of those of the sphere and of the surface."""
    v = _scaled(level.metric, level.map.faces)
    if share == 1:
        return v
    return np.column_stack((np.sqrt(1 - share) * level.map.sphere, np.sqrt(share) * v))


def _scaled(p: FloatArray, f: IntArray) -> FloatArray:
    """Scale positions of any dimension so that the faces have the area 4 pi together."""
    a, b = (p[f[:, k]] - p[f[:, 0]] for k in (1, 2))
    doubled = np.sqrt(np.maximum(row_dots(a, a) * row_dots(b, b) - row_dots(a, b) ** 2, 0))
    return p * np.sqrt(8 * np.pi / doubled.sum())
