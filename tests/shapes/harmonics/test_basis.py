"""The real basis: closed forms, the addition theorem, scipy's own functions."""

from __future__ import annotations

import math
from decimal import Decimal, localcontext
from fractions import Fraction

import numpy as np
import pytest
import scipy.special

from igl_spheremap.shapes.harmonics.basis import (
    analysis,
    degree_of,
    gauss_rows,
    grid_points,
    legendre,
    longitudes,
    power,
    synthesis,
)
from igl_spheremap.sphere.rows import unit_rows


def points(n, seed=0):
    return unit_rows(np.random.default_rng(seed).normal(size=(n, 3)))


def basis(degree, x):
    return synthesis(np.eye((degree + 1) ** 2), x)


def test_low_degrees_are_the_known_polynomials():
    p = np.concatenate((points(50), [[0, 0, 1], [0, 0, -1], [1, 0, 0]]))
    x, y, z = p.T
    first = np.sqrt(0.75 / np.pi) * np.stack((y, z, x), axis=1)
    second = np.sqrt(3.75 / np.pi) * np.stack(
        (x * y, y * z, (3 * z**2 - 1) / np.sqrt(12), x * z, (x**2 - y**2) / 2), axis=1
    )
    known = np.concatenate((np.full((len(p), 1), np.sqrt(0.25 / np.pi)), first, second), axis=1)
    assert np.abs(basis(2, p) - known).max() < 1e-14


def test_addition_theorem():
    """The sum over m of Y_lm(a) Y_lm(b) is (2 l + 1) / (4 pi) P_l(a . b)."""
    degree = 40
    a, b = basis(degree, points(20, 1)), basis(degree, points(20, 2))
    cosine = np.einsum("ij,ij->i", points(20, 1), points(20, 2))
    for ell in range(degree + 1):
        rows = slice(ell * ell, (ell + 1) ** 2)
        known = (2 * ell + 1) / (4 * np.pi) * scipy.special.eval_legendre(ell, cosine)
        assert np.abs((a[:, rows] * b[:, rows]).sum(axis=1) - known).max() < 2e-13


@pytest.mark.skipif(
    not hasattr(scipy.special, "sph_harm_y"), reason="scipy 1.15 brings these functions"
)
def test_the_basis_is_scipys_without_the_phase():
    degree, x = 12, points(50)
    ours = basis(degree, x)
    theta, phi = np.arctan2(np.hypot(x[:, 0], x[:, 1]), x[:, 2]), np.arctan2(x[:, 1], x[:, 0])
    for ell in range(degree + 1):
        for m in range(-ell, ell + 1):
            Y = scipy.special.sph_harm_y(ell, abs(m), theta, phi) * (-1) ** m
            real = Y.real if m == 0 else np.sqrt(2) * (Y.real if m > 0 else Y.imag)
            assert np.abs(ours[:, ell * ell + ell + m] - real).max() < 1e-14


def exact_legendre(degree, z, s):
    """Rows m = 0 ... degree of P_degree,m at a rational point of the circle, rounded once."""
    rows = []
    for m in range(degree + 1):
        last, P = Fraction(0), Fraction(1)
        for k in range(m):
            P *= (2 * k + 1) * s
        for ell in range(m + 1, degree + 1):
            last, P = P, ((2 * ell - 1) * z * P - (ell + m - 1) * last) / (ell - m)
        square = P * P * (2 * degree + 1) / Fraction(math.perm(degree + m, 2 * m))
        rows.append(math.copysign(math.sqrt(square / 4) / math.sqrt(math.pi), P))
    return np.array(rows)


@pytest.mark.parametrize("degree", [5, 20, 50])
def test_the_functions_are_exact_to_what_rounding_the_point_costs(degree):
    """Near the poles, too, where recurrences in z lose half the digits."""
    for text in ("1/1000", "1/100", "1/17", "1/3", "1", "4", "99"):
        u = Fraction(text)  # the tangent of half the colatitude
        z, s = (1 - u * u) / (1 + u * u), 2 * u / (1 + u * u)
        *_, P = legendre(degree, np.array([float(z)]), np.array([float(s)]))
        assert np.abs(P[:, 0] - exact_legendre(degree, z, s)).max() < 4e-16 * degree


def test_orders_that_underflow_do_no_harm():
    """Near a pole sin(theta)^m leaves the range of float64; the zonal functions there are those of Legendre."""
    x = np.array([[1e-9, 0, 1]])
    c = np.zeros((601**2, 1))
    c[600 * 600 + 600] = 1
    assert np.allclose(synthesis(c, x), np.sqrt(1201 / (4 * np.pi)), rtol=1e-10)


@pytest.mark.parametrize("height", [1.0, -1.0])
def test_points_next_to_a_pole_have_the_values_of_the_pole(height):
    """At subnormal distances a division overflows."""
    c, tiny = np.random.default_rng(0).normal(size=(49, 2)), np.finfo(float).smallest_subnormal
    x = [[a, b, height] for a in (0, tiny, -7 * tiny, 1e-310) for b in (0, tiny, 1e-309, -1e-320)]
    assert np.allclose(
        synthesis(c, np.array(x)), synthesis(c, np.array([[0, 0, height]])), rtol=1e-14, atol=1e-14
    )


def test_power_counts_each_degree_once():
    c = np.random.default_rng(3).normal(size=(36, 2))
    assert degree_of(c) == 5
    assert np.isclose(power(c).sum(), (c**2).sum())
    assert np.isclose(power(c)[2], (c[4:9] ** 2).sum())


@pytest.mark.parametrize("n", [1, 2, 7, 60])
def test_gauss_rows_are_those_of_numpy(n):
    z, w = gauss_rows(n)
    known = np.polynomial.legendre.leggauss(n)
    assert np.abs(z[::-1] - known[0]).max() < 1e-14
    assert np.abs(w[::-1] - known[1]).max() < 1e-14


def polynomial(n, z):
    """P_n and its derivative at a decimal number."""
    last, P = Decimal(1), z
    for ell in range(1, n):
        last, P = P, ((2 * ell + 1) * z * P - ell * last) / (ell + 1)
    return P, n * (z * P - last) / (z * z - 1)


@pytest.mark.parametrize("row", [0, 1, 5, 99])
def test_gauss_rows_keep_their_digits_near_the_poles(row):
    """Beside 40 digits: those of numpy and scipy are off by 2e-11 and more."""
    n = 200
    z, w = gauss_rows(n)
    with localcontext() as context:
        context.prec = 40
        exact = Decimal(z[row].item())
        for _ in range(3):
            P, slope = polynomial(n, exact)
            exact -= P / slope
        _, slope = polynomial(n, exact)
        weight = 2 / ((1 - exact * exact) * slope**2)
    assert abs(z[row] - float(exact)) < 2e-16
    assert w[row] == pytest.approx(float(weight), rel=1e-12)


def test_gauss_rows_integrate_up_to_degree_2n_minus_1_and_no_further():
    z, w = gauss_rows(5)
    for k in range(10):
        assert np.isclose(w @ z**k, (1 + (-1) ** k) / (k + 1), atol=1e-15)
    assert abs(w @ z**10 - 2 / 11) > 1e-4


@pytest.mark.parametrize(("degree", "bound"), [(0, 1e-15), (1, 1e-14), (50, 1e-12), (100, 5e-12)])
def test_round_trip(degree, bound):
    c = np.random.default_rng(degree).normal(size=((degree + 1) ** 2, 2))
    z, w = gauss_rows(degree + 1)
    values = synthesis(c, grid_points(z, longitudes(2 * degree + 2)).reshape(-1, 3))
    assert np.abs(analysis(values.reshape(degree + 1, -1, 2), z, w, degree) - c).max() <= bound
