"""The common refinement tiles both surfaces, whatever vertices and edges coincide."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

import igl_spheremap as ism
from igl_spheremap.mesh.edges import half_edges
from igl_spheremap.resampling.transfer import interpolate
from igl_spheremap.shapes.correspondence.overlay import Overlay, overlay


def signed_areas(
    v: np.ndarray, f: np.ndarray, p: np.ndarray, parts: np.ndarray, owner: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Areas of parts in the planes of the faces that own them, and of these faces."""
    normal, own = (
        np.cross(q[g[:, 1]] - q[g[:, 0]], q[g[:, 2]] - q[g[:, 0]]) for q, g in ((p, parts), (v, f))
    )
    twice = np.linalg.norm(own, axis=1)
    return np.einsum("ij,ij->i", normal, own[owner]) / twice[owner] / 2, twice / 2


def check_tiles(
    common: Overlay, a: ism.SphereMap, b: ism.SphereMap, tolerance: float = 1e-12
) -> None:
    assert half_edges(common.faces, len(common.on_source)) is not None
    assert len(common.faces) == 2 * len(common.on_source) - 4
    assert np.array_equal(common.on_source[: len(a.vertices)], a.vertices)
    assert np.array_equal(common.on_target[common.target_vertex], b.vertices)
    sides = (a, common.on_source, common.source_face), (b, common.on_target, common.target_face)
    for (result, positions, owner), unresolved in zip(sides, common.unresolved, strict=True):
        areas, whole = signed_areas(result.vertices, result.faces, positions, common.faces, owner)
        assert (areas >= 0).all()
        assert np.count_nonzero(areas == 0) == unresolved <= 1e-4 * len(areas)
        assert np.abs(np.bincount(owner, areas, len(whole)) / whole - 1).max() < tolerance
    assert np.allclose(
        interpolate(a.vertices, a.faces, common.source_location), common.on_source, atol=1e-13
    )
    assert np.allclose(
        interpolate(b.vertices, b.faces, common.target_location), common.on_target, atol=1e-13
    )


def mapped(name: str, n: int) -> ism.SphereMap:
    return ism.spherical_conformal_map(*ism.samples.make(name, n_vertices=n))


def turned(a: ism.SphereMap, seed: int) -> ism.SphereMap:
    return ism.sphere_map(
        a.vertices, a.faces, a.sphere @ Rotation.random(random_state=seed).as_matrix()
    )


def hull(points: np.ndarray) -> ism.SphereMap:
    """The convex hull of points about the origin, mapped along its radii."""
    x = points / np.linalg.norm(points, axis=1, keepdims=True)
    f = ConvexHull(x).simplices.astype(np.int64)
    inward = np.linalg.det(x[f]) < 0
    f[inward] = f[inward][:, ::-1]
    return ism.sphere_map(points, f, x)


@pytest.mark.parametrize("seed", range(4))
def test_every_face_is_positive_on_both_and_areas_are_kept(seed: int) -> None:
    a, b = turned(mapped("pear", 700), seed), mapped("dumbbell", 1100)
    common = overlay(a, b)
    check_tiles(common, a, b)
    assert len(common.on_source) > len(a.vertices) + len(b.vertices)


def test_both_orders_give_the_same_refinement() -> None:
    a, b = turned(mapped("spheroid", 400), 1), mapped("pear", 600)
    there, back = overlay(a, b), overlay(b, a)
    assert len(there.faces) == len(back.faces)
    for p, q in ((there.on_source, back.on_target), (there.on_target, back.on_source)):
        low = np.sort(p.round(9), axis=0), np.sort(q.round(9), axis=0)
        assert np.allclose(*low, atol=1e-8)
    pairs = set(zip(there.source_face.tolist(), there.target_face.tolist(), strict=True))
    assert pairs == set(zip(back.target_face.tolist(), back.source_face.tolist(), strict=True))


def test_a_surface_on_itself_is_itself() -> None:
    a = mapped("pear", 800)
    common = overlay(a, a)
    check_tiles(common, a, a)
    assert np.array_equal(common.on_source, common.on_target)
    assert set(map(tuple, np.sort(common.faces, axis=1))) == set(
        map(tuple, np.sort(a.faces, axis=1))
    )


CUBE = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
AXES = np.vstack((np.eye(3), -np.eye(3)))
MIDDLES = np.array(
    [p for p in itertools.product((-1.0, 0.0, 1.0), repeat=3) if np.count_nonzero(p) == 2]
)
SOLIDS = {
    "cube": CUBE, "axes": AXES, "middles": MIDDLES, "tetrahedron": CUBE[[0, 3, 5, 6]], "opposite": -CUBE[[0, 3, 5, 6]],
    "cube and axes": np.vstack((CUBE, AXES)), "middles and axes": np.vstack((MIDDLES, AXES)),
    "all": np.vstack((CUBE, AXES, MIDDLES)),
}  # fmt: skip


@pytest.mark.parametrize("names", list(itertools.product(SOLIDS, repeat=2)), ids="-".join)
def test_vertices_on_edges_and_edges_along_edges_are_exact_ties(names: tuple[str, str]) -> None:
    a, b = (hull(SOLIDS[name]) for name in names)
    check_tiles(overlay(a, b), a, b)


@pytest.mark.parametrize("seed", range(3))
def test_common_vertices_are_one(seed: int) -> None:
    """Landmarks that are met: vertices of both meshes at the same point."""
    rng = np.random.default_rng(seed)
    x, y = rng.normal(size=(2, 200, 3))
    y[:60] = x[100:160]
    a, b = hull(x), hull(y)
    common = overlay(a, b)
    check_tiles(common, a, b)
    assert np.array_equal(common.target_vertex[:60], np.arange(100, 160))


@pytest.mark.parametrize("sizes", [(42, 162), (162, 642)])
def test_edges_that_coincide_but_for_rounding_are_merged(sizes: tuple[int, int]) -> None:
    """An icosphere halves the edges of the one before it, at midpoints that are rounded."""
    turn = Rotation.random(random_state=2).as_matrix()
    a, b = (ism.sphere_map(x, f, x @ turn) for x, f in (ism.samples.sphere(n) for n in sizes))
    common = overlay(a, b)
    check_tiles(common, a, b)
    assert len(common.on_source) == sizes[1]


@pytest.mark.parametrize("sizes", [(42, 252), (92, 42)])
def test_edges_of_one_great_circle_that_overlap_in_part_cross_at_one_point(
    sizes: tuple[int, int],
) -> None:
    """Edges of icosahedra cut in three and five parts lie on edges cut in two: their chords are far from parallel."""
    turn = Rotation.random(random_state=1133).as_matrix()
    a, b = (ism.sphere_map(x, f, x @ turn) for x, f in (ism.samples.sphere(n) for n in sizes))
    check_tiles(overlay(a, b), a, b)


# a neck is small on the sphere
@pytest.mark.parametrize(("name", "tolerance"), [("pear", 1e-12), ("dumbbell", 1e-11)])
@pytest.mark.parametrize("noise", [0.0, 1e-16, 1e-15, 3e-15, 1e-14, 1e-13, 1e-9, 1e-4])
def test_a_map_that_is_nearly_the_other_one_gives_positive_faces(
    noise: float, name: str, tolerance: float
) -> None:
    """Turned there and back, and shaken: rounding, and far above it."""
    a, turn = mapped(name, 1500), Rotation.random(random_state=4).as_matrix()
    x = a.sphere @ turn @ turn.T + noise * np.random.default_rng(0).normal(size=a.sphere.shape)
    b = ism.sphere_map(a.vertices, a.faces, x / np.linalg.norm(x, axis=1, keepdims=True))
    common = overlay(b, a)
    check_tiles(common, b, a, tolerance)
    assert np.abs(common.on_source - common.on_target).max() < tolerance + 1000 * noise


def halved(v: np.ndarray, f: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The ends of each edge, and faces with vertices in the middle of their sides, numbered after the others."""
    sides = np.sort(f[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    ends, number = np.unique(sides, axis=0, return_inverse=True)
    (a, b, c), (p, q, r) = f.T, number.reshape(-1, 3).T + len(v)
    return ends, np.concatenate(
        [np.column_stack(each) for each in ((a, p, r), (p, b, q), (r, q, c), (p, q, r))]
    )


@pytest.mark.parametrize("seed", [0, 1, 5, 9, 13, 14])
def test_random_coincidences_are_merged_on_purpose(seed: int) -> None:
    """Points, and middles of edges, that were turned there and back, shaken, or triangulated otherwise."""
    rng = np.random.default_rng(seed)
    a = hull(rng.normal(size=(int(rng.integers(20, 150)), 3)) * rng.uniform(0.3, 3, 3))
    turn, noise = Rotation.random(random_state=seed).as_matrix(), 10 ** rng.uniform(-16.5, -10)
    x = a.sphere @ turn @ turn.T
    if seed % 4 == 0:
        x, v, f = x + noise * rng.normal(size=x.shape), a.vertices, a.faces
    else:
        ends, f = halved(a.vertices, a.faces)
        v, x = (np.concatenate((p, p[ends].mean(axis=1))) for p in (a.vertices, x))
        x += noise * rng.normal(size=x.shape) * (seed % 4 - 1)
    b = ism.sphere_map(v, f, x / np.linalg.norm(x, axis=1, keepdims=True))
    common = overlay(a, b)
    assert half_edges(common.faces, len(common.on_source)) is not None
    assert len(common.faces) == 2 * len(common.on_source) - 4
    assert np.array_equal(common.on_target[common.target_vertex], b.vertices)
    sides = (a, common.on_source, common.source_face), (b, common.on_target, common.target_face)
    for result, positions, owner in sides:
        areas, whole = signed_areas(result.vertices, result.faces, positions, common.faces, owner)
        assert (areas > 0).all()
        assert np.isclose(areas.sum(), whole.sum(), rtol=1e-12, atol=0)


def test_faces_without_area_on_b_have_none_there_and_keep_theirs_on_a() -> None:
    a, b = turned(mapped("spheroid", 300), 3), mapped("pear", 400)
    flat = b.vertices.copy()
    i, j, k = b.faces[0]
    flat[k] = (flat[i] + flat[j]) / 2
    squeezed = ism.sphere_map(flat, b.faces, b.sphere)
    common = overlay(a, squeezed)
    areas, whole = signed_areas(
        a.vertices, a.faces, common.on_source, common.faces, common.source_face
    )
    assert (areas > 0).all()
    assert np.allclose(np.bincount(common.source_face, areas), whole, rtol=1e-12)
    corners = common.on_target[common.faces[common.target_face == 0]]
    assert (
        np.abs(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])).max() < 1e-15
    )


def test_a_folded_map_is_refused() -> None:
    a = mapped("spheroid", 300)
    x = a.sphere.copy()
    x[5] = -x[5]
    folded = ism.SphereMap(a.mesh, x, ism.certify(x, a.faces), a.run)
    with pytest.raises(ism.FoldingsRemain):
        overlay(folded, a)


@pytest.mark.parametrize("name", ["dumbbell", "pear"])
def test_limbs_that_float64_does_not_resolve_on_the_other_surface_have_no_negative_faces(
    name: str,
) -> None:
    a, b = mapped("spring", 600), turned(mapped(name, 300), 0)
    common = overlay(a, b)
    assert half_edges(common.faces, len(common.on_source)) is not None
    sides = (a, common.on_source, common.source_face), (b, common.on_target, common.target_face)
    for (result, positions, owner), unresolved in zip(sides, common.unresolved, strict=True):
        areas, whole = signed_areas(result.vertices, result.faces, positions, common.faces, owner)
        assert (areas >= 0).all()
        assert np.isclose(areas.sum(), whole.sum(), rtol=1e-12, atol=0)
        corners = positions[common.faces[areas == 0]]
        shortest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).min(axis=1)
        assert shortest.max(initial=0) <= 1e-15 * np.ptp(positions)
        assert unresolved == len(corners)
    assert common.unresolved[1] > 100
