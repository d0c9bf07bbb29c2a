"""Products of rows are numpy's; unit rows are unit at every size, and stay as they are."""

import numpy as np
import pytest

from igl_spheremap.sphere.rows import row_crosses, row_dets, row_dots, unit_rows

A, B, C = np.random.default_rng(0).normal(size=(3, 100, 3))


def test_products_are_those_of_numpy():
    assert np.allclose(row_dots(A, B), (A * B).sum(axis=1))
    assert np.allclose(row_crosses(A, B), np.cross(A, B))
    assert np.allclose(row_dets(A, B, C), np.linalg.det(np.stack((A, B, C), axis=1)))


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
