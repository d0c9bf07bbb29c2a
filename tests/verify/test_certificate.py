"""The certificate finds every planted fault."""

import numpy as np
import pytest
from triangulations import icosphere, random_rotation

import igl_spheremap as ism
from igl_spheremap import MeshError

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
    with pytest.raises(ValueError, match="read-only"):
        result.sphere[0] = -result.sphere[0]
