"""Shapes as coefficients: known shapes, convergence, invariance, alignment."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.special
from scipy.spatial.transform import Rotation

import igl_spheremap as ism
from igl_spheremap.shapes.harmonics.basis import synthesis

R, Q = Rotation.from_euler("ZYZ", [[0.4, 2.1, -1.0], [-2.0, 0.7, 0.3]]).as_matrix()


def on_sphere(shape, level):
    """The map of a surface that is given as a function on the sphere."""
    x, f = ism.samples.sphere(10 * 4**level + 2)
    return ism.sphere_map(shape(x), f, x)


def lump(x):
    """A shape of degree 3 without symmetry."""
    c = np.zeros((16, 3))
    c[[3, 1, 2], [0, 1, 2]] = 5, 3, 8
    c[4:] = 0.3 * np.random.default_rng(1).normal(size=(12, 3))
    return synthesis(c, x)


@pytest.fixture(scope="module")
def shape():
    return ism.shapes.spherical_harmonics(on_sphere(lump, 4), degree=10)


def test_coefficients_of_a_band_limited_shape_converge_at_second_order():
    errors = []
    for level in (2, 3, 4):
        result = on_sphere(lump, level)
        c = ism.shapes.spherical_harmonics(result, degree=3, oversampling=30).coefficients
        fine = ism.shapes.spherical_harmonics(result, degree=8, oversampling=12).coefficients
        known = np.zeros((16, 3))
        known[[3, 1, 2], [0, 1, 2]] = 5, 3, 8
        known[4:] = 0.3 * np.random.default_rng(1).normal(size=(12, 3))
        errors.append(np.abs(c - known).max())
        # a coefficient does not depend on the degree that was asked for
        assert np.abs(fine[:16] - c).max() < 2e-3
    assert (np.log2(np.array(errors[:-1]) / errors[1:]) > 1.8).all()


def test_the_error_is_the_distance_from_the_source(shape):
    result = on_sphere(lump, 4)
    off = ((shape.evaluate(result.sphere) - result.vertices) ** 2).sum(axis=1)
    areas = shape.source.areas
    diagonal = np.linalg.norm(np.ptp(result.vertices, axis=0))
    assert np.isclose(shape.error()[10], 100 * np.sqrt(areas @ off / areas.sum()) / diagonal)
    assert shape.error()[3] < 0.5 < shape.error()[2]


def test_finer_grids_converge_to_the_integrals():
    """At about second order: the function is continuous, its slope jumps at edges."""
    result = ism.spherical_conformal_map(*ism.samples.make("dino", n_vertices=1500))
    exact, *others = (
        ism.shapes.spherical_harmonics(result, degree=8, oversampling=n).coefficients
        for n in (40, 8, 2)
    )
    fine, coarse = (np.linalg.norm(c - exact) / np.linalg.norm(exact[1:]) for c in others)
    assert fine < min(1e-3, coarse / 6)


def test_constants_and_data():
    result = on_sphere(lump, 3)
    constant = ism.shapes.spherical_harmonics(result, np.full(len(result.sphere), 7.0), degree=4)
    assert np.allclose(
        constant.coefficients[:, 0], np.eye(25)[0] * 7 * np.sqrt(4 * np.pi), atol=1e-12
    )
    both = ism.shapes.spherical_harmonics(result, result.vertices[:, :2], degree=4)
    three = ism.shapes.spherical_harmonics(result, degree=4)
    assert np.allclose(both.coefficients, three.coefficients[:, :2], atol=1e-14)


def test_surfaces_on_any_mesh_of_the_sphere(shape):
    v, _ = shape.surface("ico:2")
    x, _ = ism.samples.sphere(162)
    assert np.array_equal(v, shape.evaluate(x))
    result = on_sphere(lump, 3)
    again, faces = shape.surface(result)
    assert np.array_equal(faces, result.faces)
    assert np.allclose(again, shape.surface((7 * result.sphere, faces))[0], atol=1e-12)


def test_a_rotated_sphere_describes_the_same_surface(shape):
    turned = shape.rotated(R)
    x, _ = ism.samples.sphere(162)
    assert np.allclose(turned.evaluate(x @ R.T), shape.evaluate(x), atol=1e-12)
    assert np.allclose(turned.power(), shape.power(), rtol=1e-12)
    assert np.allclose(turned.error(), shape.error(), rtol=1e-9)


def test_alignment_undoes_rotations_and_shifts(shape):
    moved = ism.shapes.SphericalHarmonics(
        shape.coefficients @ Q.T,
        type(shape.source)(shape.source.x, shape.source.values @ Q.T, shape.source.areas),
    ).rotated(R)
    moved.coefficients[0] += [3, 4, 5]
    moved.source.values[:] += np.array([3, 4, 5]) * np.sqrt(0.25 / np.pi)
    a, b = shape.align(), moved.align()
    assert np.allclose(a.harmonics.coefficients, b.harmonics.coefficients, atol=1e-11)
    assert np.allclose(a.skew, b.skew, atol=1e-11)
    assert np.allclose(a.harmonics.error(), b.harmonics.error(), rtol=1e-9)


def test_aligned_axes_are_sorted_and_degree_one_is_diagonal(shape):
    aligned = shape.align()
    x, y, z = aligned.axes
    assert z > x > y
    first = aligned.harmonics.coefficients[1:4]  # rows y, z, x of the sphere
    assert np.allclose(first, np.diag([x, y, z])[[1, 2, 0]] * np.sqrt(4 * np.pi / 3), atol=1e-12)
    assert np.allclose(aligned.axes, np.array([5, 3, 8]) * np.sqrt(0.75 / np.pi), rtol=0.01)
    assert np.sort(aligned.skew)[1] > 0
    for rotation in (aligned.surface_rotation, aligned.sphere_rotation):
        assert np.isclose(np.linalg.det(rotation), 1)


def test_a_template_decides_between_the_four_frames(shape):
    aligned = shape.align().harmonics
    for flip in ([1, -1, -1], [-1, 1, -1], [-1, -1, 1], [1, 1, 1]):
        template = aligned._in_frame(np.diag(flip), np.diag(flip).astype(float))
        chosen = shape.align(template).harmonics
        assert np.allclose(chosen.coefficients, template.coefficients, atol=1e-11)
    bare = ism.shapes.SphericalHarmonics(shape.coefficients)
    assert np.isnan(bare.align(aligned).skew).all()
    assert np.allclose(bare.align(aligned).harmonics.coefficients, aligned.coefficients, atol=1e-11)


def test_degrees_that_a_mesh_or_a_map_does_not_carry_are_named():
    """A limb on a conformal map, and more coefficients than vertices."""
    v, f = ism.samples.make("dumbbell", n_vertices=500)
    conformal = ism.spherical_conformal_map(v, f)
    assert "balance 1" in ism.shapes.spherical_harmonics(conformal, degree=8).notes[0]
    preserving = conformal.rebalance(1)
    assert ism.shapes.spherical_harmonics(preserving, degree=8).notes == ()
    carried = int(np.sqrt(len(v))) - 1
    assert ism.shapes.spherical_harmonics(preserving, degree=carried).notes == ()
    with pytest.warns(UserWarning, match=f"carry degree {carried}"):
        ism.shapes.coefficients_from_mesh(v, f, carried + 1)


def theirs(basis, ell, m, x):
    """The basis functions (cosine, sine) of a program, from its source, by scipy's, which have the phase (-1)^m."""
    theta, phi = np.arccos(x[:, 2]), np.arctan2(x[:, 1], x[:, 0])
    # pyshtools' SHExpandDH of a grid that begins at -x: mean square 1, no phase
    if basis == "aics-shparam":
        Y = (-1) ** m * scipy.special.sph_harm_y(ell, m, theta, phi + np.pi) * np.sqrt(4 * np.pi)
        return Y * np.sqrt(1 + (m > 0))
    if basis == "ktch":  # _real_sph_harm_y
        return (-1) ** m * scipy.special.sph_harm_y(ell, m, theta, phi) * np.sqrt(1 + (m > 0))
    return scipy.special.sph_harm_y(ell, m, theta, phi)  # SphericalHarmonicPolynomial of SPHARM-PDM


@pytest.mark.skipif(
    not hasattr(scipy.special, "sph_harm_y"), reason="scipy 1.15 brings these functions"
)
@pytest.mark.parametrize("basis", ["spharm-pdm", "ktch", "aics-shparam"])
def test_coefficients_in_the_order_and_norm_of_programs_describe_the_same_surface(basis):
    v, f = ism.samples.make("pear", n_vertices=400)
    c = ism.shapes.coefficients_from_mesh(v, f, 4, basis=basis)
    x = np.linalg.qr(np.random.default_rng(0).normal(size=(6, 3, 3)))[0].reshape(-1, 3)
    values = np.zeros((len(x), 3))
    for ell in range(5):
        for m in range(ell + 1):
            Y = theirs(basis, ell, m, x)
            if basis == "spharm-pdm":
                cosine, sine = c[ell * ell + max(2 * m - 1, 0)], c[ell * ell + 2 * m] * (m > 0)
            elif basis == "ktch":
                rows = c.reshape(3, 25).T
                cosine, sine = rows[ell * ell + ell + m], rows[ell * ell + ell - m] * (m > 0)
            else:
                cosine, sine = c[:, 0, ell, m], c[:, 1, ell, m]
            values += np.outer(Y.real, cosine) + np.outer(Y.imag, sine)
    shape = ism.shapes.spherical_harmonics(ism.balanced_spherical_map(v, f, balance=1), degree=4)
    assert np.abs(values - shape.evaluate(x)).max() < 1e-12 * np.abs(v).max()


def test_ktch_fits_the_same_coefficients():
    """Its least squares over samples of the sphere, of a surface that has no higher degrees."""
    ktch = pytest.importorskip("ktch.harmonic", reason="ktch is not installed")
    x, f = ism.samples.sphere(642)
    c = ism.shapes.spherical_harmonics(ism.sphere_map(lump(x), f, x), degree=4)
    fit = ktch.SphericalHarmonicAnalysis(n_harmonics=4, registration=None)
    angles = np.column_stack((np.arccos(x[:, 2]), np.arctan2(x[:, 1], x[:, 0])))
    found = fit.fit_transform([c.evaluate(x)], theta_phi=[angles])[0]
    assert np.abs(found - c.in_basis("ktch")).max() < 1e-10


def test_pyshtools_expands_as_aics_shparam_does():
    """The call that aics-shparam makes, of our surface on its grid, whose first column lies at -x."""
    expand = pytest.importorskip("pyshtools.expand", reason="pyshtools is not installed")
    x, f = ism.samples.sphere(642)
    c = ism.shapes.spherical_harmonics(ism.sphere_map(lump(x), f, x), degree=4)
    theta, phi = np.pi * np.arange(32)[:, None] / 32, 2 * np.pi * np.arange(64) / 64 - np.pi
    grid = np.stack(
        np.broadcast_arrays(
            np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)
        ),
        -1,
    )
    z = c.evaluate(grid.reshape(-1, 3))[:, 2].reshape(32, 64)
    assert (
        np.abs(expand.SHExpandDH(z, sampling=2, lmax_calc=4) - c.in_basis("aics-shparam")[2]).max()
        < 1e-10
    )


def test_refusals(shape):
    result = on_sphere(lump, 2)
    with pytest.raises(ism.MeshError, match=r"not finite at 1 vertex, e\.g\. 5;"):
        ism.shapes.spherical_harmonics(result, np.where(np.arange(162) == 5, np.nan, 0))
    with pytest.raises(ism.MeshError, match=r"shape \(3,\) but the mesh has 162 vertices"):
        ism.shapes.spherical_harmonics(result, [1, 2, 3])
    for degree, error in ((-1, ValueError), (1001, ValueError), (2.5, TypeError)):
        with pytest.raises(error, match=f"degree is {degree}; give "):
            ism.shapes.spherical_harmonics(result, degree=degree)
    with pytest.raises(ValueError, match="oversampling"):
        ism.shapes.spherical_harmonics(result, oversampling=0.5)
    with pytest.raises(ism.MeshError, match="2 columns"):
        ism.shapes.spherical_harmonics(result, result.vertices[:, :2]).surface()
    bare = ism.shapes.SphericalHarmonics(shape.coefficients)
    with pytest.raises(ism.MeshError, match="no source to compare"):
        bare.error()
    with pytest.raises(ism.MeshError, match="give a template"):
        bare.align()
    with pytest.raises(ism.MeshError, match="degree 0"):
        ism.shapes.spherical_harmonics(result, degree=0).align()
    for columns, degree, words in ((2, 3, "2 columns"), (3, 0, "degree 0")):
        template = ism.shapes.SphericalHarmonics(np.ones(((degree + 1) ** 2, columns)))
        with pytest.raises(ism.MeshError, match=words):
            shape.align(template)
    with pytest.raises(ValueError, match="unknown basis 'pdm': choose orthonormal, spharm-pdm"):
        shape.in_basis("pdm")
    with pytest.raises(ism.MeshError, match="not orthogonal"):
        shape.rotated(np.diag([1, 1, -1]))


def test_results_print_in_one_short_line():
    x, f = ism.samples.sphere(162)
    v = x * [1, 1.5, 2] + 0.2 * x[:, :1] ** 2  # no symmetry: axes have a front
    result = ism.sphere_map(v, f, x)
    shape = ism.shapes.spherical_harmonics(result, degree=4)
    registration = ism.shapes.register(result, result, features=(v, v), stages=["rotation"])
    results = (
        shape,
        shape.source,
        shape.align(),
        registration,
        registration.candidates[0],
        ism.check_mesh(v, f),
        ism.repair_mesh(v, f),
        ism.weighted_eigen_projection(v, f, x),
        ism.texture_atlas(x, f),
        ism.SphereLocator(x, f).locate(v),
        ism.resample(result, "ico:1"),
    )
    for each in results:
        assert repr(each).startswith(type(each).__name__ + "(")
        assert "\n" not in repr(each)
        assert len(repr(each)) < 120
