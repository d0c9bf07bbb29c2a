"""Annotations: bit for bit, as nibabel reads and writes them, and between formats."""

from __future__ import annotations

import numpy as np
import pytest

from igl_spheremap import MeshError
from igl_spheremap.io.records import Label
from igl_spheremap.io.scalars import read_labels, read_scalars, write_scalars

TABLE = (
    Label(0, "unknown", (0.0, 0.0, 0.0, 0.0)),
    Label(1, "V1", (25 / 255, 5 / 255, 1.0, 1.0)),
    Label(2, "Großhirn", (1.0, 200 / 255, 3 / 255, 1.0)),
)
KEYS = np.random.default_rng(0).integers(0, 3, 162)


ANNOT, GIFTI, NPZ = "lh.a.annot", "lh.a.label.gii", "lh.a.npz"


@pytest.mark.parametrize(
    "chain",
    [(ANNOT, GIFTI, ANNOT), (ANNOT, NPZ, ANNOT), (GIFTI, NPZ, GIFTI), (GIFTI, ANNOT, GIFTI)],
)
def test_round_trips_are_bit_for_bit(chain, tmp_path):
    pytest.importorskip("nibabel")
    contents, maps, table = [], {"a": KEYS}, TABLE
    for name in chain:
        path = tmp_path / name
        write_scalars(path, maps, metadata={"labels": table, "structure": "CortexLeft"}, force=True)
        contents.append(path.read_bytes())
        maps, table = read_scalars(path), read_labels(path)
        assert np.array_equal(maps["a"], KEYS)
        assert table == TABLE
    assert contents[0] == contents[2]


def test_nibabel_reads_and_writes_the_same_bytes(tmp_path):
    freesurfer = pytest.importorskip("nibabel.freesurfer")
    write_scalars(tmp_path / "lh.a.annot", {"a": KEYS}, metadata={"labels": TABLE})
    keys, colours, names = freesurfer.read_annot(tmp_path / "lh.a.annot")
    # it takes black for no label, whatever the table says
    assert np.array_equal(keys, np.where(KEYS == 0, -1, KEYS))
    assert [name.decode() for name in names] == [label.name for label in TABLE]
    assert colours[:, :4].tolist() == [[0, 0, 0, 255], [25, 5, 255, 0], [255, 200, 3, 0]]
    freesurfer.write_annot(tmp_path / "lh.b.annot", keys, colours[:, :4], names)
    assert (tmp_path / "lh.b.annot").read_bytes() == (tmp_path / "lh.a.annot").read_bytes()


def test_files_of_older_programs(tmp_path):
    """The table without places, vertices in another order, a vertex without a label, and two labels of one colour."""
    rows = np.array([[2, 10], [0, 20], [1, 99], [3, 10]], dtype=">i4")
    words = [b"t\0", b"ten\0", b"twenty\0", b"also ten\0"]
    numbers = [
        np.array(row, dtype=">i4").tobytes()
        for row in ([10, 0, 0, 0], [20, 0, 0, 0], [10, 0, 0, 0])
    ]
    texts = [np.array(len(word), dtype=">i4").tobytes() + word for word in words]
    table = texts[0] + b"".join(
        text + number for text, number in zip(texts[1:], numbers, strict=True)
    )
    head = np.array([1, 3], dtype=">i4").tobytes()
    (tmp_path / "rh.old.style.annot").write_bytes(
        np.array(4, dtype=">i4").tobytes() + rows.tobytes() + head + table
    )
    ((name, keys),) = read_scalars(tmp_path / "rh.old.style.annot").items()
    assert name == "old.style"
    assert keys.tolist() == [1, -1, 0, 0]
    assert [label.name for label in read_labels(tmp_path / "rh.old.style.annot")] == [
        "ten",
        "twenty",
        "also ten",
    ]


def test_what_no_annotation_can_hold_is_named(tmp_path):
    path = tmp_path / "lh.a.annot"
    twin = (*TABLE, Label(3, "twin", TABLE[1].rgba))
    for keys, metadata, words in (
        (KEYS, {}, "no table"),
        (KEYS, {"labels": twin}, "'V1' and 'twin' have the same"),
        (KEYS + 1, {"labels": TABLE}, "the label 3, which its table lacks"),
        (KEYS + 0.5, {"labels": TABLE}, "whole numbers"),
        (KEYS, {"labels": (Label(0, "bright", (2.0, 0.0, 0.0, 1.0)),)}, "not from 0 to 1"),
    ):
        with pytest.raises(MeshError, match=words):
            write_scalars(path, {"a": keys}, metadata=metadata)
        assert not list(tmp_path.iterdir())


def test_gifti_files_say_that_they_hold_labels(tmp_path):
    nibabel = pytest.importorskip("nibabel")
    write_scalars(
        tmp_path / "a.label.gii",
        {"areas": KEYS},
        metadata={"labels": TABLE, "structure": "CortexRight"},
    )
    image = nibabel.load(tmp_path / "a.label.gii")
    array = image.get_arrays_from_intent("NIFTI_INTENT_LABEL")[0]
    assert array.data.dtype == np.int32
    assert image.labeltable.get_labels_as_dict() == {label.key: label.name for label in TABLE}
    assert image.meta["AnatomicalStructurePrimary"] == "CortexRight"
    write_scalars(tmp_path / "a.shape.gii", {"areas": KEYS})
    assert read_labels(tmp_path / "a.shape.gii") is None
    write_scalars(tmp_path / "lh.areas", {"areas": KEYS})
    assert read_labels(tmp_path / "lh.areas") is None
