"""Shape models of small bodies: the layouts that archives describe."""

from __future__ import annotations

import numpy as np
import pytest

import igl_spheremap as ism

V, F = ism.samples.make("spheroid", n_vertices=162)


def lines(*tables):
    """Tables of whole and other numbers as text, a line a row."""
    return "".join(" ".join(f"{x:10}" for x in row) + "\n" for table in tables for row in table)


def numbered(rows, first=1):
    return [[k, *row] for k, row in enumerate(rows, first)]


@pytest.mark.parametrize(
    ("name", "tables"),
    [
        (
            "count_before_each.tab",
            ([[len(V)]], numbered(V.tolist()), [[len(F)]], numbered((F + 1).tolist())),
        ),
        ("counts_first.tab", ([[len(V), len(F)]], V.tolist(), (F + 1).tolist())),
        ("from_zero.tab", ([[len(V), len(F)]], V.tolist(), F.tolist())),
        (
            "numbered_from_zero.tab",
            ([[len(V)]], numbered(V.tolist(), 0), [[len(F)]], numbered(F.tolist(), 0)),
        ),
        (
            "thomas.ver",
            (
                [[len(V), len(F)]],
                V.tolist(),
                [row for each in (F + 1).tolist() for row in ([3], each)],
            ),
        ),
        (
            "letters.tab",
            ([["v", *row] for row in V.tolist()], [["f", *row] for row in (F + 1).tolist()]),
        ),
    ],
)
def test_tables_of_plates(name, tables, tmp_path):
    (tmp_path / name).write_text(lines(*tables))
    mesh = ism.read_mesh(tmp_path / name)
    assert np.array_equal(mesh.v, V)
    assert np.array_equal(mesh.f, F)


def test_what_is_written_reads_back(tmp_path):
    ism.write_mesh(tmp_path / "a.tab", V, F)
    mesh = ism.read_mesh(tmp_path / "a.tab")
    assert np.array_equal(mesh.v, V)
    assert np.array_equal(mesh.f, F)
    assert (tmp_path / "a.tab").read_text().splitlines()[len(V) + 1] == str(len(F))


@pytest.mark.parametrize("name", ["a.ver", "a.ICQ"])
def test_layouts_that_are_only_read_are_not_written_under_their_names(name, tmp_path):
    with pytest.raises(ism.FileError, match=r"are read only; write \.tab$"):
        ism.write_mesh(tmp_path / name, V, F)
    assert not any(tmp_path.iterdir())


def grids(q):
    """Points of six faces of a cube, in the order and directions of ICQ (J runs towards negative y on the first)."""
    s = np.linspace(-1, 1, q + 1)
    j, i = (each.ravel() for each in np.meshgrid(s, s, indexing="ij"))
    one = np.ones_like(i)
    return np.concatenate(
        [
            np.column_stack(each)
            for each in (
                (i, -j, one),
                (i, -one, -j),
                (-one, -i, -j),
                (-i, one, -j),
                (one, i, -j),
                (i, j, -one),
            )
        ]
    )


@pytest.mark.parametrize("q", [1, 2, 8])
def test_grids_of_icq_meet_along_the_edges_of_a_cube(q, tmp_path):
    (tmp_path / "cube.icq").write_text(lines([[q]], grids(q).tolist()))
    mesh = ism.read_mesh(tmp_path / "cube.icq")
    assert len(mesh.v) == 6 * q * q + 2
    assert len(mesh.f) == 12 * q * q
    info = ism.info(mesh)
    assert info.quality.volume == pytest.approx(8)
    assert info.quality.area == pytest.approx(24)
    ism.check_mesh(mesh)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("5\n1 0 0 0\n", "cut off"),
        (
            lines([[4, 4]], V[:4].tolist(), (F[:3] + 1).tolist()),
            "3 lines follow where 4 plates are announced",
        ),
        (
            lines([[1]], np.roll(grids(1), 1, axis=0).tolist()),
            "do not meet along the edges of a cube",
        ),
        ("4 x\n", "whole numbers"),
        ("# a comment alone\n", "cut off"),
    ],
)
def test_the_fault_of_a_model_is_named(text, words, tmp_path):
    (tmp_path / "a.tab").write_text(text)
    with pytest.raises(ism.MeshError, match=words):
        ism.read_mesh(tmp_path / "a.tab")
