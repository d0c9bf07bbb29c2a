"""Maps in files: certified as written, with a mark of their origin, at any radius."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from file_names import ALL, needs
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap import FileError, angle_differences, samples, spherical_conformal_map
from igl_spheremap.io.files import read_mesh, read_sphere
from igl_spheremap.io.float32 import Float32Map
from igl_spheremap.io.write_mesh import write_mesh
from igl_spheremap.io.written_map import certify_radius, make_mark, read_mark, write_map
from igl_spheremap.verify.certificate import certify


@pytest.mark.parametrize(
    ("name", "radius"),
    [
        ("s.obj", 1),
        ("s.ply", 1),
        ("s.npz", 1),
        ("lh.sphere", 100),
        ("s.surf.gii", 100),
        ("s.stl", 1),
    ],
)
def test_a_map_is_certified_as_written(name, radius, result, tmp_path):
    needs(name)
    check = write_map(tmp_path / name, result)
    assert check.folding_free
    assert check.radius == pytest.approx(radius, rel=1e-6)
    x, f = read_sphere(tmp_path / name)
    assert certify(x / np.linalg.norm(x, axis=1)[:, None], f).folding_free


@pytest.fixture
def tiny(result):
    """A certified map with one edge of 1e-10, which float32 can't hold."""
    x = result.sphere.copy()
    i, j = result.faces[0, :2]
    x[j] = x[i] + 1e-9 * (x[j] - x[i])
    x /= np.linalg.norm(x, axis=1)[:, None]
    certificate = certify(x, result.faces)
    assert certificate.folding_free
    return dataclasses.replace(result, sphere=x, certificate=certificate)


def plainly(x, f, radius=1.0, v=None):
    """Rounding to float32 that repairs nothing."""
    positions = (radius * x).astype(np.float32)
    return Float32Map(positions, certify(x, f), np.empty(0, dtype=np.int64))


def test_float32_folds_are_seen(tiny, tmp_path, monkeypatch):
    pytest.importorskip("nibabel")
    monkeypatch.setattr("igl_spheremap.io.written_map.certified_float32", plainly)
    assert not write_map(tmp_path / "s.surf.gii", tiny).folding_free
    assert write_map(tmp_path / "s.obj", tiny).folding_free
    with pytest.raises(FileError, match="too coarse"):
        write_map(tmp_path / "s.stl", tiny)
    assert not (tmp_path / "s.stl").exists()


@pytest.mark.parametrize("name", ["s.surf.gii", "lh.sphere", "s.stl", "s.glb"])
def test_float32_folds_are_repaired_in_the_file(name, tiny, tmp_path):
    needs(name)
    check = write_map(tmp_path / name, tiny)
    assert check.folding_free
    assert 0 < check.moved < 20
    if not name.endswith(".stl"):
        x, f = read_sphere(tmp_path / name)
        assert np.array_equal(f, tiny.faces)
        shift = np.linalg.norm(x / check.radius - tiny.sphere, axis=1)
        assert (shift > 1e-6).sum() <= check.moved


def test_nothing_is_moved_where_rounding_folds_nothing(result, tmp_path):
    pytest.importorskip("nibabel")
    assert write_map(tmp_path / "lh.sphere", result).moved == 0
    x, _ = read_sphere(tmp_path / "lh.sphere")
    assert np.array_equal(x, (100 * result.sphere).astype(np.float32))


def test_a_unit_sphere_has_radius_one_to_the_last_digit():
    x, f = samples.make("sphere", n_vertices=200)
    assert certify_radius(x * (1 + 1e-15), f).radius == 1
    assert certify_radius(100 * x, f).radius == pytest.approx(100)


def test_limbs_too_narrow_for_float32_are_stretched_with_hardly_a_loss_in_angles(tmp_path):
    v, f = samples.make("octopus", n_vertices=3000, arm_length=3.0)
    result = spherical_conformal_map(v, f)
    path = tmp_path / "map.surf.gii"
    check = write_map(path, result)
    assert check.folding_free
    assert check.moved > 100
    assert (
        np.abs(angle_differences(v, f, read_mesh(path).v)).mean()
        < 1.3 * np.abs(result.angle_differences()).mean()
    )


V, F = ism.samples.sphere(42)


@pytest.mark.parametrize("name", ALL)
def test_every_format_keeps_the_mark_of_a_map(name, result, tmp_path):
    needs(name)
    write_map(tmp_path / name, result)
    assert read_mark(tmp_path / name) == make_mark(result.vertices, result.faces, "auto", {})
    write_mesh(tmp_path / f"plain-{name}", V, F)
    assert read_mark(tmp_path / f"plain-{name}") is None


@pytest.mark.parametrize("name", [name for name in ALL if not name.endswith(".npz")])
def test_a_second_run_writes_the_same_bytes(name, tmp_path):
    """Time, host, folder and process leave no trace."""
    needs(name)
    contents = []
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        write_map(tmp_path / folder / name, ism.spherical_conformal_map(V, F))
        contents.append((tmp_path / folder / name).read_bytes())
    assert contents[0] == contents[1]


def test_the_mark_distinguishes_input_method_options_and_version(monkeypatch):
    other = V.copy()
    other[0, 0] = np.nextafter(other[0, 0], 2)
    marks = [
        make_mark(V, F, "auto", {}),
        make_mark(other, F, "auto", {}),
        make_mark(V, F[:, [1, 2, 0]], "auto", {}),
        make_mark(V, F, "lai2014", {}),
        make_mark(V, F, "auto", {"polish": "angles"}),
        make_mark(V, F, "auto", {"weights": np.arange(3.0)}),
        make_mark(V, F, "auto", {"weights": np.arange(4.0)}),
        make_mark(V, F, "auto", {"a": "x" * 60}),
        make_mark(V, F, "auto", {"a": "x" * 61}),
    ]
    # nothing else changes a version
    monkeypatch.setattr("igl_spheremap.io.written_map.__version__", "0.0.0")
    marks.append(make_mark(V, F, "auto", {}))
    assert len(set(marks)) == len(marks)
    assert make_mark(V.astype(">f8"), F.astype(np.int32), "auto", {}) == marks[-1]


@pytest.mark.parametrize("value", [1, "two words", "\n", "<&>", "é", "x" * 500, {"b": [1]}])
def test_a_mark_is_one_short_line_of_ascii_whatever_the_options_are(value, result, tmp_path):
    """An STL header has 80 bytes, and FreeSurfer's programs read 199 bytes of a comment."""
    options = {"a": value}
    mark = make_mark(V, F, "stereographic", options)
    assert len(mark) <= 80
    assert mark.isascii()
    assert mark.isprintable()
    for name in ALL:
        needs(name)
        run = dataclasses.replace(result.run, settings=options)
        write_map(tmp_path / name, dataclasses.replace(result, run=run), force=True)
        found = read_mark(tmp_path / name)
        assert found == make_mark(result.vertices, result.faces, "auto", options)


@pytest.mark.parametrize("name", ["ball.obj", "ball.off", "ball.ply", "ball.stl", "ball.glb"])
def test_other_programs_read_files_with_marks(name, result, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    write_map(tmp_path / name, result)
    other = trimesh.load(tmp_path / name, force="mesh", process=False)
    assert np.allclose(
        np.asarray(other.vertices)[other.faces], result.sphere[result.faces], atol=1e-6
    )


@pytest.mark.parametrize("name", ["ball.obj", "ball.off", "ball.ply"])
def test_libigl_reads_files_with_marks(name, result, tmp_path):
    igl = pytest.importorskip("igl")
    write_map(tmp_path / name, result)
    v, f = igl.read_triangle_mesh(str(tmp_path / name))[:2]
    assert np.allclose(v, read_mesh(tmp_path / name).v, atol=1e-9)
    assert np.array_equal(f, result.faces)


def test_freesurfer_s_own_reader_finds_the_mark_as_the_comment(result, tmp_path):
    freesurfer = pytest.importorskip("nibabel.freesurfer")
    write_map(tmp_path / "lh.sphere.conformal", result)
    *_, comment = freesurfer.read_geometry(tmp_path / "lh.sphere.conformal", read_stamp=True)
    assert comment == read_mark(tmp_path / "lh.sphere.conformal")


def test_damaged_files_have_no_mark(tmp_path):
    for name, data in (("a.gii.gz", b"\x1f\x8bxx"), ("a.npz", b"PK"), ("a.obj", b"")):
        (tmp_path / name).write_bytes(data)
        assert read_mark(tmp_path / name) is None


X, FACES = icosphere(2)


@pytest.mark.parametrize("radius", [1e-300, 1e-170, 1e-110, 1e-3, 100.0, 1e105, 1e155, 1e300])
def test_a_sphere_of_any_radius_is_certified(radius):
    check = certify_radius(radius * X, FACES)
    assert check.folding_free
    assert check.radius == pytest.approx(radius, rel=1e-12)


@pytest.mark.parametrize("radius", [1.1e-103, 1e-170, 1e155])
def test_a_flipped_face_is_found_at_any_radius(radius):
    x = radius * X
    x[[3, 50]] = x[[50, 3]]
    certificate = certify_radius(x, FACES)
    assert not certificate.folding_free
    assert len(certificate.flipped) >= 4
    assert len(certificate.off_sphere) == 0


def test_rows_that_are_not_finite_change_no_radius():
    check = certify_radius(100 * np.where(np.arange(len(X))[:, None] == 7, np.nan, X), FACES)
    assert check.radius == pytest.approx(100)
    assert check.not_finite.tolist() == [7]
    assert len(check.off_sphere) == 0


def test_rows_off_the_sphere_are_off_relative_to_the_radius():
    x = 1e-200 * X * np.where(np.arange(len(X)) == 7, 1.001, 1.0)[:, None]
    assert certify_radius(x, FACES).off_sphere.tolist() == [7]
