"""The command template: the files of a group, left-out surfaces, and added members."""

import csv
import importlib.util
import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from family import AMOUNTS, family, group_of

import igl_spheremap as ism
from igl_spheremap.apps.cli import main
from igl_spheremap.apps.cli.exits import Exit
from igl_spheremap.io.scalars import read_scalars
from igl_spheremap.mesh.measure import surface_area
from igl_spheremap.shapes.groups.design import read_design


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Four bodies, and one that is open."""
    path = tmp_path_factory.mktemp("bodies")
    for k, each in enumerate(family(AMOUNTS[:4], n=200)):
        ism.write_mesh(path / f"body{k}.ply", *each)
        np.save(path / f"body{k}.npy", np.full(len(each[0]), float(k)))
    v, f = ism.samples.make("spheroid", n_vertices=200)
    ism.write_mesh(path / "open.ply", v, f[1:])
    return path


@pytest.fixture(scope="module")
def group(folder):
    """The folder of the group of three: one of five bodies is excluded, and one rated fail."""
    out = folder / "group"
    shutil.copy(folder / "body3.ply", folder / "bad.ply")
    (folder / "ratings.tsv").write_text(
        f"source\tstatus\trating\tcomment\n{folder}/body0.ply\tcertified\tpass\t\n"
        f'{folder}/bad.ply\tcertified\tfail\t"\'=a ""hole"""\n'
    )
    words = [
        "template",
        f"{folder}/*.ply",
        "--out",
        str(out),
        "--to",
        "ico:1",
        "--modes",
        "2",
        "--balance",
        "0.9",
    ]
    words += ["--exclude", str(folder / "body3.ply"), "--ratings", str(folder / "ratings.tsv")]
    words += ["--feature", "height={folder}/{stem}.npy", "--json", str(folder / "g.json")]
    assert main([*words, "-q"]) == Exit.FAILED
    return out


def rows(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file, delimiter="\t"))


def test_the_folder_holds_the_group_in_several_formats(group, folder):
    found = ism.shapes.read_group(group)
    assert found.balance == 0.9
    assert repr(found).startswith("Group(3 members, 3 left out, 42 vertices, 2 modes")
    assert np.allclose(ism.read_mesh(group / "mean.ply").v, found.vertices)
    assert np.allclose(
        ism.read_mesh(group / "mean.vtk").metadata["point_data"]["mode_1"],
        found.modes[0] * np.sqrt(found.variances[0]),
    )
    table = rows(group / "members.tsv")
    assert [row["status"] for row in table] == ["member"] * 3 + ["left out"] * 3
    reasons = {Path(row["member"]).stem: row["reason"] for row in table[3:]}
    assert reasons["body3"] == "excluded by --exclude"
    assert reasons["bad"] == 'rated fail: =a "hole"'
    assert "open surface" in reasons["open"]
    means = read_scalars(group / "mean.ply")
    assert np.allclose((means["height"], means["height_sd"]), 1)
    if importlib.util.find_spec("nibabel"):
        gifti = read_scalars(group / "mean.shape.gii")
        assert gifti.keys() == means.keys()
        assert np.allclose(gifti["spread"], found.spread)
    assert [float(row["mode_1"]) for row in table[:3]] == found.scores[:, 0].tolist()
    assert ism.read_map(group / "members" / "body1.npz").certificate.folding_free
    page = (group / "index.html").read_text()
    cards = json.loads(page.partition('class="cards">')[2].partition("</script>")[0])["cards"]
    assert [card["row"]["status"] for card in cards] == ["left out"] * 3 + ["member"] * 3
    doubtful = {member.name for member in found.members if member.doubts}
    order = [
        (card["row"]["source"] not in doubtful, -card["row"]["distance"]) for card in cards[3:]
    ]
    assert order == sorted(order)
    assert all((group / card["picture"]).exists() for card in cards[3:])
    assert len(json.loads((folder / "g.json").read_text())["left_out"]) == 3


def test_what_is_added_changes_no_other_file(group, folder, capsys):
    before = {path: path.read_bytes() for path in group.rglob("*") if path.is_file()}
    assert main(["template", "--add", str(folder / "body3.ply"), "--out", str(group)]) == 0
    (folder / "other").mkdir()
    shutil.copy(folder / "body3.ply", folder / "other")
    again = [str(folder / "open.ply"), str(folder / "other" / "body3.ply")]
    assert main(["template", "--add", *again, "--out", str(group)]) == Exit.FAILED
    assert "left out" in capsys.readouterr().out
    assert all(path.read_bytes() == data for path, data in before.items())
    table = rows(group / "added.tsv")
    assert [row["status"] for row in table] == ["added", "left out", "added"]
    assert len([*(group / "added").glob("body3*.npz")]) == 2
    third = ism.balanced_spherical_map(ism.read_mesh(folder / "body3.ply"), balance=0.9)
    placed = ism.shapes.read_group(group).place(third)
    assert float(table[0]["mode_1"]) == placed.scores[0]
    assert ism.read_map(group / "added" / "body3.npz").certificate.folding_free


def test_a_table_of_variables_is_tested(group, tmp_path, capsys):
    table = tmp_path / "design.tsv"
    table.write_text("member\tage\nbody2\t3\nbody0\t1\nbody1\t2.5\n")
    assert (
        main(["template", "--design", str(table), "--out", str(group), "--permutations", "19"]) == 0
    )
    said = capsys.readouterr().out
    assert "age" in said
    assert "written" in said
    (row,) = rows(group / "tests.tsv")
    found = ism.shapes.permutation_test(ism.shapes.read_group(group), [1, 2.5, 3], permutations=19)
    assert float(row["smallest_p"]) == found.p.min()
    with np.load(group / "test_age.npz") as arrays:
        assert (arrays["statistic"] == found.statistic).all()
    # 3 members have 6 orders, of which that from last to first has the same F
    assert "no p is below" in said
    for _ in range(2):  # the second replaces the first
        page = (group / "index.html").read_text()
        assert page.count("<h3>age</h3>") == page.count("A unit of age more") == 1
        assert "effect of age; pale where p" in page
        assert "<h2>Members</h2>" in page
        assert main(["template", "--design", str(table), "--out", str(group), "-q"]) == 0


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("member\tage\nbody2\t3\n", "no whole row for"),
        ("member\tage\nbody0\t1\nbody0\t1\nbody1\t2\nbody2\t3\n", "2 rows for"),
        ("member\tage\tage\nbody0\t1\t1\nbody1\t2\t1\nbody2\t3\t5\n", "two columns 'age'"),
        (
            "member\tage\tmonths\nbody0\t1\t12\nbody1\t2\t24\nbody2\t4\t48\n",
            "column age: the variable is constant",
        ),
        (
            "member\tage\tsite\nbody0\t1\ta\nbody1\t2\ta\nbody2\t4\ta\n",
            "column site: the variable is 'a' for all",
        ),
        ("member\tage\tsite\nbody0\t1\ta\nbody1\t\ta\nbody2\tNA\ta\n", "1 of 3 members"),
    ],
)
def test_designs_that_can_not_be_tested_are_refused_by_name(group, tmp_path, capsys, text, says):
    (tmp_path / "design.tsv").write_text(text)
    assert (
        main(["template", "--design", str(tmp_path / "design.tsv"), "--out", str(group)])
        == Exit.NO_MESH
    )
    assert says in capsys.readouterr().err


def test_a_row_for_two_members_of_one_stem_is_refused(tmp_path):
    (tmp_path / "design.tsv").write_text("member\tage\none\t3\n")
    with pytest.raises(ism.MeshError, match="the row one fits a/one"):
        read_design(tmp_path / "design.tsv", ["a/one.ply", "b/one.ply"])


def test_members_with_missing_values_are_left_out_and_each_column_has_files(tmp_path, capsys):
    x, f = ism.samples.sphere(42)
    ism.shapes.write_group(
        tmp_path, group_of(x + 0.1 * np.random.default_rng(0).normal(size=(6, *x.shape)), f)
    )
    lines = [f"{k}\t{age}\t{age**2 % 7}\t{'ab'[k % 2]}" for k, age in enumerate((1, 5, 2, 4, 3))]
    long = 300 * "x"
    (tmp_path / "design.tsv").write_text(
        "\n".join([f"member\tage (y)\tage [y]\t{long}", *lines, "5\t8\tn/a\t"])
    )
    words = [
        "template",
        "--design",
        str(tmp_path / "design.tsv"),
        "--out",
        str(tmp_path),
        "--permutations",
        "19",
    ]
    assert main([*words, "--json", str(tmp_path / "found.json")]) == 0
    assert f"no age [y] and no {long[:20]}" in "".join(capsys.readouterr().out.split("\n")).replace(
        "  ", ""
    )
    found = json.loads((tmp_path / "found.json").read_text())
    assert {*found["left_out"]} == {"5"}
    assert [*found["tests"]] == ["age (y)", "age [y]", long]
    files = [row["file"] for row in rows(tmp_path / "tests.tsv")]
    assert files == ["test_age__y__1.npz", "test_age__y__2.npz", f"test_{long[:40]}.npz"]
    assert all((tmp_path / name).exists() for name in files)


def test_scores_and_features_are_tested(group, tmp_path, capsys):
    (tmp_path / "design.tsv").write_text("member\tage\nbody2\t3\nbody0\t1\nbody1\t2.5\n")
    words = [
        "template",
        "--design",
        str(tmp_path / "design.tsv"),
        "--out",
        str(group),
        "--permutations",
        "19",
    ]
    assert main([*words, "--of", "height"]) == 0
    with np.load(group / "test_age.npz") as arrays:
        found = ism.shapes.permutation_test(
            ism.shapes.read_group(group),
            [1, 2.5, 3],
            permutations=19,
            data=np.outer([0, 1, 2], np.ones(42)),
        )
        assert np.allclose(arrays["effect"], found.effect)
    assert main([*words, "--of", "scores"]) == 0
    with np.load(group / "test_age.npz") as arrays:
        assert arrays["p"].shape == (2,)
    assert main([*words, "--of", "weight"]) == Exit.NO_MESH
    assert "test shapes, scores, height" in capsys.readouterr().err


def test_a_series_is_written_in_the_order_of_its_numbers(tmp_path, capsys):
    for k, (v, f) in zip(
        (2, 10, 9), family(AMOUNTS[:1].repeat(3, axis=0), n=150, moved=False), strict=True
    ):
        ism.write_mesh(tmp_path / f"cell_{k}.ply", v * (1 + k / 10), f)
        np.save(tmp_path / f"cell_{k}.npy", np.full(len(v), float(k)))
    words = [
        "template",
        "--series",
        f"{tmp_path}/cell_*.ply",
        "--out",
        str(tmp_path / "out"),
        "--to",
        "ico:1",
    ]
    assert main([*words, "--feature", "age={folder}/{stem}.npy"]) == 0
    assert "drift" in capsys.readouterr().out
    table = rows(tmp_path / "out" / "frames.tsv")
    assert [Path(row["frame"]).stem for row in table] == ["cell_2", "cell_9", "cell_10"]
    assert np.allclose([float(row["age"]) for row in table], [2, 9, 10])
    bodies = [ism.read_mesh(row["frame"]) for row in table]
    assert np.allclose(
        [float(row["area"]) for row in table], [surface_area(each.v, each.f) for each in bodies]
    )
    with np.load(tmp_path / "out" / "series.npz") as arrays:
        assert np.allclose(
            ism.read_mesh(tmp_path / "out" / "frames" / "frame_0001.vtk").v, arrays["vertices"][1]
        )
        assert np.allclose(read_scalars(tmp_path / "out" / "mean.ply")["age"], 7)
        assert (read_scalars(tmp_path / "out" / "mean.vtk")["drift"] == arrays["drift"]).all()
    assert ism.read_map(tmp_path / "out" / "maps" / "cell_9.npz").certificate.folding_free
    with pytest.importorskip("PIL.Image").open(tmp_path / "out" / "frames.gif") as film:
        assert film.n_frames == 3
    assert "3 frames of one body" in (tmp_path / "out" / "index.html").read_text()
    assert main(words) == Exit.FILE


@pytest.mark.parametrize(
    ("words", "status", "says"),
    [
        ([], Exit.USAGE, "--add NEW"),
        (["{folder}/body0.ply", "--exclude", "other.ply"], Exit.USAGE, "--exclude other.ply"),
        (["{folder}/body*.ply"], Exit.FILE, "--force"),
        (["{folder}/body0.ply", "--feature", "{{stem}}.npy"], Exit.USAGE, "NAME=PATTERN"),
        (["{folder}/body0.ply", "--feature", "a={{steam}}.npy"], Exit.USAGE, "{stem}"),
        (
            ["{folder}/open.ply", "--ratings", "{folder}/ratings.tsv"],
            Exit.NO_MESH,
            "none of the 1 here",
        ),
        (["{folder}/body0.ply", "--to", "fsaverage5"], Exit.USAGE, "--to fsaverage5"),
        (["{folder}/body0.ply", "--out", "{folder}/body0.ply"], Exit.FILE, "can't make the folder"),
        (["--add", "a.ply", "--out", "{folder}"], Exit.FILE, "group.npz"),
        (
            ["{folder}/body0.ply", "--series", "--modes", "2", "--rigid"],
            Exit.USAGE,
            "takes no --modes and no --rigid",
        ),
        (["--add", "a.ply", "--rigid"], Exit.USAGE, "--add takes no --rigid"),
        (["--design", "a.tsv", "--to", "ico:2"], Exit.USAGE, "--design takes no --to"),
        (
            ["{folder}/body0.ply", "--permutations", "20"],
            Exit.USAGE,
            "a new group takes no --permutations",
        ),
    ],
)
def test_what_is_wrong_is_said_in_a_line(group, folder, capsys, words, status, says):
    words = [word.format(folder=folder) for word in words]
    assert main(["template", "--out", str(group), *words]) == status
    assert says in capsys.readouterr().err


def test_what_holds_no_group_is_refused(folder):
    ism.write_mesh(folder / "mesh.npz", *ism.samples.sphere(42))
    with pytest.raises(ism.MeshError, match="no group"):
        ism.shapes.read_group(folder / "mesh.npz")


def test_words_and_names_that_look_the_same_are_the_same(tmp_path):
    """A spreadsheet leaves spaces behind words; macOS decomposes accents in the names of files."""
    (tmp_path / "d.tsv").write_text(
        "member\tgroup \n\u00e4\tcontrol \nb\tcontrol\nc \t drug\n", encoding="utf-8"
    )
    design = read_design(tmp_path / "d.tsv", ["a\u0308.ply", "b.ply", "c.ply"])
    assert design.columns["group"].tolist() == ["control", "control", "drug"]
