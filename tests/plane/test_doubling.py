"""Doubled surfaces: symmetric, without chords."""

import numpy as np
import pytest
from disks import cap, grid
from scipy.spatial import Delaunay

import igl_spheremap as ism
from igl_spheremap.mesh.edges import sides
from igl_spheremap.mesh.measure import surface_area
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


@pytest.mark.parametrize("seed", [None, 0, 1, 2])
def test_what_is_split_is_the_same_surface_without_chords(seed):
    """Each chord gets its middle once, each of its two faces is parted there; up to three in a face."""
    p, f = grid(2, 9)
    if seed is not None:  # a polygon, triangulated without inner vertices
        turn = np.sort(np.random.default_rng(seed).uniform(0, 2 * np.pi, 15))
        p = np.column_stack((np.cos(turn), np.sin(turn)))
        f = Delaunay(p).simplices
        a, b, c = p[f].transpose(1, 0, 2)
        inwards = (b - a)[:, 0] * (c - a)[:, 1] < (b - a)[:, 1] * (c - a)[:, 0]
        f[inwards] = f[inwards, ::-1]
    disk = ism.check_disk(np.column_stack((p, p[:, 0] ** 2)), f)
    chords = len(f) - 1
    w, g = doubling.without_chords(disk.unit, disk.f, disk.rim)
    assert len(w) == len(p) + chords
    assert len(g) == len(f) + 2 * chords
    assert surface_area(w, g) == pytest.approx(surface_area(disk.unit, f))
    edges = np.sort(g[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2))
    keys, count = np.unique(edges, axis=0, return_counts=True)
    old = keys[(keys < len(p)).all(axis=1)]
    assert (count[(keys < len(p)).all(axis=1)] == 1).all()
    assert len(old) == len(disk.rim)
    new = ism.check_disk(w, g)
    normals = np.cross(*(new.unit[g[:, k]] - new.unit[g[:, 0]] for k in (1, 2)))
    assert (normals[:, 2] > 0).all()
