"""The certificate finds every planted fault."""

from fractions import Fraction

import numpy as np
import pytest
from triangulations import icosphere, random_rotation

import igl_spheremap as ism
from igl_spheremap import MeshError
from igl_spheremap.sphere.rows import unit_rows
from igl_spheremap.verify.certificate import after_change

X, F = icosphere(2)


def test_the_identity_is_certified():
    certificate = ism.certify(X, F)
    assert certificate.folding_free
    assert certificate.degree == 1
    assert "folding-free" in str(certificate)


def test_a_planted_fold_is_found_where_it_is():
    x = X.copy()
    x[[3, 50]] = x[[50, 3]]
    certificate = ism.certify(x, F)
    touched = np.flatnonzero(np.isin(F, [3, 50]).any(axis=1))
    assert not certificate.folding_free
    assert len(certificate.flipped)
    assert set(certificate.flipped) <= set(touched)


@pytest.mark.parametrize("seed", range(4))
def test_the_certificate_of_a_changed_map_is_that_of_the_whole_map(seed):
    rng = np.random.default_rng(seed)
    for size in (0.0, 0.1, 1.0, 3.0):
        x = unit_rows(X + 0.1 * rng.normal(size=X.shape)) * rng.choice([-1.0, 1.0])
        y, moved = x.copy(), rng.choice(len(X), 60)
        y[moved] = unit_rows(x[moved] + size * rng.normal(size=(60, 3)))
        y[moved[0]] = y[moved[1]]
        changed = np.flatnonzero(np.isin(F, moved).any(axis=1))
        found, whole = after_change(ism.certify(x, F), x, y, F, changed), ism.certify(y, F)
        assert found.flipped.tolist() == whole.flipped.tolist()
        assert found.degenerate.tolist() == whole.degenerate.tolist()
        assert (found.degree, found.faces) == (whole.degree, whole.faces)


def test_a_change_that_leaves_the_sphere_is_named():
    y = X.copy()
    y[7] *= 2
    changed = np.flatnonzero((F == 7).any(axis=1))
    assert after_change(ism.certify(X, F), X, y, F, changed).off_sphere.tolist() == [7]
    y[7] = np.nan
    assert after_change(ism.certify(X, F), X, y, F, changed).not_finite.tolist() == [7]


def test_a_mirrored_map_is_all_flipped_and_has_degree_minus_one():
    certificate = ism.certify(X * [1, 1, -1], F)
    assert len(certificate.flipped) == len(F)
    assert certificate.degree == -1
    assert not certificate.folding_free


def double_cover():
    """A sphere wrapped twice around itself, branched at the poles: all signs positive, degree 2."""
    rings, around = 7, 12
    latitude = np.pi * np.arange(1, rings) / rings
    angle = 4 * np.pi * np.arange(around) / around
    x = [[0, 0, 1.0]] + [
        [np.sin(t) * np.cos(a), np.sin(t) * np.sin(a), np.cos(t)] for t in latitude for a in angle
    ]
    x.append([0, 0, -1.0])

    def at(i, j):
        return 1 + i * around + j % around

    f = []
    for j in range(around):
        f.append([0, at(0, j), at(0, j + 1)])
        f.append([len(x) - 1, at(rings - 2, j + 1), at(rings - 2, j)])
        for i in range(rings - 2):
            f += [
                [at(i, j), at(i + 1, j), at(i + 1, j + 1)],
                [at(i, j), at(i + 1, j + 1), at(i, j + 1)],
            ]
    return np.array(x), np.array(f)


def test_a_double_cover_is_found_by_its_degree_alone():
    certificate = ism.certify(*double_cover())
    assert len(certificate.flipped) == len(certificate.degenerate) == 0
    assert certificate.degree == 2
    assert not certificate.folding_free


def test_a_collapsed_patch_is_degenerate():
    x = X.copy()
    patch = np.isin(F, np.flatnonzero(X[:, 2] > 0.8)).all(axis=1)
    x[X[:, 2] > 0.8] = [0, 0, 1]
    certificate = ism.certify(x, F)
    assert set(np.flatnonzero(patch)) <= set(certificate.degenerate)
    assert not certificate.folding_free


def test_everything_at_one_point_has_degree_zero():
    certificate = ism.certify(np.tile([0, 0, 1.0], (len(X), 1)), F)
    assert len(certificate.degenerate) == len(F)
    assert certificate.degree == 0


def test_a_map_to_half_the_sphere_has_degree_zero():
    x = X * [1, 1, 0.5]
    x[:, 2] = np.abs(x[:, 2]) + 0.1
    x /= np.linalg.norm(x, axis=1)[:, None]
    certificate = ism.certify(x, F)
    assert certificate.degree == 0
    assert not certificate.folding_free


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_numbers_that_are_none_are_named(value):
    x = X.copy()
    x[5, 1] = value
    certificate = ism.certify(x, F)
    assert certificate.not_finite.tolist() == [5]
    assert not certificate.folding_free
    assert "not finite" in str(certificate)


def test_rows_off_the_unit_sphere_are_named():
    x = X.copy()
    x[5] *= 1.01
    x[8] = 0
    certificate = ism.certify(x, F)
    assert certificate.off_sphere.tolist() == [5, 8]
    assert not certificate.folding_free
    assert str(certificate).startswith("not folding-free")  # row 8 has no direction
    assert str(ism.certify(1.01 * X, F)).startswith(
        f"no face folds, but: {len(X)} vertices off the unit sphere"
    )


def test_single_precision_is_close_enough_to_the_sphere():
    assert ism.certify(X.astype(np.float32), F).folding_free


def test_faces_are_checked_too():
    with pytest.raises(ism.MeshError, match="open surface"):
        ism.certify(X, F[1:])
    with pytest.raises(ism.MeshError, match="unreferenced"):
        ism.certify(np.vstack((X, X[:1])), F)


def solid_angle_degree(x, f):
    """Degree by the sum of signed solid angles (Van Oosterom and Strackee 1983)."""
    a, b, c = (x[f[:, k]] for k in range(3))
    det = np.einsum("ij,ij->i", a, np.cross(b, c))
    rest = 1 + (a * b).sum(1) + (b * c).sum(1) + (c * a).sum(1)
    return 2 * np.arctan2(det, rest).sum() / (4 * np.pi)


@pytest.mark.parametrize("seed", range(12))
def test_degree_is_that_of_solid_angles_on_wild_maps(seed):
    rng = np.random.default_rng(seed)
    x = X + rng.normal(size=X.shape) * rng.choice([0.1, 0.5, 2.0])
    x /= np.linalg.norm(x, axis=1)[:, None]
    expected = solid_angle_degree(x, F)
    assert abs(expected - round(expected)) < 1e-9
    assert ism.certify(x, F).degree == round(expected)


@pytest.mark.parametrize("seed", range(4))
def test_degree_survives_symmetric_positions(seed):
    """Directions that lie on edges or vertices must not confuse the count."""
    x, f = icosphere(0)
    assert ism.certify(x @ random_rotation(seed), f).degree == 1
    octahedron = np.vstack((np.eye(3), -np.eye(3)))
    faces = [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
    assert ism.certify(octahedron, faces).degree == 1


@pytest.mark.parametrize("dtype", ["longdouble", "int64"])
def test_numbers_that_float64_would_round_are_refused(dtype):
    if np.finfo(np.longdouble).eps == np.finfo(float).eps:
        pytest.skip("longdouble is float64 on this machine")
    x = X.astype(np.longdouble)
    exact, f = x.astype(np.float64), F
    # the same numbers in more digits
    assert ism.certify(exact.astype(np.longdouble), f).folding_free
    x[7] *= 1 + np.finfo(np.longdouble).eps
    if dtype == "int64":
        x = (X * 2**60).astype(np.int64) | 1
    with pytest.raises(MeshError, match=f"dtype {np.dtype(dtype)} are not float64 numbers"):
        ism.certify(x, f)


@pytest.mark.parametrize("kind", ["int64", "uint64", "list"])
def test_whole_numbers_beyond_float64_are_refused_in_the_plane_too(kind, tmp_path):
    """Rounded to float64, the third corner would lie on the other side of the line through the first two."""
    rng = np.random.default_rng(0)
    for _ in range(10):
        k = int(rng.integers(2**53, 2**60)) | 1
        corners = [[0, 0], [2 * k, 2 * k], [k, k - 1]]
        p = [[0.5, 0], *corners[1:]] if kind == "list" else np.array(corners, dtype=kind)
        with pytest.raises(MeshError, match="are not float64 numbers in"):
            ism.certify(p, [[0, 2, 1]])
        if kind != "list":
            np.savez(tmp_path / "map.npz", vertices=np.eye(3), faces=[[0, 1, 2]], plane=p)
            with pytest.raises(MeshError, match="are not float64 numbers in"):
                ism.read_plane_map(tmp_path / "map.npz")
    assert ism.certify(np.array([[0, 0], [2**60, 0], [0, 2**60]]), [[0, 1, 2]]).folding_free


def test_the_map_of_a_certificate_can_t_be_changed():
    result = ism.spherical_conformal_map(X * [1, 1.2, 1.5], F)
    disk = ism.disk_conformal_map(X, F[1:])
    for array in (
        *(result.sphere, result.faces, result.vertices, result.rebalance(0.5).sphere),
        *(disk.plane, disk.faces, disk.vertices, ism.flatten(X, F[1:]).plane),
    ):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = array[1]


def test_results_are_of_copies():
    """Neither can a change of what was given change a result, nor does a result make it read-only."""
    v, f, x = X * [1, 1.2, 1.5], F.copy(), X.copy()
    result = ism.sphere_map(v, f, x)
    for given in (v, f, x):
        given[:] = given[::-1].copy()
    assert ism.certify(result.sphere, result.faces).folding_free
    assert (result.vertices == X * [1, 1.2, 1.5]).all()
    assert (result.faces == F).all()


def exact_determinant(a, b, c):
    (a0, a1, a2), (b0, b1, b2), (c0, c1, c2) = a, b, c
    return a0 * (b1 * c2 - b2 * c1) + a1 * (b2 * c0 - b0 * c2) + a2 * (b0 * c1 - b1 * c0)


def exact_sign(*rows):
    determinant = exact_determinant(*rows)
    return (determinant > 0) - (determinant < 0)


def exact_degree(x, f, rng):
    """Signed count of the faces over a direction that lies in no plane through the origin and an edge."""
    while True:
        q = [Fraction(int(n)) for n in rng.integers(-(2**40), 2**40, 3)]
        total = 0
        for a, b, c in f.tolist():
            sides = [exact_sign(q, x[i], x[j]) for i, j in ((a, b), (b, c), (c, a))]
            if 0 in sides:
                break
            if len(set(sides)) == 1 and sides[0] == exact_sign(x[a], x[b], x[c]):
                total += sides[0]
        else:
            return total


def double_pyramid(n):
    """Triangles of a ring of n vertices, and of one on either side."""
    k = np.arange(n)
    upper = np.column_stack((np.full(n, n), k, (k + 1) % n))
    lower = np.column_stack((np.full(n, n + 1), (k + 1) % n, k))
    return np.concatenate((upper, lower))


def few_rows(n, rng):
    """Unit rows as exotic as float64 has them: coordinates and distances from the ends of axes of any size."""
    tiny = 10.0 ** -rng.integers(0, 322, size=(n, 1))
    ends = np.eye(3)[rng.integers(3, size=n)] * rng.choice([-1.0, 1.0], (n, 1))
    kinds = (
        rng.normal(size=(n, 3)),
        rng.normal(size=(n, 3)) * 10.0 ** rng.integers(-320, 3, size=(n, 3)),
        ends + tiny * rng.normal(size=(n, 3)),
        ends + tiny[0] * rng.integers(-2, 3, size=(n, 3)),
        rng.integers(-1, 2, size=(n, 3)) + tiny[0] * rng.integers(-2, 3, size=(n, 3)),
    )
    x = kinds[rng.integers(len(kinds))]
    x[~x.any(axis=1)] = [0, 0, 1]
    return unit_rows(x)


@pytest.mark.parametrize("seed", range(4))
def test_the_certificate_of_few_vertices_is_that_of_fractions(seed):
    rng = np.random.default_rng(seed)
    meshes = [np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])]
    meshes += [double_pyramid(n) for n in (3, 4, 5)]
    for _ in range(150):
        f = meshes[rng.integers(len(meshes))]
        x = few_rows(f.max() + 1, rng)
        found, exact = ism.certify(x, f), [[Fraction(each) for each in row] for row in x.tolist()]
        signs = np.array([exact_sign(*(exact[k] for k in face)) for face in f])
        assert found.flipped.tolist() == np.flatnonzero(signs < 0).tolist()
        assert found.degenerate.tolist() == np.flatnonzero(signs == 0).tolist()
        if (signs != 0).all():
            assert found.degree == exact_degree(exact, f, rng)


def rings(depth, around=3):
    """A map of rings about an axis, from within 10^-depth of one pole to as near to the other one."""
    t = 2 * np.pi * np.arange(around) / around
    size = 10.0**-depth
    low, high = (
        np.column_stack((size * np.cos(t), size * np.sin(t), np.full(around, side)))
        for side in (-1.0, 1.0)
    )
    k = np.arange(around)
    next_k = (k + 1) % around
    f = [np.column_stack((np.full(around, 2 * around), next_k, k))]
    f += [
        np.column_stack((k, next_k, around + next_k)),
        np.column_stack((k, around + next_k, around + k)),
    ]
    f += [np.column_stack((np.full(around, 2 * around + 1), around + k, around + next_k))]
    x = np.vstack((low, high, [[0, 0, -1.0], [0, 0, 1.0]]))
    v = np.vstack((low * [1 / size, 1 / size, 1], high * [1 / size, 1 / size, 1], 2 * x[-2:]))
    return v, np.concatenate(f), x


@pytest.mark.parametrize("depth", [20, 100, 163, 250, 307])
def test_maps_within_any_distance_of_both_poles_are_maps(depth):
    """Directions between corners cancel there; every door takes them."""
    v, f, x = rings(depth)
    assert ism.certify(x, f).folding_free
    assert not ism.certify(x, f[:, ::-1]).folding_free
    result = ism.sphere_map(v, f, x)
    assert ism.repair_foldings(v, f, x).certificate.folding_free
    face, weights = ism.SphereLocator(x, f).locate(x)
    assert (f[face, weights.argmax(axis=1)] == np.arange(len(x))).all()
    assert np.isfinite(result.angle_differences()).all()
