"""The surfaces of labels: their place and volume, and the flags that make spheres of them."""

from __future__ import annotations

import gzip

import numpy as np
import pytest
from other_programs import label_image

import igl_spheremap as ism
from igl_spheremap import MeshError
from igl_spheremap.io.files import parts_in, read_mesh
from igl_spheremap.mesh.measure import inside_out

pytest.importorskip("nibabel")


@pytest.mark.parametrize(
    ("name", "kind", "dtype"),
    [
        ("labels.nii.gz", "Nifti1Image", np.uint8),
        ("labels.nii", "Nifti1Image", np.int16),
        ("second.nii", "Nifti2Image", np.float32),
        ("aseg.mgz", "MGHImage", np.int32),
    ],
)
def test_surfaces_lie_in_the_world_of_the_image(name, kind, dtype, tmp_path):
    image, affine, holder = label_image(kind, dtype)
    holder.to_filename(tmp_path / name)
    assert parts_in(tmp_path / name) == [f"{tmp_path / name}:{k}" for k in (1, 3, 17)]
    mesh = read_mesh(f"{tmp_path / name}:1")
    given = ism.label_surface(image, 1, affine=affine)
    assert np.abs(mesh.v - given[0]).max() < 1e-5
    assert np.array_equal(mesh.f, given[1])
    places = np.argwhere(image == 1) @ affine[:3, :3].T + affine[:3, 3]
    assert np.abs(mesh.v.mean(axis=0) - places.mean(axis=0)).max() < 1e-4
    assert (
        np.abs(mesh.v - places.mean(axis=0)).max() < np.abs(places - places.mean(axis=0)).max() + 2
    )
    assert ism.spherical_conformal_map(mesh).certificate.folding_free


@pytest.mark.parametrize("turn", [np.diag([1.0, 1, 1, 1]), np.diag([-1.0, 1, 1, 1])])
def test_surfaces_are_closed_outwards_and_halve_the_way_to_other_voxels(turn):
    """A box that touches all borders, one of whose corners is missing: its volume is known."""
    image = np.full((4, 5, 6), 2)
    v, f = ism.label_surface(image, 2, affine=turn)
    assert (v.min(axis=0) * turn.diagonal()[:3]).min() == -0.5 or turn[0, 0] < 0
    assert not inside_out(v, f)
    assert np.ptp(v, axis=0).tolist() == [4, 5, 6]
    ism.check_mesh(v, f)
    one = np.zeros((3, 3, 3), dtype=bool)
    one[1, 1, 1] = True
    v, f = ism.label_surface(one, 1, affine=turn)
    assert len(v) == 6  # an octahedron
    assert np.abs(np.linalg.norm(v - v.mean(axis=0), axis=1) - 0.5).max() < 1e-12


@pytest.mark.parametrize("seed", range(3))
def test_labels_of_noise_are_manifold_and_become_spheres(seed):
    rng = np.random.default_rng(seed)
    image = rng.random((9, 9, 9)) < 0.6
    v, f = ism.label_surface(image, 1)
    edges = np.sort(np.concatenate([f[:, [0, 1]], f[:, [1, 2]], f[:, [2, 0]]]), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()
    mesh = ism.repair_mesh(v, f, keep_largest=True, handles="cut")
    assert ism.spherical_conformal_map(mesh).certificate.folding_free


@pytest.mark.parametrize(
    ("image", "name", "words"),
    [
        (None, "a.nii", r"holds the labels 1, 3 and 17; give one of them, as .*a\.nii:1"),
        (None, "a.nii:4", "no voxel has the label 4; it has 1, 3 and 17"),
        (np.zeros((3, 3, 3), "u1"), "a.nii", "no label but 0"),
        (np.full((3, 3, 3), 0.5, "f4"), "a.nii", "grey values"),
        (np.full((3, 3, 3), np.nan, "f4"), "a.nii", "grey values"),
        (np.ones((3, 3, 3, 2), "u1"), "a.nii", "array of 3 x 3 x 3 x 2"),
        (np.arange(27, dtype="u1").reshape(3, 3, 3), "a.nii", "10, 11, 12 and 14 more"),
    ],
)
def test_what_is_no_label_is_named(image, name, words, tmp_path):
    nibabel = pytest.importorskip("nibabel")
    holder = label_image()[2] if image is None else nibabel.Nifti1Image(image, np.eye(4))
    holder.to_filename(tmp_path / "a.nii")
    with pytest.raises(MeshError, match=words):
        read_mesh(tmp_path / name)


def test_a_mask_needs_no_label_and_a_last_axis_of_one_is_none(tmp_path):
    nibabel = pytest.importorskip("nibabel")
    image = (label_image()[0] == 1).astype("u1")
    nibabel.Nifti1Image(5 * image[..., None], np.eye(4)).to_filename(tmp_path / "a.nii.gz")
    assert np.array_equal(read_mesh(tmp_path / "a.nii.gz").v, ism.label_surface(image, 1)[0])


def test_an_image_that_announces_more_than_there_is_takes_no_memory(tmp_path):
    data = bytearray(label_image()[2].to_bytes())
    data[42:48] = np.array([30000, 30000, 30000], "<i2").tobytes()  # its shape
    for name, content in (("a.nii", bytes(data)), ("a.nii.gz", gzip.compress(bytes(data)))):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(MeshError, match="27000000000000 are announced"):
            read_mesh(tmp_path / name)


@pytest.mark.parametrize("affine", [np.zeros((4, 4)), np.eye(3), np.full((4, 4), np.nan)])
def test_an_affine_matrix_is_invertible(affine):
    with pytest.raises(MeshError, match="4 x 4 and invertible"):
        ism.label_surface(np.ones((2, 2, 2)), 1, affine=affine)
