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
    flat = ism.flatten(SHEETS[name](*p.T), f, balance=balance)
    assert flat.certificate.folding_free
    # its triangles are no parts of one plane sheet: quadrilaterals across rulings bend
    if name != "cone":
        assert np.abs(flat.log_length_ratios()).max() < 1e-6
        assert np.abs(flat.angle_differences()).max() < 1e-4
    assert np.abs(flat.log_length_ratios()).mean() < 0.01


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
        assert np.abs(flat.log_length_ratios()).max() < 1e-6


def test_turning_the_surface_turns_nothing_but_the_image():
    v, f, _ = cap(8, 1.8)
    turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])
    a, b = (
        np.linalg.norm(p[:, None] - p, axis=2)
        for p in (ism.flatten(w, f).plane for w in (v, v @ turn.T))
    )
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
    assert np.isfinite(flat.log_length_ratios()).all()


def test_balance_trades_angles_for_areas():
    v, f, _ = half(*ism.samples.make("spheroid", n_vertices=1500), axis=0)
    maps = [ism.flatten(v, f, balance=balance) for balance in (0, 0.7, 1)]
    angles = [np.abs(m.angle_differences()).mean() for m in maps]
    areas = [np.abs(m.log_area_ratios()).mean() for m in maps]
    edges = [np.abs(m.log_length_ratios()).mean() for m in maps]
    assert angles == sorted(angles)
    assert areas == sorted(areas, reverse=True)
    assert min(edges) == edges[1]
    assert maps[1].balance == 0.7


def test_a_notebook_and_a_person_read_the_same():
    v, f, _ = cap(3, 1.5)
    flat = ism.flatten(v, f)
    assert repr(flat).startswith("FlatMap(37 vertices")
    assert "boundary crosses itself nowhere" in flat._repr_html_()


def spiral(p):
    """A strip in the plane, of five turns, unless it is lifted off it."""
    turn, r = 0.3 * p[:, 0], 1 + 0.09 * p[:, 0] + p[:, 1]
    return np.column_stack((r * np.cos(turn), r * np.sin(turn), 0 * r))


def scroll(p):
    r = 1 + 0.01 * p[:, 0]
    return np.column_stack((r * np.cos(p[:, 0] / 8), r * np.sin(p[:, 0] / 8), p[:, 1]))


def folded(p):
    """A sheet of paper folded flat."""
    return np.column_stack((np.abs(p[:, 0] - 40), p[:, 1] + p[:, 0] / 8, 0 * p[:, 0]))


FLAT = {
    "spiral": spiral,
    "rectangle 1e6": lambda p: p @ np.diag([1, 1e-6])[:, [0, 1, 1]] * [1, 1, 0],
    "rectangle 1e8": lambda p: p @ np.diag([1, 1e-8])[:, [0, 1, 1]] * [1, 1, 0],
}
ROLLED = {
    "scroll": scroll,
    "folded": folded,
    "wall": lambda p: np.column_stack((np.cos(0.4 * p[:, 0]), np.sin(0.4 * p[:, 0]), p[:, 1])),
}


@pytest.mark.parametrize("seed", [None, 0, 1])
@pytest.mark.parametrize("name", [*FLAT, *ROLLED])
def test_flat_surfaces_come_back_congruent_and_rolled_ones_isometric(name, seed):
    p, f = grid(2 if name == "spiral" else 4, 81)
    v = (FLAT | ROLLED)[name](p)
    if seed is not None:
        v = v @ np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    flat = ism.flatten(v, f)
    edges = np.vstack((f[:, :2], f[:, 1:]))
    before, after = (
        np.linalg.norm(q[edges[:, 0]] - q[edges[:, 1]], axis=1) for q in (v, flat.plane)
    )
    assert flat.certificate.folding_free
    assert np.abs(after / before - 1).max() < (1e-9 if name in FLAT else 1e-6)


def test_what_overlaps_when_unrolled_is_laid_out_with_a_note():
    """A flat ring of 1.5 turns, one above the other, is a disk; no layout keeps its lengths."""
    p, f = grid(2, 41)
    turn, r = 3 * np.pi * p[:, 0] / 40, 1 + p[:, 1]
    flat = ism.flatten(np.column_stack((r * np.cos(turn), r * np.sin(turn), 1e-9 * turn)), f)
    assert flat.certificate.folding_free
    assert any("overlaps itself" in note for note in flat.run.notes)
    stopped = ism.flatten(
        np.column_stack((p, 0 * p[:, 0])), f, listener=lambda iterate: next(iter(()))
    )
    assert stopped.certificate.folding_free


def chain(seed):
    """A random chain of points with steps of very different lengths, in space, triangulated as a convex polygon."""
    rng = np.random.default_rng(seed)
    v = np.cumsum(rng.normal(size=(16, 3)) * 10 ** rng.uniform(-2, 0, (16, 1)), axis=0)
    faces, open_ends = [], [(0, 15)]
    while open_ends:
        a, b = open_ends.pop()
        if b - a > 1:
            middle = int(rng.integers(a + 1, b))
            faces.append((a, middle, b))
            open_ends += [(a, middle), (middle, b)]
    return v, faces


@pytest.mark.parametrize("seed", [2, 16, 23, 26, 31, 48])
def test_what_overlaps_starts_from_the_map_that_keeps_lengths_better(seed):
    """From the conformal disk lengths end off by factors of 15 to 42."""
    flat = ism.flatten(*chain(seed))
    assert flat.certificate.folding_free
    assert np.abs(flat.log_length_ratios()).max() < np.log(10)
    assert flat.status is not ism.Status.SHORT


@pytest.mark.parametrize("name", ["dino", "bird"])
def test_banks_of_cuts_slide_along_each_other(name):
    # where they halt each other the means are .39 and .12
    body = ism.repair_disk(*ism.samples.make(name, n_vertices=4000), cut=8)
    flat = ism.flatten(body.v, body.f)
    assert flat.certificate.folding_free
    assert np.abs(flat.log_length_ratios()).mean() < 0.1


def test_status_and_notes_say_where_lengths_are_far_off():
    seen = set()
    for (v, f), balance in ((chain(17), 0.7), (cap(8, 3.0)[:2], 0), (cap(8, 1.5)[:2], 0.7)):
        flat = ism.flatten(v, f, balance=balance)
        off = np.exp(np.abs(flat.log_length_ratios()).max())
        seen.add((off > 10, balance > 0))
        far = off > 10 and balance > 0  # a conformal map is not asked for lengths
        assert (flat.status is ism.Status.SHORT) == far
        assert any(f"a factor of up to {off:.3g}" in note for note in flat.run.notes) == far
    assert len(seen) == 3


def test_where_doubling_folds_a_map_that_keeps_the_boundary_is_start_enough():
    """A crumpled fan: most of its vertices lie on the boundary, whose double folds."""
    n = 60
    rng, turn = np.random.default_rng(0), np.linspace(0, 1.5 * np.pi, n)
    rim = rng.uniform(0.7, 1, n)[:, None] * np.column_stack((np.cos(turn), np.sin(turn)))
    v = np.vstack(([0, 0, 0], np.column_stack((rim, 0.3 * rng.normal(size=n)))))
    i = np.arange(1, n)
    flat = ism.flatten(v, np.column_stack((0 * i, i, i + 1)))
    assert flat.certificate.folding_free
    assert flat.conformal is None
    again = flat.rebalance(0.7)
    np.testing.assert_array_equal(again.plane, flat.plane)
