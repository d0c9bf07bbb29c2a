"""Distortion of maps whose singular values are known."""

from __future__ import annotations

import numpy as np

import igl_spheremap as ism
from igl_spheremap.resampling.locate import Location
from igl_spheremap.shapes.correspondence.stretch import Distortion


def test_a_similarity_has_none() -> None:
    v, f = ism.samples.make("pear", n_vertices=400)
    found = Distortion.of(
        v, 7 * v @ np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0], f
    )
    assert np.allclose(found.symmetric_dirichlet, 4)
    assert np.allclose(found.area_ratio, 1)
    assert np.allclose(found.angle_ratio, 1, atol=1e-6)


def test_a_stretch_of_the_plane_has_its_singular_values() -> None:
    rng = np.random.default_rng(1)
    p = np.column_stack((rng.normal(size=(90, 2)), np.zeros(90)))
    f = np.arange(90).reshape(-1, 3)
    turn = np.array([[0.6, 0.8, 0], [-0.8, 0.6, 0], [0, 0, 1]])
    found = Distortion.of(p, p * [3.0, 0.5, 1.0] @ turn, f)
    s1, s2 = 3 / np.sqrt(1.5), 0.5 / np.sqrt(1.5)  # after scaling to equal area
    assert np.allclose(found.angle_ratio, 6)
    assert np.allclose(found.area_ratio, 1)
    assert np.allclose(found.symmetric_dirichlet, s1**2 + s2**2 + s1**-2 + s2**-2)


def test_the_inverse_has_the_same_distortion() -> None:
    a, b = (
        ism.spherical_conformal_map(*ism.samples.make(name, n_vertices=500))
        for name in ("pear", "dumbbell")
    )
    nothing = Location(np.empty(0, dtype=np.int64), np.empty((0, 3)))
    there, back = (
        ism.shapes.SurfaceMap(*pair, nothing.face, nothing).distortion()
        for pair in ((a, b), (b, a))
    )
    for name in ("symmetric_dirichlet", "area_ratio", "angle_ratio"):
        one, other = there.figures["over_source"][name], back.figures["over_target"][name]
        assert np.allclose(list(one.values()), list(other.values()), rtol=1e-6)


def test_faces_without_area_count_as_far() -> None:
    v, f = ism.samples.make("pear", n_vertices=400)
    flat = v.copy()
    flat[f[0]] = v[f[0, 0]]
    figures = Distortion.of(v, flat, f).figures
    lost = sum(np.isin(f, f[0]).sum(axis=1) >= 2)
    assert lost >= 4
    assert figures["over_source"]["area_ratio"]["above_100"] > 0
    assert figures["over_target"]["area_ratio"]["above_100"] == 0


def test_caps_have_no_part_in_the_figures() -> None:
    """A body whose cap is blown up is the body itself."""
    x, f = ism.samples.sphere(642)
    caps = (x[f][..., 2] > 0.8).all(axis=1)
    inside = np.setdiff1d(f[caps], f[~caps])
    v = x * [1, 1.2, 1.5]
    blown = v.copy()
    blown[inside] *= 1.5
    nothing = Location(np.empty(0, dtype=np.int64), np.empty((0, 3)))
    a, b = (ism.sphere_map(each, f, x, caps=caps) for each in (v, blown))
    figures = ism.shapes.SurfaceMap(a, b, nothing.face, nothing).distortion().figures
    for over in ("over_source", "over_target"):
        assert np.isclose(figures[over]["symmetric_dirichlet"]["p95"], 4)
    a, b = (ism.sphere_map(each, f, x) for each in (v, blown))
    stretch = ism.shapes.SurfaceMap(a, b, nothing.face, nothing).distortion()
    assert stretch.figures["over_target"]["area_ratio"]["p95"] > 1.1
