"""Products of rows are numpy's; unit rows are unit at every size, and stay as they are."""

import numpy as np
import pytest
from triangulations import unit

from igl_spheremap.sphere.rows import (
    INFINITE,
    along,
    binary_sizes,
    column_dots,
    from_chart,
    inner,
    row_crosses,
    row_dets,
    row_dots,
    row_lengths,
    scale_rows,
    tangent,
    tangent_axes,
    to_chart,
    unit_rows,
    weighted_moment,
    weighted_sum,
)

RNG = np.random.default_rng(0)
A, B, C = np.random.default_rng(0).normal(size=(3, 100, 3))


def test_products_are_those_of_numpy():
    assert np.allclose(row_dots(A, B), (A * B).sum(axis=1))
    assert np.allclose(
        row_dots(A[:, :2].copy(), B[:, 1:].copy()), (A[:, :2] * B[:, 1:]).sum(axis=1)
    )
    assert np.allclose(row_dots(A[::2], B[::2]), (A * B).sum(axis=1)[::2])
    assert np.allclose(row_crosses(A, B), np.cross(A, B))
    assert np.allclose(row_dets(A, B, C), np.linalg.det(np.stack((A, B, C), axis=1)))


def test_sums_over_rows_are_those_of_numpy():
    weights = RNG.random(100)
    assert np.allclose(weighted_sum(weights, A), weights @ A)
    assert np.isclose(weighted_sum(weights, A[:, 0]), weights @ A[:, 0])
    assert np.allclose(weighted_moment(weights, A, B), A.T @ np.diag(weights) @ B)
    assert np.isclose(inner(A, B), np.vdot(A, B))
    assert np.allclose(along(A, B[0]), A @ B[0])
    assert np.allclose(column_dots(A.T, B.T), (A * B).sum(axis=1))


def test_the_tangent_part_is_what_is_left_without_the_normal_part():
    x = unit_rows(A)
    part = tangent(x, B)
    assert np.allclose(row_dots(part, x), 0)
    assert np.allclose(np.cross(B - part, x), 0)


@pytest.mark.parametrize("size", [1.0, 1e-320, 1e-200, 1e200, 1e307])
def test_lengths_and_units_of_rows_of_any_size(size):
    x = size * A
    few = 1e-14 + 2e-323 / size  # a subnormal number has few digits
    assert np.allclose(row_lengths(x) / size, np.linalg.norm(x / size, axis=1), rtol=few)
    largest = np.abs(scale_rows(x)).max(axis=1)
    assert ((largest >= 0.5) & (largest < 1)).all()
    assert np.allclose(scale_rows(x) * (binary_sizes(x) / size)[:, None], x / size, rtol=few)
    assert (np.log2(binary_sizes(x)) % 1 == 0).all()
    assert binary_sizes(np.zeros((1, 3))) == 1


@pytest.mark.parametrize("size", [1.0, 1e-320, 1e-300, 1e-160, 1e160, 1e307])
def test_rows_of_any_size_become_unit_rows(size):
    tolerance = 1e-15 + 5e-324 / size  # a subnormal number has few digits
    mixed = np.where(np.arange(100)[:, None] % 2, size * A, A)
    for x in (size * A, mixed):
        y = unit_rows(x)
        assert np.abs(np.linalg.norm(y, axis=1) - 1).max() < 1e-15
        assert np.abs(y - unit_rows(A)).max() < 10 * tolerance


def test_unit_rows_stay_bit_for_bit_and_zero_rows_stay_zero():
    x = unit_rows(A)
    turn = np.linalg.qr(B[:3])[0]
    for y in (x, x @ turn, np.vstack((x, 0 * x))):
        assert unit_rows(y).tobytes() == y.tobytes()


POLES = np.vstack((unit(RNG.normal(size=(40, 3))), [[0, 0, 1], [0, 0, -1], [1, 0, 0], [0, -1, 0]]))


def disc(n, size):
    return size * (RNG.normal(size=n) + 1j * RNG.normal(size=n))


@pytest.mark.parametrize("size", [1e-12, 1e-5, 1.0, 30.0])
def test_charts_are_inverse_to_each_other_at_every_scale(size):
    z = disc(len(POLES), size)
    assert np.abs(to_chart(from_chart(z, POLES), POLES) - z).max() < 1e-15 * max(1, size) ** 2 * 20


def test_the_chart_is_twice_the_tangent_of_half_the_angle_from_the_pole():
    x = unit(RNG.normal(size=POLES.shape))
    angle = np.arccos((x * POLES).sum(axis=1))
    assert np.allclose(np.abs(to_chart(x, POLES)), 2 * np.tan(angle / 2))


def test_the_pole_is_at_zero_and_the_opposite_point_at_infinity():
    assert (to_chart(POLES, POLES) == 0).all()
    assert (np.abs(to_chart(-POLES, POLES)) >= INFINITE).all()
    assert np.allclose(from_chart(np.full(len(POLES), INFINITE + 0j), POLES), -POLES)


def test_charts_of_opposite_poles_are_inversions_of_each_other():
    """z z' = 4 up to a turn, and with full relative precision near both poles."""
    for size in (1e-9, 1e-3, 1.0):
        z = disc(len(POLES), size)
        x = POLES + np.einsum(
            "kij,ki->kj", np.stack(tangent_axes(POLES), axis=1), np.column_stack((z.real, z.imag))
        )
        x /= np.linalg.norm(x, axis=1)[:, None]
        assert np.allclose(np.abs(to_chart(x, POLES) * to_chart(x, -POLES)), 4, rtol=1e-12)


def test_charts_keep_orientation_and_angles():
    pole = POLES[:1]
    for z in disc(20, 1.0):
        around = from_chart(z + 1e-6 * np.array([0, 1, 1j]), pole)
        a, b = around[1] - around[0], around[2] - around[0]
        assert np.linalg.det(np.stack((around[0], a, b))) > 0
        assert abs(a @ b) < 1e-5 * np.linalg.norm(a) * np.linalg.norm(b)
        assert np.isclose(np.linalg.norm(a), np.linalg.norm(b), rtol=1e-5)


def test_tangent_axes_are_orthonormal_and_right_handed():
    e1, e2 = tangent_axes(POLES)
    frames = np.stack((e1, e2, POLES), axis=1)
    assert np.allclose(frames @ frames.transpose(0, 2, 1), np.eye(3))
    assert np.allclose(np.linalg.det(frames), 1)
