"""Doubled surfaces: symmetric, without chords."""

import numpy as np
from disks import cap, grid

import igl_spheremap as ism
from igl_spheremap.mesh.edges import sides
from igl_spheremap.plane import doubling
from igl_spheremap.plane.doubling import centred, double_map


def test_edges_between_boundary_vertices_are_split():
    p, f = grid(2, 9)
    disk = ism.check_disk(np.column_stack((p, p[:, 1] ** 2)), f)
    image, double = double_map(disk, None)
    n_chords = (3 * len(f) - len(disk.rim)) // 2
    assert len(double.faces) == 2 * (len(f) + 2 * n_chords)
    assert len(double.vertices) == len(p) + 2 * n_chords
    assert image.shape == p.shape


def test_centring_balances_the_double_on_the_sphere():
    v, f, exact = cap(8, 1.5)
    disk = ism.check_disk(v, f)
    z = exact @ [1, 1j]
    z = (z - 0.5) / (1 - 0.5 * z)
    p = centred(np.column_stack((z.real, z.imag)), disk)
    assert np.abs(p - exact).max() < 1e-2
    mean = (disk.A[:, None] * (2 * p / (1 + (p * p).sum(axis=1))[:, None])).sum(axis=0)
    assert np.abs(mean).max() < 1e-9


def test_chords_of_a_fan_are_split_in_a_few_passes(monkeypatch):
    """Faces around one vertex that each wait for their neighbour took a pass each."""
    n, passes = 60, []
    turn = np.linspace(0, 5, n)
    v = np.vstack(([0, 0, 0], np.column_stack((np.cos(turn), np.sin(turn), turn**2))))
    i = np.arange(1, n)
    disk = ism.check_disk(v, np.column_stack((0 * i, i, i + 1)))
    monkeypatch.setattr(doubling, "sides", lambda f: passes.append(0) or sides(f))
    w, f = doubling.without_chords(disk.unit, disk.f, disk.rim)
    assert len(passes) <= 4  # the last finds none
    assert len(w) == len(v) + n - 2
    assert len(ism.check_disk(w, f).rim) == len(disk.rim)
