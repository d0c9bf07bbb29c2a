"""Whatever collapses, the triangles stay those of a closed sphere, each side between two of them."""

import numpy as np
import pytest

from igl_spheremap.mesh.edges import half_edges
from igl_spheremap.samples import sphere
from igl_spheremap.shapes.correspondence.cells import Coincidences
from igl_spheremap.shapes.correspondence.complex import Complex
from igl_spheremap.shapes.correspondence.levels import hull_faces


def complex_of(n):
    f = sphere(n)[1]
    return Complex(dict(enumerate(map(tuple, f.tolist())))), n, len(f)


def check(complex):
    """Numbered anew the faces are a closed oriented sphere, and `around` names those at each vertex."""
    faces = np.array(list(complex.faces.values()))
    used, f = np.unique(faces, return_inverse=True)
    assert half_edges(f.reshape(-1, 3), len(used)) is not None
    assert len(faces) == 2 * len(used) - 4
    at = {v: {i for i, corners in complex.faces.items() if v in corners} for v in used.tolist()}
    assert {v: rows for v, rows in complex.around.items() if rows} == at


def divided(complex, i, new, number):
    """Divide a face in three at a vertex within it; the new ones have `number` and the next."""
    a, b, c = complex.faces[i]
    complex.put({i: (new, b, c), number: (a, new, c), number + 1: (a, b, new)})


@pytest.mark.parametrize("seed", range(3))
def test_random_collapses_keep_a_sphere(seed):
    rng = np.random.default_rng(seed)
    complex, vertex, number = complex_of(162)
    for k in range(20):
        divided(complex, int(rng.choice(list(complex.faces))), vertex + k, number + 2 * k)
    while len(complex.faces) > 4:
        out = int(rng.choice([v for v, rows in complex.around.items() if rows]))
        edit = complex.collapsed(out, min(complex.neighbours(out)))
        if edit:
            complex.put(*edit)
            check(complex)


def test_a_side_whose_ends_have_a_third_common_neighbour_stays():
    complex, vertex, number = complex_of(12)
    a, b, c = complex.faces[0]
    (beyond,) = complex.around[b] & complex.around[c] - {0}
    divided(complex, 0, vertex, number)
    divided(complex, beyond, vertex + 1, number + 2)
    # the ends have both new vertices and two others in common
    assert complex.collapsed(b, c) is None
    assert complex.collapsed(vertex, a) is not None


def test_nodes_that_merge_in_turn_all_become_the_last_one():
    """A vertex of one surface meets a crossing, which then meets a vertex of the other one."""
    x = np.vstack((np.eye(3), -np.eye(3)))
    f = hull_faces(x)
    complex = Complex(dict(enumerate(map(tuple, f.tolist()))))
    face = next(i for i, corners in complex.faces.items() if 0 in corners)
    divided(complex, face, 6, 8)
    beside = next(i for i, corners in complex.faces.items() if {0, 6} <= {*corners})
    divided(complex, beside, 7, 10)
    inwards = x[f[face]].mean(axis=0) - x[0]
    on = np.vstack((x, x[0] + 1.2e-15 * inwards, x[0] + 1.5e-15 * inwards))
    owners = np.arange(12)
    owners[8:] = face
    merged = Coincidences(
        np.array([complex.faces[i] for i in range(12)]),
        np.stack((owners, owners)),
        np.stack((on, on)),
        (x[f], x[f]),
        (np.arange(6), np.array([7, 1, 2, 3, 4, 5])),
    )
    assert merged.merge() == 0
    assert merged.node.tolist() == [0, 1, 2, 3, 4, 5, 0, 0]
    assert {frozenset(corners) for corners in merged.faces[merged.left].tolist()} == {
        *map(frozenset, f.tolist())
    }
