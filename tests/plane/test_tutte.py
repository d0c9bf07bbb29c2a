"""Tutte's map: exact where it is known, and free of foldings whatever the boundary."""

import igl
import numpy as np
import pytest
from disks import cap, grid, half, polar

import igl_spheremap as ism
from igl_spheremap.plane.doubling import centred
from igl_spheremap.plane.tutte import by_harmonic_measure, by_lengths, evenly, tutte_map


def turns(circle):
    """Angles from each point to the next."""
    z = circle @ [1, 1j]
    return np.angle(np.roll(z, -1) / z)


def test_a_flat_disk_is_its_own_map():
    p, f = polar(9)
    disk = ism.check_disk(np.column_stack((p, 0 * p[:, 0])), f)
    assert np.abs(tutte_map(disk, p[disk.rim]) - p).max() < 1e-12


def test_corners_of_a_square_are_quarter_turns_apart():
    """Both diagonals mirror the triangulation."""
    p, f = grid(9, 9)
    disk = ism.check_disk(np.column_stack((p, 0 * p[:, 0])), f)
    circle = by_harmonic_measure(disk)
    corners = np.flatnonzero(np.isin(disk.rim, [0, 8, 72, 80]))
    assert turns(circle[corners]) == pytest.approx(np.full(4, np.pi / 2), abs=1e-9)


def test_the_harmonic_measure_of_a_triangle_away_from_its_corners_vanishes():
    """The density at a corner of angle a is that of r^(pi / a - 1)."""
    p, f = grid(33, 33)
    below = f[p[f].sum(axis=2).max(axis=1) <= 32]
    rows, below = np.unique(below, return_inverse=True)
    disk = ism.check_disk(np.column_stack((p[rows], 0 * rows)), below.reshape(-1, 3))
    arcs = turns(by_harmonic_measure(disk))
    assert arcs.sum() == pytest.approx(2 * np.pi)
    bottom = arcs[:32]  # from the right angle to a corner of 45 degrees
    assert bottom[0] < bottom[1:16].min()
    assert np.cumsum(bottom)[3] / np.cumsum(bottom)[1] == pytest.approx(2**2, rel=0.1)


@pytest.mark.parametrize("angle", [75, 150])
def test_errors_on_a_cap_fall_with_the_square_of_its_edges(angle):
    errors = []
    for rings in (8, 16, 32):
        v, f, exact = cap(rings, np.radians(angle))
        disk = ism.check_disk(v, f)
        p = centred(tutte_map(disk, by_harmonic_measure(disk)), disk)
        z, w = tutte_map(disk, p[disk.rim]) @ [1, 1j], exact @ [1, 1j]
        turn = np.exp(1j * np.angle((disk.A * z.conj() * w).sum()))
        errors.append(np.sqrt((disk.A * np.abs(turn * z - w) ** 2).sum()))
    assert np.log2(errors[0] / errors[2]) / 2 > 1.8


@pytest.mark.parametrize("shear", [0.0, 3.0, 30.0])
@pytest.mark.parametrize("place", [by_lengths, by_harmonic_measure])
def test_no_face_folds(place, shear):
    v, f, _ = half(*ism.samples.make("bunny", n_vertices=3500))
    v = v + shear * v[:, :1] * [0, 1, 0]
    disk = ism.check_disk(v, f)
    circle = place(disk)
    assert (turns(circle) > 0).all()
    assert ism.certify(tutte_map(disk, circle), f).folding_free
    random = np.sort(np.random.default_rng(0).uniform(0, 2 * np.pi, len(disk.rim)))
    assert ism.certify(
        tutte_map(disk, np.column_stack((np.cos(random), np.sin(random)))), f
    ).folding_free


@pytest.mark.parametrize("rows", [2, 3])
def test_strips_have_room_for_each_boundary_vertex(rows):
    p, f = grid(rows, 40)
    disk = ism.check_disk(np.column_stack((p, p[:, 0] ** 2 / 40)), f)
    arcs = turns(by_harmonic_measure(disk))
    assert arcs.min() > 0
    assert arcs.sum() == pytest.approx(2 * np.pi)


def test_one_face_is_a_triangle_on_the_circle():
    disk = ism.check_disk(np.eye(3), [[0, 1, 2]])
    assert turns(by_harmonic_measure(disk)) == pytest.approx(np.full(3, 2 * np.pi / 3))


def test_each_inner_vertex_is_at_the_weighted_mean_of_its_neighbours():
    """With cotangents of the surface for weights, where these fold no face."""
    v, f, _ = half(*ism.samples.make("pear", n_vertices=1500))
    disk = ism.check_disk(v, f)
    p = tutte_map(disk, by_lengths(disk))
    pull = igl.cotmatrix(v, f) @ p
    inner = np.setdiff1d(np.arange(len(v)), disk.rim)
    assert np.abs(pull[inner]).max() < 1e-9 * np.abs(pull[disk.rim]).max()
    assert np.array_equal(p[disk.rim], by_lengths(disk))


def test_the_circle_is_shared_out_by_the_lengths_of_edges_or_evenly():
    """No edge counts as shorter than a thousandth of the mean."""
    p, f = polar(4)
    p[:, 1] *= 3
    disk = ism.check_disk(np.column_stack((p, 0 * p[:, 0])), f)
    ring = p[disk.rim]
    length = np.linalg.norm(np.roll(ring, -1, axis=0) - ring, axis=1)
    assert turns(by_lengths(disk)) == pytest.approx(2 * np.pi * length / length.sum())
    assert turns(evenly(disk)) == pytest.approx(np.full(24, 2 * np.pi / 24))
    for circle in (by_lengths(disk), evenly(disk)):
        assert np.allclose((circle**2).sum(axis=1), 1)
    p[disk.rim[1]] = p[disk.rim[0]]
    short = turns(by_lengths(ism.check_disk(np.column_stack((p, 0 * p[:, 0])), f)))
    assert short[0] / short.mean() == pytest.approx(1e-3, rel=1e-2)
