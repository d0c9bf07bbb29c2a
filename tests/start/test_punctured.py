"""Maps of a punctured mesh: the dipole against inversion, the start against the conformal map."""

import igl
import numpy as np
import pytest
from triangulations import icosphere, random_points

import igl_spheremap as ism
from igl_spheremap.mesh.measure import face_areas
from igl_spheremap.operators.laplacian import build_operators
from igl_spheremap.sphere.rows import unit_rows
from igl_spheremap.start.punctured import (
    candidate_faces,
    dipole_map,
    is_coarse,
    punctured_start,
    to_sphere,
)
from igl_spheremap.verify.distortion import mean_angle_difference


def test_a_dipole_in_the_plane_is_inversion():
    """Far from the pole on a fine sphere z is 1 / w: stereographic projection, but for a similarity."""
    errors = []
    for level in (3, 4, 5):
        x, f = icosphere(level)
        mesh = ism.check_mesh(x, f)
        z = dipole_map(mesh, build_operators(mesh), 0)
        pole = unit_rows(x[f[0]].mean(axis=0, keepdims=True))[0]
        across = np.linalg.svd(pole[None])[2][1:]
        if np.linalg.det(np.vstack((across, -pole))) < 0:
            across = across[::-1]
        exact = (x @ across.T @ [1, 1j]) / (1 - x @ pole)
        far = x @ pole < 0.5
        basis = np.column_stack((exact[far], np.ones(far.sum())))
        fit, _, _, _ = np.linalg.lstsq(basis, z[far], rcond=None)
        errors.append(np.abs(basis @ fit - z[far]).max() / abs(fit[0]))
    assert errors[0] < 0.1
    # first order: a face holds the pole, not a point
    assert (np.array(errors[:-1]) / errors[1:] > 1.7).all()


def test_any_puncture_is_within_a_tenth_of_the_harmonic_energys_minimum_and_the_start_within_a_hundredth():
    mesh = ism.check_mesh(*ism.samples.make("pear", n_vertices=2000))
    operators = build_operators(mesh)
    lowest = ism.spherical_conformal_map(mesh.v, mesh.f).energy
    for faces, share in ((None, 1e-2), ([0], 0.1), ([500], 0.1)):
        x = punctured_start(mesh, operators, faces).x
        assert np.linalg.norm(mesh.A @ x) < 1e-4
        assert ism.harmonic_energy(mesh.v, mesh.f, x) < (1 + share) * lowest


@pytest.mark.parametrize("n", [600, 1200, 4000])
@pytest.mark.parametrize("name", ["pear", "spheroid"])
def test_the_error_of_a_puncture_is_that_of_a_few_faces(name, n):
    """Without its quadratic part, of threefold symmetry, it is that of some five; with it, of some 20."""
    mesh = ism.check_mesh(*ism.samples.make(name, n_vertices=n))
    lowest = ism.spherical_conformal_map(mesh.v, mesh.f, tolerance=1e-6).energy
    start = punctured_start(mesh, build_operators(mesh))
    assert start.energy - lowest < 6 * 4 * np.pi / len(mesh.f)


def test_a_fine_map_is_not_coarse_and_a_point_is():
    x, f = icosphere(2)
    assert not is_coarse(face_areas(unit_rows(x), f).sum())
    assert is_coarse(face_areas(np.tile([0.0, 0.0, 1.0], (len(x), 1)), f).sum())
    assert is_coarse(face_areas(*icosphere(0)).sum())


def tried(mesh, faces):
    """The start from some faces, and how many of them were tried."""
    rest = iter(faces)
    start = punctured_start(mesh, build_operators(mesh), rest)
    return start, len(faces) - len(list(rest))


def with_flat_faces(x, f, share, seed=0):
    """The mesh with a vertex more on one edge of some faces, each of which has two faces without area then; these."""
    chosen = np.random.default_rng(seed).permutation(len(f))[: int(share * len(f))]
    a, b, c = f[chosen].T
    new = len(x) + np.arange(len(chosen))
    flat = np.column_stack((a, b, new))
    rest = np.vstack((np.column_stack((b, c, new)), np.column_stack((c, a, new))))
    faces = np.vstack((np.delete(f, chosen, axis=0), rest, flat))
    return np.vstack((x, (x[a] + x[b]) / 2)), faces, np.arange(len(faces) - len(flat), len(faces))


def test_a_good_start_ends_the_trials_and_a_face_without_area_is_never_a_good_place():
    x, f = icosphere(3)
    w, g, flat = with_flat_faces(x * [1, 1.3, 2], f, 0.02)
    mesh = ism.check_mesh(w, g)
    good = list(candidate_faces(mesh))
    assert set(good).isdisjoint(flat)
    assert tried(mesh, good)[1] == 1
    for face in flat.tolist():
        start, count = tried(mesh, [face, *good])
        assert count == 2
        assert start.energy <= tried(mesh, [face])[0].energy
    assert start.energy < 1.1 * 4 * np.pi


def test_if_all_starts_are_poor_that_of_least_energy_is_taken_and_on_a_coarse_mesh_that_of_best_angles():
    """Every face is then tried."""
    x, f = icosphere(3)
    w, g, flat = with_flat_faces(x * [1, 1.3, 2], f, 0.02)
    mesh = ism.check_mesh(w, g)
    each = [tried(mesh, [face])[0].energy for face in flat.tolist()]
    best, count = tried(mesh, flat.tolist())
    assert count == len(flat)
    assert best.energy == min(each) < max(each)
    x, f = icosphere(0)
    noise = 0.2 * np.random.default_rng(0).normal(size=(len(x), 1))
    coarse, faces = ism.check_mesh(x * np.exp(noise), f), list(range(len(f)))
    angles = [mean_angle_difference(coarse, tried(coarse, [face])[0].x) for face in faces]
    best, count = tried(coarse, faces)
    assert count == len(faces)
    assert mean_angle_difference(coarse, best.x) == min(angles) < max(angles)


def test_candidates_are_well_shaped_faces_of_middling_size():
    """Of a mesh of all shapes and sizes; four different ones, of the smallest mesh, too."""
    x, f = icosphere(4)
    x = unit_rows(x + 0.1 * np.random.default_rng(0).normal(size=x.shape))
    mesh = ism.check_mesh(x * np.exp(x[:, :1]), f)
    areas, sides = face_areas(mesh.v, f), igl.edge_lengths(mesh.v, f)
    shape, size = areas / (sides**2).sum(axis=1), areas / np.median(areas)
    score = shape * np.sqrt(np.minimum(size, 1 / size))
    faces = list(candidate_faces(mesh))
    assert len(set(faces)) == 4
    assert (score[faces] > np.quantile(score, 0.94)).all()
    assert score[faces[0]] > np.quantile(score, 0.999)
    tetrahedron = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    small = ism.check_mesh(tetrahedron, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]))
    assert sorted(candidate_faces(small)) == [0, 1, 2, 3]


def test_a_plane_map_is_lifted_by_inverse_stereographic_projection():
    """The middle goes to the north, infinity to the south pole, half the weight to each side; similarities go out."""
    x = random_points(300, seed=1)
    z = (x[:, 0] + 1j * x[:, 1]) / (1 + x[:, 2])
    weights = np.random.default_rng(0).random(300)
    y = to_sphere(z.copy(), weights)
    assert np.allclose((y**2).sum(axis=1), 1)
    back = (y[:, 0] + 1j * y[:, 1]) / (1 + y[:, 2])
    basis = np.column_stack((z, np.ones(300)))
    fit, *_ = np.linalg.lstsq(basis, back, rcond=None)
    assert np.abs(basis @ fit - back).max() < 1e-12 * np.abs(back).max()
    assert abs(weights[y[:, 2] > 0].sum() / weights.sum() - 0.5) < 0.02
    for scale in (0.1, 3):
        assert np.abs(to_sphere(scale * z + 10 - 4j, weights) - y).max() < 1e-12
    far = to_sphere(np.append(z, 1e200), np.append(weights, 0.0))
    assert np.abs(far[-1] - [0, 0, -1]).max() < 1e-9


def test_without_a_face_to_puncture_the_gauss_map_is_the_start():
    mesh = ism.check_mesh(*ism.samples.make("pear", n_vertices=500))
    x = punctured_start(mesh, build_operators(mesh), []).x
    assert np.linalg.norm(mesh.A @ x) < 1e-4
    gauss = ism.gauss_map(mesh.v, mesh.f)
    assert mean_angle_difference(mesh, x) == pytest.approx(
        mean_angle_difference(mesh, gauss), rel=0.3
    )


@pytest.mark.parametrize("scales", [[1, 0, 0], [1, 1e-200, 0]])
@pytest.mark.parametrize("points", ["two", "many"])
def test_a_body_without_any_area_has_a_start(scales, points):
    """Its vertices lie on a line, or at its ends."""
    x, f = icosphere(2)
    if points == "two":
        x = np.where(x > 0, 1.0, 0.0)
    mesh = ism.check_mesh(x * scales, f)
    start = punctured_start(mesh, build_operators(mesh))
    assert np.allclose((start.x**2).sum(axis=1), 1)
    assert np.isfinite(start.energy)
