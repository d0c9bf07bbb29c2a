"""Maps of a punctured mesh: the dipole against inversion, the start against the conformal map."""

import numpy as np
import pytest
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap.mesh.measure import face_areas
from igl_spheremap.operators.laplacian import build_operators
from igl_spheremap.sphere.rows import unit_rows
from igl_spheremap.start.punctured import dipole_map, is_coarse, punctured_start


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


@pytest.mark.parametrize("name", ["pear", "spheroid"])
def test_the_error_of_a_puncture_is_that_of_a_few_faces(name):
    """Without its quadratic part, of threefold symmetry, it is that of some five; with it, of 25."""
    mesh = ism.check_mesh(*ism.samples.make(name, n_vertices=4000))
    lowest = ism.spherical_conformal_map(mesh.v, mesh.f, tolerance=1e-6).energy
    assert punctured_start(mesh, build_operators(mesh)).energy - lowest < 10 * 4 * np.pi / len(
        mesh.f
    )


def test_a_fine_map_is_not_coarse_and_a_point_is():
    x, f = icosphere(2)
    assert not is_coarse(face_areas(unit_rows(x), f).sum())
    assert is_coarse(face_areas(np.tile([0.0, 0.0, 1.0], (len(x), 1)), f).sum())
    assert is_coarse(face_areas(*icosphere(0)).sum())
