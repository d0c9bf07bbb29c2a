"""The lens is a Moebius map, and follows the foldings wherever they are."""

import numpy as np
import pytest
from drawing import drive, needs_drawing

import igl_spheremap as ism
from igl_spheremap.draw.lens import Lens, follow
from igl_spheremap.sphere.moebius import moebius
from igl_spheremap.verify.certificate import orientation_signs


def unit(rows):
    return rows / np.linalg.norm(rows, axis=-1, keepdims=True)


@pytest.mark.parametrize("place", [[0.0, 0, 1], [0.0, 0, -1], [0.3, -0.8, 0.5]])
def test_the_lens_is_the_moebius_map_towards_its_place_and_a_turn(place):
    x = unit(np.random.default_rng(1).normal(size=(50, 3)))
    lens = Lens(unit(np.array(place)), 5.0)
    c = lens.place * (lens.power - 1) / (lens.power + 1)
    assert lens(x) == pytest.approx(moebius(x, c) @ lens.axes().T, abs=1e-12)
    assert np.linalg.det(lens.axes()) == pytest.approx(1)
    assert lens(lens.place[None])[0] == pytest.approx([0, 0, 1], abs=1e-12)


def test_a_strong_lens_magnifies_by_its_power_at_its_place():
    place = unit(np.array([0.3, -0.8, 0.5]))
    step = 1e-9 * np.cross(place, [1.0, 0, 0])
    moved = Lens(place, 1e7)(unit(place[None] + step))[0]
    assert np.hypot(*moved[:2]) / np.linalg.norm(step) == pytest.approx(1e7, rel=1e-3)


def test_the_plain_view_is_the_map_itself():
    x = unit(np.random.default_rng(2).normal(size=(50, 3)))
    assert follow([x], np.array([[0, 1, 2]]), np.empty(0, dtype=np.int64))[0](x) == pytest.approx(
        x, abs=1e-14
    )


def test_a_fold_planted_at_a_limb_s_tip_comes_to_the_front_and_is_seen():
    v, f = ism.samples.make("dino", n_vertices=1500)
    x = ism.spherical_conformal_map(v, f).sphere.copy()
    tip = int(np.argmin(ism.conformal_factor(v, f, x)))
    around = np.unique(f[(f == tip).any(axis=1)])
    other = around[around != tip][0]
    x[tip] = unit(x[other] + 0.2 * (x[other] - x[tip]))  # across the edge opposite to it
    folded = np.flatnonzero(orientation_signs(x, f) <= 0)
    assert len(folded)
    size = np.ptp(x[f[folded]], axis=1).max()
    y = follow([x], f, folded)[0](x)
    assert np.ptp(y[f[folded]], axis=1).max() > max(0.05, 3 * size)
    assert y[f[folded]][..., 2].min() > 0.5


def test_at_its_limit_the_lens_fills_the_view_with_what_it_is_on_and_no_more():
    x, f = ism.samples.make("sphere", n_vertices=2562)
    faces = np.flatnonzero((f == 100).any(axis=1))
    (plain,) = follow([x], f, faces)
    (lens,) = follow([x], f, faces, power=1e9)
    assert plain.power < lens.power == lens.limit
    heights = lens(x)[np.unique(f[faces])][:, 2]
    assert np.sort(heights)[:-1] == pytest.approx(0, abs=0.15)  # corners of the ring reach the rim
    assert heights.max() > 0.5


@needs_drawing
def test_a_fold_is_seen_from_every_side_however_small_it_is():
    figures = drive("""
from igl_spheremap.apps.viewer.colouring import Colouring
from igl_spheremap.apps.viewer.compare import PartsView
from igl_spheremap.apps.viewer.grid import Part
v, f = ism.samples.make('sphere', n_vertices=600)
small, (a, b, c) = v.copy(), f[np.argmax(v[f, 2].mean(axis=1))]
small[a] = (v[b] + v[c]) / 2 + 1e-6 * (v[b] + v[c] - 2 * v[a])  # just across the edge opposite
small[a] /= np.linalg.norm(small[a])
folded = ism.certify(small, f).flipped
app.open_for(Pictures('unused.png', size=(800, 400)))
grey = Colouring(np.full(f.shape, 0.8), folded)
view = PartsView([[Part('surface', small, f), Part('map', small, f, grey, image=True)]])
ps.set_user_callback(lambda: app.draw_app(view))
red = []
for _ in range(6):
    view.grid.rotate(1.0, 0.4)
    image = window.grab()
    red.append([vermilion(image[:, :400]), vermilion(image[:, 400:])])
figures = dict(red=red, folded=len(folded))
""")
    assert figures["folded"] > 0
    for plain, marked in figures["red"]:
        assert plain == 0
        assert marked > 1e-5
