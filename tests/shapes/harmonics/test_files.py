"""Coefficient files: exact round trips, SPHARM-PDM's layout, damage named."""

from __future__ import annotations

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.shapes.harmonics.basis import rows_of
from igl_spheremap.shapes.harmonics.rotation import to_complex


@pytest.fixture
def shape():
    return ism.shapes.SphericalHarmonics(np.random.default_rng(0).normal(size=(36, 3)))


def test_coef_files_read_back(shape, tmp_path):
    ism.shapes.write_coefficients(tmp_path / "a.coef", shape)
    again = ism.shapes.read_coefficients(tmp_path / "a.coef")
    assert np.abs(again.coefficients - shape.coefficients).max() < 1e-15
    assert again.source is None


def test_npz_files_keep_the_source(tmp_path):
    x, f = ism.samples.sphere(162)
    shape = ism.shapes.spherical_harmonics(ism.sphere_map(x, f, x), x[:, :1], degree=3)
    ism.shapes.write_coefficients(tmp_path / "a.npz", shape)
    again = ism.shapes.read_coefficients(tmp_path / "a.npz")
    assert np.array_equal(again.coefficients, shape.coefficients)
    assert np.array_equal(again.error(), shape.error())
    ism.shapes.write_coefficients(
        tmp_path / "b.npz", ism.shapes.SphericalHarmonics(shape.coefficients)
    )
    assert ism.shapes.read_coefficients(tmp_path / "b.npz").source is None


def test_the_layout_is_that_of_spharm_pdm(tmp_path):
    """Rows m = 0, then cosine and sine of each m; the basis has the phase (-1)^m and no sqrt(2)."""
    c = np.zeros((9, 3))
    c[1:4, 0] = 1, 2, 3  # y, z, x
    ism.shapes.write_coefficients(tmp_path / "a.coef", ism.shapes.SphericalHarmonics(c))
    text = (tmp_path / "a.coef").read_text()
    assert text.startswith("{ 9,{")
    assert text.endswith("}}")
    first = [float(row.strip("{} ,").split(",")[0]) for row in text.split("\n")][1:4]
    assert np.allclose(first, [2, -3 * np.sqrt(2), -1 * np.sqrt(2)])


def test_ktch_reads_the_same_function(shape, tmp_path):
    """It holds the complex coefficients of the basis with the phase (-1)^m."""
    ktch = pytest.importorskip("ktch.io", reason="ktch is not installed")
    ism.shapes.write_coefficients(tmp_path / "a.coef", shape)
    theirs = ktch.read_spharmpdm_coef(tmp_path / "a.coef").to_numpy()
    ours = np.concatenate([to_complex(shape.coefficients[rows_of(ell)]) for ell in range(6)])
    assert np.abs(theirs - ours).max() < 1e-14


def test_aics_shparam_reconstructs_the_body():
    """The radius of a body seen from inside, by its own function, whose rows are rings of latitude."""
    shtools = pytest.importorskip("aicsshparam.shtools", reason="aics-shparam is not installed")
    x, f = ism.samples.sphere(10_242)
    radius = 3 + x[:, 0] * x[:, 2] + 0.5 * x[:, 1] - 0.4 * x[:, 0] ** 3
    shape = ism.shapes.spherical_harmonics(ism.sphere_map(x, f, x), radius, degree=8)
    _, grid = shtools.get_reconstruction_from_coeffs(shape.in_basis("aics-shparam")[0])
    rows, columns = grid.shape
    theta = np.pi * np.arange(rows)[:, None] / rows
    phi = 2 * np.pi * np.arange(columns) / columns - np.pi
    y = np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta) + 0 * phi
    assert np.abs(grid - (3 + y[0] * y[2] + 0.5 * y[1] - 0.4 * y[0] ** 3)).max() < 2e-3


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "damaged"),
        ("{ 2,{1, 2, 3},{4, 5, 6}}", "a square number"),
        ("{ 4,{1, 2, 3},{4, 5, 6}}", "6 numbers, but 4 rows"),
        ("{ 1,{1, 2, x}}", "damaged"),
        ("{ 1,{1, 2, nan}}", "coefficients"),
    ],
)
def test_damage_is_named(tmp_path, text, sentence):
    (tmp_path / "a.coef").write_text(text)
    with pytest.raises(ism.MeshError, match=sentence):
        ism.shapes.read_coefficients(tmp_path / "a.coef")


def test_refusals(shape, tmp_path):
    ism.shapes.write_coefficients(tmp_path / "a.coef", shape)
    with pytest.raises(ism.FileError, match="exists already"):
        ism.shapes.write_coefficients(tmp_path / "a.coef", shape)
    with pytest.raises(ism.FileError, match=r"\.coef and \.npz"):
        ism.shapes.write_coefficients(tmp_path / "a.txt", shape)
    with pytest.raises(ism.FileError, match="can't read"):
        ism.shapes.read_coefficients(tmp_path / "missing.coef")
    with pytest.raises(ism.MeshError, match="three columns"):
        ism.shapes.write_coefficients(
            tmp_path / "b.coef", ism.shapes.SphericalHarmonics(shape.coefficients[:, :1])
        )
    assert not (tmp_path / "b.coef").exists()
    (tmp_path / "c.npz").write_bytes(b"nothing")
    with pytest.raises(ism.MeshError, match="damaged"):
        ism.shapes.read_coefficients(tmp_path / "c.npz")
