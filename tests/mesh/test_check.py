"""The check of a mesh takes inputs of clear meaning, and names every fault."""

import igl
import numpy as np
import pytest
from triangulations import flip_edges, icosphere

import igl_spheremap as ism
from igl_spheremap.mesh.check import check_faces

V, F = icosphere(2)


def fault(v, f):
    with pytest.raises(ism.MeshError) as caught:
        ism.check_mesh(v, f)
    message = str(caught.value)
    assert "\n" not in message
    return message


@pytest.mark.parametrize(
    "v",
    [
        V.tolist(),
        V.astype(np.float32),
        V.astype(">f8"),
        np.asfortranarray(V),
        np.repeat(V, 2, axis=0)[::2],
        (1000 * V).astype(np.int32),
    ],
    ids=["list", "float32", "big-endian", "fortran", "strided", "integers"],
)
@pytest.mark.parametrize(
    "f",
    [
        F.tolist(),
        F.astype(np.int32),
        F.astype(">i4"),
        F.astype(np.uint64),
        np.asfortranarray(F),
        F.astype(float),
    ],
    ids=["list", "int32", "big-endian", "unsigned", "fortran", "whole floats"],
)
def test_input_of_any_layout_means_the_same(v, f):
    mesh = ism.check_mesh(v, f)
    assert np.array_equal(mesh.f, F)
    assert mesh.f.dtype == np.int64
    assert mesh.unit.flags.c_contiguous
    assert np.allclose(mesh.unit, ism.check_mesh(V, F).unit, atol=2e-3)
    ism.gauss_map(v, f)  # and libigl takes what the check makes of it


def test_read_only_input_is_neither_refused_nor_changed():
    v, f = V.copy(), F.copy()
    v.flags.writeable = f.flags.writeable = False
    mesh = ism.check_mesh(v, f)
    assert not np.shares_memory(mesh.v, v)
    assert not np.shares_memory(mesh.f, f)
    assert not np.shares_memory(check_faces(f, len(v)), f)


@pytest.mark.parametrize(
    ("scale", "shift"), [(1e-7, 0), (1e150, 0), (1e-150, 0), (1, 1e5), (3, -2)]
)
def test_source_is_scaled_to_unit_area(scale, shift):
    mesh = ism.check_mesh(scale * V + shift, F)
    assert np.array_equal(mesh.v, scale * V + shift)
    assert np.isclose(igl.doublearea(mesh.unit, mesh.f).sum() / 2, 1)
    assert np.allclose(mesh.unit, ism.check_mesh(V, F).unit, atol=1e-9)


def test_positions_on_a_line_are_legitimate():
    mesh = ism.check_mesh(V[:, [0]] * [1.0, 2.0, 3.0], F)
    assert np.isfinite(mesh.unit).all()
    assert np.abs(mesh.unit).max() <= 1


def test_any_triangulated_sphere_passes():
    f = flip_edges(F, 2000, np.random.default_rng(1))
    assert np.array_equal(ism.check_mesh(V, f).f, f)


def planted(change):
    v, f = V.copy(), F.copy()
    return change(v, f) or (v, f)


def pinch(v, f):
    f[f == 100] = 0
    f[f == len(v) - 1] = 100
    return v[:-1], f


def two(v, f):
    return np.vstack((v, v + 3)), np.vstack((f, f + len(v)))


def flip_first(v, f):
    f[0] = f[0, ::-1]


def flip_every_second(v, f):
    f[::2] = f[::2, ::-1]


def set_nan(v, f):
    v[7, 1] = np.nan


def set_infinite(v, f):
    v[9, 2] = -np.inf


@pytest.mark.parametrize(
    ("change", "names"),
    [
        (set_nan, ["not finite", "7"]),
        (set_infinite, ["not finite", "9"]),
        (
            lambda v, f: (v, f[1:]),
            ["open surface: 1 hole (3 edges) near (", "repair_mesh(v, f, holes='fill') does"],
        ),
        (
            lambda v, f: (v, np.vstack((f, f[5]))),
            ["non-manifold edge", "1 face given twice, e.g. 5:"],
        ),
        (lambda v, f: (v, np.vstack((f, [[3, 3, 4]]))), ["degenerate", str(len(F))]),
        (lambda v, f: (v, f + 1), ["out of range", "1-based"]),
        (lambda v, f: (v, f - 1), ["out of range", "-1"]),
        (lambda v, f: (np.vstack((v, [[0, 0, 9]])), f), ["unreferenced", str(len(V))]),
        (flip_first, ["inconsistent orientation: 3 edges"]),
        (flip_every_second, ["inconsistent orientation"]),
        (pinch, ["non-manifold vertex: 1 vertex", "e.g. 0;"]),
        (two, ["2 components of 320, 320 faces"]),
        (lambda v, f: (0 * v + 5, f), ["zero area"]),
        (lambda v, f: (v, f[:0]), ["no faces"]),
        (lambda v, f: (v[:0], f), ["no vertices"]),
        (lambda v, f: (v, np.hstack((f, f[:, :1]))), ["triangles"]),
        (lambda v, f: (v[:, :2], f), ["three coordinates"]),
        (lambda v, f: (v.T, f), ["transposed"]),
        (lambda v, f: (v, f.T), ["transposed"]),
        (lambda v, f: (v, f + 0.5), ["whole numbers"]),
        (lambda v, f: (v, f + 1e300), ["whole numbers of 64 bits"]),
        (lambda v, f: (v, f * np.nan), ["whole numbers"]),
        (lambda v, f: (v.astype(complex), f), ["complex"]),
        (lambda v, f: (v.astype(str), f), ["dtype"]),
        (lambda v, f: (None, f), ["dtype"]),
        (lambda v, f: (v, [[0, 1, 2], [0, 1]]), ["ragged"]),
        (lambda v, f: (np.ma.masked_array(v, v > 2), f), ["vertices are a masked array"]),
        (lambda v, f: (v, np.ma.masked_array(f, f == 3)), ["faces are a masked array"]),
        (lambda v, f: (v[:3], [[0, 1, 2], [0, 2, 1]]), ["3 vertices", "at least 4"]),
    ],
)
def test_each_fault_is_named_with_its_place(change, names):
    message = fault(*planted(change))
    for name in names:
        assert name in message


def test_two_triangles_make_no_surface_for_any_function():
    """Faces without a repeated directed edge, Euler characteristic 2: only the number of vertices gives it away."""
    v, f = np.eye(3), [[0, 1, 2], [0, 2, 1]]
    for refused in (
        lambda: check_faces(f, 3),
        lambda: ism.certify(v, f),
        lambda: ism.spherical_conformal_map(v, f),
        lambda: ism.repair_mesh(v, f),
        lambda: ism.repair_foldings(v, f, v),
    ):
        with pytest.raises(ism.MeshError, match="3 vertices: a closed surface has at least 4"):
            refused()


def grid(twist):
    """Torus, or Klein bottle if one seam is glued with a twist: 8 by 8 vertices."""

    def at(i, j):
        return (i % 8) * 8 + (-j if twist and i // 8 % 2 else j) % 8

    return np.array(
        [
            t
            for i in range(8)
            for j in range(8)
            for t in (
                (at(i, j), at(i + 1, j), at(i + 1, j + 1)),
                (at(i, j), at(i + 1, j + 1), at(i, j + 1)),
            )
        ]
    )


def test_handles_are_counted():
    v = np.random.default_rng(0).normal(size=(64, 3))
    assert "genus 1" in fault(v, grid(twist=False))


def test_one_sided_surfaces_are_distinguished_from_misoriented_ones():
    v = np.random.default_rng(0).normal(size=(64, 3))
    assert "not orientable" in fault(v, grid(twist=True))


def test_characteristic_two_is_not_enough():
    # Sphere - torus - sphere, each pinched to the next at a vertex: Euler characteristic 2, and no sphere.
    n = len(V)
    torus = grid(twist=False) + n
    far = F + n + 64
    f = np.vstack((F, torus, far))
    f[f == n] = 0
    f[f == n + 64] = n + 9
    used, f = np.unique(f, return_inverse=True)
    f = f.reshape(-1, 3)
    assert len(used) - len(f) * 3 // 2 + len(f) == 2
    assert "3 components" in fault(np.random.default_rng(0).normal(size=(len(used), 3)), f)


def test_results_share_no_memory_with_what_was_given():
    v, f, x = V.copy(), F.copy(), V.copy()
    for result in (
        ism.spherical_conformal_map(v, f),
        ism.repair_foldings(v, f, x),
        ism.sphere_map(v, f, x),
    ):
        for made in (result.vertices, result.faces, result.sphere):
            assert not any(np.shares_memory(made, given) for given in (v, f, x))


@pytest.mark.parametrize(
    "use",
    [
        lambda masked: ism.certify(masked, F),
        lambda masked: ism.repair_foldings(V, F, masked),
        lambda masked: ism.cayley_update(V, masked, 1.0),
        lambda masked: ism.angle_differences(V, F, masked),
        lambda masked: ism.SphereLocator(V, F).locate(masked),
        lambda masked: ism.transfer(ism.SphereLocator(V, F), masked[:, 0], V),
        lambda masked: ism.texture_atlas(V, F).carry(masked),
        lambda masked: ism.texture_atlas(masked, F),
        lambda masked: ism.shapes.from_grid(masked[:4, :2], V),
        lambda masked: ism.shapes.spherical_harmonics(ism.sphere_map(V, F, V), masked),
    ],
)
def test_masked_arrays_are_refused_wherever_arrays_are_taken(use):
    with pytest.raises(ism.MeshError, match="are a masked array"):
        use(np.ma.masked_array(V, V > 0.9))


def test_meshes_that_only_move_share_what_their_faces_say():
    mapper = ism.SphereMapper(V, F)
    edges = mapper.mesh.edges
    mapper.move(V @ np.diag([1, 2, 3]))
    assert mapper.mesh.edges is edges


def test_a_map_stands_for_its_sphere_and_its_faces():
    result = ism.sphere_map(V, F, V)
    assert str(ism.certify(result)) == str(ism.certify(V, F))
    points = np.random.default_rng(0).normal(size=(20, 3))
    ours, theirs = (ism.SphereLocator(*given).locate(points) for given in ((result,), (V, F)))
    assert np.array_equal(ours.face, theirs.face)
    assert np.array_equal(ours.weights, theirs.weights)
    for projection in ("equirectangular", "octahedral"):
        atlas = ism.texture_atlas(result, projection=projection)
        assert np.array_equal(atlas.uv, ism.texture_atlas(V, F, projection=projection).uv)
    with pytest.raises(TypeError, match="faces are missing"):
        ism.certify(V)


@pytest.mark.parametrize(
    "use",
    [
        lambda result: ism.check_mesh(result, F),
        lambda result: ism.spherical_conformal_map(V, result),
        lambda result: ism.angle_differences(V, F, result),
        lambda result: ism.repair_foldings(V, F, result),
        lambda result: ism.repair_mesh(result, F),
        lambda result: ism.SphereLocator(result).locate(result),
        lambda result: ism.landmark_map(V, F, [0, 1], result),
    ],
)
def test_a_map_where_arrays_are_wanted_is_refused_in_words(use):
    with pytest.raises(
        ism.MeshError, match="are a SphereMap; give its vertices, its faces or its sphere"
    ):
        use(ism.sphere_map(V, F, V))


def test_data_without_a_column_are_refused():
    result = ism.sphere_map(V * [1, 1, 2], F, V)
    nothing = np.empty((len(V), 0))
    with pytest.raises(ism.MeshError, match="of one number or more"):
        ism.shapes.register(result, result, features=(nothing, nothing))
    with pytest.raises(ism.MeshError, match="of one number or more"):
        ism.shapes.spherical_harmonics(result, nothing)
