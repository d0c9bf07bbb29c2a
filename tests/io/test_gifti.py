"""GIFTI: the data kept beside the mesh, and refusals."""

from __future__ import annotations

import numpy as np
import pytest

from igl_spheremap import MeshError
from igl_spheremap.io.files import read_mesh
from igl_spheremap.io.write_mesh import write_mesh

nibabel = pytest.importorskip("nibabel")


def test_gifti_keeps_structure_and_coordinate_system(ball, tmp_path):
    v, f = ball
    xform = np.diag([2.0, 3.0, 4.0, 1.0])
    points = nibabel.gifti.GiftiDataArray(
        v.astype(np.float32),
        "NIFTI_INTENT_POINTSET",
        coordsys=nibabel.gifti.GiftiCoordSystem(dataspace=1, xformspace=4, xform=xform),
        meta=nibabel.gifti.GiftiMetaData(AnatomicalStructurePrimary="CortexLeft"),
    )
    triangles = nibabel.gifti.GiftiDataArray(f.astype(np.int32), "NIFTI_INTENT_TRIANGLE")
    nibabel.save(nibabel.gifti.GiftiImage(darrays=[points, triangles]), tmp_path / "in.surf.gii")
    mesh = read_mesh(tmp_path / "in.surf.gii")
    write_mesh(tmp_path / "out.surf.gii", mesh.v, mesh.f, metadata=mesh.metadata)
    out = nibabel.load(tmp_path / "out.surf.gii").darrays[0]
    assert out.meta["AnatomicalStructurePrimary"] == "CortexLeft"
    assert (out.coordsys.dataspace, out.coordsys.xformspace) == (1, 4)
    assert np.array_equal(out.coordsys.xform, xform)


def test_a_scalar_map_is_no_surface(tmp_path):
    data = nibabel.gifti.GiftiDataArray(np.zeros(5, dtype=np.float32), "NIFTI_INTENT_SHAPE")
    nibabel.save(nibabel.gifti.GiftiImage(darrays=[data]), tmp_path / "a.shape.gii")
    with pytest.raises(MeshError, match="no surface"):
        read_mesh(tmp_path / "a.shape.gii")


def test_arrays_of_many_dimensions_are_refused_before_they_are_counted(ball, tmp_path):
    path = tmp_path / "a.surf.gii"
    write_mesh(path, *ball)
    path.write_bytes(
        path.read_bytes().replace(b'Dimensionality="2"', b'Dimensionality="2000000000"')
    )
    with pytest.raises(MeshError, match="dimensions"):
        read_mesh(path)


def test_gifti_names_the_hemisphere_of_the_file_s_name_where_the_source_names_none(ball, tmp_path):
    v, f = ball
    write_mesh(tmp_path / "rh.pial.ply", v, f)
    for source, target, structure in (
        ("rh.pial.ply", "sphere.surf.gii", "CortexRight"),  # by the source's name
        ("plain.ply", "lh.sphere.surf.gii", "CortexLeft"),  # by its own
        ("rh.pial.ply", "lh.sphere.surf.gii", "CortexRight"),  # the source knows better
        ("plain.ply", "sphere.surf.gii", None),
    ):
        write_mesh(tmp_path / source, v, f, force=True)
        write_mesh(
            tmp_path / target, v, f, force=True, metadata=read_mesh(tmp_path / source).metadata
        )
        points = nibabel.load(tmp_path / target).get_arrays_from_intent("NIFTI_INTENT_POINTSET")[0]
        assert dict(points.meta).get("AnatomicalStructurePrimary") == structure
