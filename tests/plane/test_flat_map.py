"""Flat maps: developable surfaces come out isometric, and no boundary crosses itself."""

import numpy as np
import pytest
from disks import cap, grid, half

import igl_spheremap as ism
from igl_spheremap.mesh.measure import surface_area


def cone(t, s):
    """A point of a cone around the z axis, unrolled coordinates (t angle, s distance)."""
    k = 0.6
    return np.column_stack((k * s * np.cos(t / k), k * s * np.sin(t / k), np.sqrt(1 - k * k) * s))


SHEETS = {
    "cylinder": lambda x, y: np.column_stack((np.cos(x / 4), np.sin(x / 4), y / 4)),
    "cone": lambda x, y: cone(x / 6, 1 + y / 4),
    "wave": lambda x, y: np.column_stack((x - np.sin(x) / 4, np.cos(x), y)),
}


@pytest.mark.parametrize("balance", [0.3, 0.7, 1])
@pytest.mark.parametrize("name", SHEETS)
def test_what_unrolls_is_unrolled(name, balance):
    p, f = grid(7, 13)
    flat = ism.flatten(SHEETS[name](*p.T), f, balance)
    assert flat.certificate.folding_free
    if name != "cone":  # its triangles are no parts of one plane sheet: quadrilaterals across rulings bend
        assert np.abs(flat.edge_ratios()).max() < 1e-6
        assert np.abs(flat.angle_differences()).max() < 1e-4
    assert np.abs(flat.edge_ratios()).mean() < 0.01


def test_units_area_and_direction_are_the_surface_s():
    p, f = grid(6, 11)
    v = np.column_stack((p, np.zeros(len(p)))) * 25.4
    flat = ism.flatten(v, f)
    q = flat.plane - flat.plane.mean(axis=0)
    assert np.abs(q - (v - v.mean(axis=0))[:, :2]).max() < 1e-3
    w, g, _ = cap(8, 1.5)
    image = ism.flatten(w, g).image
    assert surface_area(image, g) == pytest.approx(surface_area(w, g))


@pytest.mark.parametrize("scales", [(1e300, 1e300), (1e-310, 1e-310), (1, 1e-160), (1, 0)])
def test_extreme_scales_and_surfaces_without_area(scales):
    p, f = grid(6, 11)
    flat = ism.flatten(np.column_stack((p * scales, 0 * p[:, 0])), f)
    assert flat.certificate.folding_free
    assert np.isfinite(flat.plane).all()
    if scales[0] == scales[1]:
        assert np.abs(flat.edge_ratios()).max() < 1e-6


def test_turning_the_surface_turns_nothing_but_the_image():
    v, f, _ = cap(8, 1.8)
    turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])
    a, b = (np.linalg.norm(p[:, None] - p, axis=2) for p in (ism.flatten(w, f).plane for w in (v, v @ turn.T)))
    assert np.abs(a - b).max() < 1e-6


def hand(fingers=4):
    """A comb whose teeth curl towards each other: laid out with little distortion, they would overlap."""
    p, f = grid(20, 4 * fingers + 1)
    x, y = p.T
    palm = y[f].max(axis=1) <= 4
    f = f[palm | ((x[f].max(axis=1) - 1) % 4 < 2)]
    rows, f = np.unique(f, return_inverse=True)
    x, y = x[rows], y[rows]
    height = np.maximum(y - 4, 0)
    v = np.column_stack((x, np.minimum(y, 4) + 6 * np.sin(height / 6), 6 - 6 * np.cos(height / 6)))
    return v, f.reshape(-1, 3)


def test_fingers_stay_apart():
    v, f = hand()
    flat = ism.flatten(v, f)
    assert flat.certificate.folding_free
    assert not len(flat.certificate.crossings)


def winding(turns):
    """A helical strip, whose flat layout is an annulus covered several times: it has to bend, or it would overlap."""
    p, f = grid(5, int(40 * turns))
    angle, radius = 2 * np.pi * p[:, 0] / 40, 2 + p[:, 1] / 4
    return np.column_stack((radius * np.cos(angle), -radius * np.sin(angle), 0.05 * angle)), f


@pytest.mark.parametrize("turns", [1.5, 2.2])
def test_a_helical_strip_is_laid_out_without_overlap(turns):
    flat = ism.flatten(*winding(turns))
    assert flat.certificate.folding_free
    assert np.isfinite(flat.edge_ratios()).all()


def test_balance_trades_angles_for_areas():
    v, f, _ = half(*ism.samples.make("spheroid", n_vertices=1500), axis=0)
    maps = [ism.flatten(v, f, balance) for balance in (0, 0.7, 1)]
    angles = [np.abs(m.angle_differences()).mean() for m in maps]
    areas = [np.abs(m.area_ratios()).mean() for m in maps]
    edges = [np.abs(m.edge_ratios()).mean() for m in maps]
    assert angles == sorted(angles)
    assert areas == sorted(areas, reverse=True)
    assert min(edges) == edges[1]
    assert maps[1].balance == 0.7


def test_a_notebook_and_a_person_read_the_same():
    v, f, _ = cap(3, 1.5)
    flat = ism.flatten(v, f)
    assert repr(flat).startswith("FlatMap(37 vertices")
    assert "boundary crosses itself nowhere" in flat._repr_html_()
