"""The benchmarks run: each has a name, a line on its measure, and calls existing functions."""

import csv
import subprocess
import sys

import numpy as np
import pytest
from corpus import ROOT
from disks import half

import igl_spheremap as ism
from igl_spheremap.plane.plane_map import in_space

pytestmark = pytest.mark.skipif(
    not (ROOT / "benchmarks").exists(), reason="the benchmarks are not installed"
)


def benchmark(*words):
    """The output of a benchmark."""
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks", *words], cwd=ROOT, capture_output=True, text=True
    )
    if "No module named" in done.stderr:
        pytest.skip(done.stderr.splitlines()[-1])
    assert done.returncode == 0, done.stderr
    return done.stdout


def names():
    return [line.split()[0] for line in benchmark("--list").splitlines()]


def test_the_list_says_what_each_measures():
    lines = benchmark("--list").splitlines()
    assert len(lines) > 5
    assert all(len(line.split()) > 4 for line in lines)
    assert {line.split()[0] for line in lines} <= {
        path.stem for path in (ROOT / "benchmarks").glob("*.py")
    }


OPTIONS = (
    "balanced_maps",
    "convergence",
    "cortices",
    "disks",
    "factors",
    "gather",
    "groups",
    "individual",
    "judge",
    "mindboggle",
    "paper",
    "peers",
    "permutations",
    "phases",
    "player",
    "random_meshes",
    "readings",
    "repairs",
    "scaling",
    "shapes",
    "solids",
    "versions",
)


#: Starts benchmarks, one after the other; one that needs a package which is not there is left out.
STARTS = """
import sys
from importlib import import_module
from benchmarks.__main__ import main
for name, *words in {!r}:
    try:
        main([name, *words]) if words else import_module(f"benchmarks.{{name}}")
    except ModuleNotFoundError as error:
        assert "igl_spheremap" not in error.name, error
        print(f"python -m benchmarks {{name}}: {{error}}")
    except SystemExit as end:
        assert not end.code, name
"""


def test_every_benchmark_with_options_explains_them_and_the_others_find_what_they_import():
    others = ["population", "throughput"]
    assert {*OPTIONS, *others} <= set(names())
    code = STARTS.format([*([name, "--help"] for name in OPTIONS), *([name] for name in others)])
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert [name for name in OPTIONS if f"python -m benchmarks {name}" not in done.stdout] == []


def test_a_level_of_scaling_is_a_row_of_figures():
    assert "| 0 | yes |" in benchmark(
        "scaling", "map", "sample:spheroid:n_vertices=500", "--levels", "0"
    )


def test_two_of_the_readings_are_the_paper_as_printed_and_as_programmed():
    code = """
import sys
sys.path.insert(0, "tests")
import numpy as np
import igl_spheremap as ism
from benchmarks.readings import WAYS, course
v, f = ism.samples.make("spheroid", n_vertices=500)
for name, method in (("H = L F / A, L2, area 1", ism.Lai2014.as_printed(max_iterations=40)),
                     ("H = L F, Frobenius", ism.Lai2014.as_programmed(max_iterations=40))):
    seen = []
    ism.algorithm_1(v, f, method=method, listener=lambda it: it.stage == "harmonic" and seen.append(it.energy))
    assert len(seen) == 41
    assert np.allclose(course(v, f, WAYS[name])[:41, 0], seen, rtol=1e-9), name
"""
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_parts_are_listed_once_and_no_wheel_has_parts_of_both_sets():
    with (ROOT / "benchmarks" / "parts.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len({row["sha256"] for row in rows}) == len(rows)
    sets = {
        name: {row["wheel"] for row in rows if row["set"] == name}
        for name in ("tune", "test", "judge")
    }
    assert set.union(*sets.values()) == {row["wheel"] for row in rows}
    assert not sets["tune"] & (sets["test"] | sets["judge"])


def test_rows_of_the_papers_settings_are_kept_so_that_a_second_call_goes_on(tmp_path):
    folder, file = tmp_path / "eggs", tmp_path / "rows.csv"
    folder.mkdir()
    ism.write_mesh(folder / "egg.obj", *ism.samples.make("spheroid", n_vertices=900))
    words = ("paper", str(folder), "--csv", str(file), "--settings")
    assert "| eggs | auto | 1 | 0 | 0; 0 |" in benchmark(*words, "auto")
    file.write_text(file.read_text().replace(",auto,0,", ",auto,7,"))
    printed = benchmark(*words, "auto", "Lai2014()")
    assert "| eggs | auto | 1 | 1 | 0; 0 |" in printed
    assert "| eggs | Lai2014() | 1 | 0 | 0; 0 | 1; 0; 0; 0 |" in printed


def test_a_part_that_a_manifest_lists_is_found_in_its_wheel(tmp_path):
    """Two components of an OBJ file in a wheel: the second is the one that is listed."""
    code = f"""
import sys
sys.path.insert(0, "tests")
from pathlib import Path
import numpy as np
import igl_spheremap as ism
from benchmarks.gather import components_of, digest
(v, f), (w, g) = ism.samples.sphere(42), ism.samples.sphere(162)
path = Path({str(tmp_path)!r}) / "two.obj"
ism.write_mesh(path, np.vstack((v, w + 3)), np.vstack((f, g + len(v))))
first, second = components_of(path)
assert digest(*second) == digest(w + 3, g) != digest(*first)
print("found")
"""
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.stdout == "found\n", done.stderr


def test_a_subject_gets_its_own_labels_from_its_turned_copy(tmp_path):
    """Files as Mindboggle-101 has them; and another one's labels do not fit as well."""
    code = f"""
from pathlib import Path
import numpy as np
import igl_spheremap as ism
from benchmarks.mindboggle import _FILE, write_labels
v, f = ism.samples.make("pear", n_vertices=600)
v = v + 0.1 * np.sin(4 * v[:, [1, 2, 0]] + [0, 1, 2])
labels = np.digitize(v[:, 2], np.quantile(v[:, 2], [0.2, 0.4, 0.6, 0.8])) - 1
for side in ("lh", "rh"):
    folder = Path({str(tmp_path)!r})
    write_labels(folder / "one" / _FILE.format(side), v, f, labels)
    write_labels(folder / "two" / _FILE.format(side), v[:, [1, 2, 0]], f, labels if side == "lh" else labels[::-1])
"""
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    benchmark("mindboggle", str(tmp_path), "--out", str(tmp_path / "figures.csv"))
    with (tmp_path / "figures.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["source"] for row in rows] == ["one", "two"] * 2
    assert all(
        (float(row["agree"]) > 0.98 and float(row["dice"]) > 0.98) == (row["side"] == "lh")
        for row in rows
    )
    assert {row["folded"] for row in rows} == {"0"}


def test_the_judge_says_what_is_wrong_with_each_map(tmp_path):
    """A ball's map to itself is an isometry; beside it all that may be wrong with a file."""
    (x, f), other = ism.samples.sphere(162), ism.samples.sphere(42)
    folded, bad, (flat, g, _) = x.copy(), x.copy(), half(x, f)
    folded[[3, 90]] = x[[90, 3]]
    bad[7] = np.nan
    maps = {
        "right": (5 * x, f),
        "folded": (folded, f),
        "mirrored": (x * [-1, 1, 1], f),
        "empty": (bad, f),
        "aside": (x + 3, f),
        "another": other,
        "onto": (x, f),
        "disk": (in_space(flat[:, :2]), g),
    }
    meshes, theirs = tmp_path / "meshes", tmp_path / "theirs"
    meshes.mkdir()
    theirs.mkdir()
    for name in (*maps, "missing"):
        ism.write_mesh(meshes / f"{name}.obj", *(flat, g) if name == "disk" else (2 * x, f))
    ism.write_mesh(meshes / "onto.target.obj", x, f)
    for name, (positions, faces) in maps.items():
        ism.write_mesh(theirs / f"{name}.sphere.off", positions, faces)
    (theirs / "right.sphere.off").unlink()
    np.save(theirs / "right.npy", 5 * x)
    (theirs / "times.tsv").write_text("right\t0.5\nmissing\t\tit gave up\n")
    words = "--meshes", meshes, "--table", tmp_path / "table.tsv", "--page", tmp_path / "page.html"
    assert "| theirs | 1 of 7 |" in benchmark("judge", *map(str, (theirs, *words)))
    assert "theirs" in (tmp_path / "page.html").read_text()
    with (tmp_path / "table.tsv").open(newline="") as file:
        rows = {row["mesh"]: row for row in csv.DictReader(file, delimiter="\t")}
    assert {name: row["verdict"] for name, row in rows.items()} == {
        "right": "certified",
        "folded": "folded",
        "mirrored": "mirrored",
        "empty": "not finite",
        "aside": "folded",
        "another": "another mesh",
        "onto": "certified",
        "disk": "certified",
        "missing": "missing",
    }
    assert int(rows["folded"]["folds"]) == ism.certify(folded, f).foldings
    assert [rows[name]["degree"] for name in ("right", "mirrored", "aside")] == ["1", "-1", "0"]
    assert all(float(rows["right"][measure]) < 1e-6 for measure in ("angle", "area", "edge"))
    assert [rows["right"]["seconds"], rows["missing"]["note"]] == ["0.5", "it gave up"]
    assert "42 vertices" in rows["another"]["note"]


def test_published_maps_are_judged_on_their_own_numbers(tmp_path, monkeypatch):
    """A sphere as it is, mirrored, of another radius, with rounded radii and folded, a flat part, and what is none."""
    monkeypatch.syspath_prepend(str(ROOT))
    from benchmarks import judge_published

    place = tmp_path / "me+mine"
    place.mkdir()
    x, f = ism.samples.sphere(162)
    folded = x.copy()
    folded[0] = -x[0]
    meshes = {
        "same": (x, f),
        "mirrored": (100 * x * [-1, 1, 1], f),
        "rounded": (x.round(4), f),
        "folded": (folded, f),
        "open": (x, f[1:]),
        "flat": (half(x, f)[0] * [1, 1, 0], half(x, f)[1]),
    }
    for name, mesh in meshes.items():
        ism.write_mesh(place / f"{name}.ply", *mesh)
    rows = [
        f"{name},me/mine,,{name}.ply,,{'plane' if name == 'flat' else 'sphere'}"
        for name in [*meshes, "missing"]
    ]
    (tmp_path / "rows.csv").write_text("\n".join(["whose,source,commit,path,surface,kind", *rows]))
    monkeypatch.setattr(judge_published, "MANIFEST", tmp_path / "rows.csv")
    clones = tmp_path / "clones" / "me+mine" / "repo"
    clones.mkdir(parents=True)
    found = {
        row["from"]: row for row in judge_published.judge_published(tmp_path, clones.parents[1])
    }
    assert found["same"]["verdict"] == found["flat"]["verdict"] == "homeomorphism"
    assert found["mirrored"]["verdict"] == "homeomorphism, mirrored"
    assert (found["mirrored"]["radius"], found["mirrored"]["degree"]) == ("100", "-1")
    assert found["rounded"]["verdict"].startswith(
        "homeomorphism, once scaled to the sphere: radii vary by "
    )
    assert found["folded"]["verdict"] == "folded"
    assert found["folded"]["folded faces"] == str(ism.certify(folded, f).foldings)
    assert "open surface" in found["open"]["verdict"]
    assert "not to be had" in found["missing"]["verdict"]
    assert len(judge_published.by_verdict([*found.values()])) == 1 + len(rows)
