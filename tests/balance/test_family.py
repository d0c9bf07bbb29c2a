"""The family of balances on surfaces whose maps are known by other means."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import least_squares

import igl_spheremap as ism
from igl_spheremap.balance.family import POWER, balanced_energy, balanced_iterates, log_factor
from igl_spheremap.balance.flat_faces import FlatFaces, log_areas
from igl_spheremap.balance.kept_factor import KeptFactor
from igl_spheremap.mesh.check import check_mesh
from igl_spheremap.newton.faces import FaceProblem
from igl_spheremap.newton.loop import Trial
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


class Scripted:
    """A problem and a search of which the values after each step, the steps' lengths and predictions are given."""

    def __init__(self, values, lengths=None, aheads=None):
        self.values, self.energy, self.taken = values, self, 0
        self.area, self.lengths, self.aheads = np.full(4, np.pi), lengths, aheads
        self.length, self.ahead = 1.0, np.inf

    def value(self, x):
        return self.values[0]

    def model(self, x):
        return None

    def step(self, problem, x, model):
        self.taken += 1
        if self.taken == len(self.values):
            return None
        if self.lengths:
            self.length = self.lengths[self.taken - 1]
        if self.aheads:
            self.ahead = self.aheads[self.taken - 1]
        return Trial(x, self.values[self.taken], np.zeros(1, bool))


def residuals(*script):
    problem = Scripted(*script)
    return [each.residual for each in balanced_iterates(problem, problem, np.eye(3))]


@pytest.mark.parametrize("ratio", [0.05, 0.5, 0.8])
def test_the_residual_of_whole_steps_is_what_their_geometric_series_leaves(ratio):
    least = 7.0
    values = [least + ratio**k for k in range(8)]
    found = residuals(values)
    assert found[0] == np.inf
    left = [(value - least) / value for value in values]
    assert found[3:] == pytest.approx(left[3:], rel=0.15)


def test_the_residual_of_shortened_steps_is_the_largest_of_the_last_three_gains():
    values = [10.0, 8.0, 7.5, 7.4, 7.39]
    gains = [a / b - 1 for a, b in pairwise(values)]
    found = residuals(values, [0.5] * 4)
    assert found[3:] == pytest.approx([max(gains[:3]), max(gains[1:4])])
    assert found[1] == 1.0  # before three steps nothing is known to be small


def test_a_residual_is_at_most_what_an_old_factor_predicts_and_0_where_there_is_no_energy():
    assert residuals([10.0, 8.0, 7.0], [0.5] * 2, [np.inf, 1e-4])[2] == 1e-4
    assert residuals([0.0]) == [0.0]
    assert residuals([10.0, 1e-20])[-1] == 0.0


@pytest.mark.parametrize("balance", [0.0, 0.4, 1.0])
def test_the_target_is_a_power_of_the_conformal_factor_that_fills_the_sphere(balance):
    """Its exponent is 1 - balance; the sum over the source is that of the factor, docs/balance.md (10)."""
    mesh, _, conformal = spheroid(642)
    source = FlatFaces.of(mesh.unit, mesh.f)
    energy, factor = balanced_energy(source, conformal, balance), log_factor(source, conformal)
    assert (source.area * np.exp(energy.target)).sum() == pytest.approx(
        (source.area * np.exp(factor)).sum()
    )
    assert np.ptp(energy.target - (1 - balance) * factor) < 1e-12
    assert energy.weight == pytest.approx(min(balance, 0.97))
    assert energy.area_error(conformal) == pytest.approx(
        np.average(np.abs(log_areas(source, conformal) - energy.target), weights=source.area)
    )


def test_the_factor_of_a_similarity_is_its_scale_and_averages_stay_between_neighbours():
    mesh, _, conformal = spheroid(642)
    source = FlatFaces.of(mesh.v, mesh.f)
    twice = log_areas(source, 2 * conformal) - log_areas(source, conformal)
    assert np.allclose(twice, 2 * np.log(2))
    assert np.allclose(log_factor(source, 2 * conformal) - log_factor(source, conformal), twice)
    single, smooth = log_areas(source, conformal), log_factor(source, conformal)
    near = [np.isin(mesh.f, face).any(axis=1) for face in mesh.f]
    wider = [np.isin(mesh.f, mesh.f[at]).any(axis=1) for at in near]
    for k, at in enumerate(wider):
        assert single[at].min() - 1e-12 < smooth[k] < single[at].max() + 1e-12
    rough = [np.abs(each[at] - each[at].mean()).mean() for each in (single, smooth) for at in near]
    assert sum(rough[len(near) :]) < sum(rough[: len(near)])
