"""Surfaces that can be unrolled, and others that can't: every length stays, and faces keep their side."""

import numpy as np
import pytest
from disks import cap, grid
from triangulations import random_rotation

import igl_spheremap as ism
from igl_spheremap.mesh.arrays import own_unit
from igl_spheremap.plane.unrolling import stretch, unrolled

P, F = grid(7, 13)


def lengths(p):
    i, j = F.ravel(), F[:, [1, 2, 0]].ravel()
    return np.linalg.norm(p[i] - p[j], axis=1)


def areas(p):
    a, b, c = p[F].transpose(1, 0, 2)
    return ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2


#: A strip around a cylinder, and one that is bent back and forth.
ROLLED = [
    np.column_stack((np.cos(P[:, 0] / 4), np.sin(P[:, 0] / 4), P[:, 1] / 4)),
    np.column_stack((P[:, 0] - np.sin(P[:, 0]) / 4, np.cos(P[:, 0]), P[:, 1])),
]


@pytest.mark.parametrize("turned_over", [False, True])
@pytest.mark.parametrize("v", [*ROLLED, np.column_stack((P, 0 * P[:, 0]))])
def test_every_length_stays_and_faces_are_seen_from_outside(v, turned_over):
    f = F[:, ::-1] if turned_over else F
    disk = ism.check_disk(v @ random_rotation(2) + 3, f)
    p = unrolled(disk)
    scale = lengths(p) / lengths(v)
    assert np.ptp(scale) < 1e-9 * scale[0]
    assert np.log2(scale[0]) == pytest.approx(
        round(np.log2(scale[0]))
    )  # a power of two: rounds nothing
    assert (areas(p) * (1 - 2 * turned_over) > 0).all()
    assert stretch(disk, p) < 1e-9


def test_what_has_curvature_is_not_unrolled():
    """A cap, the tip of a cone, and a sheet with one vertex lifted; without the tip the cone is."""
    v, f, _ = cap(6, 0.5)
    assert unrolled(ism.check_disk(v, f)) is None
    z = v[:, :2] @ [1, 1j]
    cone = np.column_stack((v[:, :2], np.abs(z)))
    assert unrolled(ism.check_disk(cone, f)) is None
    for height, flat in ((1e-2, False), (1e-9, True)):
        lifted = np.column_stack((P, 0 * P[:, 0]))
        lifted[45, 2] = height
        assert (unrolled(ism.check_disk(lifted, F)) is not None) == flat


def test_stretch_is_the_largest_share_by_which_an_edge_changes():
    disk = ism.check_disk(np.column_stack((P, 0 * P[:, 0])), F)
    own = own_unit(disk.v)[0][:, :2]
    for scale in (1.0, 1.25, 0.5):
        assert stretch(disk, scale * own) == pytest.approx(abs(scale - 1), abs=1e-12)
    moved = own.copy()
    moved[0] += (own[0] - own[1]) / 2  # one edge is half as long again
    assert stretch(disk, moved) == pytest.approx(0.5)
