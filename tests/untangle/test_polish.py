"""Polishing lowers what it says it lowers, and keeps every sign."""

from __future__ import annotations

import numpy as np
import pytest

from igl_spheremap import samples, spherical_conformal_map
from igl_spheremap.descent.preconditioned import harmonic_map
from igl_spheremap.mesh.check import check_mesh
from igl_spheremap.operators.laplacian import build_operators
from igl_spheremap.sphere.gauge import fix_gauge
from igl_spheremap.untangle.polish import polish_map
from igl_spheremap.verify.certificate import Certificate
from igl_spheremap.verify.distortion import mesh_angle_differences


@pytest.fixture(scope="module")
def bird():
    mesh = check_mesh(*samples.make("bird", n_vertices=1500))
    operators = build_operators(mesh)
    return mesh, fix_gauge(mesh, harmonic_map(mesh, operators).last.x)


def test_angle_polish_lowers_the_mean(bird):
    mesh, x = bird
    y = polish_map(mesh, x)
    assert Certificate.of(y, mesh.f).folding_free
    before, after = (np.abs(mesh_angle_differences(mesh, z)).mean() for z in (x, y))
    assert after < 0.93 * before


def test_a_polished_map_is_in_the_gauge():
    v, f = samples.make("bird", n_vertices=1500)
    result = spherical_conformal_map(v, f, polish="angles")
    assert result.certificate.folding_free
    assert np.linalg.norm(check_mesh(v, f).A @ result.sphere) < 1e-12
