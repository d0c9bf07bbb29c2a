"""Pairs of edges that may meet: no more than in proportion to the edges, however these lie beside each other."""

import numpy as np
import pytest

from igl_spheremap.verify import rim, strip_tree
from igl_spheremap.verify.rim import plane_signs, rim_crossings


def spikes(k, inner):
    """A star."""
    turn = 2 * np.pi * np.arange(k) / k
    return (
        np.column_stack((np.cos(turn), np.sin(turn)))
        * np.where(np.arange(k) % 2, 1, inner)[:, None]
    )


def slanted_comb(k):
    """Long teeth beside each other, along no axis."""
    x = np.arange(k) / k
    p = np.vstack((np.column_stack((x, np.arange(k) % 2)), [[1, -1], [0, -1]]))
    return p @ np.array([[0.8, 0.6], [-0.6, 0.8]])


def jagged_comb(k):
    """The same with teeth of all lengths: chords have all directions."""
    p = slanted_comb(k)
    p[:-2] += np.random.default_rng(0).uniform(-0.4, 0.4, k)[:, None] * [-0.6, 0.8]
    return p


@pytest.mark.parametrize(
    "p", [spikes(3000, 0.2), 1e3 + spikes(3001, 0.2), slanted_comb(3000), jagged_comb(3000)]
)
def test_edges_side_by_side_are_compared_with_few_others(p, monkeypatch):
    compared, near = [], strip_tree._Runs.near
    monkeypatch.setattr(
        rim, "plane_signs", lambda q, f: compared.append(len(f)) or plane_signs(q, f)
    )
    monkeypatch.setattr(
        strip_tree._Runs, "near", lambda runs, i, j: compared.append(len(i)) or near(runs, i, j)
    )
    assert not rim_crossings(p, np.arange(len(p))).any()
    assert sum(compared) < 20 * len(p)  # bounding boxes of each edge meet those of hundreds


@pytest.mark.parametrize("seed", range(5))
def test_all_meetings_of_long_polygons_are_found(seed):
    """Lines across a star, against every pair of edges: floating-point signs decide where corners lie at random."""
    rng = np.random.default_rng(seed)
    p = spikes(500, 0.05) * np.exp(rng.uniform(-3, 0, 500))[:, None]
    p = np.vstack((p, rng.uniform(-1, 1, (20, 2))))
    a, b = p, np.roll(p, -1, axis=0)

    def side(at, to, q):
        u, w = to - at, q - at
        return u[..., 0] * w[..., 1] > u[..., 1] * w[..., 0]

    one, other = a[:, None], b[:, None]
    hit = (side(one, other, a) != side(one, other, b)) & (side(a, b, one) != side(a, b, other))
    i = np.arange(len(p))
    hit[(np.abs(i[:, None] - i) <= 1) | (np.abs(i[:, None] - i) == len(p) - 1)] = False
    assert (rim_crossings(p, i) == hit.any(axis=1)).all()
