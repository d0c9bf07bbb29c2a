"""The check of disks names the fault, its place and the remedy."""

import numpy as np
import pytest
from disks import polar
from triangulations import icosphere

import igl_spheremap as ism

P, F = polar(3)
V = np.column_stack((P, np.zeros(len(P))))


def test_the_boundary_is_found_in_its_direction():
    disk = ism.check_disk(V, F)
    assert disk.rim.tolist() == list(range(len(V) - 18, len(V)))
    assert ism.check_disk(V, F[:, ::-1]).rim.tolist() == [
        len(V) - 18,
        *range(len(V) - 1, len(V) - 18, -1),
    ]


def test_a_triangle_is_a_disk():
    assert ism.check_disk(np.eye(3), [[0, 1, 2]]).rim.tolist() == [0, 1, 2]


def test_areas_and_units():
    disk = ism.check_disk(1e-9 * V + 5, F)
    assert disk.A.sum() == pytest.approx(1)
    assert np.ptp(disk.unit, axis=0).max() > 0.9
    assert (disk.v == 1e-9 * V + 5).all()


def torus(n=6):
    """A torus, from which the first face is dropped."""
    i, j = np.divmod(np.arange(n * n), n)
    right, up = i * n + (j + 1) % n, (i + 1) % n * n + j
    across = (i + 1) % n * n + (j + 1) % n
    a = np.arange(n * n)
    t, u = 2 * np.pi * i / n, 2 * np.pi * j / n
    v = np.column_stack(((3 + np.cos(u)) * np.cos(t), (3 + np.cos(u)) * np.sin(t), np.sin(u)))
    return v, np.vstack((np.column_stack((a, up, across)), np.column_stack((a, across, right))))[1:]


def pinched():
    """A disk two of whose boundary vertices are one."""
    return V[:-1], np.where(len(V) - 1 == F, len(V) - 10, F)


@pytest.mark.parametrize(
    ("mesh", "words"),
    [
        (lambda: icosphere(1), ["closed surface", "spherical_conformal_map"]),
        (lambda: (V, F[6:]), ["unreferenced", "1 vertex", "0"]),
        (
            lambda: (V[1:], F[6:] - 1),
            ["2 boundary loops", "18 and 6 edges", "near (", "holes='fill'"],
        ),
        (torus, ["1 handle ", "3 edges", "near (", "handles='cut'"]),
        (pinched, ["non-manifold vertex", str(len(V) - 10)]),
        (lambda: (V, np.vstack((F[:-1], F[-1:, ::-1]))), ["inconsistent orientation", "reverse"]),
        (lambda: (V, np.vstack((F, F[:1]))), ["non-manifold edge"]),
        (lambda: (V, np.vstack((F, [[0, 0, 1]]))), ["degenerate", str(len(F))]),
        (lambda: (np.vstack((V, V + 3)), np.vstack((F, F + len(V)))), ["2 components"]),
        (lambda: (V, F + 1), ["1-based"]),
        (lambda: (V * np.nan, F), ["not finite"]),
        (lambda: (0 * V, F), ["zero area"]),
        (lambda: (V, F[:0]), ["no faces"]),
    ],
)
def test_what_is_no_disk_is_refused_with_place_and_remedy(mesh, words):
    with pytest.raises(ism.MeshError) as error:
        ism.check_disk(*mesh())
    assert all(word in str(error.value) for word in words), error.value
    assert "\n" not in str(error.value)
