"""Signs and certificates are exact for finite numbers of any size: rational arithmetic is the judge."""

from fractions import Fraction

import numpy as np
import pytest
from triangulations import delaunay_sphere, icosphere

import igl_spheremap as ism
from igl_spheremap.verify.signs import determinant_signs, orientation_signs

X, F = icosphere(2)


def rational_signs(a, b, c):
    """Signs by exact rational arithmetic: slow, and beyond doubt."""
    signs = []
    for rows in zip(a, b, c, strict=True):
        (p, q, r), (s, t, u), (v, w, z) = (
            [Fraction(float(number)) for number in row] for row in rows
        )
        det = p * (t * z - u * w) - q * (s * z - u * v) + r * (s * w - t * v)
        signs.append((det > 0) - (det < 0))
    return np.array(signs)


def nearly_flat(a, b, rng):
    """Third rows in the plane of the two others, up to rounding, and up to one unit in the last place of a number."""
    with np.errstate(all="ignore"):
        weight = rng.choice([-3.0, -2.0, -1.0, 1.0, 2.0, 3.0], size=(2, len(a), 1))
        c = weight[0] * a + weight[1] * b
        moved = rng.random(len(a)) < 0.7
        k = rng.integers(0, 3, size=len(a))[moved]
        c[moved, k] = np.nextafter(c[moved, k], rng.choice([-np.inf, np.inf], size=moved.sum()))
    return np.where(np.isfinite(c), c, 1.0)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("mixed", ["numbers", "rows", "columns", "scales", "near ones"])
def test_signs_are_those_of_rational_arithmetic_at_all_scales(mixed, seed):
    """Exponents from 2^-1074 to 2^1020, differing within a face: 2,400 determinants, most of them all but 0."""
    rng = np.random.default_rng(seed)
    shape = {
        "numbers": (2, 160, 3),
        "rows": (2, 160, 1),
        "columns": (1, 1, 3),
        "scales": (1, 160, 1),
        "near ones": (1, 160, 1),
    }[mixed]
    exponent = rng.integers(-1074, 1020, size=shape)
    if mixed == "near ones":
        exponent = exponent + rng.integers(-60, 60, size=(2, 160, 3))
    a, b = np.ldexp(rng.normal(size=(2, 160, 3)), np.clip(exponent, -1074, 1020))
    c = nearly_flat(a, b, rng)
    assert np.array_equal(determinant_signs(a, b, c), rational_signs(a, b, c))
    assert np.array_equal(determinant_signs(c, a, -b), -rational_signs(a, b, c))


@pytest.mark.parametrize("scale", [1.0, 1e-6, 1e-12, 1e-15])
def test_signs_are_those_of_rational_arithmetic_down_to_tiny_faces(scale):
    rng = np.random.default_rng(7)
    x, f = delaunay_sphere(60, rng)
    x = np.array([0.6, 0.0, 0.8]) + scale * rng.normal(size=x.shape)
    x /= np.linalg.norm(x, axis=1)[:, None]
    expected = rational_signs(*x[f.T])
    assert np.array_equal(orientation_signs(x, f), expected)
    certificate = ism.certify(x, f)
    assert np.array_equal(certificate.flipped, np.flatnonzero(expected < 0))
    assert np.array_equal(certificate.degenerate, np.flatnonzero(expected == 0))


@pytest.mark.parametrize("power", [*range(-360, -329, 3), -700, -1000, 300, 900])
def test_a_fold_of_one_unit_in_the_last_place_is_found_at_every_radius(power):
    """The third corner of a face lies in the plane of the two others but for one unit: every radius sees it alike."""
    rng = np.random.default_rng(abs(power))
    a, b = rng.normal(size=(2, 200, 3))
    c = nearly_flat(a, b, rng)
    expected = rational_signs(a, b, c)
    assert (expected < 0).sum() > 20
    assert np.array_equal(
        determinant_signs(*(np.ldexp(rows, power) for rows in (a, b, c))), expected
    )


@pytest.mark.parametrize(
    ("radius", "dtype"),
    [
        *(
            (radius, float)
            for radius in (1e-310, 1e-110, 1.1e-103, 1e-40, 1e105, 1e154, 1e300, 1e308)
        ),
        *((radius, np.float32) for radius in (1e-37, 1e-5, 1e38)),
    ],
)
def test_a_sphere_of_any_radius_is_judged_like_the_unit_sphere(radius, dtype):
    x = (radius * X).astype(dtype)
    certificate = ism.certify(x, F)
    assert len(certificate.off_sphere) == len(X)
    assert certificate.foldings == 0
    assert certificate.degree == 1
    x[[3, 50]] = x[[50, 3]]
    flipped = ism.certify(x, F).flipped
    assert np.array_equal(flipped, np.flatnonzero(rational_signs(*x[F.T]) < 0))
    assert len(flipped) >= 4


def test_a_sphere_of_two_thousand_smallest_steps_is_what_its_numbers_say():
    x = 1e-320 * X
    assert np.array_equal(orientation_signs(x, F), rational_signs(*x[F.T]))
    assert ism.certify(x, F).degree == 1


def test_rows_of_any_lengths_give_the_same_verdict():
    """Only directions count: each row has a radius of its own, from 1e-290 to 1e290."""
    radius = 2.0 ** np.random.default_rng(0).integers(-960, 960, size=(len(X), 1))
    certificate = ism.certify(radius * X, F)
    assert certificate.foldings == 0
    assert certificate.degree == 1
    assert ism.certify(-radius * X, F).degree == -1


def tip(size):
    """A sphere with a triangle of that size at the north pole; its rows are unit rows."""
    angle = 2 * np.pi * np.arange(3) / 3
    flat = np.column_stack((np.cos(angle), np.sin(angle)))
    x = np.vstack(
        (
            np.column_stack((size * flat, np.ones(3))),
            np.column_stack((flat, np.zeros(3))),
            [[0, 0, -1]],
        )
    )
    f = [[0, 1, 2]]
    for i, j in ((0, 1), (1, 2), (2, 0)):
        f += [[i, 3 + i, 3 + j], [i, 3 + j, j], [3 + j, 3 + i, 6]]
    return x, np.array(f)


@pytest.mark.parametrize("size", [1e-10, 1e-90, 1e-93, 1e-110, 1e-162, 1e-300, 1e-322])
def test_faces_at_a_pole_are_exact_down_to_the_smallest_numbers(size):
    x, f = tip(size)
    assert ism.certify(x, f).folding_free
    x[[1, 2]] = x[[2, 1]]
    assert 0 in ism.certify(x, f).flipped
    x[1] = x[2]
    assert 0 in ism.certify(x, f).degenerate


def test_a_double_cover_of_any_radius_is_found_by_its_degree():
    around = 12
    angle = 4 * np.pi * np.arange(around) / around
    x = np.vstack(
        (np.column_stack((np.cos(angle), np.sin(angle), 0 * angle)), [[0, 0, 1], [0, 0, -1]])
    )
    i = np.arange(around)
    j = (i + 1) % around
    f = np.vstack(
        (np.column_stack((i, j, 0 * i + around)), np.column_stack((j, i, 0 * i + around + 1)))
    )
    for radius in (1e-300, 1e-110, 1.0, 1e110, 1e300):
        certificate = ism.certify(radius * x, f)
        assert certificate.foldings == 0
        assert certificate.degree == 2


def test_a_row_that_is_not_finite_has_no_sign():
    x = X.copy()
    x[F[0, 0], 1] = np.nan
    assert (orientation_signs(x, F)[(F[0, 0] == F).any(axis=1)] == 0).all()
    assert (orientation_signs(x, F)[(F[0, 0] != F).all(axis=1)] == 1).all()
    assert orientation_signs(x, F[:0]).shape == (0,)
