"""One body that two triangulations carry, so that the truth is known: each lies over the sphere that it was made of."""

import numpy as np
import pytest
from family import body, spiral

import igl_spheremap as ism


@pytest.fixture(scope="session")
def pair():
    """Its area-preserving maps, and where the vertices of the first lie on the second: positions, nearest vertices."""
    rng = np.random.default_rng(0)
    (x, f), (y, g) = (spiral(n, rng) for n in (280, 350))
    v, w = body(x, 0.5, -0.5), body(y, 0.5, -0.5)
    located = ism.SphereLocator(y, g).locate(x)
    truth = np.einsum("ij,ijk->ik", located.weights, w[g[located.face]])
    a, b = (ism.balanced_spherical_map(*each, balance=1.0) for each in ((v, f), (w, g)))
    return a, b, truth, g[located.face, located.weights.argmax(axis=1)]


@pytest.fixture(scope="session")
def found(pair):
    """The match of both."""
    return ism.shapes.match(*pair[:2])
