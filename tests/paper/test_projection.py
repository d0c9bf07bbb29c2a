"""docs/projection.md: the rest of a small deviation from a conformal map after one weighted eigen-projection."""

from fractions import Fraction
from itertools import product
from math import prod

import numpy as np
import pytest
from numpy.polynomial import legendre
from scipy.spatial.transform import Rotation
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap.mesh.measure import vertex_areas
from igl_spheremap.sphere.moebius import center
from igl_spheremap.sphere.rows import tangent, unit_rows

#: Factors of gradients of degrees 1 to 7 on a round source.
FACTORS = [
    Fraction(1, 3),
    Fraction(21, 25),
    *(Fraction(-4, (k - 2) * (k + 3)) for k in range(3, 8)),
]
#: Axes that no symmetry of the icosahedron shares.
TURN = Rotation.from_rotvec([0.3, 0.5, 0.7])


def fields(x, degree):
    """Gradients of the zonal and of a sectoral harmonic of this degree."""
    y = TURN.apply(x, inverse=True)
    slope = legendre.Legendre.basis(degree).deriv()(y[:, 2])
    power = degree * (y[:, 0] + 1j * y[:, 1]) ** (degree - 1)
    zonal = slope[:, None] * [0, 0, 1]
    sectoral = np.column_stack([power.real, -power.imag, np.zeros(len(y))])
    return [tangent(x, TURN.apply(each)) for each in (zonal, sectoral)]


def left_of(v, f, x, field):
    """The change of the star map by a small field, by central differences, per unit of it."""
    tiny = 1e-3 / np.linalg.norm(field, axis=1).max()
    above, below = (
        ism.weighted_eigen_projection(v, f, unit_rows(x + s * tiny * field)).star_map
        for s in (1, -1)
    )
    return (above - below) / (2 * tiny)


def factor(v, f, field):
    A = vertex_areas(v, f)[:, None]
    return (A * left_of(v, f, v, field) * field).sum() / (A * field**2).sum()


def errors(level, degree):
    """Relative errors of the factors of both fields."""
    v, f = icosphere(level)
    expected = float(FACTORS[degree - 1])
    return np.array([factor(v, f, field) / expected - 1 for field in fields(v, degree)])


@pytest.mark.parametrize("degree", range(1, 8))
def test_gradients_keep_the_factors_of_the_theorem(degree):
    coarse, middle = (np.abs(errors(level, degree)) for level in (3, 4))
    assert (middle < coarse).all()
    assert np.allclose(coarse / middle, 4, rtol=0.1)  # second order


@pytest.mark.slow
@pytest.mark.parametrize("degree", range(1, 8))
def test_factors_are_within_three_percent_on_a_fine_icosphere(degree):
    middle, fine = (np.abs(errors(level, degree)) for level in (4, 5))
    assert fine.max() < 0.03
    assert np.allclose(middle / fine, 4, rtol=0.05)


@pytest.mark.parametrize("degree", [2, 3, 5])
def test_nothing_is_left_of_turned_gradients(degree):
    v, f = icosphere(3)
    for field in fields(v, degree):
        assert abs(factor(v, f, np.cross(v, field))) < 1e-4


def test_the_triple_eigenvalue_splits_at_degree_two():
    v, f = icosphere(4)
    T, tiny = np.diag([1.0, 0.5, -1.5]), 1e-3
    before, after = (
        ism.weighted_eigen_projection(v, f, unit_rows(v + e * tangent(v, v @ T))) for e in (0, tiny)
    )
    assert np.allclose(
        (after.eigenvalues - before.eigenvalues) / tiny, 12 / 5 * np.sort(np.diag(T)), rtol=0.01
    )


def boosts_left(n):
    """The matrix by which boosts of a spheroid's conformal map are multiplied, and Sigma."""
    v, f = ism.samples.make("spheroid", n_vertices=n, aspect=3)
    A = vertex_areas(v, f) / vertex_areas(v, f).sum()
    x = center(ism.spherical_conformal_map(v, f).sphere, A)
    for _ in range(20):  # to the fixed point of this mesh
        x = ism.weighted_eigen_projection(v, f, x).star_map
    image = vertex_areas(x, f)
    boosts = [tangent(x, np.tile(e, (len(x), 1))) for e in np.eye(3)]
    gram = np.einsum("aij,bij,i->ab", boosts, boosts, image)
    left = np.array([left_of(v, f, x, boost) for boost in boosts])
    return np.linalg.solve(gram, np.einsum("aij,bij,i->ab", boosts, left, image)), np.einsum(
        "i,ij,ik->jk", A, x, x
    )


def test_boosts_are_multiplied_by_the_second_moments_of_the_source():
    coarse, fine = (np.abs(np.subtract(*boosts_left(n))).max() for n in (642, 2562))
    assert fine < 0.012
    assert 3 < coarse / fine < 5


# The proof's identities, in exact arithmetic: polynomials are dictionaries from exponents to coefficients.


def plus(p, q, scale=1):
    total = {key: p.get(key, 0) + scale * q.get(key, 0) for key in p.keys() | q.keys()}
    return {key: value for key, value in total.items() if value}


def times(p, q):
    total = {}
    for (a, s), (b, t) in product(p.items(), q.items()):
        total = plus(total, {tuple(map(sum, zip(a, b, strict=True))): s * t})
    return total


def slope(p, i):
    lowered = {k: tuple(e - (j == i) for j, e in enumerate(k)) for k in p if k[i]}
    return {lowered[k]: k[i] * p[k] for k in lowered}


def laplace(p):
    total = {}
    for i in range(3):
        total = plus(total, slope(slope(p, i), i))
    return total


def mean(p):
    """Over the unit sphere."""

    def odd(n):
        return prod(range(n, 0, -2))

    return sum(
        Fraction(c * odd(k[0] - 1) * odd(k[1] - 1) * odd(k[2] - 1), odd(sum(k) + 1))
        for k, c in p.items()
        if not any(e % 2 for e in k)
    )


X = [{tuple(int(i == j) for j in range(3)): Fraction(1)} for i in range(3)]
SQUARE = plus(plus(times(X[0], X[0]), times(X[1], X[1])), times(X[2], X[2]))


def harmonic(degree):
    """A random polynomial of a degree, less multiples of |x|^2 until its Laplacian vanishes."""
    rng = np.random.default_rng(degree)
    keys = [k for k in product(range(degree + 1), repeat=3) if sum(k) == degree]
    Y = term = {
        k: Fraction(int(c)) for k, c in zip(keys, rng.integers(1, 9, len(keys)), strict=True)
    }
    scale, power = Fraction(1), {(0, 0, 0): Fraction(1)}
    for j in range(1, degree // 2 + 1):
        term, power = laplace(term), times(power, SQUARE)
        scale /= -2 * j * (2 * degree - 2 * j + 1)
        Y = plus(Y, times(power, term), scale)
    assert not laplace(Y)
    return Y


@pytest.mark.parametrize("degree", range(1, 8))
def test_the_product_with_x_has_two_degrees(degree):
    """(l Y x + grad Y) / (2l + 1) is, on the sphere, the gradient of Y in space by 2l + 1: of degree l - 1."""
    Y = harmonic(degree)
    for i in range(3):
        low = {k: c / (2 * degree + 1) for k, c in slope(Y, i).items()}
        high = plus(times(Y, X[i]), times(SQUARE, low), -1)
        assert not laplace(low)
        assert not laplace(high)
    splits = [3 * mean(times(Y, times(X[i], X[j]))) for i, j in product(range(3), repeat=2)]
    assert any(splits) == (degree == 2)


@pytest.mark.parametrize("degree", range(1, 8))
def test_factors_follow_from_the_two_degrees(degree):
    """Before centring, which takes 2/3 of the boosts of a round source."""
    high = -2 * Fraction(degree + 1, degree + 3) * Fraction(-1, 2 * degree + 1)
    if degree == 2:
        Y = harmonic(2)
        # q = -6 Y
        N = [[-18 * mean(times(Y, times(X[i], X[j]))) for j in range(3)] for i in range(3)]
        T = [[slope(slope(Y, i), j).get((0, 0, 0), 0) for j in range(3)] for i in range(3)]
        assert [[-n / 2 for n in row] for row in N] == [
            [Fraction(3, 5) * t for t in row] for row in T
        ]
        total = Fraction(3, 5) + high
    else:
        total = -2 * Fraction(degree, degree - 2) / (2 * degree + 1) + high
    assert (total * Fraction(1, 3) if degree == 1 else total) == FACTORS[degree - 1]
