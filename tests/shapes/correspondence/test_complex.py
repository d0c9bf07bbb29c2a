"""Whatever is edited, the triangles stay those of a closed sphere, each side between two of them."""

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


def collapse(complex, rng, vertex, number):
    out = int(rng.choice([v for v, rows in complex.around.items() if rows]))
    edit = complex.collapsed(out, min(complex.neighbours(out)))
    if edit and len(complex.faces) > 4:
        complex.put(*edit)
    return vertex, number


def divide(complex, rng, vertex, number):
    complex.put(complex.divided(int(rng.choice(list(complex.faces))), vertex, number))
    return vertex + 1, number + 2


def halve(complex, rng, vertex, number):
    p, q, _ = complex.faces[int(rng.choice(list(complex.faces)))]
    complex.put(complex.halved(p, q, vertex, number))
    return vertex + 1, number + 2


@pytest.mark.parametrize("seed", range(3))
def test_random_edits_keep_a_sphere(seed):
    rng = np.random.default_rng(seed)
    complex, vertex, number = complex_of(42)
    for edit in rng.choice([collapse, collapse, divide, halve], 300):
        vertex, number = edit(complex, rng, vertex, number)
        check(complex)


def test_a_side_whose_ends_have_a_third_common_neighbour_stays():
    complex, vertex, number = complex_of(12)
    a, b, c = complex.faces[0]
    (beyond,) = {*complex.beside(b, c)} - {0}
    complex.put(complex.divided(0, vertex, number))
    complex.put(complex.divided(beyond, vertex + 1, number + 2))
    # the ends have both new vertices and two others in common
    assert complex.collapsed(b, c) is None
    assert complex.collapsed(vertex, a) is not None


def test_nodes_that_merge_in_turn_all_become_the_last_one():
    """A vertex of one surface meets a crossing, which then meets a vertex of the other one."""
    x = np.vstack((np.eye(3), -np.eye(3)))
    f = hull_faces(x)
    complex = Complex(dict(enumerate(map(tuple, f.tolist()))))
    face = next(i for i, corners in complex.faces.items() if 0 in corners)
    complex.put(complex.divided(face, 6, 8))
    beside = next(i for i, corners in complex.faces.items() if {0, 6} <= {*corners})
    complex.put(complex.divided(beside, 7, 10))
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
