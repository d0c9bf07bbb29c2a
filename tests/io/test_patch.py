"""FreeSurfer's patches: bytes as its programs write them, round trips, and damage."""

import struct

import numpy as np
import pytest
from disks import half
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap.io.patch import Patch, read_patch, write_patch

V, F = icosphere(3)
W, G, ROWS = half(V, F)


def patch():
    rim = ism.check_disk(W, G).rim
    return Patch(ROWS, W, np.isin(np.arange(len(W)), rim))


def test_a_file_byte_by_byte(tmp_path):
    rows = [(7, (1.0, 2.0, 3.0), False), (0, (0.5, 0.0, -1.0), True)]
    data = struct.pack(">ii", -1, len(rows))
    data += b"".join(
        struct.pack(">ifff", -(k + 1) if border else k + 1, *x) for k, x, border in rows
    )
    path = tmp_path / "lh.cut.patch.3d"
    path.write_bytes(data)
    read = read_patch(path)
    assert read.rows.tolist() == [7, 0]
    assert read.border.tolist() == [False, True]
    assert read.positions.tolist() == [list(x) for _, x, _ in rows]
    write_patch(path, read, force=True)
    assert path.read_bytes() == data


def test_the_part_of_a_surface_comes_back(tmp_path):
    write_patch(tmp_path / "lh.half.patch.3d", patch())
    read = read_patch(tmp_path / "lh.half.patch.3d")
    v, f = read.part(V, F)
    assert (v == W).all()
    assert (f == G).all()
    assert (read.border == patch().border).all()
    with pytest.raises(ism.MeshError, match="surface"):
        read.part(V[:50], F[:1])


@pytest.mark.parametrize(
    "damage",
    [
        lambda data: data[:-1],
        lambda data: data[:6],
        lambda data: b"",
        lambda data: b"\0" * len(data),
        lambda data: data[:8] + data[24:40] + data[24:],
        lambda data: data + b"1234",
        lambda data: data[:4] + struct.pack(">i", 2**31 - 1) + data[8:],
        lambda data: data[:4] + struct.pack(">i", 0),
    ],
)
def test_damage_is_refused_in_one_line(tmp_path, damage):
    path = tmp_path / "lh.half.patch.flat"
    write_patch(path, patch())
    path.write_bytes(damage(path.read_bytes()))
    with pytest.raises(ism.MeshError) as error:
        read_patch(path)
    assert "\n" not in str(error.value)
    assert path.name in str(error.value)


def test_files_are_replaced_only_by_force(tmp_path):
    path = tmp_path / "lh.half.patch.3d"
    write_patch(path, patch())
    with pytest.raises(ism.FileError):
        write_patch(path, patch())
    with pytest.raises(ism.FileError):
        read_patch(tmp_path / "missing.patch.3d")
