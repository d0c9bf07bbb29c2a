"""Clusters of folded faces, and which of them a picture does not show."""

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.draw.folds import SEEN, Clusters, Marks


def test_faces_are_in_one_cluster_if_a_chain_of_shared_vertices_leads_from_one_to_the_other():
    _, f = ism.samples.make("sphere", n_vertices=600)
    folded = np.sort(np.random.default_rng(1).choice(len(f), 120, replace=False))
    clusters = Clusters.of(f, folded)
    label = {}
    for k, cluster in enumerate(clusters):
        label |= dict.fromkeys(cluster.tolist(), k)
    assert sorted(label) == folded.tolist()
    for one in folded:
        touching = folded[np.isin(f[folded], f[one]).any(axis=1)]
        assert {label[int(other)] for other in touching} == {label[int(one)]}
    for cluster in clusters:  # nothing of a cluster can be left out
        reached = cluster[:1]
        for _ in cluster:
            reached = cluster[np.isin(f[cluster], f[reached]).any(axis=1)]
        assert len(reached) == len(cluster)
    assert (
        clusters.sizes.tolist()
        == [len(cluster) for cluster in clusters]
        == sorted(clusters.sizes, reverse=True)
    )
    assert (clusters[-1] == list(clusters)[-1]).all()
    with pytest.raises(IndexError):
        clusters[len(clusters)]
    assert not list(Clusters.of(f, folded[:0]))


@pytest.mark.parametrize("sphere", [True, False])
def test_what_is_marked_covers_fewer_pixels_than_are_seen_or_lies_behind(sphere):
    v, f = ism.samples.make("sphere", n_vertices=600)
    place = int(np.argmax(v[f, 2].mean(axis=1)))
    faces = f[:, ::-1] if sphere else f  # folded faces of a map turn inwards
    marks = Marks.of(v, faces, np.array([place]), sphere)
    a, b, c = v[f[place]]
    normal = np.cross(b - a, c - a)
    enough = SEEN / np.sqrt(np.linalg.norm(normal) / 2)
    normal /= np.linalg.norm(normal)
    if sphere:
        normal = (a + b + c) / np.linalg.norm(a + b + c)
    assert len(marks.unseen(normal, 1.001 * enough)[0]) == 0
    places, front = marks.unseen(normal, 0.999 * enough)
    assert places == pytest.approx((a + b + c)[None] / 3)
    assert front.tolist() == [True]
    assert marks.unseen(-normal, 100 * enough)[1].tolist() == [False]


def test_a_fold_in_the_plane_is_seen_from_above_whichever_way_its_face_turns():
    x = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [-9, 0, 0], [0, -9, 0]])
    for face in ([0, 1, 2], [0, 2, 1]):
        marks = Marks.of(x, np.array([face, [0, 3, 4]]), np.array([0]), True)
        assert len(marks.unseen(np.array([0.0, 0, 1]), 1.01 * SEEN * np.sqrt(2))[0]) == 0
        assert marks.unseen(np.array([0.0, 0, 1]), 0.99 * SEEN * np.sqrt(2))[1].tolist() == [True]


def test_a_sliver_is_marked_however_long_it_is():
    x = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1e-3, 0], [-9, 0, 0], [0, -9, 0]])
    marks = Marks.of(x, np.array([[0, 2, 1], [0, 3, 4]]), np.array([0]), True)
    for pixels in (400, 900, 1100):  # its area is 80, 405 and 605 pixels, its width .4, .9 and 1.1
        assert len(marks.unseen(np.array([0.0, 0, 1]), pixels)[0]) == (pixels < 1000)
