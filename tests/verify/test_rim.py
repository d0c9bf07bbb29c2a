"""Boundaries in the plane: meetings are found, whatever the size and the rounding."""

from fractions import Fraction

import numpy as np
import pytest
from disks import grid, polar

import igl_spheremap as ism
from igl_spheremap.verify.rim import plane_signs, rim_crossings, rim_direction


def meets_exactly(p):
    """Which edges of a polygon meet others but at shared corners, by fractions and every pair."""
    q = [tuple(map(Fraction, row)) for row in p.tolist()]
    k, met = len(q), set()

    def side(a, b, c):
        return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])

    def within(a, b, c):
        return side(a, b, c) == 0 and all(
            min(a[i], b[i]) <= c[i] <= max(a[i], b[i]) for i in (0, 1)
        )

    for i in range(k):
        for j in range(i):
            a, b, c, d = q[i], q[(i + 1) % k], q[j], q[(j + 1) % k]
            if (i - j) % k in (1, k - 1):
                first, corner, last = (c, d, b) if (i - j) % k == 1 else (a, b, d)
                dot = sum((first[m] - corner[m]) * (last[m] - corner[m]) for m in (0, 1))
                hit = side(first, corner, last) == 0 and dot > 0
            else:
                hit = (
                    side(a, b, c) * side(a, b, d) < 0 and side(c, d, a) * side(c, d, b) < 0
                ) or any(
                    within(*edge, point)
                    for edge, points in (((a, b), (c, d)), ((c, d), (a, b)))
                    for point in points
                )
            met |= {i, j} if hit else set()
    return np.isin(np.arange(k), list(met))


@pytest.mark.parametrize("seed", range(60))
def test_meetings_are_those_of_exact_arithmetic(seed):
    rng = np.random.default_rng(seed)
    k = int(rng.integers(4, 14))
    # many corners on edges, and edges on one line
    coarse = rng.integers(0, 5, (k, 2)).astype(float) / 8
    coarse = coarse[np.any(coarse != np.roll(coarse, 1, axis=0), axis=1)]
    if len(coarse) > 3:
        assert (rim_crossings(coarse, np.arange(len(coarse))) == meets_exactly(coarse)).all()
    turn = np.sort(rng.random(k)) * 2 * np.pi
    star = np.column_stack((np.cos(turn), np.sin(turn))) * rng.random((k, 1))
    assert (rim_crossings(star, np.arange(k)) == meets_exactly(star)).all()


@pytest.mark.parametrize("scale", [1e-200, 1.0, 1e150])
def test_a_tall_rectangle_of_thousands_of_edges_meets_itself_nowhere(scale):
    side = np.arange(3000) * scale
    p = np.concatenate(
        (np.column_stack((0 * side, side[::-1])), np.column_stack((0 * side + scale, side)))
    )
    rim = np.arange(len(p))
    assert not rim_crossings(p, rim).any()
    assert rim_direction(p, rim) == 1
    assert rim_direction(p, rim[::-1]) == -1
    p[4000, 0] = -scale / 2  # a spike through the other side
    assert rim_crossings(p, rim).sum() >= 3


def test_a_corner_that_turns_back_on_itself_is_found():
    p = np.array([[0, 0], [2, 0], [3, 0], [1, 0], [1, 1.0]])
    assert rim_crossings(p, np.arange(5))[[1, 2]].all()


def test_signs_are_exact_where_rounding_decides():
    tiny = 2.0**-80
    p = np.array([[0, 0], [1, 1], [0.5, 0.5 + tiny], [0.5, 0.5 - tiny], [0.5, 0.5]]) * 3
    assert plane_signs(p, np.array([[0, 1, 4]])).tolist() == [0]
    assert plane_signs(
        np.array([[0, 0], [1.0, 1], [tiny, 2 * tiny]]), np.array([[0, 1, 2]])
    ).tolist() == [1]


def spiral(turns):
    """A strip wound around the origin: every face is positive, and it overlaps itself after one turn."""
    p, f = grid(3, 60)
    angle, radius = 2 * np.pi * turns * p[:, 0] / 59, 2 + p[:, 1] / 2
    return np.column_stack((radius * np.cos(-angle), radius * np.sin(-angle))), f


@pytest.mark.parametrize(("turns", "free"), [(0.9, True), (1.1, False), (2.5, False)])
def test_a_strip_that_overlaps_itself_fails_though_no_face_folds(turns, free):
    certificate = ism.certify(*spiral(turns))
    assert certificate.foldings == 0
    assert certificate.folding_free is free
    assert bool(len(certificate.crossings)) is not free
    assert certificate.boundary_loops == 1
    assert ("meet" in str(certificate)) is not free


def test_a_disk_wound_twice_around_its_centre_fails():
    p, f = polar(4)
    certificate = ism.certify(np.column_stack(((z := (p @ [1, 1j]) ** 2).real, z.imag)), f)
    assert not certificate.folding_free


def test_planted_folds_and_mirrors_are_found():
    p, f = polar(3)
    assert ism.certify(p, f)
    mirrored = ism.certify(p * [1, -1], f)
    assert (len(mirrored.flipped), mirrored.degree) == (len(f), -1)
    folded = p.copy()
    folded[0] = 3
    assert set(ism.certify(folded, f).flipped) < set(np.flatnonzero((f == 0).any(axis=1)))
    folded[0] = np.nan
    assert ism.certify(folded, f).not_finite.tolist() == [0]


def test_what_is_no_map_of_a_disk_is_refused():
    p, f = polar(2)
    for x in (p[:-1], p[:, :1], [[0, 1], [2]], p.astype(str)):
        with pytest.raises(ism.MeshError):
            ism.certify(x, f)
    with pytest.raises(ism.MeshError, match="boundary loops"):
        ism.certify(p[1:], f[6:] - 1)


def test_a_certificate_says_what_is_wrong_and_no_more():
    """If the boundary crosses itself, the image has no covering number."""
    p, f = polar(3)
    folded, crossing, twice = p.copy(), p.copy(), p @ np.diag([1, -1])
    folded[0] = 3
    rim = ism.flatten(np.column_stack((p, 0 * p[:, 0])), f).rim
    crossing[rim[[0, 1]]] = p[rim[[1, 0]]]
    assert "covered" not in str(ism.certify(folded, f))
    assert "boundary edges that meet others" in str(ism.certify(crossing, f))
    assert "covered" not in str(ism.certify(crossing, f))
    assert "a mirror image, not folded" in str(ism.certify(twice, f))
