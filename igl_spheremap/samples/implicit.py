"""Implicit shapes, thick curves and their smooth unions, as meshes: march, relax, subdivide, project."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import igl
import numpy as np

from ..errors import check_number
from ..mesh.arrays import TINY, FloatArray, IntArray
from ..mesh.edges import components
from .icosphere import MOST_VERTICES


@dataclass(frozen=True, eq=False)
class Limb:
    """Union of round balls along a polyline, their radius linear on each segment."""

    centres: FloatArray  # (k, 3)
    radii: FloatArray  # (k,)
    # space is divided by these: below 1, flat along an axis
    squash: tuple[float, float, float] = (1.0, 1.0, 1.0)

    def __call__(self, points: FloatArray) -> FloatArray:
        """Lower bound of the distance of (k, 3) points to the limb, negative inside."""
        squash = np.array(self.squash)
        points, start = points / squash, self.centres[:-1] / squash
        along = np.diff(self.centres / squash, axis=0)
        squared = np.einsum("ij,ij->i", along, along)
        dot = points @ along.T - np.einsum("ij,ij->i", start, along)
        t = np.clip(dot / squared, 0.0, 1.0)
        square = (
            np.einsum("ij,ij->i", points, points)[:, None]
            - 2.0 * points @ start.T
            + np.einsum("ij,ij->i", start, start)
            + t * (t * squared - 2.0 * dot)
        )
        radius = self.radii[:-1] + t * np.diff(self.radii)
        return float(squash.min()) * np.min(np.sqrt(np.maximum(square, 0.0)) - radius, axis=1)

    def box(self) -> FloatArray:
        """(2, 3) corners of a box that holds the limb."""
        reach = self.radii[:, None] * np.array(self.squash)
        return np.stack([(self.centres - reach).min(axis=0), (self.centres + reach).max(axis=0)])


def limb(
    knots: Sequence[Sequence[float]], squash: tuple[float, float, float] = (1.0, 1.0, 1.0)
) -> Limb:
    """Limb along a spline through knots ``(x, y, z, radius)``."""
    # takes .2 s, which only limbs need
    from scipy.interpolate import CubicSpline, PchipInterpolator

    k = np.array(knots, dtype=np.float64)
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(k[:, :3], axis=0), axis=1))])
    # eight straight pieces a knot look smooth
    s = np.linspace(0.0, length[-1], 8 * (len(k) - 1) + 1)
    return Limb(CubicSpline(length, k[:, :3])(s), PchipInterpolator(length, k[:, 3])(s), squash)


@dataclass(frozen=True, eq=False)
class SmoothUnion:
    """Union of limbs, blended where they are closer than 20 blend lengths: farther off exp(-20) is 2e-9."""

    limbs: tuple[Limb, ...]
    blend: float

    def __call__(self, points: FloatArray) -> FloatArray:
        """``-blend * log(sum(exp(-d / blend)))`` over the limbs' distances d."""
        distance = np.stack([self._distance(each, points) for each in self.limbs])
        nearest = distance.min(axis=0)
        return nearest - self.blend * np.log(
            np.sum(np.exp((nearest - distance) / self.blend), axis=0)
        )

    def _distance(self, part: Limb, points: FloatArray) -> FloatArray:
        """Distance to the limb; for points too far off to be blended, that to its box, which is smaller."""
        lower, upper = part.box()
        distance = np.linalg.norm(points - np.clip(points, lower, upper), axis=1)
        near = distance < 20.0 * self.blend
        distance[near] = part(points[near])
        return distance

    def box(self) -> FloatArray:
        """(2, 3) corners of a box that holds the union, the swelling of the blend included."""
        boxes = np.stack([each.box() for each in self.limbs])
        swell = self.blend * (1.0 + np.log(len(self.limbs)))
        return np.stack([boxes[:, 0].min(axis=0) - swell, boxes[:, 1].max(axis=0) + swell])


Field = Callable[[FloatArray], FloatArray]
"""Maps (k, 3) points to (k,) values: negative inside, and 1-Lipschitz, a lower bound of the distance to the surface."""

_CUBE = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
)


def mesh_implicit(
    field: Field, box: FloatArray, n_vertices: int, detail: float
) -> tuple[FloatArray, IntArray]:
    """Closed genus-0 mesh of ``field == 0`` inside the box, with about ``n_vertices`` vertices.

    If there are vertices enough, marching cubes makes a mesh with grid spacing at most ``detail``; its slivers vanish
    under relaxation. Finer meshes come from it by midpoint subdivision and projection, which keep the triangles' shape.
    Rounds of relaxation, here, and steps, below, were chosen by looking at the meshes.
    """
    v, f = _march(field, box, detail)
    check_number(n_vertices, "n_vertices", len(v) // 3, MOST_VERTICES)  # coarser grids lose limbs
    levels = max(int(np.log2(n_vertices / len(v)) // 2), 0)
    scale = detail * np.sqrt(len(v))
    # a coarse grid may join limbs; one a little finer is unlikely to
    for surplus in (1.0, 1.05, 1.1, 1.15):
        v, f = _march_to_count(field, box, surplus * n_vertices / 4**levels, scale)
        if len(v) - len(f) // 2 == 2:
            break
    else:
        raise ValueError(f"{n_vertices} vertices can't resolve this shape: ask for more")
    v = _relax(field, v, f, rounds=10)
    for _ in range(levels):
        v, f = igl.upsample(v, f)
        v = _relax(field, v, f, rounds=3)
    return np.ascontiguousarray(v), np.ascontiguousarray(f, dtype=np.int64)


def _relax(field: Field, v: FloatArray, f: IntArray, rounds: int) -> FloatArray:
    """Slide vertices along the surface to even out the triangles, then put them onto it."""
    for _ in range(rounds):
        v = _slide(v, f)
        v = v - evaluate(field, v)[:, None] * igl.per_vertex_normals(v, f)
    return _settle(field, v, f)


def _settle(field: Field, v: FloatArray, f: IntArray, steps: int = 4) -> FloatArray:
    """Secant steps along vertex normals to the zero set; a vertex whose normal leads past the longest edge stays."""
    normal = igl.per_vertex_normals(v, f)
    value, move = evaluate(field, v), np.zeros(len(v))
    step = -value
    for _ in range(steps):
        move += step
        before, value = value, evaluate(field, v + move[:, None] * normal)
        slope = np.divide(value - before, step, out=np.ones_like(step), where=step != 0.0)
        step = -value / np.clip(slope, 0.25, 1.0)  # that of a distance is 1
    move[np.abs(move) > np.linalg.norm(v[f] - v[f[:, [1, 2, 0]]], axis=2).max()] = 0.0
    return v + move[:, None] * normal


def evaluate(field: Field, points: FloatArray, block: int = 1 << 10) -> FloatArray:
    """Apply the field block by block, so that temporaries stay in cache."""
    return np.concatenate([field(points[i : i + block]) for i in range(0, len(points), block)])


def _march_to_count(
    field: Field,
    box: FloatArray,
    count: float,
    scale: float,
    tries: int = 4,
    tolerance: float = 0.03,
) -> tuple[FloatArray, IntArray]:
    """Marching cubes on the grid that yields ``count`` vertices: spacing near ``scale / sqrt(count)``."""
    for _ in range(tries):
        spacing = scale / np.sqrt(count)
        v, f = _march(field, box, spacing)
        if abs(len(v) / count - 1.0) < tolerance:
            break
        scale = spacing * np.sqrt(len(v))
    return v, f


def _march(
    field: Field, box: FloatArray, spacing: float, coarsest: int = 8
) -> tuple[FloatArray, IntArray]:
    """Marching cubes over those cubes of an octree that the surface can meet.

    The octree starts with cubes of an edge of `coarsest` grid spacings.
    """
    n = np.ceil((box[1] - box[0]) / (coarsest * spacing)).astype(np.int64)
    size = coarsest
    cubes = size * np.stack(np.meshgrid(*map(np.arange, n), indexing="ij"), axis=-1).reshape(-1, 3)
    while True:
        centre = box[0] + spacing * (cubes + 0.5 * size)
        cubes = cubes[np.abs(evaluate(field, centre)) <= 0.5 * np.sqrt(3.0) * spacing * size]
        if size == 1:
            break
        size //= 2
        cubes = (cubes[:, None, :] + size * _CUBE[None]).reshape(-1, 3)
    corners = (cubes[:, None, :] + _CUBE[None]).reshape(-1, 3)
    stride = coarsest * n + 1
    key = (corners[:, 0] * stride[1] + corners[:, 1]) * stride[2] + corners[:, 2]
    _, first, index = np.unique(key, return_index=True, return_inverse=True)
    grid = box[0] + spacing * corners[first]
    v, f, _ = igl.marching_cubes(evaluate(field, grid), grid, index.reshape(-1, 8), 0.0)
    return _largest_part(v, f)


def _largest_part(v: FloatArray, f: IntArray) -> tuple[FloatArray, IntArray]:
    """The component with most vertices: a grid too coarse for a thin tip cuts beads off it."""
    _, part = components(f.ravel(), np.roll(f, 1, axis=1).ravel(), len(v))
    keep = part == np.argmax(np.bincount(part))
    return v[keep], (np.cumsum(keep) - 1)[f[keep[f[:, 0]]]]


def _slide(v: FloatArray, f: IntArray) -> FloatArray:
    """Move each vertex in its tangent plane towards the area-weighted mean of its faces' centroids."""
    area = igl.doublearea(v, f)
    centroid = v[f].mean(axis=1)
    corners = f.ravel()
    moment = [np.bincount(corners, np.repeat(area * centroid[:, k], 3), len(v)) for k in range(3)]
    weight = np.maximum(np.bincount(corners, np.repeat(area, 3), len(v)), TINY)
    normal = igl.per_vertex_normals(v, f)
    move = np.stack(moment, axis=1) / weight[:, None] - v
    return v + move - np.einsum("ij,ij->i", move, normal)[:, None] * normal
