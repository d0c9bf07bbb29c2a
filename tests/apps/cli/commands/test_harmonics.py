"""The commands for spherical harmonics and grids: their files, and their failures."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import igl_spheremap as ism
from igl_spheremap.apps.cli import main
from igl_spheremap.apps.cli.exits import Exit
from igl_spheremap.io.files import read_mesh
from igl_spheremap.io.scalars import write_scalars
from igl_spheremap.io.write_mesh import write_mesh

SOURCE = "sample:pear:n_vertices=500"
V, F = ism.samples.make("pear", n_vertices=500)


@pytest.fixture(scope="module")
def sphere(tmp_path_factory):
    path = tmp_path_factory.mktemp("maps") / "sphere.obj"
    write_mesh(path, ism.spherical_conformal_map(V, F).sphere, F)
    return str(path)


def test_harmonics_writes_what_the_api_gives(sphere, tmp_path):
    out, surface, table = (str(tmp_path / name) for name in ("a.coef", "a.ply", "a.tsv"))
    words = [
        "harmonics",
        SOURCE,
        sphere,
        out,
        "--degree",
        "6",
        "--surface",
        surface,
        "--to",
        "ico:2",
        "--table",
        table,
    ]
    assert main([*words, "--quiet"]) == 0
    shape = ism.shapes.spherical_harmonics(ism.sphere_map(V, F, read_mesh(sphere).v), degree=6)
    assert np.allclose(
        ism.shapes.read_coefficients(out).coefficients, shape.coefficients, atol=1e-14
    )
    assert np.allclose(read_mesh(surface).v, shape.surface("ico:2")[0], atol=1e-14)
    assert main([*words, "--quiet", "--force", "--to", sphere]) == 0
    assert np.allclose(read_mesh(surface).v, shape.evaluate(read_mesh(sphere).v), atol=1e-14)
    rows = np.loadtxt(table, skiprows=1)
    assert np.allclose(
        rows, np.stack((np.arange(7), shape.error(), shape.power()), axis=1), rtol=1e-5, atol=1e-12
    )


def test_alignment_and_templates(sphere, tmp_path):
    first, second = str(tmp_path / "a.npz"), str(tmp_path / "b.coef")
    assert main(["harmonics", SOURCE, sphere, first, "--align", "-q"]) == 0
    assert main(["harmonics", SOURCE, sphere, second, "--align", "--template", first, "-q"]) == 0
    a, b = ism.shapes.read_coefficients(first), ism.shapes.read_coefficients(second)
    assert np.allclose(a.coefficients, b.coefficients, atol=1e-12)
    assert np.allclose(a.coefficients[0], 0)


def test_data_by_name(sphere, tmp_path):
    data, out = tmp_path / "data.npz", str(tmp_path / "out.npz")
    write_scalars(data, {"height": V[:, 2], "width": V[:, 0]})
    assert main(["harmonics", SOURCE, sphere, out, "--data", f"{data}:height", "-q"]) == 0
    given = ism.sphere_map(V, F, read_mesh(sphere).v)
    shape = ism.shapes.spherical_harmonics(given, V[:, 2])
    assert np.allclose(ism.shapes.read_coefficients(out).coefficients, shape.coefficients)
    assert main(["grid", SOURCE, sphere, out, "--data", str(data), "--rows", "8", "-f", "-q"]) == 0
    with np.load(out) as archive:
        assert np.array_equal(archive["grid"], ism.shapes.to_grid(given, V[:, [2, 0]], rows=8))


def test_pictures(sphere, tmp_path):
    pillow = pytest.importorskip("PIL.Image")
    out = tmp_path / "a.png"
    write_scalars(tmp_path / "places.npz", dict(zip("xyz", V.T, strict=True)))
    places = ["--data", str(tmp_path / "places.npz")]
    assert main(["grid", SOURCE, sphere, str(out), *places, "--rows", "16", "-q"]) == 0
    write_scalars(tmp_path / "flat.npz", dict.fromkeys("abc", np.ones(len(V))))
    assert (
        main(
            [
                "grid",
                SOURCE,
                sphere,
                str(tmp_path / "b.png"),
                "--data",
                str(tmp_path / "flat.npz"),
                "-q",
            ]
        )
        == 0
    )
    image = np.asarray(pillow.open(out))
    assert image.shape == (16, 32, 3)
    assert np.ptp(image[..., 2].astype(int)) == 255  # the pear is longest along z
    assert image.min() == 0


def test_one_table_of_many_surfaces_in_frames_that_agree(tmp_path, capsys):
    """The same body in other poses has the same row, and a body that grows along one field has one mode."""
    rng = np.random.default_rng(0)
    x, f = ism.samples.sphere(162)
    body = x * [1.0, 0.7, 0.5] + 0.2 * x[:, :1] ** 2 * [1, 0, 0.5] + 0.1 * x[:, 1:2] ** 3
    moved = [
        body,
        *(
            body @ Rotation.random(random_state=rng).as_matrix() + rng.normal(size=3)
            for _ in range(2)
        ),
        body + 0.05 * x[:, 2:] ** 2 * [0, 0, 1],
    ]
    for k, v in enumerate(moved):
        write_mesh(tmp_path / f"b{k}.ply", v, f)
        write_mesh(tmp_path / f"b{k}_sphere.ply", x, f)
    write_mesh(tmp_path / "c.obj", body, f)
    words = ["harmonics", f"{tmp_path}/b?.ply", "{folder}/{stem}_sphere.ply"]
    options = ["--degree", "5", "--align", "--modes", "2"]
    assert main([*words, str(tmp_path / "all.tsv"), *options]) == 0
    assert "4 of 4" in capsys.readouterr().out
    assert main([*words, str(tmp_path / "all.npz"), *options, "-q"]) == 0
    lines = [line.split("\t") for line in (tmp_path / "all.tsv").read_text().splitlines()]
    assert lines[0][:6] == ["surface", "mode_1", "x_l0m0", "y_l0m0", "z_l0m0", "x_l1m-1"]
    with np.load(tmp_path / "all.npz") as arrays:
        rows, scores = arrays["coefficients"], arrays["scores"]
        assert (
            np.array([line[1:] for line in lines[1:]], dtype=float).tolist()
            == np.column_stack((scores, rows.reshape(4, -1))).tolist()
        )
        assert np.allclose(rows[1:3], rows[:1], atol=1e-9)
        assert np.isclose((arrays["modes"] ** 2).sum() / (4 * np.pi), 1)
        assert np.isclose(
            scores[3, 0] - scores[0, 0], np.sqrt(((rows[3] - rows[0]) ** 2).sum() / (4 * np.pi))
        )
    assert (
        main(["harmonics", f"{tmp_path}/[bc]*.*", words[2], str(tmp_path / "some.csv"), "-q"])
        == Exit.FAILED
    )


@pytest.mark.parametrize(
    ("words", "status", "sentence"),
    [
        (["harmonics", "a.coef", "--modes", "2"], 64, "--modes goes with many surfaces"),
        (["harmonics", "a.coef", "--template", "b.coef"], 64, "--align"),
        (["harmonics", "a.coef", "--degree", "-2"], 64, "--degree: -2 is out of range"),
        (["harmonics", "a.txt"], 74, ".coef and .npz"),
        (["harmonics", "a.coef", "--surface", "a.ply", "--to", "ico:77"], 64, "--to"),
        (["harmonics", "a.npz", "--data", "short.npz"], 2, "give data of this mesh"),
        (["harmonics", "a.npz", "--data", "short.npz:none"], 2, "no map 'none'"),
        (["harmonics", "a.npz", "--data", "missing.npz"], 74, "can't read"),
        (["grid", "a.jpg"], 64, ".png, .npz or .npy"),
        (["grid", "a.png"], 64, "8 bits of each position"),
        (["grid", "a.npz", "--rows", "0"], 64, "--rows: 0 is out of range"),
    ],
)
def test_failures_are_one_line(sphere, tmp_path, monkeypatch, capsys, words, status, sentence):
    monkeypatch.chdir(tmp_path)
    write_scalars("short.npz", {"height": V[:9, 2]})
    assert main([words[0], SOURCE, sphere, *words[1:]]) == status
    err = capsys.readouterr().err
    assert sentence in err
    assert err.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["short.npz"]


def test_a_folded_sphere_is_refused(sphere, tmp_path, capsys):
    x = read_mesh(sphere).v.copy()
    x[[10, 20]] = x[[20, 10]]
    write_mesh(tmp_path / "folded.obj", x, F)
    assert main(["harmonics", SOURCE, str(tmp_path / "folded.obj"), str(tmp_path / "a.coef")]) == 3
    assert "flipped faces" in capsys.readouterr().err
