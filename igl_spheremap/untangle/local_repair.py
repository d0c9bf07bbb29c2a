"""Local repair of foldings, at a cost that depends on their surroundings only.

Thin faces fold when a vertex crosses their long side by a tiny distance: small moves of their corners put that right.
Vertices around other foldings are removed and put back (embedding.py). Moved vertices are relaxed towards the mesh's
angles.
"""

from __future__ import annotations

import numpy as np

from ..mesh.arrays import TINY, BoolArray, FloatArray, IntArray
from ..mesh.check import Mesh
from ..mesh.edges import marked, touching
from ..mesh.measure import corner_angles
from ..sphere.moebius import fix_gauge
from ..sphere.rows import binary_sizes, column_crosses, column_dots, unit_rows, weighted_sum
from ..verify.certificate import Certificate, after_change
from ..verify.distortion import mean_angle_difference
from ..verify.signs import column_signs, folded_faces
from .embedding import (
    REMOVED_RINGS,
    PositionsListener,
    dilate,
    embed_nearby,
    fix_orientation,
    of_part,
    progressive_embedding,
    with_rows,
)
from .relax import AngleLoss, relax_angles

#: Rings around foldings within which small moves move vertices.
_MOVED_RINGS = 2
#: Rings that are relaxed with the vertices moved by a repair.
RELAXED_RINGS = 2


def are_few(foldings: int, f: IntArray, share: float = 0.01) -> bool:
    """True if one face folds, or at most this share of all: above, layouts by angles are nearer than repairs."""
    return foldings <= max(1.0, share * len(f))


def has_few_foldings(certificate: Certificate, f: IntArray) -> bool:
    """True if the foldings are to be repaired locally: they are few, and the degree is 1."""
    return are_few(certificate.foldings, f) and certificate.degree == 1


def repair_locally(
    mesh: Mesh,
    x: FloatArray,
    before: Certificate,
    listener: PositionsListener | None = None,
    after: FloatArray | None = None,
) -> tuple[FloatArray, Certificate]:
    """A map free of foldings: by small moves, embedding of remaining folds, and relaxation of moved vertices.

    `before` is the certificate of the map, whose numbers are finite. `listener` is called with the map after each round
    of small moves, and after each batch of embedded vertices. `after` is the result of small moves, if it is known.
    Unless embedding has to move more, all is done on a patch around the foldings.
    """
    if 2 * before.foldings > len(mesh.f):
        x = fix_orientation(x, mesh.f)
        before = Certificate.of(x, mesh.f)
    y, folded = x, np.append(before.flipped, before.degenerate)
    if after is not None:
        y, folded = after, np.flatnonzero(folded_faces(after, mesh.f))
    rings = REMOVED_RINGS + _MOVED_RINGS  # around faces that small moves fold, too
    patch = mesh.edges.patch_around(mesh.f[folded], rings)
    notify = of_part(listener, y, patch.vertices)
    part = y[patch.vertices]
    if after is None:
        part = small_moves(part, patch.f, notify)
    part = embed_nearby(part, patch.f, patch.rim, listener=notify)
    y = with_rows(y, patch.vertices, part)
    moved = patch.vertices[(part != x[patch.vertices]).any(axis=1)]
    if after is not None:
        moved = np.flatnonzero((y != x).any(axis=1))
    y, faces = _relaxed(mesh, y, moved)
    certificate = after_change(before, x, y, mesh.f, faces)
    if not certificate.folding_free:
        y = progressive_embedding(y, mesh.f, listener)
        y, _ = _relaxed(mesh, y, np.flatnonzero((y != x).any(axis=1)))
        certificate = Certificate.of(y, mesh.f)
    return y, certificate


def _relaxed(mesh: Mesh, x: FloatArray, moved: IntArray) -> tuple[FloatArray, IntArray]:
    """A map relaxed towards the mesh's angles around vertices that have moved, and the faces there."""
    near = mesh.edges.within(moved, RELAXED_RINGS)
    faces = mesh.edges.faces_at(near)
    f = mesh.f[faces]
    loss = AngleLoss(corner_angles(mesh.unit, f).T)
    return relax_angles(x, f, loss, marked(near, len(x)), sweeps=30, tolerance=0.01), faces


def unfolded(mesh: Mesh, x: FloatArray) -> FloatArray:
    """The map itself, or repaired locally if a face folds."""
    certificate = Certificate.of(x, mesh.f)
    if certificate.foldings:
        return repair_locally(mesh, x, certificate)[0]
    return x


def small_moves(
    x: FloatArray,
    f: IntArray,
    listener: PositionsListener | None = None,
    patience: int = 200,
    moves: int = 1000,
) -> FloatArray:
    """Try to repair foldings by small moves of the vertices around them.

    It ends after `patience` rounds in which no fewer faces fold, or earlier, once these rounds moved `moves` faces:
    embedding frees many faces in less time. Folds beside hubs take 50 to 200 rounds; embedding them may move the whole
    map.

    For each folded face the shortest move of its corners is computed that gives it a small positive area: a projection
    onto a half-space. If several faces move a vertex, their moves are averaged. If the half-spaces intersect, the
    iteration ends there (Agmon 1954, *The Relaxation Method for Linear Inequalities*).

    >>> x = unit_rows(np.array([[0.1, 0, 1], [-0.1, 0, 1], [0, 0.2, 1], [0, 1e-6, 1], [0, -0.2, 1.0]]))
    >>> f = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 4], [3, 1, 4]])
    >>> folded_faces(x, f).tolist(), bool(folded_faces(small_moves(x, f), f).any())
    ([False, True, False, False], False)
    """
    near = dilate(f, marked(f[folded_faces(x, f)], len(x)), _MOVED_RINGS)
    vertices, local = np.unique(f[touching(f, near)], return_inverse=True)
    faces, movable = local.reshape(-1, 3), near[vertices]
    y = best = x[vertices].T.copy()
    folded = column_signs(y.take(faces.T, axis=1)) <= 0
    fewest, since = folded.sum(), 0
    while folded.any() and since < min(patience, moves / folded.sum()):
        bad = faces[folded]
        y = _projected(y, bad.T, movable)
        if listener is not None:
            listener(with_rows(x, vertices, y.T))
        changed = touching(faces, marked(bad, len(vertices)))
        folded[changed] = column_signs(y.take(faces[changed].T, axis=1)) <= 0
        since += 1
        if folded.sum() < fewest:
            best, fewest, since = y, folded.sum(), 0
    return with_rows(x, vertices, best.T)


def _projected(
    x: FloatArray,
    folded: IntArray,
    movable: BoolArray,
    least_area: float = 1e-3,
    over_relaxation: float = 1.3,
) -> FloatArray:
    """One step of a map (3, n) that moves all folded faces, corners (3, m), towards a little area each.

    Twice that area over the square of the longest side is `least_area`, about the least angle in radians. Moves are
    longer than the shortest sufficient ones by the factor `over_relaxation`, so that fewer rounds are needed.

    Twice a face's area is det(o, q - p, r - p) with the outward unit vector o; it changes by o x (opposite side) as a
    corner moves.
    """
    p = x.take(folded, axis=1)  # coordinate, corner, face
    outward = p[:, 0] + p[:, 1] + p[:, 2]
    reach = np.sqrt(column_dots(outward, outward))
    outward /= np.where(reach > 0, reach, 1.0)
    side = p[:, [2, 0, 1]] - p[:, [1, 2, 0]]
    size = binary_sizes((np.abs(side[:, 0]) + np.abs(side[:, 1])).T)
    side /= size
    square = column_dots(side, side)
    lack = least_area * square.max(axis=0) - column_dots(
        outward, column_crosses(side[:, 1], side[:, 2])
    )
    length = size * lack / np.maximum(square.sum(axis=0), TINY)
    corners, n = folded.ravel(), len(movable)
    faces = np.bincount(corners, minlength=n)
    moved = np.flatnonzero(movable & (faces > 0))
    moves = length * column_crosses(outward[:, None], side)
    move = np.stack([np.bincount(corners, part.ravel(), n)[moved] for part in moves]) / faces[moved]
    y = x.copy()
    y[:, moved] = unit_rows((x[:, moved] + over_relaxation * move).T.copy()).T
    return y


def is_worse(mean: float, before: float) -> bool:
    """True if a mean angle difference is more than 5 percent above another: centring always changes it a bit."""
    return mean >= 1.05 * before


def restore_gauge(mesh: Mesh, x: FloatArray) -> tuple[FloatArray, Certificate]:
    """Put a certified map back into the package's gauge, which the repair has left, and certify it again.

    If the Moebius map would fold `x` although its centroid is nearly at the origin, or would spoil the angles of huge
    faces, `x` itself is returned. A Moebius map that hardly moves the centroid hardly changes angles, too.
    """
    y = fix_gauge(mesh, x)
    certificate, worse = Certificate.of(y, mesh.f), False
    if is_off_centre(mesh, x):
        mean = mean_angle_difference(mesh, x)
        worse = is_worse(mean_angle_difference(mesh, y), mean)
        if not worse and not certificate.folding_free:
            y, certificate = repair_locally(mesh, y, certificate)
            worse = is_worse(mean_angle_difference(mesh, y), mean)
    if worse or not certificate.folding_free:
        return x, Certificate.of(x, mesh.f)
    return y, certificate


def is_off_centre(mesh: Mesh, x: FloatArray) -> bool:
    """True if the centroid of the source's area is so far from the origin that a map is centred even if faces fold."""
    return float(np.linalg.norm(weighted_sum(mesh.A, x))) > 1e-3
