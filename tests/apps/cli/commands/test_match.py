"""The command match: its files, and its failures."""

import json

import numpy as np
import pytest
from drawing import needs_drawing

import igl_spheremap as ism
from igl_spheremap.apps.cli import main
from igl_spheremap.io.files import read_mesh

A, B = "sample:pear:n_vertices=200", "sample:spheroid:n_vertices=250"


@pytest.fixture
def landmarks(tmp_path):
    """Corresponding vertices of A and B as lists, and one of another length."""
    for name, vertices in (
        ("a.vts", (3, 150)),
        ("b.vts", (5, 200)),
        ("short.vts", (1,)),
        ("far.vts", (1, 9000)),
    ):
        (tmp_path / name).write_text("".join(f"{vertex}\n" for vertex in vertices))
    return lambda a, b: ["--landmarks", str(tmp_path / a), str(tmp_path / b)]


@pytest.fixture(scope="module")
def matched(tmp_path_factory):
    """The whole map from A to B, its overlay on both, and its figures."""
    path = tmp_path_factory.mktemp("matched")
    out, on_source, on_target, figures = (
        str(path / name) for name in ("whole.npz", "a.ply", "b.ply", "figures.json")
    )
    assert (
        main(["match", A, B, out, "--overlay", on_source, on_target, "--json", figures, "-q"]) == 0
    )
    return path


def test_the_overlay_lies_on_both(matched):
    pieces = read_mesh(matched / "a.ply"), read_mesh(matched / "b.ply")
    assert np.array_equal(pieces[0].f, pieces[1].f)
    v, _ = ism.samples.make("pear", n_vertices=200)
    assert np.allclose(pieces[0].v[: len(v)], v, atol=1e-6)
    report = json.loads((matched / "figures.json").read_text())
    assert report["certificate"]["folding_free"]
    assert report["distortion"]["over_source"]["symmetric_dirichlet"]["median"] >= 4


def test_an_archive_holds_the_whole_map_and_its_map_is_not_made_again(
    matched, tmp_path, monkeypatch
):
    whole, again = str(matched / "whole.npz"), str(tmp_path / "again.ply")
    onto = ism.shapes.read_surface_map(whole)
    assert len(onto.positions) == len(onto.map.vertices)
    made = []
    monkeypatch.setattr(
        "igl_spheremap.apps.cli.inputs.balanced_spherical_map",
        lambda *args, **options: made.append(args) or ism.balanced_spherical_map(*args, **options),
    )
    assert main(["match", whole, B, again, "-q"]) == 0
    assert [len(v) for v, _ in made] == [len(onto.target.vertices)]
    found, (b, _) = read_mesh(again), ism.samples.make("spheroid", n_vertices=250)
    assert np.array_equal(found.f, onto.map.faces)  # B lies on the connectivity of A
    assert np.ptp(found.v, axis=0) == pytest.approx(np.ptp(b, axis=0), rel=0.1)


@pytest.mark.parametrize(("lists", "words"), [
    (("a.vts", "short.vts"), "give lists of the same landmarks"), (("a.vts", "far.vts"), "names vertex 9000"),
    (("a.vts", "missing.vts"), "missing.vts"),
])  # fmt: skip
def test_lists_that_do_not_fit_are_named(lists, words, landmarks, tmp_path, capsys):
    assert main(["match", A, B, str(tmp_path / "out.ply"), *landmarks(*lists)]) != 0
    out, err = capsys.readouterr()
    assert out == ""
    assert words in err
    assert err.count("\n") == 1
    assert not (tmp_path / "out.ply").exists()


def test_landmarks_are_met_and_those_that_contradict_each_other_are_named(
    landmarks, tmp_path, capsys
):
    whole = str(tmp_path / "whole.npz")
    assert main(["match", A, A, whole, *landmarks("a.vts", "a.vts"), "-q"]) == 0
    assert ism.shapes.read_surface_map(whole).landmark_errors.max() == 0
    face = ism.samples.make("pear", n_vertices=100)[1][0]
    for name, vertices in (("face.vts", face), ("reversed.vts", face[::-1])):
        (tmp_path / name).write_text("".join(f"{vertex}\n" for vertex in vertices))
    small = "sample:pear:n_vertices=100"
    words = [
        "match",
        small,
        small,
        str(tmp_path / "out.ply"),
        *landmarks("face.vts", "reversed.vts"),
        "-q",
    ]
    assert main(words) == 70
    assert "--soft" in capsys.readouterr().err
    assert not (tmp_path / "out.ply").exists()
    assert main([*words, "--soft"]) == 0


def test_curves_are_lists_of_any_lengths(landmarks, tmp_path, capsys):
    f, g = (
        ism.samples.make(name, n_vertices=n)[1] for name, n in (("pear", 200), ("spheroid", 250))
    )
    for name, vertices in (("ridge.vts", f[0, :2]), ("other.vts", g[0])):
        (tmp_path / name).write_text("".join(f"{vertex}\n" for vertex in vertices))
    whole, lists = (
        str(tmp_path / "whole.npz"),
        [str(tmp_path / name) for name in ("ridge.vts", "other.vts")],
    )
    assert main(["match", A, B, whole, "--curve", *lists, "-q"]) == 0
    onto = ism.shapes.read_surface_map(whole)
    assert np.array_equal(onto.landmarks, f[0, :2])
    assert onto.landmark_errors.max() < 1e-12
    assert (
        main(["match", A, B, whole, "-f", "--curve", lists[0], str(tmp_path / "missing.vts")]) != 0
    )
    assert "missing.vts" in capsys.readouterr().err


def test_files_are_repaired_where_that_is_asked_for(tmp_path, capsys):
    v, f = ism.samples.make("pear", n_vertices=200)
    holed, out = str(tmp_path / "holed.ply"), str(tmp_path / "out.ply")
    ism.write_mesh(holed, v, f[1:])
    assert main(["match", holed, B, out, "-q"]) == 2
    assert "--fill-holes" in capsys.readouterr().err
    assert main(["match", B, holed, out, "-q", "--fill-holes"]) == 0
    assert "repaired" in capsys.readouterr().err
    assert np.array_equal(read_mesh(out).f, ism.samples.make("spheroid", n_vertices=250)[1])


def test_what_can_t_be_done_is_said_before_the_work(tmp_path, capsys):
    assert (
        main(
            [
                "match",
                A,
                B,
                str(tmp_path / "out.ply"),
                "--overlay",
                str(tmp_path / "a.ply"),
                "b.foo",
            ]
        )
        == 74
    )
    assert "b.foo: unknown format" in capsys.readouterr().err
    assert main(["match", "-", "-", str(tmp_path / "out.ply")]) == 64
    assert "stdin is read once" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_no_input_is_overwritten(tmp_path, capsys):
    cat = str(tmp_path / "cat.ply")
    ism.write_mesh(cat, *ism.samples.make("pear", n_vertices=200))
    assert (
        main(
            [
                "match",
                cat,
                B,
                str(tmp_path / "out.ply"),
                "--overlay",
                cat,
                str(tmp_path / "b.ply"),
                "-f",
            ]
        )
        == 64
    )
    assert "would be lost" in capsys.readouterr().err


@needs_drawing
def test_it_draws_without_a_display(tmp_path):
    picture = tmp_path / "picture.png"
    assert (
        main(
            [
                "match",
                A,
                B,
                str(tmp_path / "out.ply"),
                "-q",
                "--colours",
                "distortion",
                "--screenshot",
                str(picture),
            ]
        )
        == 0
    )
    from PIL import Image

    pixels = np.asarray(Image.open(picture).convert("RGB"))
    columns = np.array_split(pixels, 3, axis=1)
    assert all((column.min(axis=2) < 250).mean() > 0.1 for column in columns)
