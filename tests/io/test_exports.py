"""Textures, colours and scalar maps, as other programs read them."""

from __future__ import annotations

import os

import numpy as np
import pytest

from igl_spheremap import FileError, angle_differences, conformal_factor, samples, spherical_conformal_map
from igl_spheremap.apps.cli import main
from igl_spheremap.draw.palette import colours
from igl_spheremap.io import read_mesh, write_map, write_mesh, write_scalars, write_sphere, write_textured
from igl_spheremap.shapes.texture import checker_image, texture_atlas
from igl_spheremap.verify.vertex_maps import vertex_maps


@pytest.fixture(scope="module")
def result():
    return spherical_conformal_map(*samples.make("spheroid", n_vertices=600))


@pytest.fixture
def files(result, tmp_path):
    write_mesh(tmp_path / "source.ply", result.vertices, result.faces)
    write_sphere(tmp_path / "sphere.ply", result.sphere, result.faces)
    return [str(tmp_path / "source.ply"), str(tmp_path / "sphere.ply")]


@pytest.mark.parametrize("name", ["body.obj", "body.glb"])
@pytest.mark.parametrize("projection", ["equirectangular", "octahedral"])
def test_textures_in_another_program(name, projection, result, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    pytest.importorskip("PIL")
    atlas = texture_atlas(result.sphere, result.faces, projection)
    image = checker_image(64, 4)
    write_textured(tmp_path / name, result.vertices, result.faces, atlas, image)
    body = trimesh.load(tmp_path / name, force="mesh", process=False)
    f = np.asarray(body.faces)
    assert np.allclose(np.asarray(body.vertices)[f], atlas.carry(result.vertices)[atlas.f], atol=1e-6)
    assert np.allclose(np.asarray(body.visual.uv)[f], atlas.uv[atlas.f], atol=1e-6)
    material = body.visual.material
    picture = material.baseColorTexture if name.endswith("glb") else material.image
    assert np.array_equal(np.asarray(picture.convert("RGB")), image)
    outward = np.einsum("ij,ij->i", body.vertex_normals, np.asarray(body.vertices))
    assert (outward > 0).all()


def test_textures_are_not_overwritten(result, tmp_path):
    pytest.importorskip("PIL")
    atlas = texture_atlas(result.sphere, result.faces)
    (tmp_path / "body.png").write_text("precious")
    with pytest.raises(FileError, match=r"body.png exists already"):
        write_textured(tmp_path / "body.obj", result.vertices, result.faces, atlas, checker_image(8, 2))
    assert os.listdir(tmp_path) == ["body.png"]
    with pytest.raises(FileError, match=r"\.obj and \.glb"):
        write_textured(tmp_path / "body.off", result.vertices, result.faces, atlas, checker_image(8, 2))


def test_the_maps_are_what_they_say(result):
    maps = vertex_maps(result.vertices * 7, result.faces, result.sphere)
    factor = conformal_factor(result.vertices, result.faces, result.sphere)
    assert np.allclose(np.exp(2 * maps["factor"]) * 4 * np.pi, factor)
    size = np.abs(angle_differences(result.vertices, result.faces, result.sphere))
    for i in (0, 100, 500):
        assert maps["angles"][i] == pytest.approx(size[result.faces == i].mean())


def test_scalar_maps_in_other_programs(result, tmp_path):
    nibabel = pytest.importorskip("nibabel")
    maps = vertex_maps(result.vertices, result.faces, result.sphere)
    write_scalars(tmp_path / "a.shape.gii", maps, metadata={"structure": "CortexLeft"})
    image = nibabel.load(tmp_path / "a.shape.gii")
    assert [array.meta["Name"] for array in image.darrays] == list(maps)
    assert image.meta["AnatomicalStructurePrimary"] == "CortexLeft"
    assert np.allclose(image.darrays[1].data, maps["angles"])
    write_scalars(tmp_path / "lh.angles", {"angles": maps["angles"]})
    assert np.allclose(nibabel.freesurfer.read_morph_data(tmp_path / "lh.angles"), maps["angles"])
    write_scalars(tmp_path / "a.npz", maps)
    with np.load(tmp_path / "a.npz") as archive:
        assert np.array_equal(archive["factor"], maps["factor"])
    with pytest.raises(FileError, match="hold one map"):
        write_scalars(tmp_path / "lh.both", maps)
    with pytest.raises(FileError, match="scalar maps are written to"):
        write_scalars(tmp_path / "a.txt", maps)


def test_colours_in_a_ply(result, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    values = vertex_maps(result.vertices, result.faces, result.sphere)["factor"]
    told = {"vertex_properties": {**colours(values), "quality": values}}
    write_mesh(tmp_path / "a.ply", result.vertices, result.faces, metadata=told)
    assert np.array_equal(read_mesh(tmp_path / "a.ply").v, result.vertices)
    body = trimesh.load(tmp_path / "a.ply", process=False)
    assert np.array_equal(body.visual.vertex_colors[:, 0], told["vertex_properties"]["red"])
    assert values[body.visual.vertex_colors[:, 1].argmax()] > values[body.visual.vertex_colors[:, 1].argmin()]


def test_colours_of_anything():
    for values in (np.zeros(5), np.array([np.nan, np.inf, -np.inf, 0, 1]), np.full(3, np.nan)):
        assert all(channel.dtype == np.uint8 for channel in colours(values).values())


@pytest.mark.parametrize(
    ("name", "show"),
    [("a.glb", "octahedral"), ("a.obj", "equirectangular"), ("a.ply", "angles"), ("a.shape.gii", "factor"),
     ("lh.factor", "factor"), ("a.npz", "angles")],
)  # fmt: skip
def test_export(name, show, files, tmp_path, capsys):
    for module in ("trimesh", "PIL", "nibabel"):
        pytest.importorskip(module)
    target = str(tmp_path / name)
    assert main(["export", *files, target, "--show", show]) == 0
    assert show in capsys.readouterr().out
    assert main(["export", *files, target, "--show", show]) == 74
    assert main(["export", *files, target, "--show", show, "--force", "-q"]) == 0


def test_export_refuses(files, tmp_path, capsys):
    assert main(["export", *files, str(tmp_path / "a.ply"), "--show", "octahedral"]) == 64
    assert main(["export", *files, str(tmp_path / "a.stl"), "--show", "angles"]) == 74
    assert capsys.readouterr().err.count("\n") == 2


def test_limbs_too_narrow_for_float32_are_drawn_out_by_the_source(tmp_path):
    v, f = samples.make("octopus", n_vertices=3000, arm_length=3.0)
    result = spherical_conformal_map(v, f)
    means = []
    for name, source in (("with", result.vertices), ("without", None)):
        path = tmp_path / f"{name}.surf.gii"
        check = write_sphere(path, result.sphere, result.faces, source)
        assert check.certificate.folding_free
        means.append(np.abs(angle_differences(v, f, read_mesh(path).v)).mean())
    assert means[0] < 0.7 * means[1]
    write_map(tmp_path / "map.surf.gii", result)
    assert (read_mesh(tmp_path / "map.surf.gii").v == read_mesh(tmp_path / "with.surf.gii").v).all()
