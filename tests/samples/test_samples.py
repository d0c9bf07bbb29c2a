"""Samples are closed genus-0 meshes of good triangles, and the exact map of revolution surfaces is exact."""

from __future__ import annotations

import igl
import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from igl_spheremap import samples
from igl_spheremap.samples import SurfaceOfRevolution

SPECS = [
    *(name for name in samples.names() if name != "brain"),  # by default large
    "bird:n_vertices=1000",
    "bunny:n_vertices=2000",
    "brain:n_vertices=6000,depth=0.17",
    "dino:n_vertices=1500",
    "dumbbell:waist=0.05,n_vertices=1500",
    "octopus:arm_length=0.5,n_vertices=1500",
    "octopus:arm_length=6,n_vertices=4000",
    "sphere:n_vertices=12",
    "sphere:n_vertices=5000",
    "spheroid:aspect=0.2,n_vertices=1000",
    "spheroid:aspect=10,n_vertices=1000",
    "spring:turns=1.5,n_vertices=1000",
]

SURFACES = [
    SurfaceOfRevolution(2.0),
    SurfaceOfRevolution(0.3),
    SurfaceOfRevolution(2.5, (0.3, 0.0, 2.0)),
    SurfaceOfRevolution(1.4, (1.0, -0.4, 0.1, 0.2)),
]


@pytest.fixture(scope="module", params=SPECS)
def sample(request):
    return request.param, *samples.from_spec(request.param)


def test_sample_has_the_promised_arrays(sample):
    _, v, f = sample
    assert v.dtype == np.float64
    assert f.dtype == np.int64
    assert v.flags.c_contiguous
    assert f.flags.c_contiguous
    assert v.shape[1:] == f.shape[1:] == (3,)
    assert np.isfinite(v).all()


def test_sample_is_a_closed_oriented_sphere(sample):
    _, v, f = sample
    n = len(v)
    assert np.array_equal(np.unique(f), np.arange(n))
    tail, head = f.ravel(), np.roll(f, -1, axis=1).ravel()
    forward = tail * n + head
    assert len(np.unique(forward)) == len(forward)
    assert np.array_equal(np.sort(forward), np.sort(head * n + tail))
    graph = coo_array((np.ones(len(tail)), (tail, head)), shape=(n, n))
    assert connected_components(graph)[0] == 1
    assert n - len(forward) // 2 + len(f) == 2
    assert igl.is_vertex_manifold(f)[0]


def test_sample_is_oriented_outwards(sample):
    _, v, f = sample
    a, b, c = (v[f] - v.mean(axis=0)).transpose(1, 2, 0)
    assert np.sum(np.linalg.det(np.stack([a.T, b.T, c.T], axis=1))) > 0.0


def test_sample_has_well_shaped_triangles(sample):
    _, v, f = sample
    smallest = np.degrees(igl.internal_angles(v, f)).min(axis=1)
    assert np.percentile(smallest, 5) > 25.0
    assert smallest.min() > 1.0


def test_no_face_lies_back_on_its_neighbour(sample):
    _, v, f = sample
    normal = igl.per_face_normals(v, f, np.zeros(3))
    neighbour, _ = igl.triangle_triangle_adjacency(f)
    cosine = np.einsum("ij,ikj->ik", normal, normal[neighbour])
    assert cosine.min() > np.cos(np.radians(150.0))


@pytest.mark.parametrize("name", samples.names())
def test_size_is_near_the_request_and_the_mesh_the_same_every_time(name):
    (v, f), (again, faces) = (samples.make(name, n_vertices=3600) for _ in range(2))
    assert len(v) == pytest.approx(3600, rel=0.05)
    assert np.array_equal(v, again)
    assert np.array_equal(f, faces)


def test_gauss_map_of_the_dinosaur_folds_badly():
    v, f = samples.dino(2000)
    a, b, c = igl.per_vertex_normals(v, f)[f].transpose(1, 0, 2)
    folded = np.einsum("ij,ij->i", a, np.cross(b - a, c - a)) <= 0.0
    assert folded.mean() > 0.3


def test_octopus_arms_are_as_long_as_asked():
    """An arm's area is near its length times its circumference, so areas differ as lengths do."""
    area = [igl.doublearea(*samples.octopus(3000, arm_length=k)).sum() / 2.0 for k in (1.0, 3.0)]
    circumference = np.pi * 0.37
    assert area[1] - area[0] == pytest.approx(8 * 2 * circumference**2, rel=0.05)


def test_spring_is_a_tube_about_a_helix():
    v, _ = samples.spring(turns=3)
    inside = (v[:, 2] > 0.4) & (v[:, 2] < 2.0)
    s = np.linspace(-1.0, 4.0, 40001)
    helix = np.stack([np.cos(2 * np.pi * s), np.sin(2 * np.pi * s), 0.8 * s], axis=1)
    assert cKDTree(helix).query(v[inside])[0] == pytest.approx(0.22, abs=1e-5)


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("unicorn", "no sample is called 'unicorn'; there are: bird, brain, bunny"),
        ("dino:n_vertice=5", "sample dino has no parameter 'n_vertice'; it has: n_vertices"),
        ("dino:n_vertices", "key=value, not 'n_vertices'"),
        ("dino:n_vertices=many", "n_vertices takes a number, not 'many'"),
        ("dino:n_vertices=nan", "n_vertices takes a number, not 'nan'"),
        ("dino:n_vertices=50", "n_vertices is 50; give a number from"),
        ("sphere:n_vertices=3", "n_vertices is 3; give a number from 12"),
        ("octopus:arm_length=-1", "arm_length is -1; give a number from 0.5 to 20"),
        ("", "no sample is called ''"),
    ],
)
def test_what_makes_no_sense_is_refused_by_name(spec, message):
    with pytest.raises(ValueError, match=message):
        samples.from_spec(spec)


def test_a_spec_is_a_call():
    by_spec = samples.from_spec("spring:turns=1.5, n_vertices=2e3")
    by_call = samples.spring(n_vertices=2000, turns=1.5)
    assert np.array_equal(by_spec[0], by_call[0])


def spheroid_latitude(z, aspect):
    """Sine of the conformal latitude on a spheroid with equatorial radius 1, in closed form."""
    c = z / aspect
    sine = c / np.hypot(c, aspect * np.sqrt(1.0 - c * c))  # of the angle of the normal
    if aspect < 1.0:
        e = np.sqrt(1.0 - aspect**2)
        return np.tanh(np.arctanh(sine) - e * np.arctanh(e * sine))
    e = np.sqrt(aspect**2 - 1.0)
    return np.tanh(np.arctanh(sine) + e * np.arctan(e * sine))


@pytest.mark.parametrize("aspect", [0.1, 0.5, 0.99, 1.0, 1.3, 2.0, 5.0, 20.0])
def test_map_of_a_spheroid_is_the_closed_form(aspect):
    surface = SurfaceOfRevolution(aspect)
    v, _ = surface.mesh(2000)
    v = v[np.abs(v[:, 2]) < aspect]
    x = surface.conformal_map(v)
    assert x[:, 2] == pytest.approx(spheroid_latitude(v[:, 2], aspect), abs=1e-12)
    assert np.arctan2(x[:, 1], x[:, 0]) == pytest.approx(np.arctan2(v[:, 1], v[:, 0]), abs=1e-12)


@pytest.mark.parametrize("surface", SURFACES, ids=repr)
def test_exact_map_pulls_the_round_metric_back_to_a_multiple(surface):
    """Derivatives along meridians and parallels are stretched alike and stay orthogonal."""
    t = np.linspace(0.05, np.pi - 0.05, 200)
    angle = np.linspace(0.0, 5.0, 200)

    def point(t, angle):
        return surface.embed(
            np.stack([np.sin(t) * np.cos(angle), np.sin(t) * np.sin(angle), np.cos(t)], axis=1)
        )

    def derivative(function, h=1e-4):
        return (8.0 * (function(h) - function(-h)) - (function(2 * h) - function(-2 * h))) / (
            12.0 * h
        )

    along, around = (
        derivative(lambda h: point(t + h, angle)),
        derivative(lambda h: point(t, angle + h)),
    )
    x_along = derivative(lambda h: surface.conformal_map(point(t + h, angle)))
    x_around = derivative(lambda h: surface.conformal_map(point(t, angle + h)))

    def length(w):
        return np.linalg.norm(w, axis=1)

    assert length(x_along) / length(along) == pytest.approx(
        length(x_around) / length(around), rel=1e-8
    )
    assert np.abs(np.einsum("ij,ij->i", x_along, x_around)).max() < 1e-9
    turn = np.einsum(
        "ij,ij->i", np.cross(x_along, x_around), surface.conformal_map(point(t, angle))
    )
    assert turn.min() > 0.0


@pytest.mark.parametrize("surface", SURFACES, ids=repr)
def test_exact_map_balances_the_area_of_the_surface(surface):
    offset = [_barycentre(surface, n_vertices) for n_vertices in (4000, 16000)]
    assert offset[1] < 1e-5
    if any(surface.radius[1::2]):  # no symmetry that would balance it
        assert offset[0] / offset[1] == pytest.approx(4.0, rel=0.15)


def _barycentre(surface, n_vertices):
    v, f = surface.mesh(n_vertices)
    weight = igl.massmatrix(v, f).diagonal()
    return np.linalg.norm(weight @ surface.conformal_map(v)) / weight.sum()


@pytest.mark.parametrize("surface", SURFACES, ids=repr)
def test_exact_map_has_the_energy_of_a_conformal_map(surface):
    """Harmonic energy 4 pi and angle differences 0 in the limit, at second and at first order."""
    gap, angle = [], []
    for n_vertices in (4000, 16000):
        v, f = surface.mesh(n_vertices)
        x = surface.conformal_map(v)
        gap.append(abs(-0.5 * np.sum(x * (igl.cotmatrix(v, f) @ x)) - 4.0 * np.pi))
        angle.append(np.abs(igl.internal_angles(v, f) - igl.internal_angles(x, f)).mean())
    assert gap[0] / gap[1] == pytest.approx(4.0, rel=0.15)
    assert angle[0] / angle[1] == pytest.approx(2.0, rel=0.1)


@pytest.mark.parametrize("surface", SURFACES, ids=repr)
def test_mesh_of_revolution_lies_on_its_surface(surface):
    v, _ = surface.mesh(1000)
    c = v[:, 2] / surface.half_length
    r = np.polynomial.Polynomial(surface.radius)(c) * np.sqrt(np.maximum(1.0 - c * c, 0.0))
    assert np.hypot(v[:, 0], v[:, 1]) == pytest.approx(r, abs=1e-7)
    assert np.abs(c).max() == 1.0


def test_sphere_is_mapped_to_itself():
    v, _ = samples.sphere(700)
    assert SurfaceOfRevolution().conformal_map(v) == pytest.approx(v, abs=1e-14)


def test_a_surface_that_pinches_is_refused():
    with pytest.raises(ValueError, match="not positive"):
        SurfaceOfRevolution(1.0, (0.0, 0.0, 1.0))
    with pytest.raises(ValueError, match="half_length must be positive"):
        SurfaceOfRevolution(-1.0)


@pytest.mark.parametrize("k", [1, 3, 4, 12])
def test_spheres_are_nested_bit_for_bit(k):
    """Networks pool by slicing: the first vertices are the coarser sphere, the others lie on its edges."""
    x, f = samples.sphere(10 * k**2 + 2)
    y, g = samples.sphere(10 * (2 * k) ** 2 + 2)
    assert np.array_equal(y[: len(x)], x)
    ends = g[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    between = np.unique(ends[(ends[:, 0] >= len(x)) & (ends[:, 1] < len(x))], axis=0).reshape(
        -1, 2, 2
    )
    # each further vertex has two coarse neighbours
    assert np.array_equal(between[:, 0, 0], np.arange(len(x), len(y)))
    assert np.array_equal(between[:, 0, 0], between[:, 1, 0])
    edges = np.sort(np.concatenate([f[:, [0, 1]], f[:, [1, 2]], f[:, [2, 0]]]), axis=1)
    assert {*map(tuple, between[:, :, 1])} == {*map(tuple, edges)}
