"""Scalar maps over the vertices: written files read back, others are named."""

from __future__ import annotations

import re

import numpy as np
import pytest
from file_names import NAMED, PLACED, needs
from hypothesis import example, given, settings
from hypothesis import strategies as st

from igl_spheremap import FileError, MeshError
from igl_spheremap.io.scalars import read_scalars, write_scalars
from igl_spheremap.io.write_mesh import write_mesh
from igl_spheremap.samples import sphere
from igl_spheremap.verify.distortion import vertex_maps

VALUES = np.random.default_rng(0).normal(size=42)


@pytest.mark.parametrize("name", ["a.npz", "a.shape.gii", "a.gii.gz", *NAMED, *PLACED])
def test_maps_read_back_by_name_or_place(tmp_path, name):
    needs(name)
    write_scalars(tmp_path / name, {"sulc": VALUES, "curv": -VALUES}, surface=sphere(42))
    maps = read_scalars(tmp_path / name)
    assert list(maps) == (["0", "1"] if name in PLACED else ["sulc", "curv"])
    first, second = maps.values()
    assert np.array_equal(second, -first)
    assert np.abs(first - VALUES).max() <= (1e-7 if ".gii" in name else 0) * np.abs(VALUES).max()


@pytest.mark.parametrize("name", [*NAMED, *PLACED])
def test_labels_and_single_maps_read_back(tmp_path, name):
    keys = np.arange(42) % 5 - 1
    write_scalars(tmp_path / name, {"parts": keys}, surface=sphere(42), metadata={"labels": ()})
    (values,) = read_scalars(tmp_path / name).values()
    assert np.array_equal(values, keys)


def test_arrays_of_other_programs(tmp_path):
    """By NumPy, and tables as spreadsheets, pandas and AFNI write them."""
    np.save(tmp_path / "a.npy", VALUES.astype("f4")[:, None])
    assert np.array_equal(read_scalars(tmp_path / "a.npy")["0"], VALUES.astype("f4"))
    np.savetxt(
        tmp_path / "a.1D",
        np.column_stack([np.arange(42), VALUES]),
        header="node value",
        fmt="%.17g",
    )
    assert np.array_equal(read_scalars(tmp_path / "a.1D")["1"], VALUES)
    np.savetxt(tmp_path / "row.txt", VALUES[None], delimiter=",", fmt="%.17g")
    assert np.array_equal(read_scalars(tmp_path / "row.txt")["0"], VALUES)
    lines = [f"{k};V{k};{x!r}" for k, x in enumerate(VALUES.tolist())]
    (tmp_path / "a.csv").write_bytes(
        b'\xef\xbb\xbf;area;"mean; depth"\r\n' + "\r\n".join(lines).encode()
    )
    maps = read_scalars(tmp_path / "a.csv")
    assert list(maps) == ["0", "mean; depth"]
    assert np.array_equal(maps["mean; depth"], VALUES)
    write_scalars(tmp_path / "b.npy", {"depth": VALUES})
    assert np.array_equal(np.load(tmp_path / "b.npy"), VALUES)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        (
            "a.csv",
            b"depth\n1\nx\n",
            "line 3 reads 'x' in column 'depth' where a number is expected",
        ),
        ("a.txt", b"# made\n1\n2_0\n", "line 3 reads '2_0' in column '0'"),
        ("a.tsv", b"a\tb\n1\t2\n\n3\n", "line 4 has 1 fields where line 1 has 2"),
        ("a.csv", b"a,a\n1,2\n3,4\n", "two columns are called 'a'"),
        ("a.csv", b"area\n", "no scalar map"),
        ("a.txt", b"# nothing\n", "no numbers"),
        ("a.txt", b"1 2 3\n4 5 6\n", "2 lines of 3 fields; give one line a vertex"),
        ("lh.sphere", b"\xff\xff\xfesurface", "no data over vertices"),
        ("lh.depth", b"1 2 3", "no data over vertices"),
        (
            "a.xlsx",
            b"PK",
            "unknown format of data; the end of the name decides: PLY (.ply), VTK (.vtk), VTK XML",
        ),
    ],
)
def test_what_is_no_data_is_named_in_a_line(tmp_path, name, content, message):
    (tmp_path / name).write_bytes(content)
    with pytest.raises((MeshError, FileError), match=re.escape(message)) as caught:
        read_scalars(tmp_path / name)
    assert str(tmp_path / name) in str(caught.value)
    assert "\n" not in str(caught.value)


#: Words that a format could take for something else.
WORDS = [
    "0",
    "2020",
    "nan",
    "-inf",
    "1_0",
    "=1+1",
    "'=1+1",
    "'1",
    "+a",
    "#a",
    "a;b",
    "a\tb",
    "a,b",
    'a"b',
    '"',
    "x.npy",
    "file",
    "mark",
    "label_table",
    "allow_pickle",
    "a/b",
    "]]>",
    "&amp;",
    "%41",
    "\u00e9a",
    "\u200da",
    "x",
    "px",
    " a",
    "",
    "\n",
]
NAMES = st.lists(st.sampled_from(WORDS) | st.text(max_size=4), min_size=1, max_size=3, unique=True)


@pytest.mark.parametrize("name", ["a.npz", "a.shape.gii", *NAMED, *PLACED])
def test_a_name_comes_back_or_is_refused(tmp_path, name):
    """By its place where a format has no names, and in its letters where it has others."""
    needs(name)
    v, f = sphere(12)

    @settings(max_examples=40, deadline=None)
    @example(["NRRD"])  # begins as a file of another format
    @example(["ObjectType"])
    @given(NAMES)
    def check(names):
        maps = {each: np.arange(12.0) * (k + 1) for k, each in enumerate(names)}
        try:
            write_scalars(tmp_path / name, maps, surface=(v, f), force=True)
        except FileError:
            assert (
                any(each.strip() != each or not each or not each.isprintable() for each in names)
                or name in OTHERS
            )
            return
        found = read_scalars(tmp_path / name)
        assert len(found) == len(maps)
        assert list(found) == names or name in (*PLACED, *OTHERS)
        assert all(np.array_equal(a, b) for a, b in zip(found.values(), maps.values(), strict=True))

    check()


OTHERS = ("data.ply",)


def test_a_header_is_no_formula(tmp_path):
    write_scalars(tmp_path / "a.csv", {"=HYPERLINK(1)": VALUES, "2020": VALUES})
    assert (tmp_path / "a.csv").read_text().splitlines()[0] == "'=HYPERLINK(1),'2020"


def test_data_in_names_that_a_format_has_taken(tmp_path):
    with pytest.raises(FileError, match="can't hold data called x"):
        write_scalars(tmp_path / "a.ply", {"x": VALUES}, surface=sphere(42))
    with pytest.raises(FileError, match="with their surface"):
        write_scalars(tmp_path / "a.vtk", {"a": VALUES})
    assert list(tmp_path.iterdir()) == []


def test_freesurfer_files_are_named_by_their_ends(tmp_path):
    pytest.importorskip("nibabel")
    write_scalars(tmp_path / "lh.sulc", {"sulc": VALUES})
    assert np.allclose(read_scalars(tmp_path / "lh.sulc")["sulc"], VALUES, atol=1e-6)


def test_what_is_no_map_is_named(tmp_path):
    with pytest.raises(FileError, match="can't read"):
        read_scalars(tmp_path / "missing.npz")
    write_mesh(tmp_path / "mesh.npz", *sphere(42))
    with pytest.raises(MeshError, match="no scalar map"):
        read_scalars(tmp_path / "mesh.npz")
    (tmp_path / "damaged.npz").write_bytes(b"nothing")
    with pytest.raises(MeshError, match="damaged"):
        read_scalars(tmp_path / "damaged.npz")


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
    with pytest.raises(FileError, match="unknown format of data"):
        write_scalars(tmp_path / "a.xlsx", maps)
