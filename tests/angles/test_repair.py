"""The repair: nothing for nothing, a certificate for everything, and angles that only fall."""

from __future__ import annotations

from itertools import islice

import numpy as np
import pytest
from bodies import ring_floor, worm
from scipy.spatial import ConvexHull, Delaunay
from triangulations import unit

from igl_spheremap import Auto, Effort, samples, spherical_conformal_map
from igl_spheremap.angles.candidates import Badness, Start, from_the_best, layouts
from igl_spheremap.angles.close_angles import close_angles, proper_angles
from igl_spheremap.angles.layout import Layout, centred, onto_sphere
from igl_spheremap.angles.plan import plan_repair
from igl_spheremap.angles.repair import left_out, repair
from igl_spheremap.descent.energies import HarmonicEnergy
from igl_spheremap.descent.preconditioned import harmonic_map
from igl_spheremap.errors import OfListener
from igl_spheremap.maps.sphere_map import SphereMap
from igl_spheremap.mesh.check import check_mesh
from igl_spheremap.mesh.measure import log_edges
from igl_spheremap.newton.system import VertexSystem
from igl_spheremap.operators.laplacian import build_operators
from igl_spheremap.result.run import History, Run, Status
from igl_spheremap.sphere.moebius import center, fix_gauge
from igl_spheremap.start.punctured import candidate_faces
from igl_spheremap.untangle.embedding import fix_orientation
from igl_spheremap.untangle.local_repair import is_off_centre, repair_locally, restore_gauge
from igl_spheremap.verify.certificate import Certificate, certify
from igl_spheremap.verify.distortion import angle_differences
from igl_spheremap.verify.signs import folded_faces


def _mapped(name, **parameters):
    mesh = check_mesh(*samples.make(name, **parameters))
    operators = build_operators(mesh)
    return mesh, operators, fix_gauge(mesh, harmonic_map(mesh, operators)[0].x)


def _repaired(mesh, operators, x, listener=None, *, polish="auto", effort=None, **options):
    effort = effort or Effort()
    if 2 * folded_faces(x, mesh.f).sum() > len(mesh.f):
        x = fix_orientation(x, mesh.f)
    run = Run(Status.CONVERGED, np.nan)
    certificate = Certificate.of(x, mesh.f)
    energy = HarmonicEnergy(operators.L).evaluate(x)[0]
    plan = plan_repair(mesh, x, energy, certificate, polish, effort)
    if plan.starts:
        x, certificate, run = repair(
            mesh, x, certificate, run, plan, operators, listener, effort=effort, **options
        )
    return SphereMap(mesh, x, certificate, run)


def _mean(mesh, x):
    return np.abs(angle_differences(mesh.unit, mesh.f, x)).mean()


@pytest.fixture(scope="module")
def spheroid():
    return _mapped("spheroid", n_vertices=2000)


@pytest.fixture(scope="module")
def long_arms():
    """Mesh, operators, its folded harmonic map, the map repaired, and the iterates on the way."""
    mesh, operators, x = _mapped("octopus", n_vertices=4000, arm_length=6.0)
    seen = []
    return mesh, operators, x, _repaired(mesh, operators, x, seen.append), seen


@pytest.fixture(scope="module")
def folded(spheroid):
    """A good map with two neighbours exchanged."""
    mesh, operators, x = spheroid
    y = x.copy()
    y[mesh.f[7, :2]] = x[mesh.f[7, 1::-1]]
    assert certify(y, mesh.f).foldings
    return mesh, operators, y


def test_a_map_without_foldings_is_handed_back(spheroid):
    mesh, operators, x = spheroid
    repaired = _repaired(mesh, operators, x)
    assert repaired.sphere is x
    assert repaired.rounds == ()
    assert repaired.stretch == 1


def test_single_foldings_are_repaired_where_they_are(folded, spheroid):
    mesh, operators, x = folded
    repaired = _repaired(mesh, operators, x)
    assert repaired.certificate.folding_free
    # it is good: steps are predicted to gain little
    assert [r.start for r in repaired.rounds] == ["map", "embedding"]
    # no step depends on its angles
    assert str(repaired.rounds[1]) == "embedding: 0 folded faces"
    far = np.linalg.norm(x - x[mesh.f[7, 0]], axis=1) > 0.5
    locally, certificate = repair_locally(mesh, x, certify(x, mesh.f))
    assert (locally[far] == x[far]).all()
    assert certificate.folding_free is certify(locally, mesh.f).folding_free is True
    assert _mean(mesh, repaired.sphere) < 1.02 * _mean(mesh, spheroid[2])


def test_a_repaired_map_is_in_the_gauge(folded):
    mesh, operators, x = folded
    assert np.linalg.norm(mesh.A @ repair_locally(mesh, x, certify(x, mesh.f))[0]) > 1e-12
    repaired = _repaired(mesh, operators, x)
    assert np.linalg.norm(mesh.A @ repaired.sphere) < 1e-12
    assert np.abs(fix_gauge(mesh, repaired.sphere) - repaired.sphere).max() < 1e-12


@pytest.mark.parametrize("share", [0.25, 0.35, 0.5])
def test_what_rounding_folds_in_the_gauge_is_repaired_or_left(share, long_arms):
    mesh, _, x, repaired, _ = long_arms
    moved = center(repaired.sphere, (1 - share) * mesh.A + share / len(x))
    y, _ = repair_locally(mesh, moved, certify(moved, mesh.f))
    z, certificate = restore_gauge(mesh, y)
    assert certify(z, mesh.f).folding_free is certificate.folding_free is True
    assert np.linalg.norm(mesh.A @ z) < max(1e-3, np.linalg.norm(mesh.A @ y) / 10)
    assert not certify(fix_gauge(mesh, y), mesh.f).folding_free


def test_angles_of_a_coarse_map_are_improved_and_good_maps_are_left():
    v, f = _rod()
    mesh = check_mesh(v, f)
    operators = build_operators(mesh)
    x = fix_gauge(mesh, harmonic_map(mesh, operators)[0].x)
    assert certify(x, f).folding_free
    repaired = _repaired(mesh, operators, x)
    assert repaired.certificate.folding_free
    assert {r.start for r in repaired.rounds} == {"map", "newton"}  # of a coarse mesh, and poor
    assert _mean(mesh, repaired.sphere) < 0.5 * _mean(mesh, x)
    mesh, operators, x = _mapped("dumbbell", n_vertices=1500)
    assert _mean(mesh, x) > 2
    assert _repaired(mesh, operators, x).sphere is x


@pytest.mark.parametrize("reflection", [1, -1])
def test_a_coarse_map_whose_own_steps_bring_it_to_the_angles_needs_no_layout(reflection):
    """A coarse polyhedron inscribed in the sphere is its own map; near it the repair finds it, mirrored or not."""
    v, f = _inscribed()
    mesh = check_mesh(v, f)
    x = unit(v + 0.05 * np.cos(np.arange(v.size)).reshape(v.shape)) * [1, 1, reflection]
    assert _mean(mesh, x) > 2.4
    repaired = _repaired(mesh, build_operators(mesh), x)
    assert repaired.certificate.folding_free
    assert "angles" not in [r.start for r in repaired.rounds]
    assert _mean(mesh, repaired.sphere) < 0.3


@pytest.mark.parametrize("taper", [0.3, 1.0])
def test_layouts_around_several_holes_are_no_worse_than_the_map_alone(taper):
    v, f = _rod(taper)
    alone, several = (spherical_conformal_map(v, f, effort=Effort(holes=holes)) for holes in (0, 5))
    assert alone.certificate.folding_free
    assert several.certificate.folding_free
    assert (
        np.abs(several.angle_differences()).mean()
        <= 1.01 * np.abs(alone.angle_differences()).mean()
    )
    assert "angles" not in [r.start for r in alone.rounds]


def test_a_map_within_one_of_its_faces_counts_as_folded_everywhere_and_not_once():
    corners = np.exp(2j * np.pi * np.arange(3) / 3)
    inner = np.random.default_rng(0).dirichlet(np.ones(3), size=60) @ corners
    z = np.concatenate((corners, inner))
    f = np.vstack((Delaunay(np.column_stack((z.real, z.imag))).simplices, [0, 2, 1]))
    x, within = (
        unit(np.column_stack((2 * s * z.real, 2 * s * z.imag, 1 - s**2 * np.abs(z) ** 2)))
        for s in (3, 0.1)
    )
    badness = Badness(check_mesh(x, f))
    assert folded_faces(within, f).sum() == 1
    assert badness.folded(within) == len(f)
    assert badness.folded(x) == folded_faces(x, f).sum() < 0.1 * len(f)


def test_a_map_without_foldings_keeps_its_gauge_where_steps_lower_its_angles():
    mesh, operators, x = _mapped("bird", n_vertices=1500)
    improved = _repaired(mesh, operators, x, polish="angles")
    assert {r.start for r in improved.rounds} == {"map", "newton"}
    assert _mean(mesh, improved.sphere) < 0.98 * _mean(mesh, x)
    assert improved.certificate.folding_free
    assert np.linalg.norm(mesh.A @ improved.sphere) < 1e-9


def _inscribed():
    """The convex hull of 24 points on a spiral of the sphere."""
    k = np.arange(24) + 0.5
    z, angle = 1 - k / 12, np.pi * (1 + 5**0.5) * k
    v = np.column_stack((np.sqrt(1 - z**2) * np.cos(angle), np.sqrt(1 - z**2) * np.sin(angle), z))
    hull = ConvexHull(v)
    f = hull.simplices
    outward = np.linalg.det(v[f]) > 0
    return v, np.where(outward[:, None], f, f[:, ::-1])


def _rod(taper=1.0):
    """A rod of eight long flat sides, each but two triangles, its end narrower in one direction."""
    t = np.arange(8) * np.pi / 4
    ring = np.column_stack((np.cos(t), np.sin(t), 0 * t))
    top = np.array([0.0, 0.0, 2.0])
    v = np.vstack((0 * top, ring, ring * [taper, 1, 1] + top, top))
    a, b = 1 + np.arange(8), 1 + (np.arange(8) + 1) % 8
    f = np.vstack(
        [
            np.column_stack(c)
            for c in ((0 * a, b, a), (a, b, b + 8), (a, b + 8, a + 8), (a + 8, b + 8, 0 * a + 17))
        ]
    )
    return v, f


def test_long_arms_come_back_certified_and_conformal(long_arms):
    mesh, _, x, repaired, seen = long_arms
    assert not Certificate.of(x, mesh.f).folding_free
    assert certify(repaired.sphere, mesh.f).folding_free
    assert repaired.stretch > 1
    assert [(it.stage, it.residual) for it in seen] == [
        ("repair", r.foldings_after) for r in repaired.rounds
    ]
    assert _mean(mesh, repaired.sphere) < _mean(mesh, x)


def test_the_poles_gauge_holds_a_spring_better():
    mesh, operators, x = _mapped("spring", n_vertices=3000)
    plain, at_poles = (_repaired(mesh, operators, x, centred=centred) for centred in (True, False))
    assert plain.certificate.folding_free
    assert at_poles.certificate.folding_free
    assert (at_poles.gauge, plain.gauge) == ("poles", "centred")
    assert _mean(mesh, at_poles.sphere) < 0.7 * _mean(mesh, plain.sphere)
    assert (at_poles.stretch, plain.stretch > 1) == (1, True)
    assert (np.sort(np.abs(at_poles.sphere), axis=1)[:, 1] < 1e-15).any()


@pytest.mark.parametrize(("circumferences", "around"), [(14, 20), (160, 8)])  # 88 and 1,005 nepers
def test_a_worm_longer_than_float64_is_deep_is_whole_at_ends_of_axes(circumferences, around):
    v, f = worm(circumferences, around)
    result = spherical_conformal_map(v, f, method=Auto())
    assert result.certificate.folding_free
    assert (result.gauge, result.stretch) == ("poles", 1)
    assert any("at ends of the axes" in note for note in result.notes)
    floor = ring_floor(v, f, np.arange(1, len(v) - 1).reshape(-1, around))
    assert floor == pytest.approx(120 / around, rel=0.02)
    assert np.abs(result.angle_differences()).mean() == pytest.approx(floor, rel=0.05)
    assert log_edges(result.sphere, f).min() < -0.9 * np.pi * circumferences


# 1,980 and 1,650 nepers at least
@pytest.mark.parametrize(("circumferences", "around"), [(330, 3), (250, 6)])
def test_limbs_beyond_the_range_of_float64_are_shortened(circumferences, around):
    v, f = worm(circumferences, around)
    result = spherical_conformal_map(v, f, method=Auto(effort=Effort(systems=0)))
    assert result.certificate.folding_free
    assert (result.gauge, result.stretch > 1) == ("poles", True)
    floor = ring_floor(v, f, np.arange(1, len(v) - 1).reshape(-1, around))
    # shortened on their whole length
    assert np.abs(result.angle_differences()).mean() < 1.05 * floor


STEPS = {
    "angles": "unroll",
    "embedding": "repair_locally",
    "newton": "match_angles",
    "gauge": "restore_gauge",
}


def _repaired_where_a_step_raises(error, step, folded, monkeypatch):
    def fail(*_, **__):
        raise error

    mesh, operators, x = folded
    if step in ("angles", "newton"):  # taken where many faces are folded
        x = unit(np.where(mesh.unit[:, :1] > 0.3 * mesh.unit[:, 0].max(), x[::-1], x))
    monkeypatch.setattr(f"igl_spheremap.angles.repair.{STEPS[step]}", fail)
    monkeypatch.setattr("igl_spheremap.angles.repair.left_out", left_out)
    return _repaired(mesh, operators, x)


@pytest.mark.parametrize("step", STEPS)
def test_a_step_that_fails_leaves_the_map_and_a_note(step, folded, monkeypatch):
    error = np.linalg.LinAlgError("Singular matrix")
    repaired = _repaired_where_a_step_raises(error, step, folded, monkeypatch)
    assert repaired.certificate.folding_free is (step != "embedding")
    [note] = set(repaired.notes)
    assert note.startswith(f"the step {step} failed")
    assert "Singular matrix" in note


@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize("kind", [TimeoutError, type("SoftTimeLimitExceeded", (Exception,), {})])
def test_what_a_signal_handler_raises_during_a_step_comes_out(step, kind, folded, monkeypatch):
    with pytest.raises(kind, match="the time is over"):
        _repaired_where_a_step_raises(kind("the time is over"), step, folded, monkeypatch)


@pytest.mark.parametrize("count", [1, 2])
def test_what_a_listener_raises_is_no_step_that_failed(folded, count):
    mesh, operators, x = folded
    error, heard = ValueError("mine"), []

    def listen(iterate):
        heard.append(iterate)
        if len(heard) == count:
            raise error

    with pytest.raises(OfListener) as caught:
        _repaired(mesh, operators, x, listener=History(listen))
    assert caught.value.error is error


def test_the_poles_gauge_is_left_alone_where_float64_suffices(spheroid):
    mesh, operators, x = spheroid
    repaired = _repaired(mesh, operators, x)
    assert repaired.gauge == "centred"
    assert (repaired.sphere == x).all()


def test_a_centroid_off_the_origin_is_off_centre(spheroid):
    mesh, _, x = spheroid
    assert not is_off_centre(mesh, x)
    assert is_off_centre(mesh, center(x, np.where(mesh.unit[:, 2] > 0, 2.0, 1.0) * mesh.A))


def _coin(n=200, height=0.2):
    """A prism of n sides, flat, whose caps are fans around a vertex of their rims, as programs for parts make them."""
    t = 2 * np.pi * np.arange(n) / n
    ring = np.column_stack((np.cos(t), np.sin(t), 0 * t))
    a = np.arange(n)
    b, k = (a + 1) % n, a[1:-1]
    sides = np.vstack((np.column_stack((a, b, n + b)), np.column_stack((a, n + b, n + a))))
    caps = np.vstack(
        (np.column_stack((0 * k, k + 1, k)), np.column_stack((0 * k + n, n + k, n + k + 1)))
    )
    return np.vstack((ring, ring + np.array([0, 0, height]))), np.vstack((sides, caps))


def test_a_map_that_is_far_from_the_angles_of_thin_faces_says_so():
    v, f = _coin()
    near, far = (
        spherical_conformal_map(v, f, method=Auto(effort=effort))
        for effort in (Effort(), Effort(holes=0, systems=0))
    )
    assert near.certificate.folding_free
    assert far.certificate.folding_free
    assert np.abs(near.angle_differences()).mean() < 10 < np.abs(far.angle_differences()).mean()
    assert not any("remesh" in note for note in near.notes)
    assert sum("remesh" in note for note in far.notes) == 1


def test_layouts_around_other_faces_leave_out_the_one_that_was_cut_out_and_no_other():
    """An inversion moves another face to infinity, and leaves the angles as they were."""
    v, f = _coin(60, 5.0)
    mesh = check_mesh(v, f)
    system = VertexSystem(f, len(v), limbs=True)
    hole, other = islice(candidate_faces(mesh), 2)

    def around(face):
        return Layout.of(f, close_angles(system, proper_angles(mesh.angles), face), face)

    own, another = (centred(mesh, around(face)) for face in (hole, other))
    inverted = centred(mesh, around(hole).inverted(other))
    _, *rest = (start.x for start in layouts(mesh, inverted, system, 4))
    assert not any((x == onto_sphere(own, own.points)).all() for x in rest)
    assert any((x == onto_sphere(another, another.points)).all() for x in rest)


def test_starts_come_by_their_angles_and_those_that_stay_folded_come_last(spheroid):
    mesh, _, x = spheroid
    i, j = mesh.f[7, :2]

    def stretched(share):
        return unit(x * [1, 1, 1 + share])

    crossed = x.copy()
    crossed[i] = -x[i]  # no small move brings it back
    thin = stretched(0.2)
    thin[i] = unit(thin[mesh.f[7]].mean(axis=0)[None] * 0.1 + thin[j] * 0.9)[0]
    starts = {"far": stretched(1.0), "crossed": crossed, "near": stretched(0.5), "thin": thin}
    found = list(from_the_best(mesh, [Start(*each) for each in starts.items()]))
    assert [start.name for start in found] == ["thin", "near", "far", "crossed"]
    assert folded_faces(found[-1].after_moves, mesh.f).any()
