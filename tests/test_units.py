"""Measures of maps are the same at every scale of float64."""

from __future__ import annotations

import inspect

import numpy as np
import pytest
from disks import half
from doors import PUBLIC

import igl_spheremap as ism
from igl_spheremap.descent.energies import p_harmonic_energy
from igl_spheremap.features.feature_surface import depth_potential
from igl_spheremap.shapes.correspondence.overlay import overlay
from igl_spheremap.shapes.correspondence.stretch import Distortion
from igl_spheremap.shapes.correspondence.surface_map import nearest


@pytest.fixture(scope="module")
def pair():
    return [
        ism.spherical_conformal_map(*ism.samples.make(name, n_vertices=300))
        for name in ("pear", "spheroid")
    ]


def scaled(result, unit):
    return ism.sphere_map(unit * result.vertices, result.faces, result.sphere)


# powers of 2 round nothing
@pytest.mark.parametrize("unit", [2.0**-900, 2.0**-560, 2.0**330, 2.0**530, 2.0**996])
def test_measures_do_not_depend_on_the_unit(pair, unit):
    a, b = pair
    far_a, far_b = (scaled(each, unit) for each in pair)
    weights, far = (
        ism.transfer_matrix(*pair, method="adaptive-area") for pair in ((a, b), (far_a, far_b))
    )
    assert np.array_equal(weights.matrix.toarray(), far.matrix.toarray())
    harmonics, far = (
        ism.shapes.spherical_harmonics(a, degree=3),
        ism.shapes.spherical_harmonics(far_a, degree=3),
    )
    assert np.array_equal(harmonics.error(), far.error())
    assert np.allclose(harmonics.align().skew, far.align().skew, atol=1e-9)
    found, far = overlay(a, b), overlay(far_a, far_b)
    assert np.array_equal(found.faces, far.faces)
    assert np.array_equal(found.on_target, far.on_target / unit)
    measures = [
        Distortion.of(each.on_source, each.on_target, each.faces).figures for each in (found, far)
    ]
    assert measures[0] == measures[1]
    points = 1.01 * a.vertices[:20]
    assert np.array_equal(nearest(a, points, "A").face, nearest(far_a, unit * points, "A").face)


V, F = ism.samples.make("pear", n_vertices=300)
X = ism.spherical_conformal_map(V, F).sphere
D, H, _ = half(V, F)


def quadratic(x):
    return float(((x - X) ** 2).sum()), 2 * (x - X)


#: Each public function of v, f, at a unit: what of its result is without unit.
CALLS = {
    "SphereMapper": lambda u: ism.SphereMapper(u * V, F).map().sphere,
    "algorithm_1": lambda u: ism.algorithm_1(u * V, F, start=X).sphere,
    "algorithm_2": lambda u: ism.algorithm_2(u * V, F, start=X).sphere,
    "angle_differences": lambda u: ism.angle_differences(u * V, F, X),
    "balanced_disk_map": lambda u: ism.balanced_disk_map(u * D, H).plane,
    "balanced_spherical_map": lambda u: ism.balanced_spherical_map(u * V, F).sphere,
    "check_disk": lambda u: ism.check_disk(u * D, H).unit,
    "check_mesh": lambda u: ism.check_mesh(u * V, F).unit,
    "coefficients_from_mesh": lambda u: ism.shapes.coefficients_from_mesh(u * V, F, 6) / u,
    "conformal_factor": lambda u: ism.conformal_factor(u * V, F, X),
    "depth_potential": lambda u: depth_potential(u * V, F),
    "disk_conformal_map": lambda u: ism.disk_conformal_map(u * D, H).plane,
    "fidelity_map": lambda u: ism.fidelity_map(u * V, F, quadratic).sphere,
    "flatten": lambda u: ism.flatten(u * D, H).plane / u,
    "gauss_map": lambda u: ism.gauss_map(u * V, F),
    "harmonic_energy": lambda u: ism.harmonic_energy(u * V, F, X),
    "info": lambda u: ism.info(u * V, F[2:]).quality.smallest_angle,
    "landmark_map": lambda u: ism.landmark_map(u * V, F, [0, 5], X[[1, 6]], max_iterations=5).sphere,
    "log_area_ratios": lambda u: ism.log_area_ratios(u * V, F, X),
    "log_length_ratios": lambda u: ism.log_length_ratios(u * V, F, X),
    "p_harmonic_energy": lambda u: p_harmonic_energy(u * V, F, X, p=3),
    "p_harmonic_map": lambda u: ism.p_harmonic_map(u * V, F, p=3).sphere,
    "repair_foldings": lambda u: ism.repair_foldings(u * V, F, -X).sphere,
    "repair_disk": lambda u: ism.repair_disk(u * V, F[2:], holes="fill", cut=3).v / u,
    "repair_mesh": lambda u: ism.repair_mesh(u * D, H, weld=1e-6, holes="fill").v / u,
    "sphere_map": lambda u: ism.sphere_map(u * V, F, X).angle_differences(),
    "spherical_conformal_map": lambda u: ism.spherical_conformal_map(u * V, F).sphere,
    "weighted_eigen_projection": lambda u: ism.weighted_eigen_projection(u * V, F, X).star_map,
}  # fmt: skip


def test_the_table_has_every_function_of_v_and_f():
    def takes(public):
        ours = inspect.isfunction(public) or (
            inspect.isclass(public) and not issubclass(public, Exception)
        )
        return ours and list(inspect.signature(public).parameters)[:2] == ["v", "f"]

    calls = {name.removeprefix("shapes.") for name, public in PUBLIC.items() if takes(public)}
    in_modules = {"depth_potential", "p_harmonic_energy"}
    assert calls - {"play"} | in_modules == set(CALLS)  # it is a window


@pytest.mark.parametrize("name", CALLS)
def test_results_do_not_depend_on_the_unit(name):
    expected = np.asarray(CALLS[name](1.0), dtype=float)
    assert np.isfinite(expected).all()
    for unit in (2.0**-996, 2.0**130, 2.0**990):
        assert (
            np.abs(np.asarray(CALLS[name](unit), dtype=float) - expected).max()
            <= 1e-12 * np.abs(expected).max()
        )
