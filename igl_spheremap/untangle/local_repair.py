"""Local repair of foldings, at a cost that depends on their surroundings only.

Thin faces fold when a vertex crosses their long side by a tiny distance: small moves of their corners put that right.
Vertices around other foldings are removed and put back (embedding.py). What moved is relaxed towards the mesh's angles.
"""

from __future__ import annotations

import numpy as np

from ..mesh.arrays import BoolArray, FloatArray, IntArray
from ..mesh.check import Mesh
from ..mesh.measure import surface_area
from ..sphere.moebius import fix_gauge
from ..sphere.rows import row_crosses, row_dets, row_dots, sizes, unit_rows, weighted_sum
from ..start.punctured import is_coarse
from ..verify.certificate import Certificate
from ..verify.distortion import mean_angle_difference
from ..verify.signs import folded_faces
from .embedding import RINGS, PositionsListener, dilate, fix_orientation, progressive_embedding
from .relax import AngleLoss, relax_angles

#: Share of the faces up to which foldings are few, and repaired where they are. Measured: with 1 percent folded that
#: leads to maps as good as from angles at a quarter of the cost, with 2 percent (hairy sphere) to 3.3 degrees instead
#: of 1.1. Other shares follow from it: relaxing ends when a sweep gains less than this; a map is worse than another
#: if its angle differences are larger by five times this, and useless if 25 times as many faces are folded.
FEW = 0.01
#: Angles up to this, .06 degrees, are small. Small moves give folded faces such angles, and targets of closed angles
#: are no smaller. A map whose centroid is farther than this from the origin is centred even if that folds faces.
SMALL_ANGLE = 1e-3
#: Small moves are longer than the shortest sufficient ones by this factor.
_OVER_RELAXATION = 1.3
#: Small moves end after so many rounds without progress. With 8 a part of 149 vertices ends at 25.9, not 22.8 degrees.
_PATIENCE = 25


def has_few_foldings(certificate: Certificate, f: IntArray) -> bool:
    """True if the foldings are to be repaired locally: at most one percent of the faces, and degree 1."""
    return certificate.foldings <= max(1.0, FEW * len(f)) and certificate.degree == 1


def repair_locally(mesh: Mesh, x: FloatArray, listener: PositionsListener | None = None,
                   sweeps: int = 30) -> FloatArray:
    """A map free of foldings: by small moves, by embedding where folds are left, and by relaxing what moved.

    `listener` is called with the map after each round of small moves, and after each batch of embedded vertices.
    """
    x = fix_orientation(x, mesh.f)
    y = progressive_embedding(small_moves(x, mesh.f, listener), mesh.f, listener)
    moved = dilate(mesh.f, (y != x).any(axis=1), RINGS)
    around = mesh.f[moved[mesh.f].any(axis=1)]
    return relax_angles(y, around, AngleLoss.of(mesh.v, around), moved, sweeps=sweeps, tolerance=FEW)


def unfolded(mesh: Mesh, x: FloatArray) -> FloatArray:
    """The map itself, or repaired locally if a face folds."""
    return repair_locally(mesh, x) if folded_faces(x, mesh.f).any() else x


def small_moves(x: FloatArray, f: IntArray, listener: PositionsListener | None = None) -> FloatArray:
    """Repair foldings by small moves of the vertices around them, where that succeeds.

    For each folded face the shortest move of its corners is computed that gives it a small positive area: a projection
    onto a half-space. Where several faces move a vertex, their moves are averaged. The iteration ends in the
    intersection of the half-spaces if it is not empty (Agmon 1954, *The Relaxation Method for Linear Inequalities*).

    >>> x = unit_rows(np.array([[0.1, 0, 1], [-0.1, 0, 1], [0, 0.2, 1], [0, 1e-6, 1], [0, -0.2, 1.0]]))
    >>> f = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 4], [3, 1, 4]])
    >>> folded_faces(x, f).tolist(), bool(folded_faces(small_moves(x, f), f).any())
    ([False, True, False, False], False)
    """
    bad = folded_faces(x, f)
    near = np.zeros(len(x), dtype=bool)
    near[f[bad]] = True
    near = dilate(f, near, RINGS)
    y, folded = x, f[bad]
    f = f[near[f].any(axis=1)]
    best, fewest, since = x, len(folded), 0
    while fewest and since < _PATIENCE:
        y = _projected(y, folded, near)
        if listener is not None:
            listener(y)
        folded = f[folded_faces(y, f)]
        best, fewest, since = (y, len(folded), 0) if len(folded) < fewest else (best, fewest, since + 1)
    return _without_failures(x, best, f)


def _without_failures(x: FloatArray, y: FloatArray, f: IntArray) -> FloatArray:
    """The moves from `x` to `y` except for those connected to foldings that are left."""
    moved = (x != y).any(axis=1)
    failed = np.zeros(len(x), dtype=bool)
    failed[f[folded_faces(y, f)]] = True
    while True:
        grown = failed | (dilate(f, failed, 1) & moved)
        if grown.sum() == failed.sum():
            return np.where(failed[:, None], x, y)
        failed = grown


def _projected(x: FloatArray, folded: IntArray, movable: BoolArray) -> FloatArray:
    """One step that moves all folded faces towards a little area each.

    Twice a face's area is det(o, q - p, r - p) with the outward unit vector o; it changes by o x (opposite side) as a
    corner moves.
    """
    p = [x.take(folded[:, k], axis=0) for k in range(3)]
    outward = p[0] + p[1] + p[2]
    reach = np.sqrt(row_dots(outward, outward))
    outward /= np.where(reach > 0, reach, 1.0)[:, None]
    side = [p[(k + 2) % 3] - p[(k + 1) % 3] for k in range(3)]
    size = sizes(np.abs(side[0]) + np.abs(side[1]))
    side = [s / size[:, None] for s in side]
    square = np.stack([row_dots(s, s) for s in side])
    slope = [row_crosses(outward, s) for s in side]
    lack = SMALL_ANGLE * square.max(axis=0) - row_dets(outward, side[1], side[2])
    length = size * lack / np.maximum(square.sum(axis=0), np.finfo(float).tiny)
    moved, corner, count = np.unique(folded.T, return_inverse=True, return_counts=True)
    moves = (length[:, None] * slope).reshape(-1, 3).T
    move = np.column_stack([np.bincount(corner.ravel(), part) for part in moves])
    y, kept = x.copy(), movable[moved]
    moved = moved[kept]
    y[moved] = unit_rows(x[moved] + _OVER_RELAXATION * move[kept] / count[kept, None])
    return y


def is_worse(mean: float, before: float) -> bool:
    """True if a mean angle difference is 5 percent above another: centring always changes angles a little."""
    return mean >= (1 + 5 * FEW) * before


def restore_gauge(mesh: Mesh, x: FloatArray, embed: bool = True) -> FloatArray:
    """Put a certified map back into the package's gauge, which the repair has left, and certify it again.

    Returns `x` itself where the Moebius map would fold it although its centroid is nearly at the origin, or at all
    unless `embed`, or would spoil the angles of huge faces.
    """
    y = fix_gauge(mesh, x)
    free = Certificate.of(y, mesh.f).folding_free
    if free and not is_coarse(surface_area(x, mesh.f)):
        return y
    if not free:
        if not embed or not is_off_centre(mesh, x):
            return x
        y = repair_locally(mesh, y)
    worse = is_worse(mean_angle_difference(mesh, y), mean_angle_difference(mesh, x))
    return y if not worse and Certificate.of(y, mesh.f).folding_free else x


def is_off_centre(mesh: Mesh, x: FloatArray) -> bool:
    """True if the centroid of the source's area is more than 1e-3 from the origin."""
    return float(np.linalg.norm(weighted_sum(mesh.A, x))) > SMALL_ANGLE
