"""`info` measures any triangles: parts, boundary loops, handles and planted faults, and their repair."""

from __future__ import annotations

import igl
import numpy as np
import pytest

import igl_spheremap as ism

V, F = ism.samples.sphere(162)


def torus(around=24, along=12):
    """A torus of that many vertices each way."""
    i, j = np.meshgrid(np.arange(around), np.arange(along), indexing="ij")
    s, t = 2 * np.pi * i / around, 2 * np.pi * j / along
    v = np.stack(
        ((2 + np.cos(t)) * np.cos(s), (2 + np.cos(t)) * np.sin(s), np.sin(t)), axis=-1
    ).reshape(-1, 3)
    a, b = (i * along + j).ravel(), ((i + 1) % around * along + j).ravel()
    c, d = (
        ((i + 1) % around * along + (j + 1) % along).ravel(),
        (i * along + (j + 1) % along).ravel(),
    )
    return v, np.concatenate((np.stack((a, b, c), 1), np.stack((a, c, d), 1)))


def joined(*meshes):
    """One mesh of several, beside each other."""
    starts = np.cumsum([0, *(len(v) for v, _ in meshes[:-1])])
    return (
        np.concatenate([v + np.array([9 * k, 0, 0]) for k, (v, _) in enumerate(meshes)]),
        np.concatenate([f + start for (_, f), start in zip(meshes, starts, strict=True)]),
    )


def parts(found):
    return [
        (part.vertices, part.faces, part.boundary_loops, part.handles)
        for part in found.topology.components
    ]


def test_parts_have_their_loops_and_handles():
    around = np.flatnonzero((F == 0).any(axis=1))
    holed = np.delete(F, [*around, np.flatnonzero((F == 161).any(axis=1))[0]], axis=0)
    found = ism.info(*joined((V, holed), torus(), (V, F[:1])))
    assert parts(found) == [
        (288, 576, (), 1),
        (161, 320 - len(around) - 1, (len(around), 3), 0),
        (3, 1, (3,), 0),
    ]
    assert found.topology.unreferenced == 1 + 159
    assert found.maps_to is None
    assert found.repair == {"keep_largest": True, "handles": "cut"}


@pytest.mark.parametrize("glued", [1, 2, 3])
def test_handles_are_those_of_the_euler_characteristic(glued):
    """Tori that are glued along faces have the sum of their handles."""
    v, f = torus()
    pieces_v, pieces_f = [v], [f]
    for k in range(1, glued):
        w = v + np.array([0, 0, 9 * k])
        face, there = f[7 * k], f[0] + len(v) * k
        bridge = np.array([[face[i], there[-i], there[(-i - 1) % 3]] for i in range(3)])
        bridge = np.concatenate(
            (bridge, [[face[i], there[(-i - 1) % 3], face[(i + 1) % 3]] for i in range(3)])
        )
        keep = np.delete(pieces_f[0], np.flatnonzero((pieces_f[0] == face).all(axis=1)), axis=0)
        pieces_f = [keep, *pieces_f[1:], f[1:] + len(v) * k, bridge]
        pieces_v.append(w)
    whole = np.concatenate(pieces_f)
    found = ism.info(np.concatenate(pieces_v), whole)
    n = glued * len(v)
    assert parts(found) == [(n, len(whole), (), glued)]
    assert n - found.topology.edges + len(whole) == igl.euler_characteristic(whole) == 2 - 2 * glued


def test_faults_of_the_lists_are_counted():
    f = np.concatenate((F, [F[0], F[1, [0, 2, 1]], [0, 0, 1], [0, 1, 999]]))
    f[200] = f[200, ::-1]
    topology = ism.info(np.vstack((V, [[np.nan, 0, 0]])), f).topology
    assert (
        topology.copies,
        topology.repeated_indices,
        topology.out_of_range,
        topology.unreferenced,
    ) == (2, 1, 1, 1)
    assert topology.reversed_edges == 3
    edges = {
        tuple(sorted(pair))
        for face in F[:2].tolist()
        for pair in zip(face, face[1:] + face[:1], strict=True)
    }
    assert topology.nonmanifold_edges == len(edges)


def test_sheets_that_touch_and_a_moebius_strip():
    v, f = joined((V, F), (V, F))
    f[f == len(V)] = 0
    found = ism.info(v, f)
    assert found.topology.nonmanifold_vertices == 1
    assert parts(found) == [(162, 320, (), 0)] * 2
    strip = np.array([[k, (k + 1) % 7, (k + 2) % 7] for k in range(7)])
    strip = ism.info(V[:7], strip)
    assert [(part.boundary_loops, part.handles) for part in strip.topology.components] == [
        ((7,), None)
    ]
    assert strip.repair is None


@pytest.mark.parametrize(
    ("f", "maps_to", "repair"),
    [
        (F, "sphere", None),
        (F[:, ::-1], "sphere", {}),
        (F[1:], "plane", {"holes": "fill"}),
        (np.vstack((F[:, ::-1][:9], F[9:])), None, {}),
    ],
)
def test_the_verdict_and_the_repair_are_those_of_the_calls_themselves(f, maps_to, repair):
    found = ism.info(V, f)
    assert (found.maps_to, found.repair) == (maps_to, repair)
    assert (found.error is None) == (maps_to == "sphere")
    if repair is not None:
        again = ism.info(ism.repair_mesh(V, f, **repair))
        assert (again.maps_to, again.repair) == ("sphere", None)
        assert found.actions == ism.repair_mesh(V, f, **repair).actions


def test_an_error_carries_its_remedy():
    with pytest.raises(ism.MeshError) as caught:
        ism.check_mesh(V, F[1:])
    assert caught.value.remedy.options == {"holes": "fill"}
    assert ism.check_mesh(ism.repair_mesh(V, F[1:], **caught.value.remedy.options)).caps.any()
    with pytest.raises(ism.MeshError) as caught:
        ism.check_mesh(V, F + 9)
    assert caught.value.remedy is None


def test_vertices_that_nearly_coincide_are_counted():
    v, f = joined((V, F), (V, F))
    v[len(V) :] = V
    assert (ism.info(v, f).quality.coincident_vertices, ism.info(v, f).quality.near_vertices) == (
        162,
        0,
    )
    v[len(V) :] += [1e-9, 0, 0]
    assert (ism.info(v, f).quality.coincident_vertices, ism.info(v, f).quality.near_vertices) == (
        0,
        324,
    )


def test_it_is_printed_in_sentences_of_calls():
    text = str(ism.info(V, F[1:]))
    assert "a disk, which can be mapped to the plane" in text
    assert "repair_mesh(v, f, holes='fill') would do this: filled 1 hole" in text
