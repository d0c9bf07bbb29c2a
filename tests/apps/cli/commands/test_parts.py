"""--parts: each closed part of a file is a surface of its own, for `info`, `batch`, and by its name for any command."""

import json
from pathlib import Path

import numpy as np
import pytest
from shell import read_table

import igl_spheremap as ism
from igl_spheremap.apps.cli import main
from igl_spheremap.apps.cli.exits import Exit

SHAPES = [
    ism.samples.make("spheroid", n_vertices=n, aspect=aspect)
    for n, aspect in ((100, 1.5), (200, 2), (150, 2.5))
]
CUP = (SHAPES[0][0], SHAPES[0][1][1:])


def together(meshes, rng):
    """One mesh of several, whose faces and vertices are in any order; with the parts in the order of their faces."""
    v, f, part, start = [], [], [], 0
    for k, (own, faces) in enumerate(meshes):
        v.append(own + 9 * k)
        f.append(faces + start)
        part += [k] * len(faces)
        start += len(own)
    v, f, order = np.concatenate(v), np.concatenate(f), rng.permutation(len(part))
    turn = rng.permutation(start)
    v[turn], f = v.copy(), turn[f[order]]
    return v, f, list(dict.fromkeys(np.array(part)[order].tolist()))


@pytest.fixture
def cells(tmp_path, monkeypatch):
    """A file of three bodies and a cup, and the bodies in the order in which the file has them."""
    monkeypatch.chdir(tmp_path)
    v, f, order = together([*SHAPES, CUP], np.random.default_rng(0))
    ism.write_mesh("cells.obj", v, f)
    return [k for k in order if k < len(SHAPES)]


def test_every_part_is_a_row_and_its_map_is_that_of_the_part_alone(cells):
    words = [
        "batch",
        "cells.obj",
        "--parts",
        "--out",
        "out/{stem}.obj",
        "--jobs",
        "1",
        "--summary",
        "all.tsv",
        "-q",
    ]
    assert main(words) == Exit.OK
    rows = read_table("all.tsv")
    assert [row.source for row in rows] == [f"cells.obj:{k}" for k in range(3)]
    assert [row.vertices for row in rows] == [len(SHAPES[k][0]) for k in cells]
    assert sorted(path.name for path in Path("out").glob("*.obj")) == [
        f"cells_{k}.obj" for k in range(3)
    ]
    for k in range(3):
        part = ism.read_mesh(f"cells.obj:{k}")
        assert sorted(map(tuple, part.v)) == sorted(map(tuple, SHAPES[cells[k]][0] + 9 * cells[k]))
        alone = ism.spherical_conformal_map(part, polish=None)
        assert np.array_equal(ism.read_mesh(f"out/cells_{k}.obj").v, alone.sphere)
    assert main(words) == Exit.OK
    assert all(row.resumed for row in read_table("all.tsv"))


def test_info_measures_each_part(cells, capsys):
    assert main(["info", "cells.obj", "--parts"]) == Exit.OK
    assert "3 closed ones, 3 of which can be mapped to the sphere" in capsys.readouterr().out
    assert main(["info", "cells.obj", "--parts", "--json", "-"]) == Exit.OK
    parts = json.loads(capsys.readouterr().out)["parts"]
    assert [part["vertices"] for part in parts] == [len(SHAPES[k][0]) for k in cells]
    assert main(["info", "cells.obj:3"]) == Exit.NO_MESH
    assert (
        "3 parts of it are closed, numbered from 0; there is no part 3" in capsys.readouterr().err
    )


def test_a_file_without_closed_parts_has_a_row_that_says_so(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    ism.write_mesh("cup.obj", *CUP)
    words = ["--parts", "--out", "{stem}.ply", "--jobs", "1", "--summary", "all.tsv", "-q"]
    assert main(["batch", "cup.obj", "none.obj", *words]) == Exit.FILE
    assert [(row.source, row.status) for row in read_table("all.tsv")] == [
        ("cup.obj", "no mesh"),
        ("none.obj", "file"),
    ]


def test_another_part_under_the_same_name_is_mapped_anew(cells):
    for k, resumed in ((0, False), (1, False), (1, True)):
        (row,) = ism.map_many([f"cells.obj:{k}"], "one.obj", force=True)
        assert (row.vertices, row.resumed) == (len(SHAPES[cells[k]][0]), resumed)


def test_faces_with_a_repeated_index_open_no_part(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    v, f, _ = together(SHAPES, np.random.default_rng(1))
    ism.write_mesh("cells.obj", v, np.concatenate((f, f[:5, [0, 0, 1]])))
    words = ["--parts", "--out", "{stem}.ply", "--jobs", "1", "-q"]
    assert main(["batch", "cells.obj", *words]) == Exit.NO_MESH
    assert main(["batch", "cells.obj", *words, "--repair"]) == Exit.OK
    assert len(list(Path().glob("cells_*.ply"))) == 3
