"""Texture atlases: geometry unchanged, no face across the seam, coordinates that lead back to the sphere."""

from __future__ import annotations

import numpy as np
import pytest

from igl_spheremap import MeshError, samples
from igl_spheremap.mesh.measure import face_areas
from igl_spheremap.resampling.texture import checker_image, cut_along_planes, texture_atlas
from igl_spheremap.sphere.rows import unit_rows

OCTAHEDRON = np.vstack([np.eye(3), -np.eye(3)])
OCTAHEDRON_FACES = np.array(
    [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
)
TETRAHEDRON = unit_rows(np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]))
TETRAHEDRON_FACES = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
PROJECTIONS = ("equirectangular", "octahedral")


def turned(n_vertices: int, seed: int = 0):
    """A sphere in general position."""
    x, f = samples.sphere(n_vertices)
    return x @ np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0], f


def meshes():
    pinned, f = turned(642)
    pinned = np.where(
        np.abs(pinned - [0, 0, 1]).sum(axis=1).argsort().argsort()[:, None] == 0, [0, 0, 1], pinned
    )
    # the north pole is in the middle of an edge
    assert not (TETRAHEDRON[0] + TETRAHEDRON[3])[:2].any()
    return {
        "general": turned(642), "aligned": samples.sphere(642), "vertex at the pole": (pinned, f),
        "octahedron": (OCTAHEDRON, OCTAHEDRON_FACES), "tetrahedron": (TETRAHEDRON, TETRAHEDRON_FACES),
    }  # fmt: skip


def from_equirectangular(uv):
    longitude, latitude = (uv[:, 0] - 0.5) * 2 * np.pi, (uv[:, 1] - 0.5) * np.pi
    return np.column_stack(
        [
            np.cos(latitude) * np.cos(longitude),
            np.cos(latitude) * np.sin(longitude),
            np.sin(latitude),
        ]
    )


def from_octahedral(uv):
    a, b = (2 * uv - 1).T
    z = 1 - np.abs(a) - np.abs(b)
    lower = z < 0
    x = np.where(lower, (1 - np.abs(b)) * np.sign(a), a)
    y = np.where(lower, (1 - np.abs(a)) * np.sign(b), b)
    return unit_rows(np.column_stack([x, y, z]))


BACK = {"equirectangular": from_equirectangular, "octahedral": from_octahedral}


@pytest.mark.parametrize("projection", PROJECTIONS)
@pytest.mark.parametrize("name", meshes())
def test_coordinates_lead_back_to_the_sphere(name, projection):
    x, f = meshes()[name]
    atlas = texture_atlas(x, f, projection=projection)
    assert atlas.uv.min() >= 0
    assert atlas.uv.max() <= 1
    assert np.abs(BACK[projection](atlas.uv) - unit_rows(atlas.carry(x))).max() < 1e-12


@pytest.mark.parametrize("projection", PROJECTIONS)
@pytest.mark.parametrize("name", meshes())
def test_the_picture_is_covered_once(name, projection):
    """Coordinates of positive orientation whose areas sum to the whole square."""
    x, f = meshes()[name]
    atlas = texture_atlas(x, f, projection=projection)
    a, b, c = (atlas.uv[atlas.f[:, k]] for k in range(3))
    u, w = b - a, c - a
    area = (u[:, 0] * w[:, 1] - u[:, 1] * w[:, 0]) / 2
    assert area.min() > -1e-15
    covered = {"equirectangular": {"octahedron": 1 / 2, "tetrahedron": 1 / 2}, "octahedral": {}}
    if projection == "octahedral":
        # the octahedron's faces are flat: nothing is lost
        assert area.sum() == pytest.approx(1, abs=1e-12)
    elif name not in covered[projection]:
        # triangles at a pole cover half of their rectangle
        assert area.sum() == pytest.approx(1, abs=0.06)


@pytest.mark.parametrize("projection", PROJECTIONS)
def test_the_surface_is_unchanged(projection):
    """The same area, the same normals, and the old vertices where they were."""
    x, f = turned(642)
    v = x * [1, 2, 3]
    atlas = texture_atlas(x, f, projection=projection)
    w = atlas.carry(v)
    assert face_areas(w, atlas.f).sum() == pytest.approx(face_areas(v, f).sum(), rel=1e-12)
    assert np.allclose(atlas.carry(np.ones(len(v))), 1)
    rows = atlas.weights.tocsr()
    whole = np.flatnonzero(np.diff(rows.indptr) == 1)
    assert set(rows[whole].indices) == set(range(len(v)))
    assert np.array_equal(w[whole], v[rows[whole].indices])


def test_only_the_seam_is_doubled():
    x, f = turned(2562)
    atlas = texture_atlas(x, f)
    y = atlas.carry(x)
    _, index, count = np.unique(y.round(12), axis=0, return_inverse=True, return_counts=True)
    doubled = unit_rows(y[count[index] > 1])
    assert np.abs(doubled[:, 1]).max() < 1e-12
    assert doubled[:, 0].max() < 1e-12
    assert 50 < len(doubled) < 0.1 * len(x)


def test_faces_are_short_in_the_picture():
    """No face runs back across the picture."""
    x, f = turned(2562)
    atlas = texture_atlas(x, f)
    span = np.ptp(atlas.uv[atlas.f], axis=1)
    assert span[:, 0].max() <= 0.25 + 1e-12  # cut at each quarter
    polar = np.abs(np.abs(atlas.uv[atlas.f, 1] - 0.5)).max(axis=1) > 0.4
    assert span[~polar, 0].max() < 0.05


@pytest.mark.parametrize("axes", [(0,), (1, 2), (0, 1, 2)])
def test_cutting_leaves_no_face_across_a_plane_and_a_closed_surface(axes):
    x, f = turned(162)
    cut = cut_along_planes(x, f, axes)
    for axis in axes:
        side = cut.x[cut.f, axis]
        assert (side.min(axis=1) * side.max(axis=1) >= 0).all()
    edges = {
        tuple(edge)
        for face in cut.f.tolist()
        for edge in zip(face, face[1:] + face[:1], strict=True)
    }
    assert len(edges) == 3 * len(cut.f)
    assert {(j, i) for i, j in edges} == edges
    assert len(cut.x) - len(cut.f) // 2 == 2
    assert np.array_equal(cut.x[: len(x)], x)


def test_refusals():
    with pytest.raises(MeshError, match="index out of range"):
        texture_atlas(OCTAHEDRON, OCTAHEDRON_FACES + 1)
    with pytest.raises(ValueError, match="equirectangular, octahedral"):
        texture_atlas(OCTAHEDRON, OCTAHEDRON_FACES, projection="mercator")
    with pytest.raises(MeshError, match="images are zero or not finite in 1 row"):
        texture_atlas(OCTAHEDRON * [[1], [1], [1], [1], [1], [0]], OCTAHEDRON_FACES)


def test_the_colours_of_the_checker_show_the_place():
    image = checker_image(64, 4)
    assert image.dtype == np.uint8
    corners = image[[0, 0, -1, -1], [0, -1, 0, -1]].astype(int)
    assert (corners[[1, 3], 0] > corners[[0, 2], 0]).any()
    assert (image[:16, :16] != image[:16, 16:32]).any()


def test_without_cuts_the_mesh_stays_and_longitudes_run_on():
    for x, f in meshes().values():
        atlas = texture_atlas(x, f, cut=False)
        assert np.array_equal(atlas.vertex[atlas.f], f)
        assert np.array_equal(atlas.carry(x), x[atlas.vertex])
        back = from_equirectangular(atlas.uv)
        assert np.allclose(back, unit_rows(x)[atlas.vertex], atol=1e-12)
        assert np.ptp(atlas.uv[atlas.f][..., 0], axis=1).max() <= 1
    with pytest.raises(ValueError, match="octahedral"):
        texture_atlas(x, f, projection="octahedral", cut=False)
