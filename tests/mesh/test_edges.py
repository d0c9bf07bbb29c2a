"""Half-edges and fans of faces, on spheres whose neighbours and fans are known."""

import numpy as np

from igl_spheremap.mesh.edges import (
    fans,
    half_edges,
    half_edges_out,
    pinched_vertices,
    shared_edges,
    sides,
)
from igl_spheremap.samples import sphere


def test_half_edges_out_of_a_vertex_run_once_to_each_neighbour():
    f, vertices = sphere(42)[1], np.array([5, 0, 41, 5])
    place, half = half_edges_out(half_edges(f, 42), vertices)
    start, stop = sides(f)
    assert (start[half] == vertices[place]).all()
    for k, vertex in enumerate(vertices.tolist()):
        around = f[(f == vertex).any(axis=1)]
        assert sorted(stop[half[place == k]].tolist()) == sorted({*around.ravel()} - {vertex})


def test_a_vertex_where_two_spheres_touch_has_two_fans_whichever_way_faces_run():
    f = sphere(12)[1]
    other = f + 11
    other[f == 0] = 7
    both = np.concatenate((f, other))
    rng = np.random.default_rng(0)
    for _ in range(3):
        first, second = shared_edges(both, 23)[2:]
        number, fan = fans(both, first, second)
        assert number == 24
        assert pinched_vertices(both, first, second).tolist() == [7]
        for vertex in range(23):
            assert len(np.unique(fan[both.ravel() == vertex])) == 1 + (vertex == 7)
        turned = rng.random(len(both)) < 0.5
        both[turned] = both[turned, ::-1]
