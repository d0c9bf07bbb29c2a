"""A mesh is checked once in each public call, and never again by functions of its map."""

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.mesh import check

V, F = ism.samples.make("spheroid", n_vertices=400)
RESULT = ism.balanced_spherical_map(V, F, balance=0.5)
X, AXIS = RESULT.conformal.sphere, [[1.0, 0.0, 0.0]]


@pytest.fixture
def checks(monkeypatch):
    """Vertices of every list of faces that is checked, and of every mesh that is normalised."""
    counts = {"checked": 0, "normalised": 0}

    def counting(name, function):
        def call(*args, **options):
            counts[name] += 1
            return function(*args, **options)

        return call

    monkeypatch.setattr(check, "_check_sphere", counting("checked", check._check_sphere))
    monkeypatch.setattr(check, "normalised", counting("normalised", check.normalised))
    return counts


@pytest.mark.parametrize(
    "call",
    [
        lambda: ism.spherical_conformal_map(V, F),
        lambda: ism.spherical_conformal_map(V, F, method="lai2014"),
        lambda: ism.spherical_conformal_map(V, F, method="gu-yau"),
        lambda: ism.spherical_conformal_map(V, F, method="stereographic"),
        lambda: ism.balanced_spherical_map(V, F, balance=1),
        lambda: ism.landmark_map(V, F, [0], AXIS, max_iterations=5),
        lambda: ism.p_harmonic_map(V, F, 3, max_iterations=5),
        lambda: ism.algorithm_2(V, F, start=X),
        lambda: ism.algorithm_1(V, F, start=X),
        lambda: ism.repair_foldings(V, F, X),
        lambda: ism.sphere_map(V, F, X),
        lambda: ism.SphereMapper(V, F).map(),
        lambda: ism.shapes.register(RESULT, RESULT, stages=("rotation",), reflect=True),
    ],
)
def test_a_mesh_is_checked_and_normalised_once(call, checks):
    call()
    assert checks == {"checked": 1, "normalised": 1}


@pytest.mark.parametrize(
    "call",
    [
        lambda: RESULT.angle_differences(),
        lambda: RESULT.conformal_factor(),
        lambda: RESULT.log_area_ratios(),
        lambda: RESULT._repr_html_(),
        lambda: RESULT.rebalance(0.6),
        lambda: ism.shapes.register(RESULT, RESULT, stages=("rotation", "moebius")),
        lambda: ism.transfer(RESULT, V, RESULT),
        lambda: ism.shapes.spherical_harmonics(RESULT, degree=3),
        lambda: ism.shapes.to_grid(RESULT, rows=4),
        lambda: ism.resample(RESULT, RESULT),
    ],
)
def test_a_map_is_not_checked_again(call, checks):
    call()
    assert checks == {"checked": 0, "normalised": 0}


def test_a_map_from_a_file_is_checked_once(checks, tmp_path):
    ism.write_map(tmp_path / "map.npz", RESULT)
    checks.update(checked=0, normalised=0)
    assert np.array_equal(ism.read_map(tmp_path / "map.npz").conformal.sphere, X)
    assert checks == {"checked": 1, "normalised": 1}
