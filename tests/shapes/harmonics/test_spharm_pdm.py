"""Folders of SPHARM-PDM: its names, its frames; existing files are kept."""

from __future__ import annotations

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.apps.cli import main
from igl_spheremap.io.files import read_sphere
from igl_spheremap.shapes.harmonics.bases import in_basis

ELLALIGN = "body_pp_surf_SPHARM_ellalign.coef"


@pytest.fixture(scope="module")
def shapes(tmp_path_factory):
    """A body without symmetry, as SegPostProcess names it, and the folder that is made of it."""
    desk = tmp_path_factory.mktemp("shapes")
    x, f = ism.samples.sphere(362)
    ism.write_mesh(desk / "body_pp_surf.vtk", 9 + x * [2, 3, 5] + x[:, [1, 2, 0]] ** 2, f)
    assert run(desk) == 0
    return desk


def run(desk, *words):
    return main(
        [
            "spharm-pdm",
            str(desk / "body_pp_surf.vtk"),
            "--out",
            str(desk / "out"),
            "--degree",
            "6",
            "--subdivision",
            "4",
            "--jobs",
            "1",
            "-q",
            *words,
        ]
    )


def test_the_map_is_certified_and_the_surface_lies_where_it_lay(shapes):
    v, f = ism.read_mesh(shapes / "out/body_pp_surf.vtk")
    x, _ = read_sphere(shapes / "out/body_pp_para.vtk")
    assert ism.certify(x, f).folding_free
    assert np.array_equal(v, ism.read_mesh(shapes / "body_pp_surf.vtk").v)
    points = ism.read_mesh(shapes / "out/body_pp_surf_SPHARM.vtk")
    assert len(points.v) == 162
    assert np.allclose(
        [points.v.min(axis=0), points.v.max(axis=0)], [v.min(axis=0), v.max(axis=0)], atol=0.3
    )
    c = ism.shapes.read_coefficients(shapes / "out/body_pp_surf_SPHARM.coef")
    assert np.allclose(points.v, c.evaluate(ism.samples.sphere(162)[0]), atol=1e-12)
    assert np.allclose(
        c.power(),
        ism.shapes.spherical_harmonics(ism.sphere_map(v, f, x), degree=6).power(),
        rtol=1e-9,
    )


def test_the_frame_is_that_of_its_own_alignment(shapes):
    """EllipseAlign: rows 2, 3 and 1 of its coefficients, made unit vectors, are the axes of the surface."""
    c = in_basis(
        ism.shapes.read_coefficients(shapes / "out/body_pp_surf_SPHARM.coef").coefficients,
        "spharm-pdm",
    )
    lengths = np.linalg.norm(c[[2, 3, 1]], axis=1)
    c[0] = 0
    aligned = ism.shapes.read_coefficients(shapes / "out" / ELLALIGN).coefficients
    assert np.allclose(
        in_basis(aligned, "spharm-pdm"), c @ (c[[2, 3, 1]] / lengths[:, None]).T, atol=1e-10
    )
    z, x, y = np.abs(c[[1, 2, 3]]).max(axis=1) * [1, 1 / np.sqrt(2), 1 / np.sqrt(2)]
    assert z > x > y


def test_a_template_directs_the_axes_and_other_files_are_kept(shapes, capsys):
    target = shapes / "out" / ELLALIGN
    own = ism.shapes.read_coefficients(target)
    turned = shapes / "turned.coef"
    half_turn = ism.shapes.SphericalHarmonics(own.coefficients * [1, -1, -1]).rotated(
        np.diag([1, -1, -1])
    )
    ism.shapes.write_coefficients(turned, half_turn)
    assert run(shapes, "--degree", "5") == 74
    assert np.array_equal(ism.shapes.read_coefficients(target).coefficients, own.coefficients)
    assert run(shapes, "--template", str(turned)) == 0
    found = ism.shapes.read_coefficients(target).coefficients
    assert np.allclose(found, ism.shapes.read_coefficients(turned).coefficients, atol=1e-9)
    out = str(shapes / "out")
    assert main(["spharm-pdm", str(turned), str(turned), "--out", out]) == 64
    assert "each input once" in capsys.readouterr().err


def test_a_template_that_holds_data_is_named(shapes, capsys):
    ism.shapes.write_coefficients(
        shapes / "data.npz", ism.shapes.SphericalHarmonics(np.ones((16, 2)))
    )
    assert (
        main(
            [
                "spharm-pdm",
                str(shapes / "body_pp_surf.vtk"),
                "--out",
                str(shapes / "other"),
                "--jobs",
                "1",
                "--template",
                str(shapes / "data.npz"),
            ]
        )
        == 2
    )
    said = capsys.readouterr()
    assert "coefficients have 2 columns" in " ".join((said.out + said.err).split())
