"""Templates keep the order of vertices of the programs that they come from."""

from __future__ import annotations

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.apps.cli import main
from igl_spheremap.io.files import read_mesh
from igl_spheremap.io.scalars import read_scalars, write_scalars
from igl_spheremap.io.templates import coarser, template_files
from igl_spheremap.io.write_mesh import write_mesh
from igl_spheremap.samples import sphere
from igl_spheremap.sphere.rows import unit_rows


def template_sphere(name, structure=None):
    """Vertices and faces of the sphere alone."""
    _, f, x = template_files(name, structure, None).read()
    return x, f


@pytest.fixture
def bare(monkeypatch, tmp_path):
    """A machine on which no other program has data, but for what nilearn brings."""
    for name in (
        "SUBJECTS_DIR",
        "FREESURFER_HOME",
        "NILEARN_DATA",
        "NILEARN_SHARED_DATA",
        "NEUROMAPS_DATA",
        "TEMPLATEFLOW_HOME",
        "HCPPIPEDIR",
    ):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("USERPROFILE", str(tmp_path / "home"))
    return tmp_path


def test_coarser_spheres_are_the_ones_that_were_cut():
    for n in (42, 162, 642, 2562):
        x, f = sphere(n)
        y, g = coarser(*sphere(4 * n - 6))
        assert np.array_equal(x, y)
        assert {*map(tuple, map(np.roll, f, -f.argmin(axis=1)))} == {
            *map(tuple, map(np.roll, g, -g.argmin(axis=1)))
        }
    backwards = x[::-1], len(x) - 1 - f
    with pytest.raises(ism.MeshError, match="not nested"):
        coarser(*backwards)


@pytest.mark.parametrize("level", [3, 4, 5])
def test_fsaverage_has_the_vertices_of_nilearn(level, bare):
    pytest.importorskip("nibabel")
    theirs, _ = read_mesh(
        pytest.importorskip("nilearn.datasets").fetch_surf_fsaverage("fsaverage5")["sphere_left"]
    )
    x, f = template_sphere(f"fsaverage{level}")
    assert np.array_equal(x, theirs[: 10 * 4**level + 2])
    assert ism.certify(unit_rows(x), f).folding_free


def test_data_land_on_the_vertices_of_the_template(bare, monkeypatch):
    """A surface that has the template's sphere itself: data and labels stay where they are, bit for bit."""
    pytest.importorskip("nibabel")
    folder = pytest.importorskip("nilearn.datasets").fetch_surf_fsaverage("fsaverage5")
    monkeypatch.chdir(bare)
    thickness = read_scalars(folder["thick_left"]).popitem()[1]
    write_scalars("data.npz", {"thickness": thickness})
    words = [
        "transfer",
        folder["white_left"],
        folder["sphere_left"],
        "out.npz",
        "--data",
        "data.npz",
        "-q",
        "--to",
    ]
    assert main([*words, "fsaverage5"]) == 0
    assert np.array_equal(read_scalars("out.npz")["thickness"], thickness)
    assert main([*words, "fsaverage4", "-f"]) == 0
    assert np.array_equal(read_scalars("out.npz")["thickness"], thickness[:2562])


def test_sides_of_fslr(bare, monkeypatch, capsys):
    """A stand-in of the template's size: which file is taken follows the side of the surface, mirrored by --reflect."""
    pytest.importorskip("nibabel")
    folder = bare / "maps" / "atlases" / "fsLR"
    folder.mkdir(parents=True)
    monkeypatch.setenv("NEUROMAPS_DATA", str(bare / "maps"))
    monkeypatch.chdir(bare)
    x, f = sphere(32_492)
    assert len(x) == 32_492
    for side, turn in (("L", 0), ("R", 1)):
        write_mesh(
            folder / f"tpl-fsLR_den-32k_hemi-{side}_sphere.surf.gii", np.roll(x, turn, axis=1), f
        )
    assert np.allclose(template_sphere("fsLR-32k", "CortexLeft")[0], x, atol=1e-7)
    assert np.allclose(
        template_sphere("fsLR-32k", "CortexRight")[0], np.roll(x, 1, axis=1), atol=1e-7
    )
    y, g = sphere(642)
    write_mesh("rh.white", y, g)
    write_mesh("white.ply", y, g)
    write_scalars("data.npz", {"z": y[:, 2]})
    words = ["out.npz", "--data", "data.npz", "--to", "fsLR-32k", "-q", "-f"]
    for options, expected in (([], np.roll(x, 1, axis=1)), (["--reflect"], x)):
        assert main(["transfer", "rh.white", "rh.white", *words, *options]) == 0
        assert np.abs(read_scalars("out.npz")["z"] - expected[:, 2]).max() < 0.01
    assert main(["transfer", "white.ply", "white.ply", *words]) == 74
    assert "a left and a right side" in capsys.readouterr().err


def test_what_is_not_there_is_named(bare, monkeypatch):
    with pytest.raises(ism.FileError, match="no sphere of fsaverage7"):
        template_sphere("fsaverage7")
    pytest.importorskip("nilearn")
    with pytest.raises(
        ism.FileError, match=r"surface of fsaverage with .*; take fsaverage5, which is on"
    ):
        template_files("fsaverage", "CortexLeft")
    with pytest.raises(ism.FileError, match="no sphere of fsLR-32k"):
        template_sphere("fsLR-32k", "CortexLeft")
    with pytest.raises(ValueError, match="choose from fsaverage3"):
        template_sphere("fsaverage2")
    (bare / "fsaverage" / "surf").mkdir(parents=True)
    monkeypatch.setenv("SUBJECTS_DIR", str(bare))
    pytest.importorskip("nibabel")
    write_mesh(bare / "fsaverage" / "surf" / "lh.sphere", *sphere(642))
    with pytest.raises(ism.MeshError, match=r"lh.sphere has 642 vertices, not 163842"):
        template_sphere("fsaverage7")


def test_surfaces_are_found_where_packages_keep_them(bare, monkeypatch):
    """FreeSurfer's folder comes first; a midthickness is the mean of white and pial; nested levels are cut out."""
    pytest.importorskip("nibabel")
    monkeypatch.setattr("igl_spheremap.io.templates.find_spec", lambda name: None)
    surf = bare / "fsaverage5" / "surf"
    surf.mkdir(parents=True)
    monkeypatch.setenv("SUBJECTS_DIR", str(bare))
    x, f = sphere(10_242)
    for hemi, turn in (("lh", 1.0), ("rh", np.array([-1.0, 1, 1]))):
        write_mesh(surf / f"{hemi}.sphere", 100 * x, f)
        for kind, size in (("white", 60), ("pial", 64)):
            write_mesh(surf / f"{hemi}.{kind}", size * x * turn, f)
    for structure, turn in (("CortexLeft", 1.0), ("CortexRight", np.array([-1.0, 1, 1]))):
        for kind, size in (("white", 60), ("pial", 64), ("midthickness", 62)):
            files = template_files("fsaverage3", structure, kind)
            v, g, y = files.read()
            assert (files.space, files.kind, len(g)) == ("fsaverage", kind, 1280)
            assert np.allclose(v, size * x[:642] * turn, atol=1e-4)
            assert np.allclose(y, 100 * x[:642], atol=1e-4)


def test_a_template_has_another_kind_where_one_is_missing(bare, monkeypatch):
    pytest.importorskip("nibabel")
    monkeypatch.setattr("igl_spheremap.io.templates.find_spec", lambda name: None)
    monkeypatch.setenv("TEMPLATEFLOW_HOME", str(bare))
    (bare / "tpl-fsLR").mkdir()
    x, f = sphere(32_492)
    write_mesh(bare / "tpl-fsLR" / "tpl-fsLR_hemi-R_den-32k_sphere.surf.gii", x, f)
    write_mesh(bare / "tpl-fsLR" / "tpl-fsLR_den-32k_hemi-R_midthickness.surf.gii", 2 * x, f)
    files = template_files("fsLR", "CortexRight", "white")
    assert (files.space, files.kind, files.size) == ("fsLR", "midthickness", 32_492)
    assert np.allclose(template_sphere("fsLR", "CortexRight")[0], x, atol=1e-6)
    with pytest.raises(
        ism.FileError, match=r"no surface of fsLR .*tpl-fsLR; python -c .*templateflow"
    ):
        template_files("fsLR", "CortexLeft")
    write_mesh(
        bare / "tpl-fsLR" / "tpl-fsLR_den-32k_hemi-R_midthickness.surf.gii",
        *sphere(642),
        force=True,
    )
    with pytest.raises(ism.MeshError, match="give a surface and its own sphere"):
        files.read()
