"""Progressive embedding: from any positions to a map that is certified free of foldings.

Vertices around foldings are removed by half-edge collapses until no folding is left, and put back in reverse order,
each inside the kernel of its star, which begins at the vertex that it was collapsed to. If float64 has no position
there, a larger region is removed, in the end the whole sphere down to a regular tetrahedron.

References
----------
Praun and Hoppe 2003, *Spherical Parametrization and Remeshing*. Shen, Jiang, Zorin and Panozzo 2019, *Progressive
Embedding*. docs/guarantee.md separates proofs from observations.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from itertools import count

import numpy as np

from ..mesh.arrays import BoolArray, FloatArray, IntArray
from ..mesh.edges import components, marked, touching
from ..sphere.rows import unit_rows
from ..verify.certificate import Certificate
from ..verify.signs import folded_faces, orientation_signs
from .collapse import Batch, Grid, ProgressiveMesh, colour_classes
from .kernel import Stars, analytic_centres, centres_beside, stars_of

#: At first vertices are removed within this many rings around foldings, and where float64 was too coarse; the number is
#: doubled until it suffices.
REMOVED_RINGS = 4


class _RegionTooSmall(Exception):
    """The foldings can't be removed without vertices outside the region."""


class _TooCoarse(Exception):
    """Float64 has no position for some vertices inside the kernels of their stars."""

    def __init__(self, vertices: IntArray) -> None:
        super().__init__()
        self.vertices = vertices


#: Called with the whole map; vertices that are still removed lie on those that they were collapsed to.
PositionsListener = Callable[[FloatArray], None]


def progressive_embedding(
    x: FloatArray, f: IntArray, listener: PositionsListener | None = None
) -> FloatArray:
    """A map without foldings; if that suffices, only vertices around the foldings of `x` move.

    If float64 is too coarse even for the rebuilt whole sphere, which was never seen, it returns `x` itself. `listener`
    is called with the map after each batch of vertices put back.

    >>> import igl
    >>> v, f = igl.icosahedron()
    >>> bool(Certificate.of(progressive_embedding(np.ones((12, 3)), f), f))
    True
    """
    x = unit_rows(x)
    y = embed_locally(fix_orientation(x, f), f, listener=listener)
    if Certificate.of(y, f).folding_free:
        return y
    with suppress(_TooCoarse):
        # bad positions must not decide collapses
        y = np.tile([0.0, 0.0, 1.0], (len(x), 1))
        every_face, every_vertex = np.ones(len(f), bool), np.ones(len(x), bool)
        return _rebuild_locally(
            y, f, every_face, forced=every_vertex, listener=listener, rings=0, keep_positions=False
        )
    return x


def embed_nearby(
    x: FloatArray,
    f: IntArray,
    fixed: BoolArray | None = None,
    grid: Grid = unit_rows,
    listener: PositionsListener | None = None,
) -> FloatArray:
    """Repair foldings by progressive embedding within `REMOVED_RINGS` of them, which nearly always suffices.

    If it does not, it returns `x` itself. Vertices that are `fixed` stay. `grid` rounds unit rows to the positions that
    are allowed.
    """
    bad = folded_faces(x, f)
    if bad.any():
        with suppress(_RegionTooSmall, _TooCoarse):
            return _rebuild_locally(x, f, bad, fixed=fixed, grid=grid, listener=listener)
    return x


def embed_locally(
    x: FloatArray,
    f: IntArray,
    grid: Grid = unit_rows,
    listener: PositionsListener | None = None,
) -> FloatArray:
    """Repair foldings by progressive embedding around them; the map's degree stays.

    Clusters of foldings that need more than the first room are repaired one by one. Foldings that this does not repair
    stay. If more than half of its faces are folded, the whole map stays.
    """
    bad = folded_faces(x, f)
    if bad.sum() > len(f) / 2:
        return x
    apart = clusters(f, bad)
    if len(apart) > 1:
        y = embed_nearby(x, f, grid=grid, listener=listener)
        if y is not x:
            return y
    for cluster in apart:
        x = _embed_cluster(x, f, cluster, grid, listener)
    return x


def clusters(f: IntArray, bad: BoolArray) -> list[BoolArray]:
    """The bad faces in groups; no edge joins these or their neighbours."""
    n = int(f.max()) + 1
    near = f[dilate(f, marked(f[bad], n), 1)[f].all(axis=1)]
    _, label = components(near[:, :2].ravel(), near[:, 1:].ravel(), n)
    own = label[f[:, 0]]
    return [bad & (own == each) for each in np.unique(own[bad])]


def _embed_cluster(
    x: FloatArray,
    f: IntArray,
    cluster: BoolArray,
    grid: Grid,
    listener: PositionsListener | None,
) -> FloatArray:
    """Repair the foldings among some faces, in ever more room; if the grid is too coarse, vertices spread out."""
    forced, rings, keep = np.zeros(len(x), dtype=bool), REMOVED_RINGS, True
    while (bad := cluster & folded_faces(x, f)).any():
        try:
            return _rebuild_locally(
                x,
                f,
                bad,
                forced=forced,
                grid=grid,
                listener=listener,
                rings=rings,
                keep_positions=keep,
            )
        except _RegionTooSmall:
            rings *= 2
        except _TooCoarse as failure:
            if forced.all():
                break
            if not keep:
                forced[failure.vertices] = True
                forced = dilate(f, forced, rings)
                rings *= 2
            keep = False
    return x


def fix_orientation(x: FloatArray, f: IntArray) -> FloatArray:
    """The one of map and mirror image with more positively oriented faces."""
    if (orientation_signs(x, f) >= 0).sum() >= len(f) / 2:
        return x
    return x * [1, 1, -1]


def dilate(f: IntArray, marked: BoolArray, rings: int) -> BoolArray:
    """Marked vertices and all within `rings` edges of them."""
    for _ in range(rings):
        grown = marked.copy()
        grown[f[touching(f, marked)]] = True
        if grown.sum() == marked.sum():
            break
        marked = grown
    return marked


def _rebuild_locally(
    x: FloatArray,
    f: IntArray,
    bad: BoolArray,
    *,
    forced: BoolArray | None = None,
    fixed: BoolArray | None = None,
    grid: Grid = unit_rows,
    listener: PositionsListener | None = None,
    rings: int = REMOVED_RINGS,
    keep_positions: bool = True,
) -> FloatArray:
    """Remove and rebuild the `forced` vertices, and as few as possible around `bad` faces, within `rings` of both.

    Vertices that are `fixed` stay. With `keep_positions` vertices return to their positions, or as near as their
    kernels allow; else they spread out.
    """
    if forced is None:
        forced = np.zeros(len(x), dtype=bool)
    faces = touching(f, dilate(f, forced | marked(f[bad], len(x)), rings))
    vertices, local = np.unique(f[faces], return_inverse=True)
    frozen = marked(f[~faces], len(x))
    if fixed is not None:
        frozen |= fixed
    mesh = ProgressiveMesh(local.reshape(-1, 3), x[vertices], frozen[vertices], grid)
    notify = of_part(listener, x, vertices)
    try:
        _rebuild(mesh, forced[vertices] & ~mesh.frozen, notify, keep_positions)
    except _TooCoarse as failure:
        raise _TooCoarse(vertices[failure.vertices]) from None
    return with_rows(x, vertices, mesh.x)


def of_part(
    listener: PositionsListener | None, x: FloatArray, vertices: IntArray
) -> PositionsListener | None:
    """The listener of some rows of a map, given that of all; None if there is none."""
    if listener is None:
        return None
    return lambda part: listener(with_rows(x, vertices, part))


def with_rows(x: FloatArray, vertices: IntArray, rows: FloatArray) -> FloatArray:
    """A map with other positions for some vertices."""
    x = x.copy()
    x[vertices] = rows
    return x


def _rebuild(
    mesh: ProgressiveMesh,
    forced: BoolArray,
    listener: PositionsListener | None,
    keep_positions: bool = False,
) -> None:
    """Remove the forced vertices and all foldings, and put everything back, changing the positions."""
    f, home = mesh.f.copy(), None
    if keep_positions:
        home = mesh.x.copy()
    batches = list(_removals(mesh, forced))
    if mesh.bad.any() or (forced & mesh.present).any():
        if mesh.frozen.any():
            raise _RegionTooSmall
        corners = mesh.f[mesh.faces()[0]]
        last = np.setdiff1d(np.flatnonzero(mesh.present), corners)
        tetrahedron = (
            np.array([[1.0, 1.0, 1.0], [-1.0, 1.0, -1.0], [1.0, -1.0, -1.0], [-1.0, -1.0, 1.0]])
            / 3**0.5
        )
        mesh.x[np.append(last, corners)] = mesh.grid(tetrahedron)
    movable = dilate(f, ~mesh.present & ~mesh.frozen, 1) & ~mesh.frozen
    _put_back(mesh, batches, movable, listener, home)


def _removals(mesh: ProgressiveMesh, forced: BoolArray, patience: int = 8) -> Iterator[Batch]:
    """Collapse until no forced vertex and no folding is left, or nothing more can go.

    Every `patience` batches a further ring around the remaining foldings is removed as well: if only vertices of folded
    faces go, a mirrored limb takes many times as long.
    """
    for turn in count():
        wanted = np.zeros_like(mesh.present)
        wanted[mesh.f[mesh.bad]] = True
        wanted = dilate(mesh.f[mesh.faces()], wanted, turn // patience) | (forced & mesh.present)
        batch = mesh.next_batch(wanted & ~mesh.frozen)
        if batch is not None:
            mesh.collapse(batch)
            yield batch
        elif mesh.frozen.any() or mesh.is_bijective() or mesh.present.sum() == 4:
            return
        else:  # no folding, yet no bijection: down to the tetrahedron
            forced = np.ones_like(forced)


def _put_back(
    mesh: ProgressiveMesh,
    batches: list[Batch],
    movable: BoolArray,
    listener: PositionsListener | None,
    home: FloatArray | None,
    growth: float = 1.5,
) -> None:
    """Reverse the collapses, newest first: towards positions `home` if given, else relaxing as the complex grows.

    Each time the number of vertices has grown by the factor `growth`, it is relaxed. That is some 25 times from a
    tetrahedron to 100,000 vertices, and costs as much as to relax all of them three times.
    """
    for batch in reversed(batches):
        mesh.x[batch.stars.vertices] = mesh.x[batch.target]
    relaxed_at = int((mesh.present & movable).sum())
    for batch in reversed(batches):
        mesh.restore(batch)
        _insert(mesh, batch, home)
        size = int((mesh.present & movable).sum())
        if home is None and size > growth * relaxed_at + 4:
            relax_areas(mesh, movable)
            relaxed_at = size
        if listener is not None:
            listener(mesh.x)


def _insert(mesh: ProgressiveMesh, batch: Batch, home: FloatArray | None) -> None:
    """Give the vertices of a batch that was just restored positions in their kernels."""
    x, stars, target = mesh.x, batch.stars, batch.target
    wanted = None
    if home is not None:
        wanted = home[stars.vertices]
    placed = centres_beside(x, stars, target, wanted)
    x[stars.vertices] = mesh.grid(placed)
    failed = ~proper(x, stars)
    if failed.any():
        raise _TooCoarse(stars.vertices[failed])


def relax_areas(mesh: ProgressiveMesh, movable: BoolArray) -> None:
    """Move each vertex once, a colour class at a time, to the analytic centre of its kernel.

    Each move raises the sum of log(face area), so that areas become more even. A move is kept only if all faces around
    are positively oriented, exactly.
    """
    x, stars = mesh.x, stars_of(mesh.f[mesh.faces()], movable & mesh.present)
    for move in map(stars.take, colour_classes(stars, len(x))):
        old = x[move.vertices]
        x[move.vertices] = mesh.grid(analytic_centres(x, move))
        rejected = ~proper(x, move)
        x[move.vertices[rejected]] = old[rejected]


def proper(x: FloatArray, stars: Stars) -> BoolArray:
    """True for the stars whose faces are all positively oriented, exactly."""
    signs = orientation_signs(x, np.stack((stars.vertices[stars.owner], stars.a, stars.b), axis=1))
    return np.asarray(np.minimum.reduceat(signs, stars.start) > 0)
