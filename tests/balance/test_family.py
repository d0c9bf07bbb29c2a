"""The family of balances on surfaces whose maps are known by other means."""

import numpy as np
import pytest
from scipy.optimize import least_squares

import igl_spheremap as ism
from igl_spheremap.balance.family import POWER, balanced_energy, balanced_iterates
from igl_spheremap.balance.flat_faces import FlatFaces
from igl_spheremap.balance.kept_factor import KeptFactor
from igl_spheremap.mesh.check import check_mesh
from igl_spheremap.newton.faces import FaceProblem
from igl_spheremap.newton.system import VertexSystem

LENGTH = 1.8  # of the spheroid, in diameters


def converged(mesh, conformal, balance):
    """The minimiser, to rounding."""
    energy = balanced_energy(FlatFaces.of(mesh.v, mesh.f), conformal, balance)
    search = KeptFactor(VertexSystem(mesh.f, len(mesh.v)), 0.0)
    *_, last = balanced_iterates(FaceProblem(energy, turns=False), search, conformal)
    return last.x


def spheroid_profile(n=200):
    """Middles of rings of a spheroid of area 4 pi: their colatitude on the parametrising sphere, radius, length."""
    edges = np.linspace(0, np.pi, n + 1)
    t = (edges[1:] + edges[:-1]) / 2
    radius, step = np.sin(t), np.hypot(np.cos(t), LENGTH * np.sin(t)) * np.pi / n
    scale = np.sqrt(4 * np.pi / (2 * np.pi * radius * step).sum())
    return edges, t, scale * radius, scale * step


def profile_map(balance):
    """Colatitudes of the image at the rings' edges, by minimising the same energy in one dimension."""
    edges, t, radius, step = spheroid_profile()
    area = 2 * np.pi * radius * step
    u = np.cumsum(step / radius) - step / radius / 2
    u -= (u[0] + u[-1]) / 2
    # conformal: colatitude 2 atan(exp(u)), its sine 1 / cosh(u)
    factor = 2 * np.log(1 / np.cosh(u) / radius)
    target = (1 - balance) * factor
    target -= np.log((area * np.exp(target)).sum() / (area * np.exp(factor)).sum())
    weight = min(balance, 0.97)

    def colatitudes(y):
        theta = np.append(0, np.cumsum(np.exp(y) * step))
        return np.pi * theta / theta[-1]

    def residuals(y):  # 2 (cosh(k u) - 1) is the square of 2 sinh(k u / 2)
        theta = colatitudes(y)
        s1 = np.log(np.diff(theta) / step)
        s2 = np.log(np.sin((theta[1:] + theta[:-1]) / 2) / radius)
        parts = (
            np.sqrt(1 - weight) * np.sinh(POWER * (s1 - s2) / 2),
            np.sqrt(weight) * np.sinh(POWER * (s1 + s2 - target) / 2),
        )
        return (np.sqrt(area) * np.stack(parts)).ravel()

    return edges, colatitudes(least_squares(residuals, np.zeros(len(t)), xtol=1e-12, ftol=1e-12).x)


def spheroid(n):
    """An icosphere stretched along z, its parametrising colatitudes, and its conformal map in the same rotation."""
    x, f = ism.samples.sphere(n)
    v = x * [1, 1, LENGTH]
    result = ism.spherical_conformal_map(v, f)
    return check_mesh(v, f), np.arccos(x[:, 2]), result.sphere


@pytest.mark.parametrize("balance", [0.5, 1.0])
def test_a_spheroid_agrees_with_the_energy_of_its_profile_to_second_order(balance):
    edges, theta = profile_map(balance)
    errors = []
    for n in (642, 2562):
        mesh, t, conformal = spheroid(n)
        x = converged(mesh, conformal, balance)
        errors.append(
            np.sqrt(np.mean((np.arccos(np.clip(x[:, 2], -1, 1)) - np.interp(t, edges, theta)) ** 2))
        )
    assert errors[1] < 2e-3
    assert errors[0] > 3 * errors[1]


def test_balance_1_puts_a_spheroid_at_its_latitudes_by_area():
    mesh, t, conformal = spheroid(2562)
    x = converged(mesh, conformal, 1.0)
    edges, _, radius, step = spheroid_profile(4000)
    height = 1 - 2 * np.append(0, np.cumsum(radius * step)) / (radius * step).sum()
    # the floor that .03 of angles leave
    assert np.abs(x[:, 2] - np.interp(t, edges, height)).max() < 0.01


@pytest.mark.parametrize("balance", [0.25, 0.5, 0.75, 1.0])
def test_the_round_sphere_stays_as_it_is(balance):
    x, f = ism.samples.sphere(642)
    assert np.abs(converged(check_mesh(x, f), x, balance) - x).max() < 2e-3
