"""`igl-spheremap export`."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy.spatial import cKDTree

from igl_spheremap import samples, spherical_conformal_map
from igl_spheremap.apps.cli import main
from igl_spheremap.io.files import read_mesh
from igl_spheremap.io.textured import write_textured
from igl_spheremap.io.write_mesh import write_mesh
from igl_spheremap.io.written_map import write_sphere
from igl_spheremap.mesh.check import check_faces
from igl_spheremap.resampling.texture import plane_atlas


@pytest.fixture
def files(tmp_path):
    result = spherical_conformal_map(*samples.make("spheroid", n_vertices=600))
    write_mesh(tmp_path / "source.ply", result.vertices, result.faces)
    write_sphere(tmp_path / "sphere.ply", result.sphere, result.faces)
    return [str(tmp_path / "source.ply"), str(tmp_path / "sphere.ply")]


@pytest.mark.parametrize(
    ("name", "show"),
    [("a.glb", "octahedral"), ("a.obj", "equirectangular"), ("a.ply", "angles"), ("a.shape.gii", "factor"),
     ("lh.factor", "factor"), ("a.npz", "angles"), ("b.glb", "angles")],
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
    assert main(["export", *files, str(tmp_path / "a.obj"), "--show", "angles"]) == 74
    assert main(["export", *files, str(tmp_path / "a.gii")]) == 64
    err = capsys.readouterr().err
    assert err.count("\n") == 3
    assert "unknown format of data" in err
    for words in (
        ["--texture", "carried", "--show", "octahedral"],
        ["--texture", "baked", "--show", "angles"],
        ["--texture", "baked", "--image", "a.png"],
    ):
        assert main(["export", *files, str(tmp_path / "a.obj"), *words]) == 64
    assert main(["export", *files, str(tmp_path / "a.obj"), "--texture", "baked"]) == 74
    assert capsys.readouterr().err.endswith("textures are read from .obj, .glb and .gltf files\n")
    write_mesh(tmp_path / "plain.obj", *read_mesh(files[0]))
    assert (
        main(
            [
                "export",
                str(tmp_path / "plain.obj"),
                files[1],
                str(tmp_path / "a.obj"),
                "--texture",
                "baked",
            ]
        )
        == 2
    )
    assert "no texture coordinates" in capsys.readouterr().err


@pytest.fixture
def painted(files, tmp_path):
    """A surface with a picture whose red is x and whose green is z, in both formats."""
    pytest.importorskip("PIL")
    pytest.importorskip("trimesh")
    v, f = read_mesh(files[0])
    uv = (v - v.min(axis=0)) / np.ptp(v, axis=0)
    place = (np.arange(256) + 0.5) / 256
    red, green = np.meshgrid(place, place[::-1])
    image = np.rint(255 * np.stack((red, green, 0 * red), axis=-1)).astype(np.uint8)
    atlas = plane_atlas(np.clip(uv[:, ::2], 0.01, 0.99), f, np.arange(len(v)), len(v))
    for name in ("painted.obj", "painted.glb"):
        write_textured(tmp_path / name, v, f, atlas, image)
    return atlas.uv


@pytest.mark.parametrize(
    ("of", "source", "target"),
    [("sphere", "painted.glb", "a.obj"), ("plane", "painted.obj", "a.glb")],
)
def test_a_baked_texture_shows_what_the_source_s_own_does(
    of, source, target, painted, files, tmp_path
):
    """trimesh reads the colours at the vertices, which are those of their places."""
    import trimesh

    source, target = str(tmp_path / source), str(tmp_path / target)
    if of == "plane":
        files[1] = str(tmp_path / "flat.obj")
        assert main(["flatten", source, files[1], "--cut", "3", "-q"]) == 0
    assert main(["export", source, files[1], target, "--texture", "baked", "-q"]) == 0
    written = trimesh.load(target, process=False, force="mesh")
    colours = written.visual.to_color().vertex_colors[:, :2] / 255
    v = read_mesh(files[0]).v
    distance, nearest = cKDTree(v).query(written.vertices)
    own = distance < 1e-6 * np.ptp(v)  # cuts at the seam add others
    assert own.sum() >= len(v)
    assert np.quantile(np.abs(colours - painted[nearest])[own], 0.99) < 0.03
    if of == "plane":
        assert {"factor", "corner"} <= written.metadata.keys()


@pytest.mark.parametrize("show", ["angles", "octahedral"])
def test_a_scene_is_turned_so_that_y_is_up(show, files, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    pytest.importorskip("PIL")
    source = "sample:spheroid:n_vertices=600"  # whose z is up
    assert main(["export", source, files[1], str(tmp_path / "a.glb"), "--show", show, "-q"]) == 0
    upright = trimesh.load_scene(tmp_path / "a.glb").to_mesh().vertices
    v = read_mesh(source).v[:, [0, 2, 1]] * [1, 1, -1]
    assert cKDTree(upright).query(v)[0].max() < 1e-6 * np.ptp(v)


@pytest.mark.parametrize("words", [[], ["--up=x"], ["--up=-z"]])
def test_a_node_of_the_file_s_name_turns_what_is_up_to_y(words, files, tmp_path):
    """By the shape where the file's name and format say nothing: a cone stands on its disk, whatever its axis."""
    trimesh = pytest.importorskip("trimesh")
    v, f = samples.sphere(642)
    tip = np.argmax(v[:, 0])
    v = np.clip(v, -0.4, None) * [0.3, 1, 1]
    v[tip] = [3, 0, 0]
    v = {"--up=x": v, "--up=-z": v[:, [1, 2, 0]] * [1, -1, -1]}.get(
        *words or [""], np.roll(v, 1, axis=1)
    )
    write_mesh(tmp_path / "cone.ply", v, f)
    write_sphere(tmp_path / "image.ply", spherical_conformal_map(v, f).sphere, f)
    names = [str(tmp_path / name) for name in ("cone.ply", "image.ply", "stands.glb")]
    assert main(["export", *names, "--show", "angles", "-q", *words]) == 0
    scene = trimesh.load_scene(tmp_path / "stands.glb")
    assert list(scene.geometry) == ["stands"]
    assert "stands" in scene.graph.nodes_geometry
    found = scene.to_mesh()
    assert np.argmax(found.vertices[:, 1]) == tip
    assert np.abs(found.vertices[tip, [0, 2]]).max() < 1e-6
    assert found.volume > 0


@pytest.mark.parametrize("target", ["a.glb", "a.obj"])
def test_a_carried_texture_keeps_its_coordinates(target, painted, files, tmp_path):
    import trimesh

    x = read_mesh(files[1]).v
    words = [
        "export",
        str(tmp_path / "painted.obj"),
        files[1],
        str(tmp_path / target),
        "--texture",
        "carried",
    ]
    assert main([*words, "--up", "y"]) == 0
    written = trimesh.load(tmp_path / target, process=False, force="mesh")
    nearest = cKDTree(x).query(written.vertices)[1]
    assert np.allclose(written.vertices, x[nearest], atol=1e-6)
    assert np.allclose(written.visual.uv, painted[nearest], atol=1e-6)


@pytest.mark.parametrize("name", ["a.glb", "a.obj"])
def test_the_vertices_that_are_counted_are_those_of_the_file(name, files, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    pytest.importorskip("PIL")
    words = ["export", *files, str(tmp_path / name), "--show", "octahedral"]
    assert main([*words, "--json", str(tmp_path / "a.json")]) == 0
    figures = json.loads((tmp_path / "a.json").read_text())
    if name == "a.glb":
        written = trimesh.load(tmp_path / name, process=False, force="mesh")
        assert figures["vertices"] == len(written.vertices) == figures["coordinates"]
    else:
        rows, _ = obj(tmp_path / name)
        assert (figures["vertices"], figures["coordinates"]) == (len(rows["v"]), len(rows["vt"]))


@pytest.mark.parametrize("row", [0, np.nan])
def test_spheres_with_rows_that_are_no_directions_are_refused(row, files, tmp_path, capsys):
    x, f = read_mesh(files[1])
    write_mesh(files[1], np.where(np.arange(len(x))[:, None] == 3, row, x), f, force=True)
    assert main(["export", *files, str(tmp_path / "a.ply"), "--show", "angles"]) == 2
    assert capsys.readouterr().err.endswith(
        "sphere.ply: images are zero or not finite in 1 row, e.g. 3; give each a direction\n"
    )


def obj(path):
    """Numbers of an OBJ file by the words of its lines; faces as (m, 3, 3) counts of v, vt and vn."""
    lines = [line.split() for line in path.read_text().splitlines()]
    rows = {
        key: np.array([line[1:] for line in lines if line[0] == key], float)
        for key in ("v", "vt", "vn")
    }
    faces = np.array(
        [[word.split("/") for word in line[1:]] for line in lines if line[0] == "f"], int
    )
    return rows, faces - 1


def test_an_obj_keeps_the_vertices_of_the_mesh(files, tmp_path):
    pytest.importorskip("PIL")
    assert main(["export", *files, str(tmp_path / "a.obj"), "--show", "equirectangular", "-q"]) == 0
    (v, f), (x, _) = (read_mesh(name) for name in files)
    rows, faces = obj(tmp_path / "a.obj")
    assert np.array_equal(rows["v"], v)
    assert np.array_equal(faces[..., 0], f)
    longitude, latitude = np.arctan2(x[:, 1], x[:, 0]), np.arcsin(x[:, 2])
    turns = (
        rows["vt"][faces[..., 1]]
        - np.stack([longitude / (2 * np.pi), latitude / np.pi], axis=-1)[f]
        - 0.5
    )
    away = np.abs(x[f][..., 2]).max(axis=1) < 0.98  # from the poles
    assert np.allclose(turns[away][..., 0], np.rint(turns[away][..., 0]), atol=1e-12)
    assert np.allclose(turns[..., 1], 0, atol=1e-9)
    # no face runs around the picture
    assert np.ptp(rows["vt"][faces[..., 1]][away][..., 0], axis=1).max() < 0.5
    assert len(rows["vt"]) > len(v)  # vertices beside the date line have two places in the picture


def test_a_cut_obj_has_the_mesh_s_vertices_first_and_none_twice(files, tmp_path):
    pytest.importorskip("PIL")
    assert main(["export", *files, str(tmp_path / "a.obj"), "--show", "octahedral", "-q"]) == 0
    v, _ = read_mesh(files[0])
    rows, faces = obj(tmp_path / "a.obj")
    assert np.array_equal(rows["v"][: len(v)], v)
    assert len(np.unique(rows["v"], axis=0)) == len(rows["v"]) > len(v)
    check_faces(faces[..., 0], len(rows["v"]))  # closed, though its texture has a seam


def test_any_picture_is_a_texture(files, tmp_path, capsys):
    images = pytest.importorskip("PIL.Image")
    picture = np.random.default_rng(0).integers(0, 256, (20, 40, 3), dtype=np.uint8)
    images.fromarray(picture).save(tmp_path / "picture.bmp")
    words = ["export", *files, str(tmp_path / "a.obj"), "--show", "equirectangular", "-q"]
    assert main([*words, "--image", str(tmp_path / "picture.bmp")]) == 0
    assert np.array_equal(np.asarray(images.open(tmp_path / "a.png")), picture)
    assert main([*words, "-f", "--image", str(tmp_path / "a.png")]) == 64
    assert main([*words, "-f", "--image", files[0]]) == 74
    assert main([*words, "-f", "--image", str(tmp_path / "nowhere.png")]) == 74
    assert (
        main(["export", *files, str(tmp_path / "b.ply"), "--show", "angles", "--image", "a.png"])
        == 64
    )
    assert capsys.readouterr().err.count("\n") == 4
