"""Repair removes planted faults, leaves sound meshes alone, and names other faults."""

from __future__ import annotations

import re

import numpy as np
import pytest
from corpus import CORPUS
from scipy.spatial import ConvexHull

from igl_spheremap import MeshError, check_mesh, samples
from igl_spheremap.io.files import read_mesh
from igl_spheremap.mesh.arrays import weld
from igl_spheremap.mesh_repair.repair_mesh import repair_mesh


@pytest.fixture
def ball() -> tuple[np.ndarray, np.ndarray]:
    return samples.sphere(162)


def oriented(f: np.ndarray) -> set[tuple[int, ...]]:
    """Faces up to the choice of their first corner."""
    return {tuple(np.roll(face, -int(np.argmin(face))).tolist()) for face in f}


def assert_consistent(repaired, v, f) -> None:
    """The index maps lead back to the input."""
    check_mesh(repaired.v, repaired.f)
    assert np.array_equal(repaired.v, np.asarray(v)[repaired.vertex_source])
    source = np.sort(repaired.vertex_image[np.asarray(f)[repaired.face_source]], axis=1)
    if not any(word in action for word in ("split", "parted") for action in repaired.actions):
        assert np.array_equal(source, np.sort(repaired.f, axis=1))
        kept = repaired.vertex_image >= 0
        assert np.array_equal(repaired.v[repaired.vertex_image[kept]], np.asarray(v)[kept])


def test_a_sound_mesh_is_left_alone(ball):
    v, f = ball
    repaired = repair_mesh(v, f)
    assert repaired.actions == ()
    assert np.array_equal(repaired.v, v)
    assert np.array_equal(repaired.f, f)
    assert_consistent(repaired, v, f)


def test_coincident_vertices_of_a_closed_surface_are_its_own_business(ball):
    """A flattened sphere has pairs of vertices at one place, and is closed all the same."""
    v, f = ball
    flat = v * [1, 1, 0]
    assert len(weld(flat)[0]) < len(v)
    assert repair_mesh(flat, f).actions == ()


def plant_soup(v, f):
    return v[f].reshape(-1, 3), np.arange(3 * len(f)).reshape(-1, 3)


def plant_unreferenced(v, f):
    return np.insert(v, [0, 50], [[9, 9, 9], [np.nan, 9, 9]], axis=0), f + 1 + (f >= 50)


def plant_repeated_index(v, f):
    return v, np.insert(f, 7, [3, 3, 9], axis=0)


def plant_copy(v, f):
    return v, np.vstack([f, f[[4, 9]], f[[4, 20]][:, ::-1]])


def plant_flips(v, f):
    flipped = f.copy()
    flipped[::3] = flipped[::3, ::-1]
    return v, flipped


def plant_inside_out(v, f):
    return v, f[:, ::-1]


@pytest.mark.parametrize(
    ("plant", "words"),
    [
        (plant_soup, "welded 798 coincident vertices"),
        (plant_unreferenced, "dropped 2 unreferenced"),
        (plant_repeated_index, "dropped 1 face with a repeated"),
        (plant_copy, "dropped 4 surplus copies"),
        (plant_flips, "reversed 107 faces"),
        (plant_inside_out, "turned the surface outward"),
    ],
)
def test_planted_faults_are_repaired(plant, words, ball):
    v, f = plant(*ball)
    repaired = repair_mesh(v, f)
    assert words in "; ".join(repaired.actions)
    assert len(repaired.actions) == 1
    assert_consistent(repaired, v, f)
    corners = {tuple(map(tuple, ball[0][face])) for face in ball[1]}
    assert {
        tuple(map(tuple, np.roll(repaired.v[face], k, axis=0)))
        for face in repaired.f
        for k in range(3)
    } >= corners


@pytest.mark.parametrize("jitter", [0, 2e-16, 1e-9, 1e-4])
def test_a_soup_is_welded_by_the_tolerance_that_its_error_names(jitter, ball):
    v, f = plant_soup(*ball)
    v = v + jitter * np.random.default_rng(0).uniform(-1, 1, v.shape)
    with pytest.raises(MeshError, match="weld") as caught:
        check_mesh(v, f)
    near = caught.value.remedy.options.get("weld", 0.0)
    assert (near > 0) == (jitter > 0)
    assert f"(repair_mesh(v, f{f', weld={near}' if near else ''}) does)" in str(caught.value)
    repaired = repair_mesh(v, f, weld=near)
    assert len(repaired.v) == len(ball[0])
    assert np.array_equal(repaired.vertex_image[f], repaired.f)
    if near:  # what one tolerance joins, a smaller one than the jitter does not
        with pytest.raises(
            MeshError, match=r"open surface.*weld the coincident vertices along them"
        ):
            repair_mesh(v, f, weld=jitter / 1e3)


def test_pieces_that_no_tolerance_joins_are_not_dropped(ball):
    v, f = plant_soup(*ball)
    with pytest.raises(MeshError, match=r"join the 320 components and close the holes$") as caught:
        check_mesh(v + 0.05 * np.random.default_rng(0).uniform(-1, 1, v.shape), f)
    assert caught.value.remedy is None
    with pytest.raises(ValueError, match=r"weld is 0\.1; give a number from 0 to 0\.01"):
        repair_mesh(v, f, weld=0.1)


def test_a_hole_is_filled_and_a_seam_beside_it_welded(ball):
    """A slit whose sides lie 1e-13 apart, and a hole of one face: each has its own remedy."""
    v, f = ball
    a = int(f[5, 0])
    fan = np.flatnonzero((f == a).any(axis=1))
    slit = f.copy()
    slit[fan[0], f[fan[0]] == a] = len(v)
    w = np.vstack((v, v[a] * (1 - 1e-13)))
    far = int(np.argmin(v[f].mean(axis=1) @ v[a]))
    with pytest.raises(MeshError) as caught:
        check_mesh(w, np.delete(slit, far, axis=0))
    assert caught.value.remedy.options == {
        "weld": caught.value.remedy.options["weld"],
        "holes": "fill",
    }
    repaired = repair_mesh(w, np.delete(slit, far, axis=0), **caught.value.remedy.options)
    assert (len(repaired.v), int(repaired.caps.sum())) == (len(v), 1)


def test_all_faults_at_once(ball):
    v, f = ball
    for plant in (plant_unreferenced, plant_flips, plant_repeated_index, plant_copy):
        v, f = plant(v, f)
    repaired = repair_mesh(v, f)
    assert_consistent(repaired, v, f)
    assert repaired.v.shape == ball[0].shape
    assert repair_mesh(repaired.v, repaired.f).actions == ()


def test_components(ball):
    v, f = ball
    w, g = samples.sphere(42)
    both = np.vstack([w + 5, v]), np.vstack([g, f + len(w)])
    with pytest.raises(MeshError, match="2 components"):
        repair_mesh(*both)
    repaired = repair_mesh(*both, keep_largest=True)
    assert np.array_equal(repaired.v, v)
    assert_consistent(repaired, *both)


def test_each_component_is_oriented_before_one_is_chosen(ball):
    v, f = ball
    w, g = samples.sphere(42)
    repaired = repair_mesh(
        np.vstack([w + 5, v]), np.vstack([g, f[:, ::-1] + len(w)]), keep_largest=True
    )
    assert oriented(repaired.f) == oriented(f)


def test_a_pinched_vertex_is_split(ball):
    v, f = ball
    far = int(np.argmin(v @ v[0]))
    pinched = np.where(f == far, 0, f)
    pinched[pinched > far] -= 1
    w = np.delete(v, far, axis=0)
    with pytest.raises(MeshError, match="non-manifold vertex"):
        check_mesh(w, pinched)
    repaired = repair_mesh(w, pinched)
    assert repaired.actions == ("split 1 vertex where sheets touch",)
    assert len(repaired.v) == len(v)
    assert repaired.vertex_source[-1] == 0
    assert_consistent(repaired, w, pinched)


def test_sheets_that_meet_in_an_edge_are_parted(ball):
    """Two balls that share an edge: four faces there, two of each."""
    v, f = ball
    number = np.arange(len(v)) + len(v)
    number[f[0, :2]] = f[0, :2]
    both, w = np.vstack([f, number[f[:, ::-1]]]), np.vstack([v, -v / 4 + v[f[0, 0]]])
    with pytest.raises(
        MeshError, match=r"non-manifold edge: 1 edge .*\(v, f, keep_largest=True\) does"
    ):
        check_mesh(w, both)
    with pytest.raises(MeshError, match="2 components"):
        repair_mesh(w, both)
    larger = np.vstack([both, [[0, 0, 1]]])
    repaired = repair_mesh(w, larger, keep_largest=True)
    assert "parted 1 edge where sheets meet" in repaired.actions
    assert oriented(repaired.f) == oriented(f)
    assert np.array_equal(repaired.vertex_image[: len(v)], np.arange(len(v)))
    fin = np.vstack([f, [[f[0, 0], f[0, 1], 60]]])
    repaired = repair_mesh(v, fin)
    assert repaired.actions[0].startswith("dropped 1 face left over at edges of more than two")
    assert np.array_equal(repaired.f, f)


def test_a_wall_inside_is_dropped_and_the_ball_stays_whole():
    """Edges of three faces around a ball: the two that go on most straight are kept."""
    v, f = samples.sphere(642)
    low = v[:, 2] < 0
    rim = np.array(
        [
            (a, b)
            for t in f.tolist()
            for a, b in zip(t, t[1:] + t[:1], strict=True)
            if low[t].all() and not low[f[((f == a).any(axis=1)) & ((f == b).any(axis=1))]].all()
        ]
    )
    wall = np.column_stack((rim, np.full(len(rim), len(v))))
    w, g = np.vstack((v, [[0, 0, -0.05]])), np.vstack((f, wall))
    with pytest.raises(MeshError, match=r"non-manifold edge: .*\(v, f\) does|keep_largest"):
        check_mesh(w, g)
    repaired = repair_mesh(w, g, keep_largest=True)
    assert np.array_equal(repaired.f, f)
    assert "percent of the area" in repaired.actions[0]


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("rounds", [0, 3, 30])
def test_sheets_are_parted_where_angles_no_longer_do(rounds, seed):
    """The surface of a rough blob of voxels, smoothed: around its edges of four faces directions don't alternate."""
    rng = np.random.default_rng(seed)
    grid = np.indices((12, 12, 12)) - 5.5
    v, f = voxels(np.sqrt((grid**2).sum(axis=0)) + rng.normal(size=(12, 12, 12)) < 4.5)
    edges = np.concatenate((f, f[:, [1, 2, 0]]), axis=1).reshape(-1, 2, 3).swapaxes(1, 2)
    edges = edges.reshape(-1, 2)
    for _ in range(rounds):
        mean = [np.bincount(edges[:, 0], v[edges[:, 1], k], len(v)) for k in range(3)]
        v = (v + np.column_stack(mean) / np.bincount(edges[:, 0], minlength=len(v))[:, None]) / 2
    with pytest.raises(MeshError, match="non-manifold edge") as caught:
        check_mesh(v, f)
    repaired = repair_mesh(v, f, **caught.value.remedy.options)
    check_mesh(repaired.v, repaired.f)
    assert "parted" in repaired.actions[0]


def blocks(rng, counts):
    """The sides of a box, each a grid of its own: on common edges vertices of one lie on edges of the other."""
    v, f = [], []
    sides = [(0, 1, 2), (1, 2, 0), (2, 0, 1)]
    for (a, b, c), flip in ((side, flip) for side in sides for flip in (0, 1)):
        n, m = counts(rng)
        i, j = (each.ravel() for each in np.meshgrid(np.arange(n + 1), np.arange(m + 1)))
        points = np.zeros((len(i), 3))
        points[:, a], points[:, b], points[:, c] = i / n, j / m, flip
        k = np.arange(len(i)).reshape(m + 1, n + 1)
        q = [k[:-1, :-1], k[:-1, 1:], k[1:, 1:], k[1:, :-1]][:: 2 * flip - 1]
        q = np.stack([each.ravel() for each in q], axis=1)
        f.append(np.vstack((q[:, [0, 1, 2]], q[:, [0, 2, 3]])) + sum(map(len, v)))
        v.append(points)
    return np.vstack(v), np.vstack(f)


@pytest.mark.parametrize("seed", range(8))
def test_t_junctions_are_stitched_in_any_pose(seed):
    """On several edges of a face, in chains where neither side has the vertices of the other: the area stays whole."""
    rng = np.random.default_rng(seed)
    v, f = blocks(rng, lambda rng: rng.integers(1, 6, 2))
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    v = (v * [3, 2, 1]) @ turn.T * 10.0 ** rng.integers(-3, 4)
    with pytest.raises(MeshError, match="open surface") as caught:
        check_mesh(v, f)
    assert caught.value.remedy.options == {}
    repaired = repair_mesh(v, f)
    areas = [
        np.linalg.norm(np.cross(*(w[g[:, k]] - w[g[:, 0]] for k in (1, 2))), axis=1)
        for w, g in ((v, f), (repaired.v, repaired.f))
    ]
    assert areas[1].sum() == pytest.approx(areas[0].sum())
    parts = np.bincount(repaired.face_source, areas[1], len(f))
    assert np.allclose(parts, areas[0])
    assert np.array_equal(repaired.v, v[repaired.vertex_source])


def test_vertices_with_nan_are_dropped_with_their_faces(ball):
    v, f = ball
    v = v.copy()
    v[[3, 90], 1] = np.nan, np.inf
    with pytest.raises(MeshError, match=r"not finite: 2 vertices .*holes='fill'\) does") as caught:
        check_mesh(v, f)
    repaired = repair_mesh(v, f, **caught.value.remedy.options)
    assert repaired.actions[0].startswith("dropped 2 vertices with NaN or infinite coordinates and")
    assert (repaired.vertex_image[[3, 90]] == -1).all()
    assert np.isfinite(repaired.v).all()


@pytest.mark.parametrize("parts", [2, 10, 11, 40])
def test_of_many_equal_parts_the_remedy_is_named_with_its_share(parts, ball):
    v, f = ball
    w = np.vstack([v + 3 * k for k in range(parts)])
    g = np.vstack([f + len(v) * k for k in range(parts)])
    with pytest.raises(MeshError, match=r"by read_mesh\('FILE:K'\), or keep the largest") as caught:
        check_mesh(w, g)
    assert f"keeps {100 / parts:.3g} percent of the area" in str(caught.value)
    assert caught.value.remedy.options == {"keep_largest": True}
    assert len(repair_mesh(w, g, keep_largest=True).f) == len(f)


def test_the_largest_part_is_that_of_most_volume(ball):
    """Not the one of most faces, as a fine bubble in a coarse box, nor a loose ground plane."""
    v, f = ball
    box = np.array([(x, y, z) for x in (0, 10) for y in (0, 10) for z in (0, 10)], dtype=float)
    sides = ConvexHull(box).simplices
    repaired = repair_mesh(
        np.vstack((v / 2 + 5, box)), np.vstack((f, sides + len(v))), keep_largest=True
    )
    assert np.array_equal(repaired.v, box)
    assert "dropped 1 smaller component, 0.511 percent of the area" in repaired.actions
    plane = np.array([(-3, -3, -2), (3, -3, -2), (3, 3, -2), (-3, 3, -2)], dtype=float)
    w, g = np.vstack((v, plane)), np.vstack((f, np.array([[0, 1, 2], [0, 2, 3]]) + len(v)))
    assert np.array_equal(repair_mesh(w, g, keep_largest=True).v, v)


def test_numbers_after_a_repair_are_those_of_the_input(ball):
    """A stray piece before it is dropped; the hole is named by vertices of the input, and by its place."""
    v, f = ball
    w = np.vstack(([[9, 9, 9], [9, 9, 8], [9, 8, 9], [8, 9, 9]], v))
    g = np.vstack(([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], f[1:] + 4))
    with pytest.raises(MeshError, match="1 hole") as caught:
        repair_mesh(w, g, keep_largest=True)
    for a, b in re.findall(r"(\d+)-(\d+)", str(caught.value)):
        assert {int(a), int(b)} <= {*(f[0] + 4).tolist()}
    assert caught.value.remedy.options == {"keep_largest": True, "holes": "fill"}


@pytest.mark.parametrize("padded", ["quads", "PyVista's quads", "one row"])
def test_arrays_of_polygons_are_cut(padded):
    box = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    quads = np.array(
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    )
    f = quads
    if padded != "quads":
        f = np.column_stack((np.full(6, 4), quads))
    if padded == "one row":
        f = f.ravel()
    with pytest.raises(MeshError, match=r"triangulate .*\(repair_mesh\(v, f\) does\)"):
        check_mesh(box, f)
    repaired = repair_mesh(box, f)
    assert repaired.actions == ("triangulated 6 polygons",)
    assert repaired.face_source.tolist() == np.repeat(np.arange(6), 2).tolist()


@pytest.mark.parametrize("ravel", [False, True])
def test_padded_triangles_are_triangles(ravel, ball):
    v, f = ball
    padded = np.column_stack((np.full(len(f), 3), f))
    if ravel:
        padded = padded.ravel()
    assert np.array_equal(check_mesh(v, padded).f, f)
    assert repair_mesh(v, padded).actions == ()


def voxels(solid):
    """The surface of voxels, two triangles for each square between a full and an empty one."""
    full = np.pad(solid, 1)
    shape, faces = np.array(full.shape) + 1, []
    for axis in range(3):
        for up in (0, 1):
            low = np.argwhere(full & ~np.roll(full, 1 - 2 * up, axis=axis))
            low[:, axis] += up
            corners = [low + np.roll([0, i, j], axis) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]
            a, b, c, d = (
                np.ravel_multi_index(corner.T, shape) for corner in corners[:: 2 * up - 1]
            )
            faces += [np.column_stack((a, b, c)), np.column_stack((a, c, d))]
    used, f = np.unique(np.vstack(faces), return_inverse=True)
    return np.column_stack(np.unravel_index(used, shape)).astype(float), f.reshape(-1, 3)


def test_a_sheet_that_touches_itself_is_parted_where_the_body_is_empty():
    """A ring of voxels whose ends touch in an edge: a body without a handle, which needs no cut."""
    solid = np.zeros((3, 3, 1), dtype=bool)
    # (1, 0) and (2, 1) meet in an edge
    solid[[0, 0, 0, 1, 2, 2, 1], [0, 1, 2, 2, 2, 1, 0], 0] = True
    v, f = voxels(solid)
    with pytest.raises(
        MeshError, match=r"non-manifold edge: 1 edge .*\(repair_mesh\(v, f\) does\)"
    ):
        check_mesh(v, f)
    repaired = repair_mesh(v, f)
    assert repaired.actions[0] == "parted 1 edge where sheets meet"
    assert len(repaired.v) == len(v) + 2
    check_mesh(repaired.v, repaired.f)
    assert np.array_equal(repaired.v, v[repaired.vertex_source])
    inward = repair_mesh(v, f[:, ::-1])
    assert len(inward.v) == len(v) + 2


@pytest.mark.parametrize("seed", range(12))
def test_random_voxels_become_spheres(seed):
    """Edges and vertices where they touch, holes through them: every body of voxels is repaired."""
    rng = np.random.default_rng(seed)
    v, f = voxels(rng.random((5, 5, 5)) < rng.uniform(0.3, 0.8))
    repaired = repair_mesh(v, f, keep_largest=True, handles="cut")
    check_mesh(repaired.v, repaired.f)


def test_what_cannot_be_repaired_is_named(ball):
    v, f = ball
    for w, g, words in (
        (v, f[1:], r"1 hole \(3 edges\)"),
        (v, np.vstack([f, [[0, 1, 500]]]), "out of range"),
        (np.where(np.arange(len(v))[:, None] == 5, np.nan, v), f, r"1 hole .*holes='fill'\) does"),
        (v, f[:0], "no faces"),
    ):
        with pytest.raises(MeshError, match=words) as caught:
            repair_mesh(w, g)
        assert "\n" not in str(caught.value)


def test_weld_against_a_slow_one():
    points = np.random.default_rng(0).integers(0, 4, (300, 3)).astype(float)
    # 0 equals -0
    points[points == 0] *= np.random.default_rng(1).choice([-1, 1], (points == 0).sum())
    v, index = weld(points)
    seen: list[tuple[float, ...]] = []
    for point in map(tuple, points.tolist()):
        if point not in seen:
            seen.append(point)
    assert [tuple(row) for row in v.tolist()] == seen
    assert np.array_equal(v[index], points)


REPAIRABLE = (
    "degenerate_index_face",
    "dup_face",
    "dup_face_flipped",
    "half_faces_flipped",
    "misoriented_bunny_real",
    "nonmanifold_edge_dino",
    "nonmanifold_vertex_pinched",
    "nonmanifold_vertex_two_heads",
    "one_face_flipped",
    "quad_faces",
    "sphere_plus_torus_chi2",
    "triangle_soup_stl",
    "two_components_cortex",
    "two_components_same",
    "unreferenced_3",
    "unreferenced_hand_tetmesh",
    "unreferenced_mid",
)


@pytest.mark.corpus
@pytest.mark.parametrize(
    "path", sorted((CORPUS / "invalid").glob("*")) or [None], ids=lambda p: p and p.stem
)
def test_the_invalid_meshes(path):
    if path is None:
        pytest.skip("no meshes")
    mesh = read_mesh(path, triangulate=True)
    if path.stem not in REPAIRABLE:
        with pytest.raises(MeshError):
            repair_mesh(mesh.v, mesh.f, keep_largest=True)
        return
    repaired = repair_mesh(mesh.v, mesh.f, keep_largest=True)
    assert_consistent(repaired, mesh.v, mesh.f)
