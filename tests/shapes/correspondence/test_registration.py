"""Registration: planted rotations and Moebius maps come back, every map is certified, bad input is named."""

from __future__ import annotations

import igl
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import igl_spheremap as ism
from igl_spheremap.features.feature_surface import FeatureSurface, depth_potential
from igl_spheremap.mesh.measure import face_areas
from igl_spheremap.shapes.correspondence import USUAL
from igl_spheremap.shapes.correspondence.features import smooth_function
from igl_spheremap.shapes.correspondence.levels import Level
from igl_spheremap.shapes.correspondence.registration import reflected
from igl_spheremap.shapes.harmonics.basis import synthesis
from igl_spheremap.shapes.harmonics.rotation import rotate, rotation_angle
from igl_spheremap.sphere.moebius import moebius
from igl_spheremap.sphere.rows import unit_rows

ALL = ["rotation", "moebius", "elastic"]
R = Rotation.from_euler("ZYZ", [1.0, 0.7, -2.0]).as_matrix()


@pytest.fixture(scope="module")
def dino():
    return ism.spherical_conformal_map(*ism.samples.make("dino", n_vertices=2000))


@pytest.fixture(scope="module")
def ball():
    """A sphere with a function on it that no rotation keeps."""
    x, f = ism.samples.sphere(642)
    values = synthesis(np.random.default_rng(0).normal(size=(36, 2)), x)
    return ism.sphere_map(x * [1, 1.2, 1.5], f, x), values


def surface_of(result):
    return FeatureSurface(ism.check_mesh(result.vertices, result.faces))


def moved(result, x):
    return ism.sphere_map(result.vertices, result.faces, x)


def test_a_copy_that_is_meshed_anew_turns_back(dino):
    decimated = igl.qslim(dino.vertices, dino.faces, int(0.6 * len(dino.faces)))
    v, f = (a for a in decimated if np.ndim(a) == 2)
    copy = ism.spherical_conformal_map(v, f)
    result = ism.shapes.register(moved(copy, copy.sphere @ R.T), dino, stages=["rotation"])
    assert rotation_angle(result.rotation @ R) < 0.2
    assert result.map.certificate.folding_free
    assert result.margin > 0.15
    assert result.notes == ()


def test_a_planted_moebius_map_comes_back(ball):
    fixed, values = ball
    moving = moved(fixed, moebius(fixed.sphere, [0.1, -0.05, 0.1]) @ R.T)
    result = ism.shapes.register(
        moving, fixed, features=(values, values), stages=["rotation", "moebius"]
    )
    off = np.linalg.norm(result.map.sphere - fixed.sphere, axis=1)
    assert (
        off.mean()
        < 0.01
        < 0.05
        < np.linalg.norm(moving.sphere @ result.rotation.T - fixed.sphere, axis=1).mean()
    )
    assert result.map.certificate.folding_free
    correlations = np.array([stage.correlation for stage in result.stages])
    assert (np.diff(correlations, axis=0) > 0).all()
    assert (correlations[-1] > 0.999).all()


def test_of_rotations_that_correlate_alike_that_of_least_strain_is_taken():
    """Features ask for half a turn, by little; a body with a bump does not."""
    x, f = ism.samples.sphere(642)
    v = x * [1, 1.2, 1.5] * (1 + 0.3 * np.exp(-4 * ((x - [1, 0, 0]) ** 2).sum(axis=1)))[:, None]
    body, c = ism.sphere_map(v, f, x), np.random.default_rng(0).normal(size=(36, 1))
    there, turned = synthesis(c, x), synthesis(c, x * [-1, -1, 1])
    features = 0.9 * there + 1.1 * turned, 1.1 * there + 0.9 * turned
    correlated = ism.shapes.register(
        moved(body, x @ R.T), body, features=features, stages=["rotation"]
    )
    assert rotation_angle(correlated.rotation @ R) > 175
    result = ism.shapes.register(moved(body, x @ R.T), body, features=features)
    assert rotation_angle(result.rotation @ R) < 5
    assert -0.1 < result.margin < 0
    assert "margin is small" in result.notes[0]


@pytest.fixture(scope="module")
def bodies():
    """A wavy body, and the same one bent smoothly: vertex i is vertex i."""
    x, f = ism.samples.sphere(642)
    v = x * np.exp(0.04 * synthesis(np.random.default_rng(0).normal(size=(81, 1)), x))
    bent = v * [1, 1.1, 0.9] + 0.05 * np.sin(3 * v[:, [1, 2, 0]])
    return ism.balanced_spherical_map(bent, f, balance=0.85), ism.balanced_spherical_map(
        v, f, balance=0.85
    )


def distance(body, p, q):
    """Median distance of rows, as a share of a body's size."""
    return np.median(np.linalg.norm(p - q, axis=1)) / np.ptp(body.vertices, axis=0).max()


def test_a_bent_body_lies_on_its_vertices_whichever_way_its_sphere_is_turned(bodies):
    bent, body = bodies
    results = (
        ism.shapes.register(moved(bent, bent.sphere @ Q.T), body, stages=stages)
        for Q, stages in ((R, ["rotation"]), (np.eye(3), USUAL), (R, USUAL))
    )
    start, *ends = (ism.transfer(body, body.vertices, result.map.sphere) for result in results)
    assert all(
        distance(body, end, body.vertices) < 0.6 * distance(body, start, body.vertices)
        for end in ends
    )
    assert distance(body, *ends) < 0.002


def test_there_and_back_is_where_it_began(bodies):
    bent, body = bodies
    there, back = (ism.shapes.register(a, b).map.sphere for a, b in (bodies, bodies[::-1]))
    again = ism.transfer(bent, bent.vertices, unit_rows(ism.transfer(body, back, there)))
    assert distance(bent, again, bent.vertices) < 0.003


def test_stages_report_what_they_did(ball):
    fixed, values = ball
    seen = []
    turned = moved(fixed, fixed.sphere @ R.T)
    result = ism.shapes.register(
        turned, fixed, features=(values, values), stages=ALL, listener=seen.append
    )
    assert [stage.name for stage in result.stages] == ["start", "rotation", "moebius", "elastic"]
    assert all(stage.strain < 1e-12 for stage in result.stages[:2])
    assert seen[0].stage == "rotation"
    assert all(ism.certify(iterate.x, fixed.faces).folding_free for iterate in seen)
    costs = [iterate.energy for iterate in seen if iterate.stage == "moebius"]
    assert costs == sorted(costs, reverse=True)
    assert seen[-1].stage == "elastic"
    assert np.array_equal(seen[-1].x, result.map.sphere)


def turning(c):
    """Coefficients (3, (L + 1)^2, k) of x cross grad f: how f changes as x turns about each axis."""
    h = 1e-6
    turns = (Rotation.from_rotvec(h * axis).as_matrix() for axis in np.eye(3))
    return np.stack([(rotate(c, R.T) - rotate(c, R)) / (2 * h) for R in turns])


def warp(x, size):
    """A smooth bijection of the sphere that is not a Moebius map, of degree 3."""
    c = np.zeros((16, 1))
    c[9:, 0] = [1, -1, 0.5, 1, -0.5, 1, -1]
    for _ in range(10):
        across = synthesis(turning(c)[:, :, 0].T, x)  # x cross the gradient
        x = unit_rows(x + size / 10 * (across - np.cross(x, across)))
    return x


def test_a_planted_warp_comes_back_through_bijections(ball):
    fixed, values = ball
    warped = moved(fixed, warp(fixed.sphere, 0.06) @ R.T)
    seen = []
    result = ism.shapes.register(
        warped, fixed, features=(values, values), stages=ALL, listener=seen.append
    )
    rigid = ism.shapes.register(
        warped, fixed, features=(values, values), stages=["rotation", "moebius"]
    )
    before, after = (
        np.degrees(np.linalg.norm(r.map.sphere - fixed.sphere, axis=1)).mean()
        for r in (rigid, result)
    )
    assert before > 4
    assert after < before / 5
    assert all(ism.certify(iterate.x, fixed.faces).folding_free for iterate in seen)
    assert (result.stages[-1].correlation > 0.99).all()
    assert 0 < result.stages[-1].strain < result.stages[-1].strain_95


def test_stiffer_maps_agree_less_and_strain_the_surfaces_less(ball):
    fixed, values = ball
    off = values + 0.5 * np.random.default_rng(1).normal(size=values.shape)
    results = [
        ism.shapes.register(fixed, fixed, features=(off, values), stages=["elastic"], stiffness=s)
        for s in (0.1, 10.0, 1e6)
    ]
    agree = [result.stages[-1].correlation.mean() for result in results]
    strain = [
        np.abs(
            np.log(face_areas(r.map.sphere, fixed.faces) / face_areas(fixed.sphere, fixed.faces))
        ).mean()
        for r in results
    ]
    assert agree[0] > agree[1] > agree[2]
    assert strain[0] > strain[1] > 1e-3 > strain[2]


def test_a_listener_may_stop(ball):
    fixed, values = ball
    warped = moved(fixed, warp(fixed.sphere, 0.06))
    seen = []

    def stop_at_the_third(iterate):
        seen.append(iterate.x)
        if len(seen) == 3:
            raise StopIteration

    result = ism.shapes.register(
        warped, fixed, features=(values, values), stages=ALL, listener=stop_at_the_third
    )
    assert np.allclose(result.map.sphere, seen[-1], atol=1e-15)
    assert [stage.name for stage in result.stages] == ["start", "rotation", "moebius"]


def test_a_mirror_image_is_reflected_first(dino):
    mirrored = ism.spherical_conformal_map(dino.vertices * [-1, 1, 1], dino.faces[:, ::-1])
    turned = moved(mirrored, mirrored.sphere @ R.T)
    result = ism.shapes.register(turned, dino, reflect=True, stages=["rotation"])
    assert np.array_equal(result.map.vertices, dino.vertices)
    assert np.array_equal(np.sort(result.map.faces), np.sort(dino.faces))
    assert np.abs(result.map.sphere - dino.sphere).max() < 1e-3


def test_a_mirror_image_keeps_its_map():
    """Bit for bit there and back; the map that was given is mirrored, and none is made anew."""
    v, f = ism.samples.make("pear", n_vertices=600)
    result = ism.balanced_spherical_map(v, f, balance=0.5, method=ism.Auto(tolerance=1e-5))
    mirror = reflected(result)
    assert (mirror.method, mirror.settings, mirror.balance) == (result.method, result.settings, 0.5)
    assert mirror.certificate.folding_free
    assert np.array_equal(mirror.sphere, result.sphere * [-1, 1, 1])
    again = reflected(mirror)
    for name in ("vertices", "faces", "sphere"):
        assert np.array_equal(getattr(again, name), getattr(result, name))
    assert np.array_equal(again.conformal.sphere, result.conformal.sphere)


def test_the_same_input_gives_the_same_bits():
    x, f = ism.samples.sphere(642)
    fixed, values = ism.sphere_map(x * [1, 1.1, 1.2], f, x), np.exp(x[:, :2])
    first, second = (
        ism.shapes.register(fixed, fixed, features=(values, values)).map.sphere for _ in range(2)
    )
    assert np.array_equal(first, second)


def test_unlike_shapes_are_certified_and_doubted():
    x, f = ism.samples.sphere(362)
    noise = np.random.default_rng(5).normal(size=(2, 362))
    ball = ism.sphere_map(x * [1, 1.1, 1.2], f, x)
    result = ism.shapes.register(ball, ball, features=(noise[0], noise[1]))
    assert result.map.certificate.folding_free
    assert "margin is small" in result.notes[0]
    assert result.margin < 0.1 * result.candidates[0].correlation


def test_limbs_of_conformal_maps_keep_their_certificate():
    """And what is lost in them is noted."""
    target, source = (
        ism.spherical_conformal_map(*ism.samples.make("dino", n_vertices=n)) for n in (5000, 2500)
    )
    result = ism.shapes.register(source, target)
    assert result.map.certificate.folding_free
    assert "the stage rotation lowered the correlation" in result.notes[-1]


def test_fixed_features_are_the_function_and_its_gradient():
    """Both of second order, on a sphere that is not a regular one."""
    rng = np.random.default_rng(3)
    c, q = rng.normal(size=(25, 1)), unit_rows(rng.normal(size=(300, 3)))
    exact = -np.cross(q, synthesis(turning(c)[:, :, 0].T, q))
    off = []
    for level in (3, 4, 5):
        x, f = ism.samples.sphere(10 * 4**level + 2)
        x = moebius(x, [0.2, 0.1, 0.1])
        level = Level(ism.sphere_map(x, f, x), x, np.empty(0, dtype=np.int64))
        values, gradients = smooth_function(level, synthesis(c, x))(q)
        off.append([np.abs(values - synthesis(c, q)).max(), np.abs(gradients[:, 0] - exact).max()])
    assert (np.divide(off[0], off[1]) > 3).all()
    assert (np.divide(off[1], off[2]) > 3).all()


def test_features_are_the_same_on_every_map(dino):
    other = moved(dino, moebius(dino.sphere, [0.3, 0.2, 0.1]))
    a, b = surface_of(dino), surface_of(other)
    assert np.array_equal(a.potential(0.1), b.potential(0.1))


def test_the_depth_potential_is_highest_on_a_bump():
    x, f = ism.samples.sphere(10 * 4**4 + 2)
    bump = np.exp(-20 * ((x - [0, 0, 1]) ** 2).sum(axis=1))
    for ell in (0.7, 0.1):
        assert depth_potential(
            x * (1 + 0.3 * bump[:, None]), f, ell=ell
        ).argmax() in np.flatnonzero(bump > 0.9)


def test_the_depth_potential_of_a_wavy_sphere():
    """r = 1 + h Y has 2 H = 2 + h (l - 1)(l + 2) Y to first order, at any scale; noise of the mesh is even in h."""
    x, f = ism.samples.sphere(10 * 4**4 + 2)
    degree, h, ell = 4, 1e-3, 0.3
    Y = synthesis(np.eye(25)[:, [degree * degree + degree + 3]], x)
    expected = h * (degree - 1) * (degree + 2) / (degree * (degree + 1) + 1 / ell**2) * Y[:, 0]
    for scale in (1.0, 1e-12, 1e100):
        there, back = (depth_potential(scale * (1 + each * Y) * x, f, ell=ell) for each in (h, -h))
        assert np.abs((there - back) / 2 - expected).max() < 0.03 * np.abs(expected).max()


def test_diffusion_keeps_the_mean_and_damps_harmonics():
    """On the unit sphere degree l is divided by (1 + l (l + 1) sigma^2 / 4)^2."""
    x, f = ism.samples.sphere(10 * 4**4 + 2)
    surface = surface_of(ism.sphere_map(x, f, x))
    assert np.allclose(surface.diffuse(np.ones((len(x), 1)), 0.5), 1)
    smooth = surface.diffuse(x[:, 2:], 0.5)[:, 0]
    assert np.allclose(smooth, x[:, 2] / (1 + 2 * 0.25 / 4) ** 2, atol=2e-3)


def test_refusals(ball):
    fixed, values = ball
    n = len(values)
    with pytest.raises(ism.MeshError, match=r"features of the source have shape \(3,\)"):
        ism.shapes.register(fixed, fixed, features=([1, 2, 3], values))
    with pytest.raises(ism.MeshError, match=r"features of the target are not finite at 1 vertex,"):
        ism.shapes.register(
            fixed, fixed, features=(values[:, 0], np.where(np.arange(n) == 7, np.nan, values[:, 0]))
        )
    with pytest.raises(ism.MeshError, match="features of the target are constant in column 0"):
        ism.shapes.register(fixed, fixed, features=(values[:, 0], np.full(n, 3.0)))
    with pytest.raises(ValueError, match="2 columns but features of the target 1"):
        ism.shapes.register(fixed, fixed, features=(values, values[:, 0]))
    with pytest.raises(ValueError, match="unknown stage 'warp'"):
        ism.shapes.register(fixed, fixed, features=(values, values), stages=["warp"])


@pytest.mark.parametrize("power", [-1000, 1000])
def test_features_of_any_size_register_alike(ball, power):
    fixed, values = ball
    turned = moved(fixed, fixed.sphere @ R.T)
    found = [
        ism.shapes.register(turned, fixed, features=(np.ldexp(values, k), values)).map.sphere
        for k in (0, power)
    ]
    assert np.array_equal(*found)
