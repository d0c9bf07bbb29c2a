"""Maps of disks against libigl's own: the harmonic one, the circle, and the energy of least squares conformal maps."""

import igl
import numpy as np
import scipy.sparse as sp
from disks import half

import igl_spheremap as ism
from igl_spheremap.operators.laplacian import summed_laplacian
from igl_spheremap.plane.tutte import by_lengths, tutte_map

DISK = ism.check_disk(*half(*ism.samples.make("pear", n_vertices=800))[:2])
RIM = DISK.rim.astype(np.int64)


def minus_area(v, f):
    """Matrix of twice the Dirichlet energy of a map (x, y) to the plane, less twice its area."""
    L = summed_laplacian(igl.cotmatrix_entries(v, f), f, len(v))
    return sp.block_diag((L, L)) - 2 * igl.vector_area_matrix(f)


def test_the_map_with_cotangents_is_libigls_harmonic_one():
    circle = by_lengths(DISK)
    expected = igl.harmonic(DISK.unit, DISK.f, RIM, circle, 1)
    assert np.abs(tutte_map(DISK, circle) - expected).max() < 1e-9


def test_lengths_share_out_the_circle_as_by_libigl():
    ours, theirs = by_lengths(DISK), igl.map_vertices_to_circle(DISK.unit, RIM)[:, :2]
    chords = [np.linalg.norm(np.roll(p, -1, axis=0) - p, axis=1) for p in (ours, theirs)]
    assert np.allclose(*chords, atol=1e-12)


def test_energy_less_area_vanishes_on_conformal_maps_and_is_least_squares_conformal_maps_energy():
    """A flat disk's own coordinates; on a curved one no map that meets the pins has less than libigl's."""
    p = ism.disk_conformal_map(DISK.v, DISK.f).plane
    flat = np.column_stack((p, np.zeros(len(p))))
    z = p.T.ravel()
    assert np.abs(minus_area(flat, DISK.f) @ z).max() < 1e-9
    Q = minus_area(DISK.unit, DISK.f)
    pins = RIM[[0, len(RIM) // 2]]
    least = np.asarray(igl.lscm(DISK.unit, DISK.f, pins, p[pins])[0]).T.ravel()
    assert 0 < least @ Q @ least < z @ Q @ z
    free = np.ones(len(p), dtype=bool)
    free[pins] = False
    assert np.abs((Q @ least)[np.tile(free, 2)]).max() < 1e-9
