"""FreeSurfer: the data kept beside the mesh, and refusals."""

from __future__ import annotations

import struct

import numpy as np
import pytest

from igl_spheremap import MeshError
from igl_spheremap.io.files import read_mesh
from igl_spheremap.io.scalars import read_scalars, write_scalars
from igl_spheremap.io.write_mesh import write_mesh

freesurfer = pytest.importorskip("nibabel.freesurfer")


def test_freesurfer_keeps_the_volume_geometry_and_is_big_endian(ball, tmp_path):
    v, f = ball
    volume = {
        "head": np.array([2, 0, 20]),
        "valid": "1  # volume info valid",
        "filename": "orig.mgz",
        "volume": np.array([256, 256, 256]),
        "voxelsize": np.array([1.0, 1.0, 1.0]),
        "xras": np.array([-1.0, 0, 0]),
        "yras": np.array([0, 0, -1.0]),
        "zras": np.array([0, 1.0, 0]),
        "cras": np.array([1.0, 2.0, 3.0]),
    }
    freesurfer.write_geometry(tmp_path / "lh.pial", v, f, volume_info=volume)
    mesh = read_mesh(tmp_path / "lh.pial")
    write_mesh(tmp_path / "lh.sphere", mesh.v, mesh.f, metadata=mesh.metadata)
    _, _, kept = freesurfer.read_geometry(tmp_path / "lh.sphere", read_metadata=True)
    assert np.array_equal(kept["cras"], volume["cras"])
    assert (tmp_path / "lh.sphere").read_bytes()[:3] == b"\xff\xff\xfe"


@pytest.mark.parametrize("counts", [(10**9, 4), (4, 10**9), (-1, 4), (4, -(2**31))])
def test_counts_that_the_file_can_t_hold_are_refused(counts, ball, tmp_path):
    path = tmp_path / "lh.pial"
    write_mesh(path, *ball)
    data = path.read_bytes()
    start = data.index(b"\n\n") + 2
    path.write_bytes(data[:start] + struct.pack(">ii", *counts) + data[start + 8 :])
    with pytest.raises(MeshError, match="cut off"):
        read_mesh(path)


def test_counts_of_curvature_that_the_file_can_t_hold_are_refused(tmp_path):
    path = tmp_path / "lh.curv"
    write_scalars(path, {"curv": np.zeros(10)})
    path.write_bytes(path.read_bytes().replace(struct.pack(">i", 10), struct.pack(">i", 10**9), 1))
    with pytest.raises(MeshError, match="cut off"):
        read_scalars(path)


def test_files_of_quads_are_read_as_triangles(tmp_path):
    """FreeSurfer's older format, each quad cut in two."""

    def three(n):
        return int(n).to_bytes(3, "big")

    v = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=">f4")
    data = b"\xff\xff\xfd" + three(4) + three(1) + v.tobytes() + b"".join(map(three, range(4)))
    (tmp_path / "lh.orig").write_bytes(data)
    mesh = read_mesh(tmp_path / "lh.orig")
    assert np.array_equal(mesh.v, v)
    assert mesh.f.tolist() == [[0, 1, 3], [2, 3, 1]]
