"""Images of labels (.nii, .nii.gz, .mgz), by nibabel: the surface of each label, in the image's coordinates."""

from __future__ import annotations

import math
from io import BytesIO
from pathlib import Path

import igl
import numpy as np
from numpy.typing import ArrayLike

from ..errors import MeshError
from ..gate import gate
from ..mesh.arrays import AnyArray, FloatArray, IntArray, listed_words, plain_array
from .nifti import array_behind, nibabel_for
from .reading import unpacked
from .records import RawMesh, of_triangles

#: Beginnings of files that are not of NIfTI's first version.
_MGH, _NIFTI2 = b"\0\0\0\1", (b"\x1c\2\0\0", b"\0\0\2\x1c")


@gate
def label_surface(
    labels: ArrayLike, label: int, *, affine: ArrayLike | None = None
) -> tuple[FloatArray, IntArray]:
    """The surface around the voxels of a label, by libigl's marching cubes.

    It is closed, even at the image's border, and lies midway between the centres of voxels with and without the label.
    It may have parts, handles and cavities: `info` counts them, `repair_mesh` makes a sphere of it.

    Parameters
    ----------
    labels : (a, b, c) array_like
        A label at each voxel.
    label : int
        The label of the surface; of a mask 1.
    affine : (4, 4) array_like, optional
        Takes the indices of voxels to coordinates, as ``image.affine`` of nibabel does; by default they are the
        coordinates.

    Returns
    -------
    (n, 3) float64 array, (m, 3) int64 array
        Vertices and faces, which are oriented outwards.

    Raises
    ------
    MeshError
        If the array does not have three dimensions, no voxel has the label, or the affine matrix is not invertible.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> image = np.zeros((9, 9, 9), dtype=int)
    >>> image[2:7, 3:6, 3:6] = 7
    >>> v, f = ism.label_surface(image, 7, affine=np.diag([2.0, 2.0, 2.0, 1.0]))
    >>> (v.max(axis=0) - v.min(axis=0)).tolist()
    [10.0, 6.0, 6.0]
    >>> ism.spherical_conformal_map(v, f).certificate.folding_free
    True
    """
    image = plain_array(labels, "labels")
    if image.ndim != 3:
        shape = "one number"
        if image.ndim:
            shape = " x ".join(map(str, image.shape))
        raise MeshError(f"it holds an array of {shape}; give a label at each voxel")
    matrix = np.eye(4)
    if affine is not None:
        matrix = plain_array(affine, "affine").astype(np.float64)
    if matrix.shape != (4, 4) or not abs(np.linalg.det(matrix[:3, :3])) > 0:
        raise MeshError("the affine matrix is not 4 x 4 and invertible; correct the image's header")
    inside = image == label
    if not inside.any():
        raise MeshError(f"no voxel has the label {label}; it has {_listed(_keys(image))}")
    spans = [np.flatnonzero(inside.any(axis=others)) for others in ((1, 2), (0, 2), (0, 1))]
    corner = [at[0] - 1 for at in spans]
    padded = np.pad(inside[tuple(slice(at[0], at[-1] + 1) for at in spans)], 1)
    places = np.stack(np.unravel_index(np.arange(padded.size), padded.shape, order="F"), axis=1)
    values = padded.ravel(order="F").astype(np.float64)
    points = np.ascontiguousarray((places + corner) @ matrix[:3, :3].T + matrix[:3, 3])
    v, f, _ = igl.marching_cubes(values, points, *padded.shape, 0.5)
    if np.linalg.det(matrix[:3, :3]) > 0:
        f = f[:, ::-1]
    return v, np.ascontiguousarray(f)


def read(path: Path, label: int | None = None) -> RawMesh:
    """The surface of a label, or of the only one of the image."""
    image, affine = _load(path)
    keys = _keys(image)
    if label is None:
        if len(keys) != 1:
            raise MeshError(
                f"it holds the labels {_listed(keys)}; give one of them, as {path}:{keys[0]}"
            )
        label = int(keys[0])
    v, f = label_surface(image, label, affine=affine)
    return RawMesh(v, of_triangles(f))


def labels_in(path: Path) -> list[int]:
    """The labels of an image but 0, in ascending order."""
    return [int(key) for key in _keys(_load(path)[0])]


def _keys(image: AnyArray) -> AnyArray:
    """The labels of an image but 0; a MeshError if there are none, or values that are no labels."""
    keys = np.unique(image)
    keys = keys[keys != 0]
    if not len(keys):
        raise MeshError("it holds no label but 0; give an image of labels")
    if not np.isfinite(keys).all() or (keys != np.rint(keys)).any():
        raise MeshError(
            "it holds grey values, no labels; threshold it first, or give an image of labels"
        )
    return keys


def _listed(keys: AnyArray) -> str:
    return listed_words(keys.astype(np.int64).tolist(), 12)


def _load(path: Path) -> tuple[AnyArray, FloatArray]:
    """An image's array and affine matrix."""
    with nibabel_for("images of labels") as nibabel:
        data = unpacked(path, times=1032)  # as far as deflate goes: images of labels do expand so
        kind = nibabel.Nifti1Header
        if data.startswith(_MGH):
            kind = nibabel.freesurfer.mghformat.MGHHeader
        elif data.startswith(_NIFTI2):
            kind = nibabel.Nifti2Header
        # without nibabel's checks, which print their mends
        header = kind.from_fileobj(BytesIO(data), check=False)
        shape = header.get_data_shape()
        if len(shape) > 4:
            raise MeshError("it holds data over surfaces (CIFTI), no image; give a surface")
        array = array_behind(header, data)
        if math.prod(shape[3:]) == 1:
            array = array.reshape(shape[:3])
        return array, np.asarray(header.get_best_affine(), dtype=np.float64)
